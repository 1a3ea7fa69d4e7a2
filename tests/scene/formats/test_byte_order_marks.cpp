// Every kind of text file with a byte order mark: a UTF-8 mark changes nothing, UTF-16 and UTF-32 marks are errors.
#include "core/io/byte_order_mark.h"
#include "scene/compile/compile.h"
#include "scene/formats/curve_file.h"
#include "scene/formats/ellipsoids.h"
#include "scene/formats/hair_file.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/mtl.h"
#include "scene/xml/spectrum_text.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <functional>
#include <vector>

namespace sheaf::test_byte_order_marks {

using namespace test;

namespace {

const std::string kMark = "\xef\xbb\xbf";

/// A kind of text file: an example, and a reader that dumps its contents.
struct TextKind {
  std::string name, text;
  std::function<std::string(const std::filesystem::path&)> read;
};

const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

std::string size_of(const Mesh& mesh) {
  return std::to_string(mesh.positions.size()) + " " + std::to_string(mesh.triangles.size());
}

std::string scene_of(const std::filesystem::path& file) {
  const Description d = read_scene(file);
  return std::to_string(d.shapes.size()) + " " + std::to_string(d.film.width);
}

const std::vector<TextKind>& kinds() {
  static const std::vector<TextKind> kKinds{
      {"a.obj", "v 5 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n",
       [](const auto& file) {
         const Mesh mesh = read_obj(file, false).mesh;
         return size_of(mesh) + " " + std::to_string(mesh.positions[0].x);
       }},
      {"a.mtl", "newmtl red\nKd 1 0 0\n", [](const auto& file) { return read_mtl(file).materials.at(0).name; }},
      {"a.ply", kPly, [](const auto& file) { return size_of(read_ply(file).mesh); }},
      {"b.ply",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nproperty float "
       "scale_0\nproperty float scale_1\nproperty float scale_2\nproperty float rot_0\nproperty float rot_1\nproperty "
       "float rot_2\nproperty float rot_3\nend_header\n1 2 3 0 0 0 1 0 0 0\n",
       [](const auto& file) { return std::to_string(read_ellipsoids(file, 1).size()); }},
      {"a.pbrt", "Film \"rgb\" \"integer xresolution\" [ 7 ]\nWorldBegin\nShape \"sphere\"\n", scene_of},
      {"a.xml", mitsuba_scene("<shape type='sphere'/>"), scene_of},
      {"a.spd", "400 0.5\n700 1\n", [](const auto& file) { return std::to_string(read_spd(file).values[0]); }},
      {"curves.txt", "0 0 0 1\n1 0 0 1\n",
       [](const auto& file) { return std::to_string(read_curve_file(file, Curves::Basis::kLinear).points.size()); }},
      {"hair.txt", "0 0 0\n1 0 0\n",
       [](const auto& file) { return std::to_string(read_hair_file(file, {}).points.size()); }}};
  return kKinds;
}

/// The text in UTF-16 or UTF-32 with its byte order mark.
std::string wide(const std::string& text, std::size_t bytes, bool big_endian) {
  std::string out;
  const auto append = [&](std::uint32_t c) {
    for (std::size_t i = 0; i < bytes; ++i) out += static_cast<char>(c >> 8 * (big_endian ? bytes - 1 - i : i));
  };
  append(0xfeff);
  for (const char c : text) append(static_cast<unsigned char>(c));
  return out;
}

}  // namespace

TEST_CASE("byte order mark: a UTF-8 mark does not change any text format") {
  const TemporaryFolder folder;
  for (const TextKind& kind : kinds()) {
    CAPTURE(kind.name);
    const std::string plain = kind.read(write_below(folder, "plain/" + kind.name, kind.text));
    CHECK(kind.read(write_below(folder, "marked/" + kind.name, kMark + kind.text)) == plain);
    CHECK_FALSE(plain.empty());
  }
}

TEST_CASE("byte order mark: UTF-16 and UTF-32 are errors with file and line") {
  const TemporaryFolder folder;
  for (const TextKind& kind : kinds())
    for (const std::size_t bytes : {std::size_t{2}, std::size_t{4}})
      for (const bool big_endian : {false, true}) {
        CAPTURE(kind.name);
        CAPTURE(bytes);
        const auto file = write_below(folder, kind.name, wide(kind.text, bytes, big_endian));
        std::string message;
        try {
          kind.read(file);
        } catch (const SceneError& error) { message = error.what(); }
        CHECK(contains(message, kind.name + ":1: the file is text in " + (bytes == 2 ? "UTF-16" : "UTF-32")));
        CHECK(contains(message, "expected UTF-8"));
      }
}

TEST_CASE("byte order mark: included files and material libraries and named spectra may begin with one") {
  const TemporaryFolder folder;
  write_below(folder, "part.xml", kMark + "<scene version='3.0.0'><shape type='sphere'/></scene>");
  CHECK(scene_of(write_below(folder, "scene.xml", mitsuba_scene("<include filename='part.xml'/>"))) == "1 768");
  write_below(folder, "part.pbrt", kMark + "Shape \"sphere\"\n");
  write_below(folder, "s.spd", kMark + "400 0.5 700 0.5\n");
  CHECK(read_scene(write_below(folder, "scene.pbrt",
                               kMark + "WorldBegin\nMaterial \"diffuse\" \"spectrum reflectance\" \"s.spd\"\nInclude "
                                       "\"part.pbrt\"\n"))
            .shapes.size() == 1);
  write_below(folder, "look.mtl", kMark + "newmtl red\nKd 1 0 0\n");
  const Description model = read_scene(
      write_below(folder, "model.obj", kMark + "mtllib look.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  CHECK(model.materials.at(0).id == "red");
}

}  // namespace sheaf::test_byte_order_marks
