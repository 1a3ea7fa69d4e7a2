// The layering of the repository: includes point only from later to earlier layers, each external library is wrapped in
// one file, and only core/simd names instruction sets.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kLayers = {"core", "scene", "kernels", "tools"};

/// A folder of a layer, and the other folders of the same layer whose headers its files may include.
struct Folder {
  std::string_view name;
  std::vector<std::string_view> may_include;
};

const std::vector<Folder> kCoreFolders = {
    {"io", {}},
    {"simd", {}},
    {"soa", {"io", "simd"}},
    {"math", {"io", "simd", "soa"}},
    {"sampling", {"io", "simd", "soa", "math"}},
    {"color", {"io", "simd", "soa", "math", "sampling"}},
    {"image", {"io", "simd", "soa", "math", "color"}},
};

/// The folder "" is that of the files of a layer that are in none of its folders: a whole scene as a file describes it
/// (description.h), and as kernels render it (scene.h).
const std::vector<Folder> kSceneFolders = {
    {"tables", {}},
    {"surfaces", {"tables"}},
    {"accel", {"tables"}},
    {"description", {"tables"}},
    {"data", {"description"}},
    {"xml", {"description"}},
    {"formats", {"description"}},
    {"spectra", {"description", "data"}},
    {"textures", {"tables", "surfaces", "description", "xml", "spectra"}},
    {"materials", {"tables", "description", "data", "xml", "formats", "spectra", "textures"}},
    {"lights", {"tables", "surfaces", "accel", "description", "data", "xml", "formats", "spectra", "textures"}},
    {"", {"tables", "accel", "description", "textures", "materials", "lights"}},
    {"dialects", {"tables", "description", "data", "xml", "formats", "textures", "materials", "lights", ""}},
    {"compile",
     {"tables", "surfaces", "accel", "description", "data", "formats", "spectra", "textures", "materials", "lights",
      ""}},
};

/// Every folder comes after those that it may include: there are no cycles.
const std::vector<Folder> kKernelFolders = {
    // Models know of no wave, film or stage.
    {"phase", {}},
    {"bsdf", {"phase"}},
    {"lights", {"bsdf"}},  // Fresnel terms of coats over emission
    {"media", {"phase", "bsdf"}},
    {"caustics", {"phase", "bsdf", "lights", "media"}},
    {"guiding", {}},
    {"film", {}},
    {"wave", {"phase", "bsdf", "lights", "media", "guiding"}},
    {"photons", {"film", "wave"}},
    {"stages", {"phase", "bsdf", "lights", "media", "caustics", "guiding", "film", "wave", "photons"}},
    {"passes", {"phase", "bsdf", "lights", "media", "caustics", "guiding", "film", "wave", "photons", "stages"}},
    {"training", {"guiding", "film", "wave", "photons", "stages", "passes"}},
    {"render", {"media", "caustics", "guiding", "film", "wave", "photons", "stages", "passes", "training"}},
    {"denoise", {}},  // works on images
};

const std::vector<Folder> kToolFolders = {
    {"console", {}},  // messages and progress
    {"options", {"console"}},
    {"report", {"console"}},  // reports of renders as text
    {"preview", {"console", "options", "report"}},
    {"job", {"console", "options", "preview"}},  // the steps around a render
    {"farm", {"console", "options", "job"}},
    {"cli", {"console", "options", "report", "preview", "job", "farm"}},
    {"python", {"console", "options", "report", "job", "farm"}},
    {"importer", {}},  // a program of its own
    {"packaging", {}},
    {"", {}},  // a program of its own
};

/// An external library that only one file may include. A header, a source of the same name and its "_writer" count as
/// one.
struct Wrapped {
  std::string_view library;
  std::vector<std::string_view> prefixes;  ///< prefixes of its headers
  std::string_view wrapper;  ///< path without extension; empty: any one file, and one of tools/importer/, a program
};

const std::vector<Wrapped> kWrapped = {
    {"xsimd", {"xsimd/"}, "core/simd/simd"},
    {"Embree", {"embree3/", "embree4/"}, "scene/accel/embree"},
    {"OpenEXR and Imath", {"OpenEXR/", "Imf", "Imath"}, ""},
    {"libpng", {"png.h"}, "core/image/formats/png"},
    {"libjpeg-turbo", {"jpeglib.h", "jerror.h"}, "core/image/formats/jpeg"},
    {"libtiff", {"tiffio.h"}, "core/image/formats/tiff_file"},
    {"libwebp", {"webp/"}, "core/image/formats/webp"},
    {"pugixml", {"pugixml.hpp"}, ""},
    {"tinyobjloader", {"tiny_obj_loader.h"}, "scene/formats/obj"},
    {"NanoVDB", {"nanovdb/"}, "scene/formats/nanovdb"},
    {"Blosc", {"blosc.h"}, "scene/formats/blosc"},
    {"zlib", {"zlib.h"}, ""},
    {"CLI11", {"CLI/"}, "tools/options/options"},
    {"libmicrohttpd", {"microhttpd.h"}, "tools/preview/http_server"},
};

