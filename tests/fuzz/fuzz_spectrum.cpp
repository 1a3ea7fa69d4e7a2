// Spectrum files of Mitsuba and pbrt, and spectra in attributes.
#include "scene/xml/spectrum_text.h"
#include "tests/fuzz/fuzz_scene.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  static const auto scene =
      make_file("scene.pbrt", "WorldBegin\nLightSource \"point\" \"spectrum I\" \"light.spd\"\nShape \"sphere\"\n");
  const auto file = make_file("light.spd", input);
  reads([&] { (void)read_spd(file); });
  reads([&] { (void)read_scene(scene); });
  for (const auto parse : {parse_rgb, parse_srgb}) reads([&] { (void)parse(input, {"text", 1}); });
  reads([&] { (void)parse_spectrum_text(input, {"text", 1}); });
}

}  // namespace sheaf::fuzz
