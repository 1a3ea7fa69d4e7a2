// Wavefront OBJ as a mesh, and as a model with the materials of an MTL file.
#include "tests/fuzz/fuzz_mesh.h"
#include "tests/fuzz/fuzz_scene.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  static const auto library = make_file("model.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\nKs 1 1 1\nNs 10\n");
  if (library.empty() || leads_out(input)) return;
  const auto file = make_file("model.obj", input);
  for (const BadFaces bad_faces : {BadFaces::kError, BadFaces::kDrop})
    reads([&] { try_mesh(read_obj(file, true, bad_faces)); });
  try_scene(file);
}

}  // namespace sheaf::fuzz
