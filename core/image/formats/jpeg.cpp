// The only file that includes libjpeg-turbo. After an error, a handler jumps back to setjmp() in run_jpeg(). The
// functions in between have no objects with destructors.
#include "core/image/formats/jpeg.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <new>
#include <utility>

#include <jpeglib.h>
//
#include <jerror.h>  // needs jpeglib.h

namespace sheaf {

namespace {

/// Usual progressive files have about 10 scans. Each scan takes time for all pixels, but may have only a few bytes.
constexpr int kMaxScans = 500;

/// Keeps the message of an error and the place to jump to.
struct JpegErrors : jpeg_error_mgr {
  std::jmp_buf target;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void jump_after_jpeg_error(j_common_ptr info, const char* message) {
  JpegErrors& errors = *static_cast<JpegErrors*>(info->err);
  std::snprintf(errors.message, sizeof(errors.message), "%s", message);
  std::longjmp(errors.target, 1);
}

[[noreturn]] void exit_after_jpeg_error(j_common_ptr info) {
  char message[JMSG_LENGTH_MAX];
  info->err->format_message(info, message);
  jump_after_jpeg_error(info, message);
}

/// libjpeg fills missing parts of damaged files with gray and only warns. Such files are rejected.
void handle_warning(j_common_ptr info, int /*level*/) {
  if (info->err->msg_code == JWRN_HIT_MARKER) jump_after_jpeg_error(info, kImageEndsEarly);
}

jpeg_error_mgr* initialized(JpegErrors& errors) {
  jpeg_std_error(&errors);
  errors.error_exit = exit_after_jpeg_error;
  errors.emit_message = handle_warning;
  return &errors;
}

/// Runs an action that calls libjpeg. Returns whether it succeeded.
template <class Action> bool run_jpeg(JpegErrors& errors, const Action& action) {
  if (setjmp(errors.target) != 0) return false;
  action();
  return true;
}

/// Passes the bytes of a file to libjpeg.
class JpegSource : public jpeg_source_mgr {
 public:
  explicit JpegSource(ImageSource file) : jpeg_source_mgr{}, file_(std::move(file)) {
    init_source = term_source = [](j_decompress_ptr) {};
    resync_to_restart = jpeg_resync_to_restart;
    fill_input_buffer = [](j_decompress_ptr info) -> boolean {
      return static_cast<JpegSource*>(info->src)->fill(info);
    };
    skip_input_data = [](j_decompress_ptr info, long count) {
      if (count > 0) static_cast<JpegSource*>(info->src)->skip(static_cast<std::size_t>(count));
    };
  }

 private:
  boolean fill(j_decompress_ptr info) {
    const std::uint64_t left = file_.size() - std::min(at_, file_.size());
    bytes_in_buffer = static_cast<std::size_t>(std::min<std::uint64_t>(buffer_.size(), left));
    next_input_byte = buffer_.data();
    if (left == 0 || !file_.read(at_, {buffer_.data(), bytes_in_buffer}))
      jump_after_jpeg_error(reinterpret_cast<j_common_ptr>(info), kImageEndsEarly);
    at_ += bytes_in_buffer;
    return TRUE;
  }

  void skip(std::size_t count) {
    const std::size_t buffered = std::min(count, bytes_in_buffer);
    next_input_byte += buffered;
    bytes_in_buffer -= buffered;
    at_ += count - buffered;
  }

  ImageSource file_;
  std::uint64_t at_ = 0;  ///< position after the buffer
  std::array<JOCTET, 1 << 14> buffer_;
};

class JpegReader final : public IntegerReader {
 public:
  explicit JpegReader(ImageSource source) : source_(std::move(source)) {}
  ~JpegReader() override { jpeg_destroy_decompress(&info_); }

