// glTF files: containers, documents, accessors, compressed meshes and their materials.
#include "tests/fuzz/fuzz_scene.h"

namespace sheaf::fuzz {

namespace {

/// Whether a document refers to a file outside of folder().
bool names_outer_file(std::string_view input) {
  return input.find("..") != std::string_view::npos || input.find("%2") != std::string_view::npos;
}

}  // namespace

void try_input(std::string_view input) {
  static const bool copied = (copy_files("tests/references/scenes", ".xml"), true);
  if (!copied || names_outer_file(input)) return;
  const auto file = make_file(input.starts_with("glTF") ? "model.glb" : "model.gltf", input);
  ReadOptions options;
  for (const bool lenient : {false, true}) {
    options.lenient = lenient;
    reads([&] {
      const Description scene = read_scene(file, options);
      for (const std::string& note : scene.notes) check_message(note);
      evaluate_motions(scene);
    });
    options.moment.time = 0.5;
    options.shutter = ShutterDescription{-0.25, 0.75, 0};
  }
}

}  // namespace sheaf::fuzz
