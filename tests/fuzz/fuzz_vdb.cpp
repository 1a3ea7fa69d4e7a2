// OpenVDB files.
#include "scene/formats/openvdb.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto file = make_file("grid.vdb", input);
  for (const char* const grid : {"", "heat"}) reads([&] { (void)read_openvdb(file, grid); });
}

}  // namespace sheaf::fuzz