  bool open(std::string& problem) {
    info_.err = initialized(errors_);
    if (!run_jpeg(errors_, [this] { read_header(); })) {
      problem = errors_.message;
      return false;
    }
    const bool has_inks = info_.out_color_space == JCS_CMYK;
    set_header(static_cast<int>(info_.image_width), static_cast<int>(info_.image_height), channel_names(), 8);
    // The coefficients of all scans, and those of black in addition
    if (jpeg_has_multiple_scans(&info_) != FALSE) header_.decoder_bytes = sizeof(JCOEF) + (has_inks ? 1 : 0);
    return true;
  }

  bool has_rows() const override { return true; }
  bool read_rows(int count, std::uint8_t* out, std::string& problem) override {
    const bool has_inks = info_.out_color_space == JCS_CMYK;
    std::vector<unsigned char> inks(has_inks ? 4 * std::size_t{info_.image_width} : 0);
    unsigned char* const row = has_inks ? inks.data() : nullptr;
    if (run_jpeg(errors_, [this, count, out, row] { read_scanlines(count, out, row); })) return true;
    problem = errors_.message;
    return false;
  }

 private:
  /// Four channels are colors of ink, which become RGB; two have no meaning.
  std::vector<std::string> channel_names() const {
    if (info_.num_components == 1) return {"Y"};
    if (info_.num_components == 2) return {"R", "G"};
    return {"R", "G", "B"};
  }

  void read_header() {
    jpeg_create_decompress(&info_);
    info_.src = &source_;
    progress_.progress_monitor = check_scans;
    info_.progress = &progress_;
    jpeg_read_header(&info_, TRUE);  // chooses CMYK for YCCK
  }

  static void check_scans(j_common_ptr info) {
    if (info->is_decompressor != FALSE && reinterpret_cast<j_decompress_ptr>(info)->input_scan_number > kMaxScans)
      jump_after_jpeg_error(info, "the file has too many scans");
  }

  bool decode(unsigned char* out, std::string& problem) override { return read_rows(header_.height, out, problem); }

  /// `inks`: memory for a row of CMYK; null: the file has other colors.
  void read_scanlines(int count, unsigned char* out, unsigned char* inks) {
    if (!is_started_) jpeg_start_decompress(&info_);
    is_started_ = true;
    const std::size_t row_values = header_.channels.size() * std::size_t{info_.image_width};
    for (int y = 0; y < count; ++y, out += row_values) {
      JSAMPROW row = inks != nullptr ? inks : out;
      jpeg_read_scanlines(&info_, &row, 1);
      if (inks != nullptr) convert_inks(inks, out);
    }
  }

  void convert_inks(const unsigned char* inks, unsigned char* out) const {
    for (JDIMENSION x = 0; x < info_.image_width; ++x, inks += 4, out += 3)
      for (int c = 0; c < 3; ++c) out[c] = static_cast<unsigned char>((inks[c] * inks[3] + 127) / 255);
  }

  JpegSource source_;
  JpegErrors errors_{};
  jpeg_progress_mgr progress_{};
  jpeg_decompress_struct info_{};
  bool is_started_ = false;
};

/// Collects the bytes that libjpeg writes.
class JpegDestination : public jpeg_destination_mgr {
 public:
  JpegDestination() : jpeg_destination_mgr{} {
    init_destination = [](j_compress_ptr info) { of(info).rewind(); };
    empty_output_buffer = [](j_compress_ptr info) -> boolean {
      of(info).append(info, of(info).buffer_.size());
      of(info).rewind();
      return TRUE;
    };
    term_destination = [](j_compress_ptr info) {
      of(info).append(info, of(info).buffer_.size() - of(info).free_in_buffer);
    };
  }

  std::vector<unsigned char> take_bytes() { return std::move(bytes_); }

 private:
  static JpegDestination& of(j_compress_ptr info) { return *static_cast<JpegDestination*>(info->dest); }

  void rewind() {
    next_output_byte = buffer_.data();
    free_in_buffer = buffer_.size();
  }

  void append(j_compress_ptr info, std::size_t count) {
    try {
      bytes_.insert(bytes_.end(), buffer_.data(), buffer_.data() + count);
      return;
    } catch (const std::bad_alloc&) {}  // the jump must not leave the handler
    jump_after_jpeg_error(reinterpret_cast<j_common_ptr>(info), "out of memory");
  }

