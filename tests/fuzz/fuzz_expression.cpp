// Substitution of names and arithmetic in the text of scene files.
#include "scene/xml/definitions.h"
#include "tests/fuzz/fuzz.h"

#include <cstdlib>

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const bool keeps_undefined = take_choice(input) % 2 == 1;
  Definitions definitions({{"frame", "7"}, {"size", "0.25"}, {"name", "abc"}});
  const auto fail = [](const SceneError& error) { throw SceneError(error); };
  const TextLocation position{{"scene.xml", 1}, 1};
  reads([&] {
    const std::string text = keeps_undefined ? definitions.substitute_defined(input, position, fail)
                                             : definitions.substitute(input, position, fail);
    // A text of one expression becomes a number
    if (input.starts_with("$(") && input.find(')') == input.size() - 1 && std::strtod(text.c_str(), nullptr) != 0 &&
        text.find_first_not_of("+-.0123456789e") != std::string::npos)
      std::abort();
  });
  reads([&] { definitions.reject_unused("scene.xml"); });
}

}  // namespace sheaf::fuzz