std::string without_extension(const fs::path& path) { return fs::path(path).replace_extension().generic_string(); }

/// Index of the layer of a path, or -1 if it is in none.
int layer_of(std::string_view path) {
  const auto found = std::find(kLayers.begin(), kLayers.end(), path.substr(0, path.find('/')));
  return found == kLayers.end() ? -1 : static_cast<int>(found - kLayers.begin());
}

/// The folder "b" of a path "a/b/c" in layer "a", empty for a file of the layer itself; nullopt for other paths.
std::optional<std::string_view> folder_in(std::string_view layer, std::string_view path) {
  if (!path.starts_with(layer) || !path.substr(layer.size()).starts_with('/')) return std::nullopt;
  path.remove_prefix(layer.size() + 1);
  const std::size_t slash = path.find('/');
  return slash == path.npos ? std::string_view() : path.substr(0, slash);
}

/// Whether a file of a layer may include a header of the same layer, by the layer's folders. A folder that is not
/// listed may include no other folder.
bool keeps_to_folders(std::string_view layer, const std::vector<Folder>& folders, std::string_view file,
                      std::string_view header) {
  const std::optional<std::string_view> from = folder_in(layer, file), to = folder_in(layer, header);
  if (!from || !to || from == to) return true;
  const auto folder = std::find_if(folders.begin(), folders.end(), [&](const Folder& f) { return f.name == *from; });
  if (folder == folders.end()) return false;
  return std::find(folder->may_include.begin(), folder->may_include.end(), *to) != folder->may_include.end();
}

/// Folders of scene/ whose headers kernels may include.
const std::set<std::string_view> kReadByKernels = {"",         "tables",    "surfaces", "accel",
                                                   "textures", "materials", "lights"};

/// Whether a file of kernels/ keeps to the folders of scene/ that kernels may include.
bool keeps_to_tables(std::string_view file, std::string_view header) {
  if (!file.starts_with("kernels/")) return true;
  const std::optional<std::string_view> folder = folder_in("scene", header);
  return !folder || (kReadByKernels.contains(*folder) && header != "scene/description.h");
}

/// The folder "c" of a path "scene/dialects/c/d", empty for files of scene/dialects/ itself; nullopt for other paths.
std::optional<std::string_view> dialect_folder(std::string_view path) {
  constexpr std::string_view kDialects = "scene/dialects/";
  if (!path.starts_with(kDialects)) return std::nullopt;
  path.remove_prefix(kDialects.size());
  const std::size_t slash = path.find('/');
  return slash == path.npos ? std::string_view() : path.substr(0, slash);
}

/// Whether an include keeps to the arrows inside scene/dialects/: common <- model <- xml <- mitsuba, nori, pbrt, gltf
/// <- scene/dialects/*.cpp. The folder of a dialect offers its entry point, read_*.h.
bool keeps_to_dialects(std::string_view file, std::string_view header) {
  const std::optional<std::string_view> from = dialect_folder(file), to = dialect_folder(header);
  if (!to || from == to || *to == "common") return true;
  if (*to == "model") return from != "common";
  if (*to == "xml") return from != "common" && from != "model";
  if (!from) return to->empty();
  return from->empty() && header.substr(header.rfind('/') + 1).starts_with("read_");
}

/// The header that a line includes, if it includes one.
std::optional<std::string> included_header(const std::string& line) {
  const auto hash = line.find_first_not_of(" \t");
  if (hash == std::string::npos || line[hash] != '#') return std::nullopt;
  const auto word = line.find_first_not_of(" \t", hash + 1);
  if (word == std::string::npos || line.compare(word, 7, "include") != 0) return std::nullopt;
  const auto open = line.find_first_of("<\"", word + 7);
  if (open == std::string::npos) return std::nullopt;
  const auto close = line.find(line[open] == '<' ? '>' : '"', open + 1);
  if (close == std::string::npos) return std::nullopt;
  return line.substr(open + 1, close - open - 1);
}

/// An include, with paths from the root of the repository.
struct Include {
  std::string file, header;
};

