// Small scenes in pbrt's format.
#pragma once

#include "tests/support/files/image_files.h"
#include "tests/support/files/scene_files.h"

namespace sheaf::test {

/// Reads a scene with `options` before WorldBegin and `world` after it. With empty options, WorldBegin is line 2.
/// `prepare` may add files to the folder.
template <class Prepare>
Description read_pbrt_world(const std::string& world, const std::string& options, Prepare prepare) {
  const TemporaryFolder folder;
  prepare(folder);
  return read_scene(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"));
}

/// Writes the empty files image.png and sky.exr.
inline void write_dummy_images(const TemporaryFolder& folder) {
  for (const char* name : {"image.png", "sky.exr"}) write_below(folder, name, "");
}

/// The same in a folder with dummy images, which are never opened.
inline Description read_pbrt_world(const std::string& world, const std::string& options = "") {
  return read_pbrt_world(world, options, write_dummy_images);
}

/// The error message for a scene whose world block starts in line 3; empty if reading succeeds.
inline std::string error_of_pbrt_world(const std::string& world, const std::string& options = "") {
  const TemporaryFolder folder;
  write_dummy_images(folder);
  return error_of(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"));
}

/// The model of a material, or of the front of a two-sided one; null if it is of another kind.
template <class Model> const Model* model_of(const Description& d, MaterialId id) {
  const MaterialDescription* material = &d.materials.at(static_cast<std::size_t>(id));
  if (const auto* sides = std::get_if<TwoSidedDescription>(&material->model))
    material = &d.materials.at(static_cast<std::size_t>(sides->front));
  return std::get_if<Model>(&material->model);
}

/// model_of() for the material of the first shape.
template <class Model> const Model* only_material(const Description& d) {
  return model_of<Model>(d, *d.shapes.at(0).material);
}

/// A spectrum given as a number or as RGB.
inline Vec3f rgb_of(const SpectrumDescription& spectrum) {
  if (const auto* gray = std::get_if<SpectrumDescription::Constant>(&spectrum.value))
    return {gray->value, gray->value, gray->value};
  return std::get<SpectrumDescription::Rgb>(spectrum.value).value;
}

}  // namespace sheaf::test