  std::vector<unsigned char> bytes_;
  std::array<JOCTET, 1 << 14> buffer_;
};

class JpegWriter {
 public:
  JpegWriter() = default;
  ~JpegWriter() { jpeg_destroy_compress(&info_); }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;

  bool write(const IntegerPixels& pixels, int quality, const std::string& description) {
    info_.err = initialized(errors_);
    return run_jpeg(errors_, [&] {
      write_header(pixels, quality, description);
      const JSAMPLE* row = static_cast<const JSAMPLE*>(pixels.values);
      for (int y = 0; y < pixels.height; ++y, row += pixels.row_bytes()) {
        JSAMPROW rows = const_cast<JSAMPROW>(row);  // libjpeg does not write to it
        jpeg_write_scanlines(&info_, &rows, 1);
      }
      jpeg_finish_compress(&info_);
    });
  }

  const char* problem() const { return errors_.message; }
  std::vector<unsigned char> take_bytes() { return destination_.take_bytes(); }

 private:
  void write_header(const IntegerPixels& pixels, int quality, const std::string& description) {
    jpeg_create_compress(&info_);
    info_.dest = &destination_;
    info_.image_width = static_cast<JDIMENSION>(pixels.width);
    info_.image_height = static_cast<JDIMENSION>(pixels.height);
    info_.input_components = pixels.channels;
    info_.in_color_space = pixels.channels == 3 ? JCS_RGB : JCS_GRAYSCALE;
    jpeg_set_defaults(&info_);
    jpeg_set_quality(&info_, quality, TRUE);
    for (int c = 0; c < info_.num_components; ++c)
      info_.comp_info[c].h_samp_factor = info_.comp_info[c].v_samp_factor = 1;
    jpeg_start_compress(&info_, TRUE);
    if (!description.empty())
      jpeg_write_marker(&info_, JPEG_COM, reinterpret_cast<const JOCTET*>(description.data()),
                        static_cast<unsigned>(std::min<std::size_t>(description.size(), kMaxMarker)));
    jpeg_write_marker(&info_, JPEG_APP0 + 1, kSrgbExif.data(), static_cast<unsigned>(kSrgbExif.size()));
  }

  static constexpr std::size_t kMaxMarker = 65533;
  /// Exif (CIPA DC-008) in little-endian order: a directory with the offset of the Exif directory, and that directory
  /// with ColorSpace = sRGB.
  static constexpr std::array<JOCTET, 50> kSrgbExif{
      'E', 'x', 'i',  'f',  0, 0, 'I', 'I', 42, 0, 8,  0, 0, 0,               // header
      1,   0,   0x69, 0x87, 4, 0, 1,   0,   0,  0, 26, 0, 0, 0, 0, 0, 0, 0,   // Exif directory
      1,   0,   0x01, 0xa0, 3, 0, 1,   0,   0,  0, 1,  0, 0, 0, 0, 0, 0, 0};  // ColorSpace

  JpegErrors errors_{};
  JpegDestination destination_;
  jpeg_compress_struct info_{};
};

}  // namespace

std::unique_ptr<ImageReader> open_jpeg(ImageSource source, std::string& problem) {
  auto reader = std::make_unique<JpegReader>(std::move(source));
  if (!reader->open(problem)) return nullptr;
  return reader;
}

std::vector<unsigned char> encode_jpeg(const IntegerPixels& pixels, int quality, const std::string& description,
                                       std::string& problem) {
  JpegWriter writer;
  if (writer.write(pixels, quality, description)) return writer.take_bytes();
  problem = writer.problem();
  return {};
}

std::string jpeg_version() {
#define SHEAF_TEXT(x) #x
#define SHEAF_EXPANDED(x) SHEAF_TEXT(x)
  return SHEAF_EXPANDED(LIBJPEG_TURBO_VERSION);
#undef SHEAF_EXPANDED
#undef SHEAF_TEXT
}

}  // namespace sheaf
