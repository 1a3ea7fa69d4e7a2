// Bytes of image files: reading in any order, across the buffer, and after the file has changed.
#include "core/image/image_source.h"
#include "core/io/error.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_image_source {

namespace {

/// Numbers that do not repeat within a buffer.
unsigned char byte_at(std::uint64_t i) { return static_cast<unsigned char>(i * 7 + i / 256); }

std::string make_bytes(std::size_t count) {
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) bytes += static_cast<char>(byte_at(i));
  return bytes;
}

constexpr std::size_t kBuffer = 1 << 14, kSize = 3 * kBuffer + 100;

}  // namespace

TEST_CASE("image source: bytes beyond the end are 0, in files and in memory") {
  const TemporaryFolder folder;
  write_bytes(folder / "a", "abc");
  const EncodedImage encoded{{'a', 'b', 'c'}, "name"};
  ImageSource file(folder / "a"), memory(encoded);
  CHECK(memory.memory() == &encoded);
  CHECK(file.memory() == nullptr);
  for (ImageSource* const source : {&file, &memory}) {
    CHECK(source->size() == 3);
    std::array<unsigned char, 3> out{9, 9, 9};
    CHECK(source->read(1, out));
    CHECK(out == std::array<unsigned char, 3>{'b', 'c', 0});
    CHECK(source->read(7, out));
    CHECK(out == std::array<unsigned char, 3>{0, 0, 0});
    CHECK(source->read(0, out));
    CHECK(out == std::array<unsigned char, 3>{'a', 'b', 'c'});
  }
}

TEST_CASE("image source: files that are missing or become shorter") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH_AS(ImageSource(folder / "none"), doctest::Contains("cannot be opened"), SceneError);
  write_bytes(folder / "a", make_bytes(kSize));
  ImageSource source(folder / "a");
  ImageStream stream(ImageSource(folder / "a")), fresh(ImageSource(folder / "a")), whole(ImageSource(folder / "a"));
  CHECK(stream.get() == byte_at(0));
  std::filesystem::resize_file(folder / "a", 10);
  std::vector<unsigned char> out(kSize);
  CHECK(source.read(0, {out.data(), 10}));
  CHECK_FALSE(source.read(0, {out.data(), 11}));
  CHECK_FALSE(whole.read(out));
  CHECK(fresh.get() == -1);
  CHECK_FALSE(stream.read({out.data(), kBuffer + 1}));
}

TEST_CASE("image stream: single bytes and blocks across the buffer") {
  const TemporaryFolder folder;
  write_bytes(folder / "a", make_bytes(kSize));
  ImageStream stream(ImageSource(folder / "a"));
  CHECK(stream.size() == kSize);
  std::uint64_t at = 0;
  const auto check_read = [&](std::size_t count) {
    std::vector<unsigned char> out(count);
    CHECK(stream.position() == at);
    REQUIRE(stream.read(out));
    bool is_equal = true;
    for (std::size_t i = 0; i < count; ++i) is_equal = is_equal && out[i] == byte_at(at + i);
    CHECK(is_equal);
    at += count;
  };
  const auto check_get = [&] {
    CHECK(stream.peek() == byte_at(at));
    CHECK(stream.get() == byte_at(at));
    ++at;
    CHECK(stream.position() == at);
  };
  check_get();
  check_read(5);
  check_read(kBuffer - 7);  // up to the last byte of the buffer
  check_get();
  check_get();
  check_read(kBuffer - 2);  // across the end of the buffer
  check_get();
  stream.seek(at = 3);
  check_get();
  check_read(2 * kBuffer);  // more than a buffer
  check_get();
  stream.seek(at = kSize - 2);
  check_get();
  check_get();
  CHECK(stream.get() == -1);
  CHECK(stream.peek() == -1);
  std::array<unsigned char, 1> out{};
  CHECK_FALSE(stream.read(out));
  stream.seek(kSize + 5);
  CHECK(stream.get() == -1);
  CHECK_FALSE(stream.read(out));
  stream.seek(at = kSize - kBuffer);
  check_read(kBuffer);
}

}  // namespace sheaf::test_image_source