/// Describes every include that breaks the rules.
std::vector<std::string> find_breaches(const std::vector<Include>& includes) {
  std::vector<std::string> breaches;
  for (const auto& [file, header] : includes) {
    if (header.starts_with("tests/") || header.starts_with("bench/"))
      breaches.push_back(file + " includes " + header + ", which is no layer");
    if (layer_of(header) > layer_of(file)) breaches.push_back(file + " includes " + header + ", of a later layer");
    if (!keeps_to_folders("core", kCoreFolders, file, header))
      breaches.push_back(file + " includes " + header + ", against the arrows of core/");
    if (!keeps_to_folders("tools", kToolFolders, file, header))
      breaches.push_back(file + " includes " + header + ", against the arrows of tools/");
    if (!keeps_to_folders("scene", kSceneFolders, file, header))
      breaches.push_back(file + " includes " + header + ", against the arrows of scene/");
    if (!keeps_to_folders("kernels", kKernelFolders, file, header))
      breaches.push_back(file + " includes " + header + ", against the arrows of kernels/");
    if (!keeps_to_tables(file, header)) breaches.push_back(file + " includes " + header + ", which is not for kernels");
    if (!keeps_to_dialects(file, header))
      breaches.push_back(file + " includes " + header + ", against the arrows of scene/dialects/");
    if (header.starts_with(".")) breaches.push_back(file + " includes " + header + ", not from the repository's root");
  }
  for (const Wrapped& wrapped : kWrapped) {
    std::set<std::string> users, importer_users;
    for (const auto& [file, header] : includes) {
      const bool is_importer = file.starts_with("tools/importer/") && wrapped.wrapper.empty();
      const auto begins = [&included = header](std::string_view prefix) { return included.starts_with(prefix); };
      const std::string user = without_extension(file);
      if (user == std::string(wrapped.wrapper) + "_writer") continue;
      if (std::any_of(wrapped.prefixes.begin(), wrapped.prefixes.end(), begins))
        (is_importer ? importer_users : users).insert(user);
    }
    if (!wrapped.wrapper.empty()) users.insert(std::string(wrapped.wrapper));
    if (importer_users.size() > 1) users.merge(importer_users);
    if (users.size() <= 1) continue;
    std::string breach = std::string(wrapped.library) + " is included by more than one file:";
    for (const std::string& user : users) breach += " " + user;
    breaches.push_back(breach);
  }
  return breaches;
}

/// Whether a line names an instruction set: a macro of the compiler, an intrinsic, or the header of one.
bool names_instruction_set(std::string_view line) {
  constexpr std::array<std::string_view, 9> kNames = {"__AVX", "__SSE",    "__FMA__",  "__ARM_",  "__x86_64__",
                                                      " _mm_", " _mm256_", " _mm512_", "intrin.h"};
  return std::any_of(kNames.begin(), kNames.end(), [&](std::string_view name) { return line.find(name) != line.npos; });
}

bool is_source(const fs::path& file) { return file.extension() == ".h" || file.extension() == ".cpp"; }

/// Names of the folders of a layer that contain sources.
std::set<std::string> folders_of(const fs::path& layer) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(layer)) {
    const fs::path file = fs::relative(entry.path(), layer);
    if (is_source(file)) names.insert(file.has_parent_path() ? file.begin()->string() : std::string());
  }
  return names;
}

std::set<std::string> names_of(const std::vector<Folder>& folders) {
  std::set<std::string> names;
  for (const Folder& folder : folders) names.emplace(folder.name);
  return names;
}

std::vector<Include> read_includes(const fs::path& root) {
  std::vector<Include> includes;
  for (const std::string_view layer : kLayers) {
    for (const auto& entry : fs::recursive_directory_iterator(root / layer)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream stream(entry.path());
      const std::string file = fs::relative(entry.path(), root).generic_string();
      for (std::string line; std::getline(stream, line);)
        if (const auto header = included_header(line)) includes.push_back({file, *header});
    }
  }
  return includes;
}

}  // namespace

TEST_CASE("every include respects the layers") {
  const auto includes = read_includes(SHEAF_SOURCE_DIR);
  REQUIRE(includes.size() > 10);
  for (const std::string& breach : find_breaches(includes)) FAIL_CHECK(breach);
}

TEST_CASE("only core/simd names instruction sets") {
  CHECK(names_instruction_set("#if defined(__AVX2__)"));
  CHECK(names_instruction_set("  return _mm_cvttss_si32(x);"));
  CHECK_FALSE(names_instruction_set("#if defined(__linux__)"));
  // Its filter of system calls names the processor.
  const std::string allowed = "tools/importer/sandbox.cpp";
  for (const std::string_view layer : kLayers) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SHEAF_SOURCE_DIR) / layer)) {
      const std::string file = fs::relative(entry.path(), SHEAF_SOURCE_DIR).generic_string();
      if (!is_source(entry.path()) || file.starts_with("core/simd/") || file == allowed) continue;
      std::ifstream stream(entry.path());
      for (std::string line; std::getline(stream, line);)
        if (names_instruction_set(line)) FAIL_CHECK(file << ": " << line);
    }
  }
}

