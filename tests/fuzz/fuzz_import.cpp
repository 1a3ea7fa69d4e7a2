// Models of COLLADA, FBX, 3D Studio and OFF, which a process of their own imports.
#include "scene/dialects/read_scene.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  constexpr const char* kNames[] = {"model.dae", "model.fbx", "model.3ds", "model.off"};
  const unsigned format = take_choice(input) % 4;
  const auto file = make_file(kNames[format], input);
  ReadOptions options;
  options.lenient = true;
  options.moment.time = 0.5;
  reads([&] {
    for (const std::string& note : read_scene(file, options).notes) check_message(note);
  });
}

}  // namespace sheaf::fuzz
