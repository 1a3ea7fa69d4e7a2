// MTL files, the material libraries of OBJ files.
#include "tests/fuzz/fuzz_scene.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  static const auto model = make_file(
      "model.obj",
      "mtllib model.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\nusemtl c\nf 2 3 1\n");
  if (leads_out(input)) return;
  make_file("model.mtl", input);
  try_scene(model);
}

}  // namespace sheaf::fuzz
