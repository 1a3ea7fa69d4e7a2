// JPEG files of all kinds, and the markers of written ones.
#include "core/image/formats/jpeg.h"
#include "core/image/image.h"
#include "core/io/error.h"
#include "core/io/memory.h"
#include "tests/support/contains.h"
#include "tests/support/files/jpeg_files.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_jpeg {

namespace {

using test::contains;
using test::jpeg_file;
using test::JpegSample;

StoredImage read(const std::string& bytes) {
  return read_stored_image(EncodedImage{{bytes.begin(), bytes.end()}, "a.jpg"});
}

/// 21 x 18 pixels of slow waves.
JpegSample sample(J_COLOR_SPACE given, J_COLOR_SPACE stored, int channels) {
  JpegSample made;
  made.width = 21;
  made.height = 18;
  made.given = given;
  made.stored = stored;
  made.channels = channels;
  for (int y = 0; y < made.height; ++y)
    for (int x = 0; x < made.width; ++x)
      for (int c = 0; c < channels; ++c)
        made.values.push_back(static_cast<unsigned char>(std::lround(128 + 60 * std::sin(0.1 * x + 0.07 * y + c))));
  return made;
}

/// The largest difference of the bytes of an image.
int max_difference(const std::vector<std::uint8_t>& a, const std::vector<unsigned char>& b) {
  REQUIRE(a.size() == b.size());
  int difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference = std::max(difference, std::abs(int{a[i]} - int{b[i]}));
  return difference;
}

std::string error_of(const std::string& bytes) {
  try {
    (void)read(bytes);
  } catch (const SceneError& error) { return error.what(); }
  return "";
}

}  // namespace

