// Encoding of TIFF files.
#include "core/image/formats/tiff.h"
#include "core/image/formats/tiff_file.h"

#include <algorithm>
#include <cstring>

namespace sheaf {

namespace {

/// Keeps the bytes that libtiff writes.
struct TiffOutput {
  std::vector<unsigned char> bytes;
  std::size_t at = 0;

  static tmsize_t read(thandle_t file, void* out, tmsize_t size) {
    TiffOutput& output = *static_cast<TiffOutput*>(file);
    if (size <= 0 || output.at >= output.bytes.size()) return 0;
    const std::size_t count = std::min(static_cast<std::size_t>(size), output.bytes.size() - output.at);
    std::memcpy(out, &output.bytes[output.at], count);
    output.at += count;
    return static_cast<tmsize_t>(count);
  }
  static tmsize_t write(thandle_t file, void* data, tmsize_t size) {
    TiffOutput& output = *static_cast<TiffOutput*>(file);
    if (size <= 0) return 0;
    const std::size_t end = output.at + static_cast<std::size_t>(size);
    try {
      if (output.bytes.size() < end) output.bytes.resize(end);
    } catch (const std::bad_alloc&) { return 0; }  // libtiff cannot pass exceptions on
    std::memcpy(&output.bytes[output.at], data, static_cast<std::size_t>(size));
    output.at = end;
    return size;
  }
  static toff_t seek(thandle_t file, toff_t offset, int origin) {
    TiffOutput& output = *static_cast<TiffOutput*>(file);
    const std::size_t from = origin == SEEK_CUR ? output.at : origin == SEEK_END ? output.bytes.size() : 0;
    return output.at = from + offset;
  }
  static toff_t size(thandle_t file) { return static_cast<TiffOutput*>(file)->bytes.size(); }
};

bool write_tiff(TIFF* file, const IntegerPixels& pixels, const std::string& description) {
  constexpr std::uint32_t kRowsPerStrip = 32;
  const auto set = [file](std::uint32_t tag, auto value) { return TIFFSetField(file, tag, value) == 1; };
  const int colors = pixels.channels - (pixels.has_alpha ? 1 : 0);
  const std::uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
  bool is_set = set(TIFFTAG_IMAGEWIDTH, pixels.width) && set(TIFFTAG_IMAGELENGTH, pixels.height) &&
                set(TIFFTAG_BITSPERSAMPLE, pixels.bits) && set(TIFFTAG_SAMPLESPERPIXEL, pixels.channels) &&
                set(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT) && set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) &&
                set(TIFFTAG_PHOTOMETRIC, colors == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB) &&
                set(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) && set(TIFFTAG_ROWSPERSTRIP, kRowsPerStrip) &&
                set(TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE) && set(TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  if (pixels.has_alpha) is_set = is_set && TIFFSetField(file, TIFFTAG_EXTRASAMPLES, 1, &alpha) == 1;
  if (!description.empty()) is_set = is_set && set(TIFFTAG_IMAGEDESCRIPTION, description.c_str());
  if (!is_set) return false;
  // The predictor overwrites the row
  std::vector<unsigned char> row(pixels.row_bytes());
  for (int y = 0; y < pixels.height; ++y) {
    std::memcpy(row.data(), static_cast<const unsigned char*>(pixels.values) + static_cast<std::size_t>(y) * row.size(),
                row.size());
    if (TIFFWriteScanline(file, row.data(), static_cast<std::uint32_t>(y), 0) < 0) return false;
  }
  return true;
}

/// Adds an Exif directory (CIPA DC-008) with ColorSpace = sRGB, and writes the main one, which refers to it.
bool write_tiff_directories(TIFF* file) {
  constexpr std::uint16_t kSrgb = 1;
  std::uint64_t at = 0;
  return TIFFSetField(file, TIFFTAG_EXIFIFD, at) == 1 && TIFFWriteDirectory(file) == 1 &&
         TIFFCreateEXIFDirectory(file) == 0 && TIFFSetField(file, EXIFTAG_COLORSPACE, kSrgb) == 1 &&
         TIFFWriteCustomDirectory(file, &at) == 1 && TIFFSetDirectory(file, 0) == 1 &&
         TIFFSetField(file, TIFFTAG_EXIFIFD, at) == 1 && TIFFWriteDirectory(file) == 1;
}

}  // namespace

std::vector<unsigned char> encode_tiff(const IntegerPixels& pixels, const std::string& description,
                                       std::string& problem) {
  TiffOutput output;
  TiffMessage message;
  TiffHandle file = open_tiff_file(output, message, "w");
  const bool is_written = file && write_tiff(file.get(), pixels, description) && write_tiff_directories(file.get());
  file.reset();
  if (is_written && message.text().empty()) return std::move(output.bytes);
  problem = message.text().empty() ? "out of memory" : message.text();
  return {};
}

}  // namespace sheaf
