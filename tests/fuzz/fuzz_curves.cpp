// Curve and hair files.
#include "scene/formats/curve_file.h"
#include "scene/formats/hair_file.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const auto file = make_file("hair.txt", input);
  reads([&] { (void)read_curve_file(file, Curves::Basis::kBspline); });
  reads([&] { (void)read_curve_file(file, Curves::Basis::kLinear); });
  reads([&] { (void)read_hair_file(file, {0.5f, 10, 0.25f}); });
  reads([&] { (void)read_hair_file(file, {0.5f, 10, 0.25f, true}); });
}

}  // namespace sheaf::fuzz