TEST_CASE("JPEG: gray, YCbCr and RGB, with and without subsampling, progressive or not") {
  struct Kind {
    J_COLOR_SPACE given, stored;
    int channels, sampling, tolerance;
    bool adobe_marker;
  };
  for (const Kind& kind : {Kind{JCS_GRAYSCALE, JCS_GRAYSCALE, 1, 1, 2, false}, Kind{JCS_RGB, JCS_YCbCr, 3, 1, 3, false},
                           Kind{JCS_RGB, JCS_YCbCr, 3, 2, 8, false}, Kind{JCS_RGB, JCS_RGB, 3, 1, 2, true}}) {
    JpegSample made = sample(kind.given, kind.stored, kind.channels);
    made.sampling = kind.sampling;
    made.adobe_marker = kind.adobe_marker;
    const StoredImage image = read(jpeg_file(made));
    CHECK(image.width == 21);
    CHECK(image.height == 18);
    CHECK(image.channels ==
          (kind.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"}));
    CHECK(max_difference(image.bytes, made.values) <= kind.tolerance);
    made.progressive = true;
    CHECK(read(jpeg_file(made)).bytes == image.bytes);
  }
}

TEST_CASE("JPEG: inks become colors, each multiplied by black, as Adobe inverts them") {
  for (const J_COLOR_SPACE stored : {JCS_CMYK, JCS_YCCK}) {
    for (const bool adobe_marker : {false, true}) {
      if (stored == JCS_YCCK && !adobe_marker) continue;  // the marker identifies YCCK
      JpegSample made = sample(JCS_CMYK, stored, 4);
      made.adobe_marker = adobe_marker;
      std::vector<unsigned char> expected;
      for (std::size_t i = 0; i < made.values.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c)
          expected.push_back(static_cast<unsigned char>(std::lround(made.values[i + c] * made.values[i + 3] / 255.0)));
      const StoredImage image = read(jpeg_file(made));
      CHECK(image.channels == std::vector<std::string>{"R", "G", "B"});
      CHECK(max_difference(image.bytes, expected) <= 6);
      made.progressive = true;
      CHECK(read(jpeg_file(made)).bytes == image.bytes);
    }
  }
  // One color, which is exact: the products are 40, 40.4 and 40.8
  JpegSample flat = sample(JCS_CMYK, JCS_CMYK, 4);
  for (std::size_t i = 0; i < flat.values.size(); ++i)
    flat.values[i] = static_cast<unsigned char>(i % 4 == 3 ? 51 : 200 + 2 * (i % 4));
  const StoredImage image = read(jpeg_file(flat));
  CHECK(int{image.bytes[0]} == 40);
  CHECK(int{image.bytes[1]} == 40);
  CHECK(int{image.bytes[2]} == 41);
}

TEST_CASE("JPEG: truncated files and files with many scans are errors") {
  JpegSample made = sample(JCS_RGB, JCS_YCbCr, 3);
  for (const bool progressive : {false, true}) {
    made.progressive = progressive;
    const std::string bytes = jpeg_file(made);
    for (std::size_t size = 4; size < bytes.size(); ++size) {
      CAPTURE(size);
      CHECK(contains(error_of(bytes.substr(0, size)),
                     "a.jpg: cannot read the image: the file is damaged or ends too early"));
    }
    // Without the end of the last scan, but with the marker of the end
    CHECK(contains(error_of(bytes.substr(0, bytes.size() - 40) + "\xff\xd9"), "the file is damaged or ends too early"));
  }
  CHECK(error_of("\xff\xd8\xff\xff") == "a.jpg: cannot read the image: the file is damaged or ends too early");
  // Repeat the first scan, up to the tables of the next one
  const std::string bytes = jpeg_file(made);
  const std::size_t begin = bytes.find("\xff\xda"), end = bytes.find("\xff\xc4", begin);
  const std::string scan = bytes.substr(begin, end - begin);
  const auto with_scans = [&](int count) {
    std::string longer = bytes.substr(0, end);
    for (int i = 0; i < count; ++i) longer += scan;
    return longer + bytes.substr(end);
  };
  CHECK(error_of(with_scans(100)).empty());
  CHECK(error_of(with_scans(600)) == "a.jpg: cannot read the image: the file has too many scans");
}

TEST_CASE("JPEG: the coefficients of progressive files count as memory") {
  JpegSample made;
  made.width = made.height = 2000;
  made.given = made.stored = JCS_GRAYSCALE;
  made.channels = 1;
  made.values.assign(std::size_t{2000} * 2000, 100);
  const double allowed = 2 * 2000.0 * 2000.0;  // bytes; the progressive file needs 3 per pixel
  const std::string plain = jpeg_file(made);
  made.progressive = true;
  const std::string progressive = jpeg_file(made);
  const MemoryFraction fraction(allowed / available_memory());
  CHECK(read(plain).width == 2000);
  CHECK_THROWS_WITH_AS((void)read(progressive), doctest::Contains("a.jpg"), Error);
}

TEST_CASE("JPEG: written files have no subsampling, a comment and the color space of Exif") {
  const JpegSample made = sample(JCS_RGB, JCS_YCbCr, 3);
  const IntegerPixels pixels{21, 18, 3, false, 8, made.values.data()};
  std::string problem;
  const auto written = [&](int quality, const std::string& description) {
    const std::vector<unsigned char> bytes = encode_jpeg(pixels, quality, description, problem);
    return std::string(bytes.begin(), bytes.end());
  };
  const std::string file = written(95, "stopped");
  CHECK(problem.empty());
  CHECK(file == written(95, "stopped"));
  CHECK(max_difference(read(file).bytes, made.values) <= 6);
  // Baseline, 8 bits, 18 x 21 pixels, three channels with sampling factors of 1
  CHECK(file.find(std::string("\xff\xc0\0\x11\x8\0\x12\0\x15\3\1\x11\0\2\x11\1\3\x11\1", 19)) != std::string::npos);
  CHECK(file.find(std::string("\xff\xfe\0\x09stopped", 11)) != std::string::npos);
  CHECK(written(95, "").find("\xff\xfe") == std::string::npos);
  CHECK(contains(file, std::string("\xff\xe1\0\x34"
                                   "Exif\0\0II*\0",
                                   14)));
  // ColorSpace, tag 0xa001, is one number of 16 bits: 1, sRGB
  CHECK(contains(file, std::string("\x01\0\x01\xa0\3\0\1\0\0\0\1\0\0\0\0\0\0\0", 18)));
  // The first step of the first quantization table: 16 at quality 50
  const std::string table("\xff\xdb\0\x43\0", 5);
  const auto first_step = [&](int quality) {
    const std::string bytes = written(quality, "");
    return int{bytes[bytes.find(table) + table.size()]};
  };
  CHECK(first_step(50) == 16);
  CHECK(first_step(95) == 2);
  CHECK(first_step(100) == 1);
  // More bytes than libjpeg's buffer
  std::vector<unsigned char> noise(3 * 300 * 200);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<unsigned char>(i * i * 2654435761u >> 13);
  const std::vector<unsigned char> large = encode_jpeg({300, 200, 3, false, 8, noise.data()}, 100, "", problem);
  CHECK(large.size() > 65536);
  CHECK(max_difference(read({large.begin(), large.end()}).bytes, noise) <= 8);
  CHECK(encode_jpeg({70000, 1, 3, false, 8, noise.data()}, 95, "", problem).empty());
  CHECK(contains(problem, "65500"));
}

}  // namespace sheaf::test_jpeg
