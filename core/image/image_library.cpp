// Detection of image formats, and checks of headers that the libraries trust.
#include "core/image/image_library.h"

#include "core/image/image_source.h"
#include "core/image/jpeg.h"
#include "core/image/png.h"
#include "core/io/error.h"
#include "core/io/memory.h"
#include "core/io/module.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>

namespace sheaf {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void reject_image(const fs::path& path, const std::string& why) {
  throw SceneError({path.string(), 0}, "cannot read the image: " + why);
}

/// The formats of image files, by their magic number.
struct MagicNumber {
  std::string_view bytes, format;
  bool in_memory = false;  ///< also read from memory
};
using namespace std::string_view_literals;
constexpr MagicNumber kMagicNumbers[] = {{"\x89PNG"sv, "png", true},
                                         {"\xff\xd8\xff"sv, "jpeg", true},
                                         {"II*\0"sv, "tiff"},
                                         {"MM\0*"sv, "tiff"},
                                         {"II+\0"sv, "tiff"},
                                         {"MM\0+"sv, "tiff"},
                                         {"#?"sv, "hdr"},
                                         {"BM"sv, "bmp"},
                                         {"P1"sv, "pnm"},
                                         {"P2"sv, "pnm"},
                                         {"P3"sv, "pnm"},
                                         {"P4"sv, "pnm"},
                                         {"P5"sv, "pnm"},
                                         {"P6"sv, "pnm"},
                                         {"Pf"sv, "pnm"},
                                         {"PF"sv, "pnm"}};

std::string format_of(ImageSource& source) {
  const bool in_memory = source.memory() != nullptr;
  std::array<unsigned char, 12> bytes{};
  source.read(0, bytes);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const MagicNumber& known : kMagicNumbers)
    if (text.starts_with(known.bytes) && (known.in_memory || !in_memory)) return std::string(known.format);
  if (text.starts_with("RIFF") && text.ends_with("WEBP")) return "webp";
  if (in_memory) reject_image(source.path(), "expected PNG, JPEG or WebP");
  if (const fs::path extension = source.path().extension(); extension == ".tga" || extension == ".TGA") return "targa";
  reject_image(source.path(),
               "expected a file of OpenEXR, PNG, JPEG, TIFF, WebP, Radiance (.hdr), BMP, PFM, PGM, PPM or TGA");
}

/// A number in little-endian order.
std::uint32_t little_endian(std::span<const unsigned char> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

/// Checks the size in a BMP header. The library allocates the pixels of compressed BMP files when it opens them.
void check_bmp(ImageSource& source) {
  constexpr std::size_t kKind = 14, kSize = 18, kEnd = 26;
  constexpr std::uint32_t kOldKind = 12;  // header with 16-bit sizes
  std::array<unsigned char, kEnd> head{};
  source.read(0, head);
  const auto number = [&](std::size_t at, std::size_t bytes) { return little_endian({&head[at], bytes}); };
  const auto side = [&](std::size_t axis) -> long long {
    if (number(kKind, 4) == kOldKind) return number(kSize + 2 * axis, 2);
    return static_cast<std::int32_t>(number(kSize + 4 * axis, 4));
  };
  // a negative height means rows from the top
  check_image_size(source.path(), side(0), std::abs(side(1)), 3, source.size());
}

/// Checks the size in the first chunk of a WebP file (RFC 9649). The library allocates the pixels when it opens it.
void check_webp(ImageSource& source) {
  constexpr std::size_t kChunk = 12, kData = 20, kEnd = 30;
  constexpr std::uint32_t k14Bits = 0x3fff;
  std::array<unsigned char, kEnd> head{};
  source.read(0, head);
  const std::string_view chunk(reinterpret_cast<const char*>(&head[kChunk]), 4);
  const auto number = [&](std::size_t at, std::size_t bytes) { return little_endian({&head[kData + at], bytes}); };
  long long width = 0, height = 0;
  if (chunk == "VP8 ") {
    width = number(6, 2) & k14Bits, height = number(8, 2) & k14Bits;
  } else if (chunk == "VP8L") {
    width = (number(1, 4) & k14Bits) + 1, height = (number(1, 4) >> 14 & k14Bits) + 1;
  } else if (chunk == "VP8X") {
    width = number(4, 3) + 1, height = number(7, 3) + 1;
  }
  constexpr std::size_t kChannels = 4, kCopies = 3;  // canvas, previous canvas and frame
  check_image_size(source.path(), width, height, kChannels, counted_image_bytes(source, "webp"));
  check_image_memory(source.path(), width, height, kChannels, kCopies);
}

/// Checks the memory for a PNM file. The library reads the whole file for its header, copies it once more, and
/// terminates the program if memory runs out.
void check_pnm(const ImageSource& source) {
  constexpr double kCopies = 3;
  const MemoryUse copies{"copies of the file", kCopies * static_cast<double>(source.size()), "use another format"};
  check_memory(fmt::format("reading the image '{}'", source.path().string()), {&copies, 1});
}

/// Checks the lengths of the chunks of a PNG file, also of those that the reader skips or does not reach. A chunk has a
/// length, four letters, the data, and a checksum.
void check_png(ImageSource& source) {
  constexpr std::uint64_t kSignature = 8, kAround = 12;
  constexpr const char* kEndsEarly = "the file is damaged or ends too early";
  const std::uint64_t size = source.size();
  for (std::uint64_t at = kSignature; at < size;) {
    if (size - at < kAround) reject_image(source.path(), kEndsEarly);
    std::array<unsigned char, 8> head{};
    source.read(at, head);
    std::uint32_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | head[i];
    if (length > size - at - kAround) reject_image(source.path(), kEndsEarly);
    if (std::memcmp(&head[4], "IEND", 4) == 0) return;
    at += kAround + length;
  }
}

}  // namespace

const ImageLibrary& image_library() {
  static const auto library = reinterpret_cast<ImageLibraryFunction*>(load_module(
      kImageLibrary, kImageLibraryFunction, "cannot read or write image formats other than OpenEXR, PNG and JPEG"));
  return *library();
}

std::string checked_image_format(ImageSource& source) {
  std::string format = format_of(source);
  if (format == "bmp") check_bmp(source);
  if (format == "pnm") check_pnm(source);
  if (format == "png") check_png(source);
  if (format == "webp") check_webp(source);
  return format;
}

std::string checked_image_format(const fs::path& file) {
  ImageSource source(file);
  return checked_image_format(source);
}

std::unique_ptr<ImageReader> open_image_reader(ImageSource source, const std::string& format, std::string& problem,
                                               std::vector<std::uint8_t> bytes) {
  if (format == "png") return open_png(std::move(source), problem);
  if (format == "jpeg") return open_jpeg(std::move(source), problem);
  if (source.memory() != nullptr) bytes = source.memory()->bytes;
  return image_library().open(source.path().string(), format, problem, std::move(bytes));
}

std::size_t counted_image_bytes(const ImageSource& source, const std::string& format) {
  constexpr std::size_t kMinWebp = std::size_t{1} << 15;
  const auto size = static_cast<std::size_t>(source.size());
  return format == "webp" ? std::max(size, kMinWebp) : size;
}

}  // namespace sheaf
