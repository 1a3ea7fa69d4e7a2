// glTF files: containers, documents, accessors, compressed meshes and their materials.
#include "scene/dialects/read_scene.h"
#include "tests/fuzz/fuzz.h"

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
      for (const std::string& note : read_scene(file, options).notes) check_message(note);
    });
    options.moment.time = 0.5;
  }
}

}  // namespace sheaf::fuzz
