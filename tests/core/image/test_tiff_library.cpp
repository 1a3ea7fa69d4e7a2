// TIFF files that libtiff writes: compression, strips, tiles, planes, byte orders and colors; and the tags of files
// that Sheaf writes.
#include "core/image/formats/tiff.h"
#include "core/image/image.h"
#include "core/io/error.h"
#include "tests/support/contains.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace sheaf::test_tiff_library {

namespace {

using test::contains;

/// How libtiff stores an image of 37 x 21 pixels.
struct Storage {
  const char* mode = "wl";  ///< byte order, 8 for BigTIFF
  std::uint16_t bits = 8, samples = 3, format = SAMPLEFORMAT_UINT;
  std::uint16_t photometric = PHOTOMETRIC_RGB, compression = COMPRESSION_NONE, predictor = PREDICTOR_NONE;
  std::uint16_t planes = PLANARCONFIG_CONTIG, orientation = ORIENTATION_TOPLEFT;
  bool is_tiled = false;
};
constexpr std::uint32_t kWidth = 37, kHeight = 21, kTile = 16, kRowsPerStrip = 16;

/// A smooth value, so that lossy compression keeps it; different in each channel.
int level(std::uint32_t x, std::uint32_t y, std::uint32_t c, int max) {
  return static_cast<int>(x * 3 + y * 2 + c * 40) * max / 255;
}

/// The value as libtiff takes it, at the end of the row.
void append_sample(std::string& row, const Storage& storage, int value) {
  if (storage.format == SAMPLEFORMAT_IEEEFP) {
    const float number = static_cast<float>(value);
    row.append(reinterpret_cast<const char*>(&number), sizeof number);
  } else {
    row.append(reinterpret_cast<const char*>(&value), storage.bits / 8);
  }
}

int max_of(const Storage& storage) { return storage.bits == 16 ? 65535 : 255; }

/// A block of pixels from a corner of the image, of one plane or of all samples; repeats the last pixels outside the
/// image.
std::string block(const Storage& storage, std::uint32_t x0, std::uint32_t y0, std::uint32_t columns, std::uint32_t rows,
                  std::uint16_t plane) {
  const bool is_separate = storage.planes == PLANARCONFIG_SEPARATE;
  std::string bytes;
  for (std::uint32_t y = y0; y < y0 + rows; ++y)
    for (std::uint32_t x = x0; x < x0 + columns; ++x)
      for (std::uint32_t c = is_separate ? plane : 0; c < (is_separate ? plane + 1u : storage.samples); ++c)
        append_sample(bytes, storage, level(std::min(x, kWidth - 1), std::min(y, kHeight - 1), c, max_of(storage)));
  return bytes;
}

void write_by_libtiff(const std::filesystem::path& path, const Storage& storage) {
  TIFF* const file = TIFFOpen(path.c_str(), storage.mode);
  REQUIRE(file != nullptr);
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, storage.bits);
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, storage.samples);
  TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, storage.format);
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC, storage.photometric);
  TIFFSetField(file, TIFFTAG_PLANARCONFIG, storage.planes);
  TIFFSetField(file, TIFFTAG_ORIENTATION, storage.orientation);
  TIFFSetField(file, TIFFTAG_COMPRESSION, storage.compression);
  if (storage.predictor != PREDICTOR_NONE) TIFFSetField(file, TIFFTAG_PREDICTOR, storage.predictor);
  if (storage.compression == COMPRESSION_JPEG) {
    TIFFSetField(file, TIFFTAG_JPEGQUALITY, 100);
    TIFFSetField(file, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  }
  const std::uint16_t planes = storage.planes == PLANARCONFIG_SEPARATE ? storage.samples : std::uint16_t{1};
  if (storage.is_tiled) {
    TIFFSetField(file, TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(file, TIFFTAG_TILELENGTH, kTile);
  } else {
    TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, kRowsPerStrip);
  }
  bool is_written = true;
  for (std::uint16_t plane = 0; plane < planes; ++plane)
    for (std::uint32_t y = 0; y < kHeight; y += storage.is_tiled ? kTile : 1) {
      if (!storage.is_tiled) {
        std::string row = block(storage, 0, y, kWidth, 1, plane);
        is_written = is_written && TIFFWriteScanline(file, row.data(), y, plane) >= 0;
      }
      for (std::uint32_t x = 0; storage.is_tiled && x < kWidth; x += kTile) {
        std::string tile = block(storage, x, y, kTile, kTile, plane);
        is_written = is_written && TIFFWriteTile(file, tile.data(), x, y, 0, plane) >= 0;
      }
    }
  TIFFClose(file);
  REQUIRE(is_written);
}

