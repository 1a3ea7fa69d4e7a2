// OFF meshes.
#include "scene/formats/off.h"
#include "tests/fuzz/fuzz_mesh.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto bad_faces = take_choice(input) % 2 == 0 ? BadFaces::kError : BadFaces::kDrop;
  const auto file = make_file("mesh.off", input);
  reads([&] { try_mesh(read_off(file, bad_faces)); });
}

}  // namespace sheaf::fuzz
