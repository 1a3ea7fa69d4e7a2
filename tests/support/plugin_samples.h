// Smallest scenes around one plugin or one snippet of the documentation, in three versions of the XML dialects, and the
// files that they need for being read.
#pragma once

#include "tests/support/files/image_files.h"
#include "tests/support/temporary_folder.h"

#include <bit>
#include <regex>
#include <string>
#include <vector>

namespace sheaf::test {

/// The dialects and versions whose readers differ.
enum class Dialect { kMitsuba, kMitsuba06, kNori };

inline const char* dialect_name(Dialect dialect) {
  return dialect == Dialect::kNori ? "Nori" : dialect == Dialect::kMitsuba ? "Mitsuba" : "0.6";
}

/// A scene of the elements, which may contain a sensor, an integrator and the like.
inline std::string scene_around(Dialect dialect, const std::string& elements) {
  const auto has = [&](const char* tag) { return elements.find(tag) != std::string::npos; };
  if (dialect == Dialect::kNori)
    return "<scene>" + std::string(has("<camera") ? "" : "<camera type='perspective'/>") +
           (has("<integrator") ? "" : "<integrator type='path'/>") + elements + "</scene>";
  return std::string("<scene version='") + (dialect == Dialect::kMitsuba ? "3.0.0" : "0.6.0") + "'>" +
         (has("<sensor") ? "" : "<sensor type='perspective'/>") +
         (has("<integrator") ? "" : "<integrator type='path'/>") + elements + "</scene>";
}

/// The places of an element in a scene: "%" stands for it.
inline std::vector<std::string> places_of(Dialect dialect, const std::string& tag) {
  const bool nori = dialect == Dialect::kNori;
  const auto shape = [&](const std::string& inside) {
    return nori ? "<mesh type='rectangle'>" + inside + "</mesh>" : "<shape type='rectangle'>" + inside + "</shape>";
  };
  const std::string interior = nori ? "" : " name='interior'";
  if (tag == "bsdf") return {shape("%")};
  if (tag == "texture" || tag == "spectrum")
    return {shape("<bsdf type='diffuse'>%</bsdf>"), shape("<bsdf type='principled'>%</bsdf>"),
            shape("<bsdf type='mask'>%<bsdf type='diffuse'/></bsdf>"), shape("<emitter type='area'>%</emitter>"),
            shape("<bsdf type='normalmap'>%<bsdf type='diffuse'/></bsdf>")};
  if (tag == "emitter" || tag == "sensor") return {"%", shape("%")};
  if (tag == "film" || tag == "sampler") return {nori ? "%" : "<sensor type='perspective'>%</sensor>"};
  if (tag == "rfilter")
    return {nori ? "<camera type='perspective'>%</camera>"
                 : "<sensor type='perspective'><film type='hdrfilm'>%</film></sensor>"};
  if (tag == "volume")
    return {shape("<medium" + interior + " type='heterogeneous'>%</medium>"),
            shape("<medium" + interior + " type='homogeneous'>%</medium>"),
            shape("<bsdf type='diffuse'><texture type='volume' name='reflectance'>%</texture></bsdf>")};
  if (tag == "phase" || tag == "phasefunction") return {shape("<medium" + interior + " type='homogeneous'>%</medium>")};
  if (tag == "subsurface") return {shape("%")};
  return {"%"};
}

/// The element in a place.
inline std::string in_place(const std::string& index, const std::string& element) {
  return std::string(index).replace(index.find('%'), 1, element);
}

/// The tag of the first element.
inline std::string first_tag(const std::string& elements) {
  std::smatch match;
  return std::regex_search(elements, match, std::regex("<([a-z]+)")) ? match[1].str() : std::string();
}

/// All scenes in which the elements of a snippet can stand.
inline std::vector<std::string> scenes_around(Dialect dialect, const std::string& elements) {
  const std::string tag = first_tag(elements);
  if (tag == "scene") return {elements};
  std::vector<std::string> scenes;
  for (const std::string& index : places_of(dialect, tag))
    scenes.push_back(scene_around(dialect, in_place(index, elements)));
  return scenes;
}

/// Writes the files that a scene names. Only what readers open has content.
inline void write_named_files(const TemporaryFolder& folder, const std::string& scene) {
  static const std::regex kFile("[\"']([A-Za-z_./]+\\.([a-z]+))[\"']");
  for (std::sregex_iterator at(scene.begin(), scene.end(), kFile), end; at != end; ++at) {
    const std::filesystem::path file = folder / (*at)[1].str();
    const std::string extension = (*at)[2].str();
    std::filesystem::create_directories(file.parent_path());
    std::string bytes;
    if (extension == "txt" || extension == "mitshair") bytes = "0 0 0 1\n1 0 0 1\n2 0 0 1\n3 0 0 1\n";
    if (extension == "mitshair") bytes = "0 0 0\n1 1 0\n2 0 0\n";
    if (extension == "spd") bytes = "400 0.1\n700 0.9\n";
    if (extension == "ply")
      bytes =
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "property float scale_0\nproperty float scale_1\nproperty float scale_2\nproperty float rot_0\n"
          "property float rot_1\nproperty float rot_2\nproperty float rot_3\nend_header\n0 0 0 0 0 0 1 0 0 0\n";
    if (extension == "vol") {
      bytes = "VOL\x03";
      for (const std::uint32_t word : {1u, 2u, 2u, 2u, 1u, 0u, 0u, 0u}) append_little(bytes, word, 4);
      for (int i = 0; i < 11; ++i) append_little(bytes, std::bit_cast<std::uint32_t>(1.0f), 4);
    }
    write_bytes(file, bytes);
    const bool is_image = extension == "exr" || extension == "png" || extension == "jpg";
    if (is_image) write_pnm(file, 2, 2, 1, 255, {0, 1, 2, 3});
  }
}

}  // namespace sheaf::test
