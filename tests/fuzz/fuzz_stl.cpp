// STL meshes.
#include "scene/formats/stl.h"
#include "tests/fuzz/fuzz_mesh.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto file = make_file("mesh.stl", input);
  reads([&] { try_mesh(read_stl(file)); });
}

}  // namespace sheaf::fuzz
