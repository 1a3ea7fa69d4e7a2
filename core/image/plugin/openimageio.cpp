// Reading and encoding of image files: the only file that includes OpenImageIO. Defines the entry point of
// sheaf_image_io.so.
#include "core/image/image_library.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace sheaf {

namespace {

/// A file in memory that the library can read.
struct MemoryFile {
  explicit MemoryFile(std::vector<std::uint8_t> all) : bytes(std::move(all)), proxy(bytes.data(), bytes.size()) {}

  std::vector<std::uint8_t> bytes;
  OIIO::Filesystem::IOMemReader proxy;
};

/// A file in memory with a path that the library can write to.
class AnonymousFile {
 public:
  AnonymousFile() : descriptor_(memfd_create("image", MFD_CLOEXEC)) {}
  ~AnonymousFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  AnonymousFile(const AnonymousFile&) = delete;
  AnonymousFile& operator=(const AnonymousFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }
  std::vector<unsigned char> bytes() const {
    const off_t size = lseek(descriptor_, 0, SEEK_END);
    std::vector<unsigned char> all(size > 0 ? static_cast<std::size_t>(size) : 0);
    std::size_t read = 0;
    while (read < all.size()) {
      const ssize_t count = pread(descriptor_, all.data() + read, all.size() - read, static_cast<off_t>(read));
      if (count <= 0) return {};
      read += static_cast<std::size_t>(count);
    }
    return all;
  }

 private:
  int descriptor_;
};

class Reader final : public ImageReader {
 public:
  Reader(std::unique_ptr<OIIO::ImageInput> input, std::unique_ptr<MemoryFile> file)
      : file_(std::move(file)), input_(std::move(input)) {
    const OIIO::ImageSpec& spec = input_->spec();
    header_ = {spec.width,
               spec.height,
               spec.depth,
               spec.nchannels,
               spec.channelnames,
               spec.deep,
               spec.format == OIIO::TypeDesc::UINT8,
               !spec.format.is_floating_point(),
               spec.tile_width,
               spec.tile_height};
    // Versions of OpenImageIO up to 3.0 premultiply the colors of WebP files by alpha, whatever was asked for.
    is_premultiplied_ = std::string_view(input_->format_name()) == "webp" && spec.nchannels == 4 &&
                        spec.alpha_channel == 3 && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
  }

  const ImageHeader& header() const override { return header_; }
  bool read(std::uint8_t* out, std::string& remark) override { return read(OIIO::TypeDesc::UINT8, out, remark); }
  bool read(float* out, std::string& remark) override { return read(OIIO::TypeDesc::FLOAT, out, remark); }

 private:
  template <class Value> bool read(OIIO::TypeDesc type, Value* out, std::string& remark) {
    try {
      const bool complete = read_all(type, out);
      if (is_premultiplied_) divide_by_alpha(out);
      remark = input_->geterror();
      return complete;
    } catch (const std::logic_error& error) {
      remark = error.what();
      return false;
    }
  }

  template <class Value> bool read_all(OIIO::TypeDesc type, Value* out) {
    const OIIO::ImageSpec& spec = input_->spec();
    if (spec.tile_width > 0) return input_->read_image(0, 0, 0, spec.nchannels, type, out);
    // Reading several rows at once takes a buffer of 64 MB, or of a whole TIFF strip, for which the file may claim any
    // height.
    const auto row = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.nchannels);
    for (int y = 0; y < spec.height; ++y, out += row)
      if (!input_->read_scanline(spec.y + y, spec.z, type, out)) return false;
    return true;
  }

  /// Undoes the premultiplication of four-channel pixels.
  void divide_by_alpha(std::uint8_t* out) const {
    for (std::size_t i = 0; i < value_count(); i += 4)
      for (std::size_t c = 0; out[i + 3] != 0 && c < 3; ++c) {
        const unsigned alpha = out[i + 3], value = (out[i + c] * 255u + alpha / 2) / alpha;
        out[i + c] = static_cast<std::uint8_t>(std::min(value, 255u));
      }
  }
  void divide_by_alpha(float* out) const {
    for (std::size_t i = 0; i < value_count(); i += 4)
      for (std::size_t c = 0; out[i + 3] > 0 && c < 3; ++c) out[i + c] = std::min(out[i + c] / out[i + 3], 1.0f);
  }
  std::size_t value_count() const {
    return static_cast<std::size_t>(header_.width) * static_cast<std::size_t>(header_.height) * 4;
  }

  std::unique_ptr<MemoryFile> file_;  ///< the file that input_ reads; null: a file on the disk
  std::unique_ptr<OIIO::ImageInput> input_;
  ImageHeader header_;
  bool is_premultiplied_ = false;
};

class Library final : public ImageLibrary {
 public:
  Library() {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
  }

  std::unique_ptr<ImageReader> open(const std::string& path, const std::string& format, std::string& problem,
                                    std::vector<std::uint8_t> bytes) const override {
    OIIO::ImageSpec config, found;
    config.attribute("oiio:UnassociatedAlpha", 1);
    std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
    if (!input) {
      problem = OIIO::geterror();
      return nullptr;
    }
    std::unique_ptr<MemoryFile> file;
    if (!bytes.empty()) {
      file = std::make_unique<MemoryFile>(std::move(bytes));
      if (!input->set_ioproxy(&file->proxy)) {
        problem = "this build of OpenImageIO cannot read files of '" + format + "' from memory";
        return nullptr;
      }
    }
    try {
      if (!input->open(path, found, config)) {
        problem = input->geterror();
        return nullptr;
      }
    } catch (const std::logic_error& error) {  // for example std::length_error for a negative size
      problem = error.what();
      return nullptr;
    }
    return std::make_unique<Reader>(std::move(input), std::move(file));
  }

  std::vector<unsigned char> encode_tiff(const IntegerPixels& pixels, const std::string& description,
                                         std::string& problem) const override {
    const OIIO::TypeDesc type = pixels.bits == 16 ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT8;
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("tiff");
    const auto fail = [&](const std::string& why) {
      problem = why;
      return std::vector<unsigned char>();
    };
    if (!output) return fail(OIIO::geterror());
    // Through a proxy, OpenImageIO 2.4 writes TIFF files without their main directory.
    const AnonymousFile file;
    if (!output->open(file.path(), make_spec(pixels, type, description))) return fail(output->geterror());
    const bool written = output->write_image(type, pixels.values);
    if (!output->close() || !written) return fail(output->geterror());
    return file.bytes();
  }

 private:
  static OIIO::ImageSpec make_spec(const IntegerPixels& pixels, const OIIO::TypeDesc& type,
                                   const std::string& description) {
    OIIO::ImageSpec spec(pixels.width, pixels.height, pixels.channels, type);
    spec.alpha_channel = pixels.has_alpha ? pixels.channels - 1 : -1;
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("DateTime", "");  // otherwise the library writes the current time
    spec.attribute("compression", "zip");
    if (!description.empty()) spec.attribute("ImageDescription", description);
    return spec;
  }
};

}  // namespace

extern "C" [[gnu::visibility("default")]] const ImageLibrary* sheaf_image_library() {
  static const Library library;
  return &library;
}

}  // namespace sheaf