/// Largest difference of a file from the image, in levels.
double max_error(const StoredImage& image, const Storage& storage) {
  const std::size_t channels = image.channels.size();
  REQUIRE(image.width == int{kWidth});
  REQUIRE(image.height == int{kHeight});
  const int max = max_of(storage);
  double error = 0;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x)
      for (std::uint32_t c = 0; c < channels; ++c) {
        const std::size_t i = (y * kWidth + x) * channels + c;
        const double scale = storage.format == SAMPLEFORMAT_IEEEFP ? 1 : max;
        const double value = image.bytes.empty() ? double{image.floats[i]} * scale : image.bytes[i];
        error = std::max(error, std::abs(value - level(x, y, c, max)));
      }
  return error;
}

}  // namespace

TEST_CASE("TIFF by libtiff: every compression in strips, tiles and planes of either byte order") {
  const TemporaryFolder folder;
  const auto file = folder / "a.tif";
  for (const char* const mode : {"wl", "wb", "w8l", "w8b"})
    for (const std::uint16_t compression :
         {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS})
      for (const std::uint16_t planes : {PLANARCONFIG_CONTIG, PLANARCONFIG_SEPARATE})
        for (const bool is_tiled : {false, true})
          for (const int bits : {8, 16, 32}) {
            Storage storage{.mode = mode, .compression = compression, .planes = planes, .is_tiled = is_tiled};
            storage.bits = static_cast<std::uint16_t>(bits);
            if (bits == 32) storage.format = SAMPLEFORMAT_IEEEFP;
            const bool may_predict = compression == COMPRESSION_LZW || compression == COMPRESSION_ADOBE_DEFLATE;
            if (may_predict && bits < 32) storage.predictor = PREDICTOR_HORIZONTAL;
            // libtiff 4.5 swaps the bytes of big-endian floats once too often
            if (may_predict && bits == 32 && std::string(mode).back() == 'l')
              storage.predictor = PREDICTOR_FLOATINGPOINT;
            INFO(std::string(mode), " compression ", compression, " planes ", planes, " tiles ", is_tiled, " bits ",
                 bits);
            write_by_libtiff(file, storage);
            const StoredImage image = read_stored_image(file);
            CHECK(image.channels == std::vector<std::string>{"R", "G", "B"});
            CHECK(image.integers == (bits < 32));
            CHECK(max_error(image, storage) < (bits == 16 ? 0.01 : 1e-6));
          }
}

TEST_CASE("TIFF by libtiff: JPEG, YCbCr and gray keep their colors and orientation") {
  const TemporaryFolder folder;
  const auto file = folder / "a.tif";
  Storage storage{.compression = COMPRESSION_JPEG};
  for (const bool is_tiled : {false, true}) {
    CAPTURE(is_tiled);
    storage.is_tiled = is_tiled;
    // RGB is read as rows, YCbCr and gray are converted by libtiff
    for (const std::uint16_t photometric : {PHOTOMETRIC_RGB, PHOTOMETRIC_YCBCR, PHOTOMETRIC_MINISBLACK}) {
      CAPTURE(photometric);
      storage.photometric = photometric;
      storage.samples = photometric == PHOTOMETRIC_MINISBLACK ? 1 : 3;
      for (const std::uint16_t orientation : {ORIENTATION_TOPLEFT, ORIENTATION_BOTRIGHT}) {
        storage.orientation = orientation;
        write_by_libtiff(file, storage);
        StoredImage image = read_stored_image(file);
        REQUIRE(image.bytes.size() == kWidth * kHeight * image.channels.size());
        CHECK(image.channels.size() == storage.samples);
        if (orientation == ORIENTATION_BOTRIGHT) {
          const std::size_t channels = image.channels.size();
          for (std::size_t i = 0, k = kWidth * kHeight - 1; i < k; ++i, --k)
            std::swap_ranges(&image.bytes[i * channels], &image.bytes[i * channels] + channels,
                             &image.bytes[k * channels]);
        }
        CHECK(max_error(image, storage) < 6);
        CHECK(read_image(file).data[5 * storage.samples] ==
              near(read_stored_image(file).bytes[5 * storage.samples] / 255.0f));
      }
    }
  }
}

