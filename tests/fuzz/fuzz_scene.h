// Reads a scene as `sheaf render` does, with and without --lenient.
#pragma once

#include "scene/dialects/read_scene.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

/// Evaluates the motions of a scene. Throws Error for those that are singular.
inline void evaluate_motions(const Description& description) {
  for (const AnimatedTransform& motion : description.motions)
    for (const double t : {0.0, 0.4, 1.0})
      (void)motion.at(description.shutter.open + t * (description.shutter.close - description.shutter.open));
}

inline void try_scene(const std::filesystem::path& file) {
  if (reads([&] { evaluate_motions(read_scene(file)); })) return;
  ReadOptions lenient;
  lenient.lenient = true;
  reads([&] {
    for (const std::string& substitute : read_scene(file, lenient).substitutions) check_message(substitute);
  });
}

}  // namespace sheaf::fuzz
