// Textures of files that are read in bands of rows equal those of the same files read as a whole, from memory.
#include "core/image/formats/jpeg.h"
#include "core/image/image_rows.h"
#include "scene/compile/textures/texture_image.h"
#include "tests/support/contains.h"
#include "tests/support/files/image_files.h"

#include <doctest/doctest.h>

#include <cstring>

namespace sheaf::test_texture_rows {

namespace {

/// A texture of a file, or of its bytes.
std::shared_ptr<TiledImage> load(const std::filesystem::path& file, bool from_memory) {
  BitmapDescription bitmap;
  bitmap.file = file;
  if (from_memory) {
    const std::string bytes = read_bytes(file);
    bitmap.encoded = std::make_shared<const EncodedImage>(EncodedImage{{bytes.begin(), bytes.end()}, "image"});
  }
  return load_tiled_image(bitmap, {});
}

}  // namespace

TEST_CASE("texture rows: PNG and JPEG files") {
  const TemporaryFolder folder;
  Image image(1021, 1103, {"R", "G", "B"});  // 4.5 MB of texels, more than four bands
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i * i % 251) / 251;
  write_png(folder / "a.png", image);
  const StoredImage values = read_stored_image(folder / "a.png");
  std::string problem;
  const std::vector<unsigned char> jpeg =
      encode_jpeg({values.width, values.height, 3, false, 8, values.bytes.data()}, 90, "", problem);
  write_bytes(folder / "a.jpg", {jpeg.begin(), jpeg.end()});
  for (const char* const name : {"a.png", "a.jpg"}) {
    CAPTURE(std::string(name));
    CHECK(ImageRows::open(folder / name).has_value());
    const auto rows = load(folder / name, false), whole = load(folder / name, true);
    REQUIRE(rows->tiles.size() == whole->tiles.size());
    CHECK(rows->width == whole->width);
    CHECK(rows->format == whole->format);
    CHECK(std::memcmp(rows->tiles.data(), whole->tiles.data(), rows->tiles.size() * sizeof(TexelLine)) == 0);
  }
  write_bytes(folder / "a.jpg", {jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() / 2)});
  std::string message;
  try {
    load(folder / "a.jpg", false);
  } catch (const SceneError& error) { message = error.what(); }
  CHECK(test::contains(message, "a.jpg: cannot read the image: the file is damaged or ends too early"));
}

TEST_CASE("texture rows: other files are read as a whole") {
  const TemporaryFolder folder;
  write_pnm(folder / "a.pgm", 2, 1, 1, 255, {3, 4});
  CHECK(!ImageRows::open(folder / "a.pgm").has_value());
}

}  // namespace sheaf::test_texture_rows
