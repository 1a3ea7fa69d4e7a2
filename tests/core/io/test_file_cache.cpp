// The cache of file contents.
#include "core/io/file_cache.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <chrono>

namespace sheaf::test_file_cache {

namespace {

namespace fs = std::filesystem;

/// Reads files and counts how often.
struct Reader {
  std::string read(const fs::path& file, const std::string& key = "text") {
    return cached(file, key, [&] {
      ++count;
      return read_bytes(file);
    });
  }
  int count = 0;
};

}  // namespace

TEST_CASE("file cache: without a cache every call reads") {
  const TemporaryFolder folder;
  write_bytes(folder / "a", "one");
  Reader reader;
  CHECK(reader.read(folder / "a") == "one");
  CHECK(reader.read(folder / "a") == "one");
  CHECK(reader.count == 2);
  CHECK(FileCache::active() == nullptr);
}

TEST_CASE("file cache: files are read once per key until they change") {
  const TemporaryFolder folder;
  write_bytes(folder / "a", "one");
  write_bytes(folder / "b", "two");
  Reader reader;
  {
    FileCache cache;
    for (int i = 0; i < 3; ++i) {
      CHECK(reader.read(folder / "a") == "one");
      CHECK(reader.read(folder / "b") == "two");
      CHECK(reader.read(folder / "a", "other key") == "one");
    }
    CHECK(reader.count == 3);
    // Another size
    write_bytes(folder / "a", "longer");
    CHECK(reader.read(folder / "a") == "longer");
    CHECK(reader.count == 4);
    // Another time
    const auto time = fs::last_write_time(folder / "b");
    write_bytes(folder / "b", "six");
    fs::last_write_time(folder / "b", time + std::chrono::seconds(2));
    CHECK(reader.read(folder / "b") == "six");
    CHECK(reader.count == 5);
  }
  CHECK(reader.read(folder / "a") == "longer");
  CHECK(reader.count == 6);
}

TEST_CASE("file cache: unused contents are dropped") {
  const TemporaryFolder folder;
  write_bytes(folder / "a", "one");
  write_bytes(folder / "b", "two");
  Reader reader;
  FileCache cache;
  reader.read(folder / "a");
  reader.read(folder / "b");
  cache.drop_unused();
  reader.read(folder / "a");
  cache.drop_unused();
  CHECK(reader.count == 2);
  reader.read(folder / "a");
  CHECK(reader.count == 2);
  reader.read(folder / "b");
  CHECK(reader.count == 3);
}

TEST_CASE("file cache: values that callers change stay as they were read") {
  const TemporaryFolder folder;
  write_bytes(folder / "a", "one");
  Reader reader;
  FileCache cache;
  std::string text = reader.read(folder / "a");
  text += "!";
  CHECK(reader.read(folder / "a") == "one");
}

}  // namespace sheaf::test_file_cache
