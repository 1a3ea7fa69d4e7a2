// Models of COLLADA, FBX and 3D Studio, which a process of their own imports.
#include "scene/dialects/read_scene.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  constexpr const char* kNames[] = {"model.dae", "model.fbx", "model.3ds"};
  const unsigned format = take_choice(input) % 3;
  const auto file = make_file(kNames[format], input);
  ReadOptions options;
  options.lenient = true;
  options.moment.time = 0.5;
  reads([&] {
    for (const std::string& note : read_scene(file, options).notes) check_message(note);
  });
}

}  // namespace sheaf::fuzz
