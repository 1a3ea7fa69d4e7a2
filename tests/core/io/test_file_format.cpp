// Detection of file formats by content and by file name.
#include "core/io/file_format.h"
#include "tests/support/capture.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_file_format {

namespace {

using namespace std::string_literals;

}  // namespace

TEST_CASE("file format: the first bytes decide whatever the file name") {
  const TemporaryFolder folder;
  struct Case {
    std::string bytes;
    FileUse use;
    const char* name;
  };
  const Case cases[] = {{"#usda 1.0\n", FileUse::kModel, "a USD scene"},
                        {"PXR-USDC\0\0"s, FileUse::kModel, "a USD scene"},
                        {"BLENDER-v300", FileUse::kModel, "a Blender file"},
                        {"Ogawa\xff", FileUse::kModel, "an Alembic file"},
                        {" BDV\0\0\0\0\xe0"s, FileUse::kScenePart, "an OpenVDB file"},
                        {"v/1\x01\x02\0\0\0"s, FileUse::kImage, "an OpenEXR image"},
                        {"\x89PNG\r\n\x1a\n", FileUse::kImage, "a PNG image"},
                        {"\xff\xd8\xff\xe0", FileUse::kImage, "a JPEG image"},
                        {"#?RADIANCE\n", FileUse::kImage, "a Radiance image"},
                        {"NanoVDB2", FileUse::kScenePart, "a NanoVDB file"},
                        {"PK\x03\x04", FileUse::kArchive, "a ZIP archive"},
                        {"\x1f\x8b\x08", FileUse::kArchive, "a compressed file"},
                        {"", FileUse::kEmpty, "empty"}};
  for (const Case& each : cases)
    for (const char* const name : {"file", "file.xml", "file.pbrt"}) {
      CAPTURE(std::string(each.name));
      write_bytes(folder / name, each.bytes);
      const FileFormat format = file_format(folder / name);
      CHECK(format.use == each.use);
      CHECK(format.name == each.name);
      CHECK(format.by_content);
    }
}

TEST_CASE("file format: the extension decides for undecided bytes that cannot be a scene") {
  const TemporaryFolder folder;
  for (const auto& [name, expected] : {std::pair{"a.usdz", "a USD scene"},
                                       {"a.vdb", "an OpenVDB file"},
                                       {"a.abc", "an Alembic file"},
                                       {"a.exr", "an OpenEXR image"},
                                       {"a.png", "a PNG image"},
                                       {"a.mtl", "a material library"}}) {
    CAPTURE_BINDING(name);
    write_bytes(folder / name, "broken");
    const FileFormat format = file_format(folder / name);
    CHECK(format.name == expected);
    CHECK_FALSE(format.by_content);
    write_bytes(folder / name, "\xef\xbb\xbf <scene/>");
    CHECK(file_format(folder / name).use == FileUse::kUnknown);
  }
  // Archives that contain another format.
  write_bytes(folder / "b.usdz", "PK\x03\x04");
  CHECK(file_format(folder / "b.usdz").name == "a USD scene");
  for (const char* const name : {"c.xml", "c.pbrt", "c.obj", "c.ply", "c.serialized", "c"}) {
    write_bytes(folder / name, "anything else");
    CHECK(file_format(folder / name).use == FileUse::kUnknown);
  }
  CHECK(file_format(folder / "gone").use == FileUse::kUnknown);
  CHECK(file_format(folder.path()).use == FileUse::kUnknown);
}

}  // namespace sheaf::test_file_format
