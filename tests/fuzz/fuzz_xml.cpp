// Scenes in XML: Mitsuba's and Nori's dialects.
#include "tests/fuzz/fuzz_scene.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  static const bool copied = (copy_files("tests/references/scenes", ".xml"), true);
  if (copied && !leads_out(input)) try_scene(make_file("scene.xml", input));
}

}  // namespace sheaf::fuzz
