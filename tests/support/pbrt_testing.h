// Small scenes of pbrt's format.
#pragma once

#include "tests/support/picture_files.h"
#include "tests/support/scene_files.h"

namespace sheaf::test {

/// Reads `world` behind WorldBegin, which stands in line 2 behind `options`; `prepare` may put files into the folder.
template <class Prepare>
Description read_pbrt_world(const std::string& world, const std::string& options, Prepare prepare) {
  const TemporaryFolder folder;
  prepare(folder);
  return read_scene(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"));
}
inline Description read_pbrt_world(const std::string& world, const std::string& options = "") {
  return read_pbrt_world(world, options, [](const TemporaryFolder&) {});
}

/// The message for what stands in lines from 3 on; empty if there is none.
inline std::string error_of_pbrt_world(const std::string& world, const std::string& options = "") {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "scene.pbrt", options + "\nWorldBegin\n" + world + "\n"));
}

}  // namespace sheaf::test
