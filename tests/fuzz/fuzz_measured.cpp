// Tensor files and the measured BRDFs in them.
#include "scene/formats/measured_file.h"
#include "scene/formats/polarized_brdf.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto file = make_file("facets.bsdf", input);
  reads([&] { (void)read_measured(file, false); });
  reads([&] { (void)read_measured(file, true); });
  reads([&] { (void)read_polarized_brdf(file); });
}

}  // namespace sheaf::fuzz
