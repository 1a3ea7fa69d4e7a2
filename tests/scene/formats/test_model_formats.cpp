// The table of the formats of models.
#include "scene/formats/model_formats.h"
#include "tests/support/capture.h"
#include "tests/support/contains.h"
#include "tests/support/files/model_files.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_model_formats {

using namespace test;

namespace {

using namespace std::string_literals;

/// A binary STL file with one triangle.
std::string binary_stl() {
  std::string bytes(80, ' ');
  bytes += "\x01\0\0\0"s;
  return bytes + std::string(50, '\0');
}

}  // namespace

TEST_CASE("model formats: every format is documented, and its extensions are on its page") {
  for (const ModelFormat& format : model_formats()) {
    CAPTURE(std::string(format.key));
    const std::string position = format.documentation;
    const std::size_t hash = position.find('#');
    const std::string page =
        read_bytes(std::filesystem::path(SHEAF_SOURCE_DIR) / "docs/scene-format" / position.substr(0, hash));
    CHECK(contains(page, "# " + position.substr(hash + 1) + "\n"));
    for (const std::string_view extension : format.known.extensions) CHECK(contains(page, std::string(extension)));
    CHECK(find_model_format("a" + std::string(format.known.extensions[0])) == &format);
  }
}

TEST_CASE("model formats: extensions are compared in any case") {
  CHECK(find_model_format("a/b.PLY") == &mesh_format("ply"));
  for (const char* const name : {"a.xml", "a.pbrt", "a", "obj", "a.obj.gz"}) CHECK(find_model_format(name) == nullptr);
  CHECK_THROWS_AS(mesh_format("gltf"), Error);
  CHECK(scene_model_extensions() == ".gltf, .glb, .dae, .fbx, .3ds, .off");
  CHECK(model_extensions() == scene_model_extensions() + ", .obj, .ply, .stl, .serialized");
}

TEST_CASE("model formats: the first bytes of a file decide whatever its name") {
  const TemporaryFolder folder;
  for (const auto& [bytes, name] : {std::pair{"glTF\x02\0\0\0"s, "a glTF model"},
                                    {"{\"asset\":{\"version\":\"2.0\"}}", "a glTF model"},
                                    {"solid x\nfacet normal 0 0 1\n", "an STL model"},
                                    {binary_stl(), "an STL model"},
                                    {"Kaydara FBX Binary  \0\x1a\0"s, "an FBX model"},
                                    {"; FBX 7.3.0 project file\n", "an FBX model"},
                                    {"<?xml version=\"1.0\"?>\n<COLLADA version=\"1.4.1\">", "a COLLADA model"},
                                    {"OFF\n3 1 3\n", "an OFF model"},
                                    {"ply\nformat ascii 1.0\n", "a PLY model"}}) {
    CAPTURE_BINDING(name);
    for (const char* const file : {"file", "file.xml", "file.pbrt"}) {
      write_bytes(folder / file, bytes);
      const FileFormat format = file_or_model_format(folder / file);
      CHECK(format.use == FileUse::kModel);
      CHECK(format.name == name);
      CHECK(format.by_content);
      CHECK(contains(error_of(folder / file), std::string("is ") + name + ", expected a scene"));
    }
  }
  write_bytes(folder / "a.GLB", "broken");
  CHECK(file_or_model_format(folder / "a.GLB").name == "a glTF model"s);
  CHECK_FALSE(file_or_model_format(folder / "a.GLB").by_content);
  write_bytes(folder / "a.obj", "\x89PNG\r\n\x1a\n");
  CHECK(contains(error_of(folder / "a.obj"), "is a PNG image, expected a scene"));
}

TEST_CASE("model formats: models from the standard input are recognized") {
  const auto key_of = [](const std::string& bytes) {
    const ModelFormat* const format = detect_model_format(bytes);
    return format == nullptr ? "" : std::string(format->key);
  };
  CHECK(key_of(cube_obj()) == "obj");
  CHECK(key_of("# a cube\n" + cube_off()) == "off");
  CHECK(key_of(cube_dae()) == "dae");
  CHECK(key_of(cube_fbx()) == "fbx");
  CHECK(key_of(cube_3ds()) == "3ds");
  CHECK(key_of("glTF\x02") == "glb");
  CHECK(key_of(" {}") == "gltf");
  CHECK(key_of("ply\n") == "ply");
  CHECK(key_of("solid a\n") == "stl");
  CHECK(key_of("\x1c\x04") == "serialized");
  for (const char* const scene : {"", "<scene/>", "Integrator \"path\"", "# comment", "Shape \"sphere\""})
    CHECK(key_of(scene).empty());
}

}  // namespace sheaf::test_model_formats
