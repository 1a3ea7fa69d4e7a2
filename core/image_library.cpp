// Loading of sheaf_image_io.so, detection of image formats, and checks of headers that OpenImageIO trusts.
#include "core/image_library.h"

#include "core/error.h"
#include "core/image.h"
#include "core/memory.h"

#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace sheaf {

namespace {

namespace fs = std::filesystem;

const ImageLibrary* load() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  const fs::path beside = folder / "sheaf_image_io.so";
  const fs::path installed = folder.parent_path() / "lib/sheaf/sheaf_image_io.so";
  const fs::path& file = fs::exists(beside, error) ? beside : installed;
  const auto fail = [&](const std::string& why) {
    return Error(ExitCode::kRuntime, "cannot read or write image formats other than OpenEXR: " + why +
                                         " (expected sheaf_image_io.so next to the program or in ../lib/sheaf)");
  };
  if (!fs::exists(file, error)) throw fail("neither '" + beside.string() + "' nor '" + installed.string() + "' exists");
  void* const handle = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (handle == nullptr) throw fail(dlerror());
  void* const function = dlsym(handle, kImageLibraryFunction);
  if (function == nullptr) throw fail("'" + file.string() + "' is not Sheaf's image library");
  return reinterpret_cast<ImageLibraryFunction*>(function)();
}

[[noreturn]] void reject_image(const fs::path& path, const std::string& why) {
  throw SceneError({path.string(), 0}, "cannot read the image: " + why);
}

std::string format_of(const fs::path& path) {
  struct Beginning {
    std::string_view bytes, format;
  };
  using namespace std::string_view_literals;
  constexpr Beginning kBeginnings[] = {{"\x89PNG"sv, "png"}, {"\xff\xd8\xff"sv, "jpeg"},
                                       {"II*\0"sv, "tiff"},  {"MM\0*"sv, "tiff"},
                                       {"II+\0"sv, "tiff"},  {"MM\0+"sv, "tiff"},
                                       {"#?"sv, "hdr"},      {"BM"sv, "bmp"},
                                       {"P1"sv, "pnm"},      {"P2"sv, "pnm"},
                                       {"P3"sv, "pnm"},      {"P4"sv, "pnm"},
                                       {"P5"sv, "pnm"},      {"P6"sv, "pnm"},
                                       {"Pf"sv, "pnm"},      {"PF"sv, "pnm"}};
  std::array<char, 4> bytes{};
  std::ifstream(path, std::ios::binary).read(bytes.data(), bytes.size());
  for (const Beginning& known : kBeginnings)
    if (std::string_view(bytes.data(), bytes.size()).starts_with(known.bytes)) return std::string(known.format);
  if (const fs::path extension = path.extension(); extension == ".tga" || extension == ".TGA") return "targa";
  reject_image(path, "expected a file of OpenEXR, PNG, JPEG, TIFF, Radiance (.hdr), BMP, PFM, PGM, PPM or TGA");
}

/// Checks the size in a BMP header. The library allocates the pixels of compressed BMP files when it opens them.
void check_bmp(const fs::path& path) {
  constexpr std::size_t kKind = 14, kSize = 18, kEnd = 26;
  constexpr std::uint32_t kOldKind = 12;  // header with 16-bit sizes
  std::array<unsigned char, kEnd> head{};
  std::ifstream(path, std::ios::binary).read(reinterpret_cast<char*>(head.data()), head.size());
  const auto number = [&](std::size_t at, std::size_t bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= std::uint32_t{head[at + i]} << (8 * i);
    return value;
  };
  const auto side = [&](std::size_t axis) -> long long {
    if (number(kKind, 4) == kOldKind) return number(kSize + 2 * axis, 2);
    return static_cast<std::int32_t>(number(kSize + 4 * axis, 4));
  };
  // a negative height means rows from the top
  check_image_size(path, side(0), std::abs(side(1)), 3, fs::file_size(path));
}

/// Checks the memory for a PNM file. The library reads the whole file for its header, copies it once more, and
/// terminates the program if memory runs out.
void check_pnm(const fs::path& path) {
  constexpr double kCopies = 3;
  const MemoryUse copies{"copies of the file", kCopies * static_cast<double>(fs::file_size(path)),
                         "use another format"};
  check_memory("reading the image '" + path.string() + "'", {&copies, 1});
}

/// Checks the lengths of the chunks of a PNG file. The library allocates the length of a chunk, up to 2 GB. A chunk has
/// a length, four letters, the data, and a checksum.
void check_png(const fs::path& path) {
  constexpr std::uint64_t kSignature = 8, kAround = 12;
  const std::uint64_t size = fs::file_size(path);
  std::ifstream file(path, std::ios::binary);
  for (std::uint64_t at = kSignature; at + kAround <= size;) {
    std::array<unsigned char, 8> head{};
    file.seekg(static_cast<std::streamoff>(at));
    file.read(reinterpret_cast<char*>(head.data()), head.size());
    std::uint32_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | head[i];
    if (length > size - at - kAround) reject_image(path, "the file is damaged or ends too early");
    if (std::memcmp(&head[4], "IEND", 4) == 0) return;
    at += kAround + length;
  }
}

}  // namespace

const ImageLibrary& image_library() {
  static const ImageLibrary* const library = load();
  return *library;
}

std::string checked_image_format(const fs::path& path) {
  std::string format = format_of(path);
  if (format == "bmp") check_bmp(path);
  if (format == "pnm") check_pnm(path);
  if (format == "png") check_png(path);
  return format;
}

}  // namespace sheaf
