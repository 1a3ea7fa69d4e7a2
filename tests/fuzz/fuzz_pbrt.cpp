// Scenes of pbrt-v4.
#include "tests/fuzz/fuzz_scene.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  static const bool copied = (copy_files("tests/renders/pbrt_twins", ".xml"), true);
  if (copied && !leads_out(input)) try_scene(make_file("scene.pbrt", input));
}

}  // namespace sheaf::fuzz