TEST_CASE("the folders of each layer are listed") {
  CHECK(folders_of(SHEAF_SOURCE_DIR "/core") == names_of(kCoreFolders));
  CHECK(folders_of(SHEAF_SOURCE_DIR "/tools") == names_of(kToolFolders));
  CHECK(folders_of(SHEAF_SOURCE_DIR "/scene") == names_of(kSceneFolders));
  CHECK(folders_of(SHEAF_SOURCE_DIR "/kernels") == names_of(kKernelFolders));
}

TEST_CASE("folders are listed after the folders that they may include") {
  for (const auto& folders : {kCoreFolders, kSceneFolders, kKernelFolders, kToolFolders}) {
    std::set<std::string_view> earlier;
    for (const Folder& folder : folders) {
      CAPTURE(std::string(folder.name));
      for (const std::string_view included : folder.may_include) CHECK(earlier.contains(included));
      earlier.insert(folder.name);
    }
  }
}

TEST_CASE("no folder holds more than 45 sources") {
  // One file per thing
  const std::set<std::string> unlimited = {"kernels/bsdf", "kernels/stages", "scene/formats", "scene/lights",
                                           "scene/materials"};
  std::map<std::string, int> sources;
  for (const char* const top : {"bench", "core", "kernels", "scene", "scenes", "tests", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SHEAF_SOURCE_DIR) / top)) {
      const std::string extension = entry.path().extension();
      if (extension == ".h" || extension == ".cpp" || extension == ".py" || extension == ".sh")
        ++sources[fs::relative(entry.path().parent_path(), SHEAF_SOURCE_DIR).generic_string()];
    }
  }
  REQUIRE(sources.size() > 20);
  for (const auto& [folder, count] : sources)
    if (count > 45 && !unlimited.contains(folder)) FAIL_CHECK(folder << " holds " << count << " sources");
}

TEST_CASE("no header includes itself through others") {
  std::map<std::string, std::vector<std::string>> included;
  for (const auto& [file, header] : read_includes(SHEAF_SOURCE_DIR))
    if (file.ends_with(".h")) included[file].push_back(header);
  std::set<std::string> done;
  std::vector<std::string> open;
  const std::function<void(const std::string&)> visit = [&](const std::string& header) {
    if (std::find(open.begin(), open.end(), header) != open.end()) FAIL_CHECK(header << " includes itself");
    if (!included.contains(header) || !done.insert(header).second) return;
    open.push_back(header);
    for (const std::string& next : included[header]) visit(next);
    open.pop_back();
  };
  for (const auto& [file, headers] : std::map(included)) visit(file);
}

TEST_CASE("include lines are recognized with any spacing") {
  CHECK(included_header("#include \"core/math/vec.h\"") == "core/math/vec.h");
  CHECK(included_header("  #  include <xsimd/xsimd.hpp>  // why") == "xsimd/xsimd.hpp");
  CHECK_FALSE(included_header("// #include <vector>").has_value());
  CHECK_FALSE(included_header("#define include").has_value());
  CHECK_FALSE(included_header("").has_value());
}

TEST_CASE("includes against the layers are found") {
  CHECK(find_breaches({{"core/math/vec.h", "core/simd/lanes.h"}, {"tools/cli/sheaf.cpp", "kernels/wave/wave.h"}})
            .empty());
  CHECK(find_breaches({{"core/math/vec.h", "scene/scene.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/scene.h", "kernels/wave/wave.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "tools/render.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "tests/helpers.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/passes/run_pass.cpp", "../wave.h"}}).size() == 1);
}

