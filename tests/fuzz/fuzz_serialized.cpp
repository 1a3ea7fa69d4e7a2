// Serialized meshes of Mitsuba. The first byte selects whether the rest is a file, or the content of a mesh of version
// 3 or 4 before compression, because mutants of a compressed stream are rarely valid.
#include "scene/formats/serialized.h"
#include "tests/fuzz/fuzz_mesh.h"
#include "tests/support/files/deflate.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const unsigned choice = take_choice(input);
  std::string bytes(input);
  if (choice % 4 >= 2) {
    const char version = choice % 2 == 0 ? '\3' : '\4';
    bytes = std::string{'\x1c', '\x04', version, '\0'} + test::deflated(bytes, 0);
  }
  const auto file = make_file("mesh.serialized", bytes);
  reads([&] { try_mesh(read_serialized(file, static_cast<int>(choice / 4 % 4))); });
}

}  // namespace sheaf::fuzz
