// The layering of the repository: includes point only from later layers to earlier ones, and each library from outside
// is wrapped in one file.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kLayers = {"core", "scene", "kernels", "tools"};

/// A folder of scene/ and the others of them whose headers its files may include.
struct Folder {
  std::string_view name;
  std::vector<std::string_view> may_include;
};

const std::vector<Folder> kSceneFolders = {
    {"description", {"tables"}},
    {"data", {"description"}},
    {"xml", {"description"}},
    {"formats", {"description"}},
    {"tables", {}},
    {"dialects", {"description", "xml", "formats", "data", "tables"}},
    {"compile", {"description", "data", "formats", "tables"}},
};

/// A library that one file alone (a header and a source of the same name count as one) may include.
struct Wrapped {
  std::string_view library;
  std::vector<std::string_view> prefixes;  ///< how its headers begin
  std::string_view wrapper;                ///< path without extension; empty: any one file
};

const std::vector<Wrapped> kWrapped = {
    {"xsimd", {"xsimd/"}, "core/simd"},
    {"Embree", {"embree3/", "embree4/"}, "scene/tables/accel"},
    {"OpenEXR and Imath", {"OpenEXR/", "Imf", "Imath"}, ""},
    {"OpenImageIO", {"OpenImageIO/"}, "core/image_io/openimageio"},
    {"tinyobjloader", {"tiny_obj_loader.h"}, ""},
    {"pugixml", {"pugixml.hpp"}, ""},
    {"NanoVDB", {"nanovdb/"}, "scene/formats/nanovdb"},
    {"zlib", {"zlib.h"}, ""},
    {"CLI11", {"CLI/"}, "tools/options"},
    {"libmicrohttpd", {"microhttpd.h"}, "tools/http_server"},
};

std::string without_extension(const fs::path& path) { return fs::path(path).replace_extension().generic_string(); }

/// The place of a path's first folder among the layers, or -1 if it is none of them.
int layer_of(std::string_view path) {
  const auto found = std::find(kLayers.begin(), kLayers.end(), path.substr(0, path.find('/')));
  return found == kLayers.end() ? -1 : static_cast<int>(found - kLayers.begin());
}

/// The folder "b" of a path "scene/b/c"; empty for other paths.
std::string_view scene_folder(std::string_view path) {
  if (!path.starts_with("scene/")) return {};
  path.remove_prefix(6);
  return path.substr(0, path.find('/'));
}

/// Folders of scene/ whose headers kernels may include.
const std::set<std::string_view> kReadByKernels = {"tables", "materials", "lights"};