TEST_CASE("includes against the folders of scene/ are found") {
  CHECK(find_breaches({{"scene/xml/xml.h", "scene/description/inputs.h"},
                       {"scene/xml/xml.h", "scene/xml/xml_values.h"},
                       {"scene/compile/compile.cpp", "scene/scene.h"},
                       {"scene/lights/point_light.cpp", "scene/xml/properties.h"},
                       {"scene/materials/ward.cpp", "scene/xml/properties.h"},
                       {"scene/description.h", "scene/materials/material.h"},
                       {"scene/compile/compile.h", "scene/description.h"},
                       {"scene/textures/bitmap.cpp", "scene/xml/properties.h"},
                       {"kernels/bsdf/ward.h", "scene/materials/ward.h"},
                       {"kernels/stages/shadow.cpp", "scene/scene.h"},
                       {"tools/cli/command_info.cpp", "scene/compile/compile.h"}})
            .empty());
  CHECK(find_breaches({{"scene/description/media.h", "scene/xml/xml.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/tables/camera.h", "scene/description/camera.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/tables/scene_view.h", "scene/accel/accel.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/accel/accel.cpp", "scene/scene.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/scene.h", "scene/compile/compile.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/formats/obj.cpp", "scene/surfaces/shape.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/materials/ward.cpp", "scene/compile/compile.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/description/media.h", "scene/materials/ward.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/compile/spectra.cpp", "scene/dialects/xml/read_spectrum.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/compile/compile_lights.cpp", "scene/xml/xml.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/lights/point_light.cpp", "scene/compile/spectra.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/new/file.cpp", "scene/description/inputs.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/materials/ward.h", "scene/description.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/xml/properties.h", "scene/textures/list.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "scene/description.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "scene/description/inputs.h"}}).size() == 1);
}

TEST_CASE("includes against the folders of kernels/ are found") {
  CHECK(find_breaches({{"kernels/bsdf/plastic.h", "kernels/bsdf/bsdf.h"},
                       {"kernels/wave/wave.h", "kernels/lights/light_tree.h"},
                       {"kernels/photons/light_task.h", "kernels/film/splat.h"},
                       {"kernels/stages/aovs.cpp", "kernels/film/camera_task.h"},
                       {"tools/cli/sheaf.cpp", "kernels/render/render.h"}})
            .empty());
  CHECK(find_breaches({{"kernels/phase/sggx.h", "kernels/bsdf/bsdf.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/bsdf/bsdf.h", "kernels/wave/wave.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/media/medium_tracking.h", "kernels/wave/path_state.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/wave/wave.h", "kernels/photons/photon.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/film/film.h", "kernels/photons/photon.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "kernels/passes/run_pass.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/denoise/denoise.cpp", "kernels/film/film.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/new/file.cpp", "kernels/bsdf/bsdf.h"}}).size() == 1);
}

TEST_CASE("breaches of the folders of scene/dialects/ are found") {
  CHECK(find_breaches({{"scene/dialects/read_scene.cpp", "scene/dialects/nori/read_nori.h"},
                       {"scene/dialects/read_scene.cpp", "scene/dialects/model/auto_camera.h"},
                       {"scene/dialects/nori/scene.cpp", "scene/dialects/nori/reader.h"},
                       {"scene/dialects/nori/scene.cpp", "scene/dialects/xml/read_geometry.h"},
                       {"tools/cli/command_render.cpp", "scene/dialects/read_scene.h"},
                       {"tools/cli/command_render.cpp", "scene/dialects/common/setting_names.h"}})
            .empty());
  CHECK(find_breaches({{"scene/dialects/read_scene.cpp", "scene/dialects/nori/reader.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/dialects/common/read_bsdf.cpp", "scene/dialects/nori/reader.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/dialects/model/auto_camera.h", "scene/dialects/read_scene.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/dialects/nori/bsdf.cpp", "scene/dialects/mitsuba/reader.h"}}).size() == 1);
  CHECK(find_breaches({{"tools/cli/command_render.cpp", "scene/dialects/pbrt/read_pbrt.h"}}).size() == 1);
}

TEST_CASE("includes of a library beside its wrapper are found") {
  CHECK(find_breaches({{"core/simd/simd.h", "xsimd/xsimd.hpp"}, {"scene/accel/embree.h", "embree3/rtcore.h"}}).empty());
  CHECK(find_breaches({{"core/sampling/warp.h", "xsimd/xsimd.hpp"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/intersect.cpp", "embree4/rtcore.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/xml/xml.h", "pugixml.hpp"}, {"scene/xml/xml.cpp", "pugixml.hpp"}}).empty());
  CHECK(
      find_breaches({{"scene/xml/xml.cpp", "pugixml.hpp"}, {"scene/dialects/nori/scene.cpp", "pugixml.hpp"}}).size() ==
      1);
  CHECK(find_breaches({{"scene/xml/xml.cpp", "pugixml.hpp"}, {"tools/importer/a.cpp", "pugixml.hpp"}}).empty());
  CHECK(find_breaches({{"tools/importer/a.cpp", "pugixml.hpp"}, {"tools/importer/b.cpp", "pugixml.hpp"}}).size() == 1);
  CHECK(find_breaches({{"tools/importer/a.cpp", "embree4/rtcore.h"}}).size() == 1);
}