TEST_CASE("TIFF by libtiff: palettes of 8 bits, and CMYK of 16") {
  const TemporaryFolder folder;
  const auto file = folder / "a.tif";
  write_by_libtiff(file, {.bits = 16, .samples = 4, .photometric = PHOTOMETRIC_SEPARATED});
  const StoredImage cmyk = read_stored_image(file);
  REQUIRE(cmyk.floats.size() == kWidth * kHeight * 3);
  const auto ink = [](std::uint32_t c) { return 1 - level(7, 5, c, 65535) / 65535.0; };
  for (std::uint32_t c = 0; c < 3; ++c) CHECK(cmyk.floats[(5 * kWidth + 7) * 3 + c] == near(ink(c) * ink(3), 1e-4));
  // Palette
  TIFF* const indexed = TIFFOpen(file.c_str(), "w");
  std::array<std::uint16_t, 256> red{}, green{}, blue{};
  for (std::size_t i = 0; i < 256; ++i) {
    red[i] = static_cast<std::uint16_t>(257 * (255 - i));
    green[i] = static_cast<std::uint16_t>(257 * i);
    blue[i] = static_cast<std::uint16_t>(257 * (i / 2));
  }
  TIFFSetField(indexed, TIFFTAG_IMAGEWIDTH, 2);
  TIFFSetField(indexed, TIFFTAG_IMAGELENGTH, 1);
  TIFFSetField(indexed, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(indexed, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_PALETTE);
  TIFFSetField(indexed, TIFFTAG_COLORMAP, red.data(), green.data(), blue.data());
  unsigned char row[] = {0, 200};
  TIFFWriteScanline(indexed, row, 0, 0);
  TIFFClose(indexed);
  CHECK(read_stored_image(file).bytes == std::vector<std::uint8_t>{255, 0, 0, 55, 200, 100});
}

TEST_CASE("TIFF by libtiff: CIE L*a*b* and LogLuv become RGB of 8 bits") {
  const TemporaryFolder folder;
  const auto file = folder / "a.tif";
  const auto read_white = [&](std::uint16_t photometric, std::uint16_t compression, int bits, void* row) {
    TIFF* const out = TIFFOpen(file.c_str(), "w");
    TIFFSetField(out, TIFFTAG_IMAGEWIDTH, 1);
    TIFFSetField(out, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(out, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(out, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(out, TIFFTAG_COMPRESSION, compression);
    TIFFSetField(out, TIFFTAG_PHOTOMETRIC, photometric);
    if (compression == COMPRESSION_SGILOG) TIFFSetField(out, TIFFTAG_SGILOGDATAFMT, SGILOGDATAFMT_FLOAT);
    CHECK(TIFFWriteScanline(out, row, 0, 0) == 1);
    TIFFClose(out);
    const StoredImage image = read_stored_image(file);
    CHECK(image.channels == std::vector<std::string>{"R", "G", "B"});
    REQUIRE(image.bytes.size() == 3);
    return std::array<int, 3>{image.bytes[0], image.bytes[1], image.bytes[2]};
  };
  std::array<std::uint8_t, 3> lab{255, 0, 0};
  std::array<float, 3> xyz{0.9505f, 1, 1.089f};
  for (const std::array<int, 3>& white : {read_white(PHOTOMETRIC_CIELAB, COMPRESSION_NONE, 8, lab.data()),
                                          read_white(PHOTOMETRIC_LOGLUV, COMPRESSION_SGILOG, 16, xyz.data())})
    for (const int value : white) CHECK(value > 200);  // libtiff keeps the white point
}

TEST_CASE("TIFF by libtiff: tags of files that Sheaf writes") {
  const TemporaryFolder folder;
  const std::vector<std::uint16_t> values(40 * 4, 1000);
  for (const bool has_alpha : {false, true}) {
    std::string problem;
    const IntegerPixels pixels{1, 40, has_alpha ? 4 : 3, has_alpha, 16, values.data()};
    const std::vector<unsigned char> bytes = encode_tiff(pixels, "text", problem);
    write_bytes(folder / "a.tif", std::string(bytes.begin(), bytes.end()));
    TIFF* const file = TIFFOpen((folder / "a.tif").c_str(), "r");
    REQUIRE(file != nullptr);
    const auto field = [file](std::uint32_t tag) {
      std::uint16_t value = 0;
      return TIFFGetField(file, tag, &value) == 1 ? int{value} : -1;
    };
    CHECK(field(TIFFTAG_COMPRESSION) == COMPRESSION_ADOBE_DEFLATE);
    CHECK(field(TIFFTAG_PREDICTOR) == PREDICTOR_HORIZONTAL);
    CHECK(field(TIFFTAG_ORIENTATION) == ORIENTATION_TOPLEFT);
    CHECK(field(TIFFTAG_PHOTOMETRIC) == PHOTOMETRIC_RGB);
    CHECK(TIFFNumberOfStrips(file) == 2);
    CHECK(TIFFNumberOfDirectories(file) == 1);
    char* description = nullptr;
    CHECK(TIFFGetField(file, TIFFTAG_IMAGEDESCRIPTION, &description) == 1);
    CHECK(description == std::string("text"));
    std::uint16_t extra = 0, *kinds = nullptr;
    CHECK(TIFFGetField(file, TIFFTAG_EXTRASAMPLES, &extra, &kinds) == (has_alpha ? 1 : 0));
    if (has_alpha && extra > 0) CHECK(kinds[0] == EXTRASAMPLE_UNASSALPHA);
    // Exif: the color space is sRGB
    std::uint64_t exif = 0;
    REQUIRE(TIFFGetField(file, TIFFTAG_EXIFIFD, &exif) == 1);
    REQUIRE(TIFFReadEXIFDirectory(file, exif) == 1);
    CHECK(field(EXIFTAG_COLORSPACE) == 1);
    TIFFClose(file);
  }
}

}  // namespace sheaf::test_tiff_library