/// Whether a file may include a header of scene/, as far as folders go.
bool keeps_to_folders(std::string_view file, std::string_view header) {
  const std::string_view from = scene_folder(file), to = scene_folder(header);
  if (to.empty() || from == to) return true;
  if (from.empty()) return !file.starts_with("kernels/") || kReadByKernels.count(to) > 0;
  const auto folder = std::find_if(kSceneFolders.begin(), kSceneFolders.end(), [&](auto& f) { return f.name == from; });
  if (folder == kSceneFolders.end()) return false;
  return std::find(folder->may_include.begin(), folder->may_include.end(), to) != folder->may_include.end();
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

/// One include: who includes what. Paths from the root of the repository.
struct Include {
  std::string file, header;
};

/// Every breach of the rules, as a sentence.
std::vector<std::string> find_breaches(const std::vector<Include>& includes) {
  std::vector<std::string> breaches;
  for (const auto& [file, header] : includes) {
    if (header.starts_with("tests/") || header.starts_with("bench/"))
      breaches.push_back(file + " includes " + header + ", which is no layer");
    if (layer_of(header) > layer_of(file)) breaches.push_back(file + " includes " + header + ", of a later layer");
    if (!keeps_to_folders(file, header))
      breaches.push_back(file + " includes " + header + ", against the arrows of scene/");
    if (header.starts_with(".")) breaches.push_back(file + " includes " + header + ", not from the repository's root");
  }
  for (const Wrapped& wrapped : kWrapped) {
    std::set<std::string> users;
    for (const auto& [file, header] : includes) {
      const auto begins = [&included = header](std::string_view prefix) { return included.starts_with(prefix); };
      if (std::any_of(wrapped.prefixes.begin(), wrapped.prefixes.end(), begins)) users.insert(without_extension(file));
    }
    if (!wrapped.wrapper.empty()) users.insert(std::string(wrapped.wrapper));
    if (users.size() <= 1) continue;
    std::string breach = std::string(wrapped.library) + " is included by more than one file:";
    for (const std::string& user : users) breach += " " + user;
    breaches.push_back(breach);
  }
  return breaches;
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

TEST_CASE("every include of the repository keeps to the layers") {
  const auto includes = read_includes(SHEAF_SOURCE_DIR);
  REQUIRE(includes.size() > 10);
  for (const std::string& breach : find_breaches(includes)) FAIL_CHECK(breach);
}

TEST_CASE("an include line is recognised however it is spaced") {
  CHECK(included_header("#include \"core/vec.h\"") == "core/vec.h");
  CHECK(included_header("  #  include <xsimd/xsimd.hpp>  // why") == "xsimd/xsimd.hpp");
  CHECK_FALSE(included_header("// #include <vector>").has_value());
  CHECK_FALSE(included_header("#define include").has_value());
  CHECK_FALSE(included_header("").has_value());
}

TEST_CASE("breaches of the layers are found") {
  CHECK(find_breaches({{"core/vec.h", "core/lanes.h"}, {"tools/sheaf.cpp", "kernels/wave/wave.h"}}).empty());
  CHECK(find_breaches({{"core/vec.h", "scene/tables/scene.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/tables/scene.h", "kernels/wave/wave.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "tools/render.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "tests/helpers.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/passes/run_pass.cpp", "../wave.h"}}).size() == 1);
}

TEST_CASE("breaches of the folders of scene/ are found") {
  CHECK(find_breaches({{"scene/xml/xml.h", "scene/description/description.h"},
                       {"scene/xml/xml.h", "scene/xml/xml_values.h"},
                       {"scene/compile/compile.cpp", "scene/tables/scene.h"},
                       {"scene/compile/lights/point_light.cpp", "scene/compile/light.h"},
                       {"kernels/stages/shadow.cpp", "scene/tables/scene.h"},
                       {"tools/command_info.cpp", "scene/compile/compile.h"}})
            .empty());
  CHECK(find_breaches({{"scene/description/description.h", "scene/xml/xml.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/tables/camera.h", "scene/description/camera.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/formats/obj.cpp", "scene/tables/shape.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/compile/spectra.cpp", "scene/dialects/common/read_spectrum.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/compile/lights/point_light.cpp", "scene/xml/xml.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/new/file.cpp", "scene/description/description.h"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/shadow.cpp", "scene/description/description.h"}}).size() == 1);
}

TEST_CASE("a library included past its wrapper is found") {
  CHECK(find_breaches({{"core/simd.h", "xsimd/xsimd.hpp"}, {"scene/tables/accel.cpp", "embree3/rtcore.h"}}).empty());
  CHECK(find_breaches({{"core/warp.h", "xsimd/xsimd.hpp"}}).size() == 1);
  CHECK(find_breaches({{"kernels/stages/intersect.cpp", "embree4/rtcore.h"}}).size() == 1);
  CHECK(find_breaches({{"scene/xml/xml.h", "pugixml.hpp"}, {"scene/xml/xml.cpp", "pugixml.hpp"}}).empty());
  CHECK(
      find_breaches({{"scene/xml/xml.cpp", "pugixml.hpp"}, {"scene/dialects/nori/scene.cpp", "pugixml.hpp"}}).size() ==
      1);
}
