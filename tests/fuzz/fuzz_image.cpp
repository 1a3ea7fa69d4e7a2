// Pictures. The first byte chooses the extension, by which a format is tried first.
#include "core/image.h"
#include "scene/formats/height_field.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/image_extensions.h"

namespace sheaf::fuzz {

void try_input(std::string_view input) {
  const unsigned choice = take_choice(input);
  const auto file = make_file("picture." + std::string(kImageExtensions[choice % std::size(kImageExtensions)]), input);
  if (!reads([&] { (void)read_picture(file); })) return;
  reads([&] { (void)read_image(file); });
  reads([&] { (void)read_height_field(file, 1, true, false); });
}

}  // namespace sheaf::fuzz
