// Reads a scene as `sheaf render` does, with and without --lenient.
#pragma once

#include "scene/dialects/read_scene.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

inline void try_scene(const std::filesystem::path& file) {
  if (reads([&] { (void)read_scene(file); })) return;
  ReadOptions lenient;
  lenient.lenient = true;
  reads([&] {
    for (const std::string& stand_in : read_scene(file, lenient).stand_ins) check_message(stand_in);
  });
}

}  // namespace sheaf::fuzz
