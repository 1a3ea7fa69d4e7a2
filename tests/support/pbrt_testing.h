// Small scenes in pbrt's format.
#pragma once

#include "tests/support/picture_files.h"
#include "tests/support/scene_files.h"

namespace sheaf::test {

/// Reads a scene with `options` before WorldBegin and `world` after it. With empty options, WorldBegin is line 2.
/// `prepare` may add files to the folder.
template <class Prepare>
Description read_pbrt_world(const std::string& world, const std::string& options, Prepare prepare) {
  const TemporaryFolder folder;
  prepare(folder);
  return read_scene(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"));
}
inline Description read_pbrt_world(const std::string& world, const std::string& options = "") {
  return read_pbrt_world(world, options, [](const TemporaryFolder&) {});
}

/// The error message for a scene whose world block starts in line 3; empty if reading succeeds.
inline std::string error_of_pbrt_world(const std::string& world, const std::string& options = "") {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"));
}

}  // namespace sheaf::test
