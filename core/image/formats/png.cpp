// The only file that includes libpng. After an error, libpng jumps back to setjmp() in run_png(). The functions in
// between have no objects with destructors.
#include "core/image/formats/png.h"

#include <png.h>

#include <array>
#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>
#include <utility>

namespace sheaf {

namespace {

/// The last error of libpng.
struct PngMessage {
  char text[256] = "libpng cannot be initialized";
};

[[noreturn]] void jump_after_png_error(png_structp png, png_const_charp text) {
  PngMessage& message = *static_cast<PngMessage*>(png_get_error_ptr(png));
  std::snprintf(message.text, sizeof(message.text), "%s", text);
  png_longjmp(png, 1);
}

void ignore_png_warning(png_structp, png_const_charp) {}

/// Runs an action that calls libpng. Returns whether it succeeded.
template <class Action> bool run_png(png_structp png, const Action& action) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  action();
  return true;
}

/// Checks the lengths of all chunks, also of those that the reader skips or does not reach. A chunk has a length, four
/// letters, the data, and a checksum.
bool has_whole_chunks(ImageSource& source) {
  constexpr std::uint64_t kSignature = 8, kAround = 12;
  for (std::uint64_t at = kSignature; at < source.size();) {
    if (source.size() - at < kAround) return false;
    std::array<unsigned char, 8> head{};
    if (!source.read(at, head)) return false;
    std::uint32_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | head[i];
    if (length > source.size() - at - kAround) return false;
    if (std::memcmp(&head[4], "IEND", 4) == 0) return true;
    at += kAround + length;
  }
  return true;
}

class PngReader final : public IntegerReader {
 public:
  explicit PngReader(ImageSource source) : source_(std::move(source)) {}
  ~PngReader() override { png_destroy_read_struct(&png_, &info_, nullptr); }

  bool open(std::string& problem) {
    if (!has_whole_chunks(source_)) {
      problem = kImageEndsEarly;
      return false;
    }
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message_, jump_after_png_error, ignore_png_warning);
    info_ = png_ == nullptr ? nullptr : png_create_info_struct(png_);
    if (info_ == nullptr || !run_png(png_, [this] { read_header(); })) {
      problem = message_.text;
      return false;
    }
    set_header(static_cast<int>(png_get_image_width(png_, info_)), static_cast<int>(png_get_image_height(png_, info_)),
               channel_names(), png_get_bit_depth(png_, info_));
    return true;
  }

  bool has_rows() const override { return header_.holds_bytes && passes_ == 1; }
  bool read_rows(int count, std::uint8_t* out, std::string& problem) override {
    const std::size_t row_bytes = png_get_rowbytes(png_, info_);
    const auto read_all = [this, count, out, row_bytes] {
      for (int y = 0; y < count; ++y) png_read_row(png_, out + static_cast<std::size_t>(y) * row_bytes, nullptr);
    };
    if (run_png(png_, read_all)) return true;
    problem = message_.text;
    return false;
  }

 private:
  static void read_bytes(png_structp png, png_bytep out, std::size_t size) {
    PngReader& reader = *static_cast<PngReader*>(png_get_io_ptr(png));
    if (size > reader.source_.size() - reader.at_ || !reader.source_.read(reader.at_, {out, size}))
      png_error(png, kImageEndsEarly);
    reader.at_ += size;
  }

  /// Reads everything before the pixels. libpng's limits hold: 1,000,000 pixels per side and 8 MB per chunk.
  void read_header() {
    png_set_read_fn(png_, this, read_bytes);
    // Skip all chunks but those of the pixels, the palette and the transparency: profiles and texts may be huge
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png_, info_);
    png_set_expand(png_);
    if (std::endian::native == std::endian::little) png_set_swap(png_);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
  }

  std::vector<std::string> channel_names() const {
    const int type = png_get_color_type(png_, info_);
    std::vector<std::string> names{"Y"};
    if ((type & PNG_COLOR_MASK_COLOR) != 0) names = {"R", "G", "B"};
    if ((type & PNG_COLOR_MASK_ALPHA) != 0) names.emplace_back("A");
    return names;
  }

  bool decode(unsigned char* out, std::string& problem) override {
    for (int pass = 0; pass < passes_; ++pass)
      if (!read_rows(header_.height, out, problem)) return false;
    return true;
  }

  ImageSource source_;
  std::uint64_t at_ = 0;  ///< bytes read
  PngMessage message_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1;  ///< of interlaced images
};

class PngWriter {
 public:
  PngWriter() = default;
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  bool write(const IntegerPixels& pixels, int level, const std::string& description) {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &message_, jump_after_png_error, ignore_png_warning);
    info_ = png_ == nullptr ? nullptr : png_create_info_struct(png_);
    return info_ != nullptr && run_png(png_, [&] {
             write_header(pixels, level, description.c_str());
             const png_byte* row = static_cast<const png_byte*>(pixels.values);
             for (int y = 0; y < pixels.height; ++y, row += pixels.row_bytes()) png_write_row(png_, row);
             png_write_end(png_, nullptr);
           });
  }

  const char* problem() const { return message_.text; }
  std::vector<unsigned char> take_bytes() { return std::move(bytes_); }

 private:
  static void append_bytes(png_structp png, png_bytep data, std::size_t size) {
    std::vector<unsigned char>& bytes = static_cast<PngWriter*>(png_get_io_ptr(png))->bytes_;
    try {
      bytes.insert(bytes.end(), data, data + size);
      return;
    } catch (const std::bad_alloc&) {}  // libpng must not jump out of the handler
    png_error(png, "out of memory");
  }

  void write_header(const IntegerPixels& pixels, int level, const char* description) {
    png_set_write_fn(png_, this, append_bytes, nullptr);
    png_set_compression_level(png_, level);
    const int colors = pixels.channels - (pixels.has_alpha ? 1 : 0);
    const int type = (colors > 1 ? PNG_COLOR_MASK_COLOR : 0) | (pixels.has_alpha ? PNG_COLOR_MASK_ALPHA : 0);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(pixels.width), static_cast<png_uint_32>(pixels.height),
                 pixels.bits, type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png_, info_, PNG_sRGB_INTENT_ABSOLUTE);
    if (*description != '\0') {
      char key[] = "Description";
      png_text text{};
      text.compression = PNG_TEXT_COMPRESSION_NONE;
      text.key = key;
      text.text = const_cast<char*>(description);  // libpng copies it
      png_set_text(png_, info_, &text, 1);
    }
    png_write_info(png_, info_);
    if (std::endian::native == std::endian::little && pixels.bits == 16) png_set_swap(png_);
  }

  std::vector<unsigned char> bytes_;
  PngMessage message_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

std::unique_ptr<ImageReader> open_png(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<PngReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

std::vector<unsigned char> encode_png(const IntegerPixels& pixels, int level, const std::string& description,
                                      std::string& problem) {
  PngWriter writer;
  if (writer.write(pixels, level, description)) return writer.take_bytes();
  problem = writer.problem();
  return {};
}

std::string png_version() { return png_get_libpng_ver(nullptr); }

}  // namespace sheaf
