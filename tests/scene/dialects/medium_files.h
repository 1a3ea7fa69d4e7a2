// Elements of media in scene files as text, and the media that they describe.
#pragma once

#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <variant>

namespace sheaf::medium_files {

using Grid = GridVolumeDescription;
using Pair = ExtinctionAlbedoDescription;
using Coefficients = AbsorptionScatteringDescription;

/// A folder with empty files of the kinds that volumes refer to.
struct Volumes {
  TemporaryFolder folder;
  Volumes() {
    for (const char* name : {"a.vol", "a.nvdb", "a.vdb", "a.VOL", "mesh.obj"}) test::write_below(folder, name, "");
    test::write_below(folder, "vol.dat", "VOL\3");
    test::write_below(folder, "nanovdb.dat", "NanoVDB0");
    test::write_below(folder, "openvdb.dat", " BDV....");
    test::write_below(folder, "text.dat", "hello");
  }
  std::filesystem::path scene(const std::string& text) const { return test::write_below(folder, "scene.xml", text); }
};

/// Reads a scene in such a folder.
inline Description read_volumes(const std::string& text) { return read_scene(Volumes().scene(text)); }

/// The error message of a scene in such a folder.
inline std::string error_of_volumes(const std::string& text) {
  const Volumes volumes;
  return test::error_of(volumes.scene(text));
}

/// A scene of Mitsuba 0.6. The elements begin in line 4.
inline std::string mitsuba06_scene(const std::string& inside) {
  return test::mitsuba_scene(inside, "<sensor type='perspective'/>", "<integrator type='volpath'/>", "0.6.0");
}

/// A scene of Nori. The elements begin in line 2.
inline std::string nori_scene(const std::string& inside, const std::string& integrator = "<integrator type='path'/>") {
  return "<scene>\n" + inside + "\n<camera type='perspective'/>" + integrator + "</scene>";
}

inline std::string nori_mesh(const std::string& inside) {
  return nori_scene("<mesh type='sphere'>" + inside + "</mesh>");
}

inline std::string medium(const std::string& type, const std::string& inside) {
  return "<medium type='" + type + "'>" + inside + "</medium>";
}
inline std::string volume(const std::string& name, const std::string& type, const std::string& inside) {
  return "<volume name='" + name + "' type='" + type + "'>" + inside + "</volume>";
}

/// The property with the name of a file.
inline std::string file(const std::string& name) { return "<string name='filename' value='" + name + "'/>"; }

/// The medium of a scene with one.
inline const MediumDescription& only_medium(const Description& d) {
  REQUIRE(d.media.size() == 1);
  return d.media[0];
}

/// The coefficients of a medium, which are of type T.
template <class T> const T& coefficients(const MediumDescription& m) {
  REQUIRE(std::holds_alternative<T>(m.coefficients));
  return std::get<T>(m.coefficients);
}

inline std::string text_of(const SpectrumDescription& s) { return test::dump(s); }
inline std::string text_of(const VolumeInput& input) {
  const auto* spectrum = std::get_if<SpectrumDescription>(&input);
  return spectrum != nullptr ? test::dump(*spectrum) : "grid " + std::get<Grid>(input).file.filename().string();
}
inline std::string constant(float v) { return text_of(SpectrumDescription::constant(v)); }
inline std::string rgb(float r, float g, float b) { return text_of(SpectrumDescription::rgb(r, g, b)); }

}  // namespace sheaf::medium_files
