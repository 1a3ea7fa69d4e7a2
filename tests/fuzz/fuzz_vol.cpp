// Mitsuba's grid volumes.
#include "scene/formats/vol_file.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto file = make_file("grid.vol", input);
  reads([&] { (void)read_vol(file, true); });
  reads([&] { (void)read_vol(file, false, VolChannels::kMatrices); });
}

}  // namespace sheaf::fuzz
