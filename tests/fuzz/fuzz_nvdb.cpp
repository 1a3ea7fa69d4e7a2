// NanoVDB files.
#include "scene/formats/nanovdb.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto file = make_file("grid.nvdb", input);
  reads([&] { (void)read_nanovdb(file, ""); });
  reads([&] {
    if (has_nanovdb_grid(file, "heat")) (void)read_nanovdb(file, "heat");
  });
}

}  // namespace sheaf::fuzz
