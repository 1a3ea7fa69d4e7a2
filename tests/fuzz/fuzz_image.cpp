// Images. The first byte selects the extension, and hence the format that is tried first. Checksums in PNG files are
// corrected, because almost none would be read otherwise. All are read from memory, too. Files that claim many pixels
// take a hundred times as long as others and tend to multiply: one in sixteen of them is read, without height fields.
#include "core/image/image.h"
#include "core/image/image_formats.h"
#include "core/io/inflate.h"
#include "scene/formats/height_field.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/image_extensions.h"

namespace sheaf::fuzz {

namespace {

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

/// Chunks of a PNG file are a length, four letters, as many bytes, and a checksum of letters and bytes.
void put_check_sums(std::string& png) {
  constexpr std::size_t kSignature = 8, kAround = 12;
  for (std::size_t at = kSignature; at + kAround <= png.size();) {
    const std::size_t length = big_endian(png, at), sum_at = at + 8 + length;
    if (length > png.size() - at - kAround) return;
    const std::uint32_t sum = check_sum(std::string_view(png).substr(at + 4, 4 + length));
    for (std::size_t i = 0; i < 4; ++i) png[sum_at + i] = static_cast<char>(sum >> (24 - 8 * i));
    at += kAround + length;
  }
}

/// Whether the header of a file claims more than a few pixels.
bool claims_much(const std::filesystem::path& file) {
  constexpr double kFew = 1 << 13;
  std::string problem;
  std::unique_ptr<ImageReader> reader;
  const auto open = [&] {
    ImageSource source(file);
    reader = find_image_format(source).open(std::move(source), problem);
  };
  if (!reads(open)) return false;
  if (!reader) return false;
  const ImageHeader& header = reader->header();
  return double(header.width) * double(header.height) * double(header.channels.size()) > kFew;
}

}  // namespace

void try_input(std::string_view input) {
  const unsigned choice = take_choice(input);
  const std::string extension(kImageExtensions[choice % std::size(kImageExtensions)]);
  std::string bytes(input);
  if (extension == "png") put_check_sums(bytes);
  const auto file = make_file("image." + extension, bytes);
  const bool is_large = claims_much(file);
  if (is_large && choice >> 4 != 15) return;
  EncodedImage encoded;
  encoded.bytes.assign(bytes.begin(), bytes.end());
  encoded.name = "image";
  reads([&] { (void)read_stored_image(encoded); });
  if (!reads([&] { (void)read_stored_image(file); })) return;
  reads([&] { (void)read_image(file); });
  if (!is_large) reads([&] { (void)read_height_field(file, 1, true, false); });
}

}  // namespace sheaf::fuzz
