// OpenEXR files: headers, pixels, images, and parts of images that `sheaf merge` joins.
#include "core/image/exr.h"
#include "tests/fuzz/fuzz.h"
#include "tools/job/parts.h"

namespace sheaf::fuzz {

namespace {

void try_part(const std::filesystem::path& file) {
  const PartFile part = read_part_header(file);
  check_same_image(part, part);
  std::array<std::vector<float>, kNameKinds> ids;
  for (std::size_t kind = 0; kind < kNameKinds; ++kind)
    if (const auto found = ids_from_attribute(part.text(part_id_attribute(kind)))) ids[kind] = *found;
  const PixelRect frame{0, 0, part.frame_width, part.frame_height};
  if (frame.area() * part.channels.size() > 1u << 20) return;
  ImageMerger merger(part.frame_width, part.frame_height, frame, part.channels, part.samples_per_pixel, ids);
  merger.add(part.part, read_exr(file));
  (void)merger.finish();
  (void)whole_metadata({part});
}

}  // namespace

void try_input(std::string_view input) {
  const auto file = make_file("image.exr", input);
  if (!is_exr(file)) return;
  reads([&] { (void)read_exr_header(file); });
  reads([&] { (void)read_exr_metadata(file); });
  reads([&] { (void)read_exr(file); });
  for (const bool raw : {false, true}) reads([&] { (void)read_stored_image(file, raw); });
  reads([&] { try_part(file); });
}

}  // namespace sheaf::fuzz
