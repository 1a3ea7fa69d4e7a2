// OBJ files: every notation of faces and every kind of error.
#include "scene/formats/obj.h"
#include "tests/support/files/deflate.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <sstream>

namespace sheaf::test_obj {

using namespace test;

namespace {

MeshFile read(std::string_view text, bool flip = false) {
  const TemporaryFile file("mesh.obj", std::string(text));
  return read_obj(file.path(), flip);
}

std::string error_in(std::string_view text) {
  return error_of([&] { read(text); });
}

constexpr std::string_view kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

std::string with_square(std::string_view rest) { return std::string(kSquare) + std::string(rest); }

/// A polygon in the plane z = x as one face.
std::string polygon_file(const std::vector<Vec2f>& outline) {
  std::ostringstream text;
  text.precision(9);
  for (const Vec2f p : outline) text << "v " << p.x << ' ' << p.y << ' ' << p.x << '\n';
  text << 'f';
  for (std::size_t i = 1; i <= outline.size(); ++i) text << ' ' << i;
  text << '\n';
  return text.str();
}

/// Area of a polygon in the plane z = x, from its outline in x and y.
double slanted_area(const std::vector<Vec2f>& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2f a = outline[i], b = outline[(i + 1) % outline.size()];
    sum += double(a.x) * b.y - double(b.x) * a.y;
  }
  return std::abs(sum) / 2 * std::numbers::sqrt2;
}

/// Checks that the triangles cover the polygon once: their areas add up to its own, and all face the same side.
void check_covers(const std::vector<Vec2f>& outline) {
  const MeshFile file = read(polygon_file(outline));
  CHECK(file.warnings.empty());
  CHECK(total_area(file.mesh) == near(slanted_area(outline), 1e-5));
  const Vec3f first = area_normal(file.mesh, 0);
  for (std::size_t i = 0; i < file.mesh.triangles.size(); ++i) CHECK(dot(first, area_normal(file.mesh, i)) >= 0.0f);
}

}  // namespace

TEST_CASE("obj: a triangle without attributes is read") {
  const Mesh mesh = read("v 0 0 0\nv 1 0 0\nv 0 2 0.5\nf 1 2 3\n").mesh;
  REQUIRE(mesh.triangles.size() == 1);
  CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
  CHECK(mesh.positions == std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 2, 0.5f}});
  CHECK(mesh.normals.empty());
  CHECK(mesh.uvs.empty());
}

TEST_CASE("obj: the four kinds of corners and negative indices give the same mesh") {
  const std::string attributes = with_square("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n");
  const Mesh full = read(attributes + "f 1/1/1 2/2/1 3/3/1\n").mesh;
  CHECK(full.normals == std::vector<Vec3f>(3, {0, 0, 1}));
  REQUIRE(full.uvs.size() == 3);
  CHECK(full.uvs[1].x == 1);
  CHECK(full.uvs[1].y == 0);
  CHECK(are_equal(full, read(attributes + "f -4/-4/-1 -3/-3/-1 -2/-2/-1\n").mesh));
  const Mesh only_normals = read(attributes + "f 1//1 2//1 3//1\n").mesh;
  CHECK(only_normals.uvs.empty());
  CHECK(only_normals.normals == full.normals);
  const Mesh only_uvs = read(attributes + "f 1/1 2/2 3/3\n").mesh;
  CHECK(only_uvs.normals.empty());
  CHECK(only_uvs.uvs.size() == 3);
  CHECK(are_equal(read(attributes + "f 1 2 3\n").mesh, read(attributes + "f 1// 2/ 3//\n").mesh));
}

TEST_CASE("obj: negative indices are relative to their line") {
  const Mesh mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n").mesh;
  REQUIRE(mesh.triangles.size() == 2);
  CHECK(mesh.positions[mesh.triangles[1][0]] == Vec3f{5, 0, 0});
}

TEST_CASE("obj: faces may come before their vertices") {
  CHECK(read("f 1 2 3\n" + std::string(kSquare)).mesh.positions[1] == Vec3f{1, 0, 0});
}

TEST_CASE("obj: corners with equal indices share a vertex and others do not") {
  const std::string text = with_square("vn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\nf 1//2 2//2 4//1\n");
  const Mesh mesh = read(text).mesh;
  CHECK(mesh.positions.size() == 6);  // four with the first normal, two more with the second
  CHECK(mesh.triangles[0][0] == mesh.triangles[1][0]);
  CHECK(mesh.triangles[2][0] != mesh.triangles[0][0]);
  CHECK(mesh.triangles[2][2] == mesh.triangles[1][2]);
}

TEST_CASE("obj: corners may lack attributes that others have") {
  const Mesh mesh = read(with_square("vt 0.2 0.3\nvn 0 1 0\nf 1/1/1 2 3\n"), true).mesh;
  REQUIRE(mesh.uvs.size() == 3);
  CHECK(mesh.uvs[0].y == near(0.7));
  CHECK(mesh.uvs[1].x == 0);
  CHECK(mesh.uvs[1].y == 0);
  CHECK(mesh.normals == std::vector<Vec3f>{{0, 1, 0}, {0, 0, 0}, {0, 0, 0}});
}

TEST_CASE("obj: texture coordinates are flipped on request and may have one or three components") {
  const std::string text = with_square("vt 0.25\nvt 0.5 0.75 0\nf 1/1 2/2 3/2\n");
  CHECK(read(text, false).mesh.uvs[1].y == 0.75f);
  CHECK(read(text, true).mesh.uvs[1].y == 0.25f);
  CHECK(read(text, true).mesh.uvs[0].x == 0.25f);
}

TEST_CASE("obj: objects and groups and lines and points are accepted beside faces") {
  const Mesh mesh =
      read("# comment\nmtllib nowhere.mtl\no first\n" +
           with_square(
               "g a b\nusemtl red\ns off\nf 1 2 3\nl 1 2\np 1\no second\ng\nusemtl\nf 1 3 4 # last\ncurv 0 1 1 2\n"))
          .mesh;
  CHECK(mesh.triangles.size() == 2);
  CHECK(mesh.positions.size() == 4);
}

TEST_CASE("obj: all line ends and blanks and continued lines are accepted") {
  const Mesh expected = read(with_square("f 1 2 3 4\n")).mesh;
  for (const std::string_view line_end : {"\r\n", "\r", "\n\n", " \t \n"}) {
    std::string text;
    for (const char c : with_square("f 1 2 3 4\n")) text += c == '\n' ? std::string(line_end) : std::string(1, c);
    CHECK(are_equal(read(text).mesh, expected));
  }
  CHECK(are_equal(read(with_square("f 1 2 3 4")).mesh, expected));
  CHECK(are_equal(read(with_square("\t f  1\t2 \\\n 3 \\\r\n 4")).mesh, expected));
  CHECK(are_equal(read("# C:\\models\\\n" + with_square("f 1 2 3 4")).mesh, expected));
}

TEST_CASE("obj: numbers in every notation and vertex colors and homogeneous coordinates are read") {
  const Mesh mesh = read("v -1.5e2 +.25 5. 0.1 0.2 0.3\nv 1E-3 -0 0 1.0\nv 0 1 0\nf 1 2 3\n").mesh;
  CHECK(mesh.positions[0] == Vec3f{-150, 0.25f, 5});
  CHECK(mesh.positions[1].x == near(1e-3f));
}

TEST_CASE("obj: numbers are rounded as those of the C library") {
  std::mt19937_64 random(9);
  for (int round = 0; round < 2000; ++round) {
    char text[64];
    const double magnitude = std::ldexp(1.0, static_cast<int>(random() % 90) - 45);
    const double value = (static_cast<double>(random() >> 11) * 0x1p-52 - 1) * magnitude;
    std::snprintf(text, sizeof(text), round % 2 == 0 ? "%.*f" : "%.*g", static_cast<int>(random() % 18), value);
    CAPTURE(std::string(text));
    const Mesh mesh = read("v " + std::string(text) + " 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh;
    CHECK(mesh.positions[0].x == static_cast<float>(std::strtod(text, nullptr)));
  }
  const Mesh mesh = read("v 1e-9999 -1e-400 0.1234567890123456789\nv 1 -0 0\nv 0 1 0\nf 1 2 3\n").mesh;
  CHECK(mesh.positions[0] == Vec3f{0, -0.0f, 0.12345679f});
  CHECK(std::signbit(mesh.positions[1].y));
  CHECK(read("v -1e400 1e9999 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh.positions[0].x == -INFINITY);
}

TEST_CASE("obj: vertices are shared at positions with many normals") {
  constexpr int kNormals = 50;
  std::string text = std::string(kSquare);
  for (int i = 0; i < kNormals; ++i) text += "vn 0 " + std::to_string(i) + " 1\n";
  std::string faces;
  for (int i = 1; i <= kNormals; ++i) faces += "f 1//" + std::to_string(i) + " 2//1 3//1\n";
  const Mesh mesh = read(text + faces + faces).mesh;
  CHECK(mesh.positions.size() == kNormals + 2);
  REQUIRE(mesh.triangles.size() == 2 * kNormals);
  for (std::size_t i = 0; i < kNormals; ++i) {
    CHECK(mesh.triangles[i] == mesh.triangles[i + kNormals]);
    CHECK(mesh.normals[mesh.triangles[i][0]].y == static_cast<float>(i));
  }
}

TEST_CASE("obj: convex polygons are triangulated") {
  check_covers({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  std::vector<Vec2f> circle;
  for (int i = 0; i < 300; ++i) circle.push_back({std::cos(0.0209f * float(i)), std::sin(0.0209f * float(i))});
  check_covers(circle);
  CHECK(read(polygon_file(circle)).mesh.triangles.size() == 298);
}

TEST_CASE("obj: concave polygons are triangulated for both windings and every first corner") {
  const std::vector<std::vector<Vec2f>> outlines = {
      {{-0.1f, 0}, {0, 9}, {0.1f, 0}, {0, 10}},                          // its shorter diagonal lies outside
      {{0, 0}, {4, 0}, {4, 4}, {3, 4}, {3, 1}, {1, 1}, {1, 4}, {0, 4}},  // U
      {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},                  // L
      {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 0.5f}, {0, 1}},               // a corner on a straight line
      {{0, 0}, {5, 0}, {5, 5}, {1, 5}, {1, 2}, {3, 2}, {3, 3}, {2, 3}, {2, 4}, {4, 4}, {4, 1}, {0, 1}}};  // spiral
  for (std::vector<Vec2f> outline : outlines) {
    for (std::size_t first = 0; first < outline.size(); ++first) {
      std::rotate(outline.begin(), outline.begin() + 1, outline.end());
      check_covers(outline);
    }
    std::reverse(outline.begin(), outline.end());
    check_covers(outline);
    for (Vec2f& p : outline) p = {p.x * 1e-4f, p.y * 1e-4f};
    check_covers(outline);
  }
}

TEST_CASE("obj: a comb-shaped polygon is triangulated exactly") {
  std::vector<Vec2f> comb;
  for (int i = 0; i < 500; ++i) { comb.push_back({float(i), i % 2 == 0 ? 1.0f : 8.0f}); }
  comb.push_back({499, 0});
  comb.push_back({0, 0});
  check_covers(comb);
}

TEST_CASE("obj: polygons that cannot be triangulated give a warning and degenerate ones do not") {
  std::mt19937 random(3);
  int roughly_cut = 0;
  for (int round = 0; round < 50; ++round) {
    std::vector<Vec2f> outline(9);
    for (Vec2f& p : outline) p = {float(random() % 1000), float(random() % 1000)};
    const MeshFile file = read(polygon_file(outline));
    CHECK(file.mesh.triangles.size() <= 7);
    if (file.warnings.empty()) continue;
    ++roughly_cut;
    CHECK(contains(file.warnings[0], "1 self-intersecting polygons"));
  }
  CHECK(roughly_cut > 10);
  CHECK(read("v 1 2 3\nf 1 1 1 1 1\n").mesh.triangles.size() == 3);
  const MeshFile with_short = read(with_square("f 1\nf 1 2\nf 1 2 3\n"));
  CHECK(with_short.mesh.triangles.size() == 1);
  REQUIRE(with_short.warnings.size() == 1);
  CHECK(contains(with_short.warnings[0], "2 faces"));
}

TEST_CASE("obj: NaN and infinite coordinates are kept") {
  for (const std::string_view number : {"nan", "-NaN", "inf", "-Infinity", "1.#QNAN", "-1.#IND", "nan(0x1)"}) {
    const Mesh mesh = read("v 0 " + std::string(number) + " 0\nv 1 0 0\nv 0 1 0\nvn nan 0 0\nf 1//1 2 3\n").mesh;
    CHECK_FALSE(is_finite(mesh.positions[0]));
    CHECK(is_finite(mesh.positions[1]));
    CHECK(mesh.normals[0] == Vec3f{0, 0, 0});
  }
  CHECK(std::isinf(read("v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh.positions[0].x));
  CHECK(is_finite(read("v 0 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh.positions[0]));
}

TEST_CASE("obj: malformed numbers are errors with a line number") {
  for (const std::string_view number :
       {"abc", "1,5", "1e", "--1", ".", "1.0f", "0x10", "1e99999", "nano", "\x01", "1\\2"}) {
    const std::string message = error_in("# first\nv 0 0 0\nv 0 " + std::string(number) + " 0\nf 1 1 1\n");
    CHECK_MESSAGE(contains(message, "mesh.obj:3: "), number);
    CHECK(contains(message, "expected a number in a vertex line"));
  }
  CHECK(contains(error_in("v 1 2\nf 1 1 1\n"), ":1: expected at least 3 numbers"));
  CHECK(contains(error_in("v\nf 1 1 1\n"), ":1: expected at least 3 numbers"));
  CHECK(contains(error_in(with_square("vn 0 1\nf 1 2 3")), ":5: expected at least 3 numbers in a normal"));
  CHECK(contains(error_in(with_square("vt\nf 1 2 3")), ":5: "));
  CHECK(contains(error_in(std::string("v 0 0 0\nv 1 0\0 0\n", 16)), ":2: "));
}

TEST_CASE("obj: malformed and impossible indices are errors with a line number") {
  for (const std::string_view corner :
       {"0", "x", "1/x", "1//x", "1/2/3/4", "/1", "//1", "1.5", "99999999999", "1/0/1"}) {
    const std::string message = error_in(with_square("f 1 2 " + std::string(corner) + "\n"));
    CHECK_MESSAGE(contains(message, "mesh.obj:5: expected a face corner"), corner);
  }
  CHECK(contains(error_in(with_square("f 1 2 3\nf 1 2 5\n")), ":6: a face refers to vertex 5, but there are 4"));
  CHECK(contains(error_in(with_square("f 1 2 -5\n")), ":5: a face refers to vertex -5, but there are 4"));
  CHECK(contains(error_in(with_square("f 1 2 -5\nf 1 2 x\n")), ":5: a face refers to vertex -5, but there are 4"));
  CHECK(contains(error_in(with_square("f 1/1 2/1 3/1\n")), ":5: a face refers to texture coordinate 1"));
  CHECK(contains(error_in(with_square("vn 0 0 1\nf 1//1 2//2 3//1\n")), ":6: a face refers to normal 2"));
  CHECK(contains(error_in(with_square("\\\nf 1 2 \\\n3\nf 1 2 999999999")), ":8: a face refers to vertex 999999999"));
}

TEST_CASE("obj: files without a mesh are errors") {
  CHECK(contains(error_of([] { read_obj("/nowhere/at/all.obj", true); }), "not found"));
  CHECK(contains(error_in(""), "empty file"));
  CHECK(contains(error_in("\n"), "holds no faces"));
  CHECK(contains(error_in(kSquare), "holds no faces"));
  CHECK(contains(error_in(std::string(1000, '\0')), "holds no faces"));
  const TemporaryFile file("x.obj", "");
  CHECK(contains(error_of([&] { read_obj(file.path().parent_path(), true); }), "not a regular file"));
}

TEST_CASE("obj: lines that tinyobjloader reads otherwise are found at every offset between lines that it reads") {
  const std::string plain = with_square("vt 0.5 0.25\nvn 0.1 -0.2 0.9\nf 1/1/1 2/1/1 3/1/1\n");
  for (const std::string_view line : {"v 0.5 0.5",
                                      "v 1.5 2/1 0.5",
                                      "v 1.2.3 4.5 6.5",
                                      "v 1.5 . 0.5",
                                      "v 1.5 - 0.5",
                                      "v 0.5 1-2 0.5",
                                      "vt 0.5 x",
                                      "vn 0.5 --1 0.5",
                                      "vt",
                                      "vn 0.5 0",
                                      "v ",
                                      "vt \t",
                                      "f 1.5 2 3",
                                      "f 1 2 3/4/5/6",
                                      "f 1/1 2/0 3/1",
                                      "f 1/1 2/-0 3/1",
                                      "f 1 2 12345678901",
                                      "f 1 2 3 # last",
                                      "f 1 2 3 last",
                                      "f 1-2 2 3",
                                      "f 0 1 2",
                                      "f /1 2 3",
                                      "f 1 2 3\v"})
    for (std::size_t offset = 0; offset < 70; ++offset) {
      const std::string text = std::string(offset, '\n') + plain + std::string(line) + "\n" + plain + plain;
      CAPTURE(line);
      if (line.find('#') != line.npos) {
        CHECK(read(text).mesh.triangles.size() == 4);
      } else {
        CHECK(contains(error_in(text), "mesh.obj:" + std::to_string(8 + offset) + ": expected"));
      }
    }
  // Slashes without an index
  const Mesh mesh = read(plain + "f 1/ 2// 3/1\n").mesh;
  REQUIRE(mesh.triangles.size() == 2);
  CHECK(mesh.uvs[mesh.triangles[1][0]].x == 0);
  CHECK(mesh.uvs[mesh.triangles[1][2]].x == 0.5f);
}

TEST_CASE("obj: pieces of any size give the same mesh and the same errors") {
  const std::string text = "mtllib a.mtl\r\n" +
                           with_square("vt 0 0\rvt 1e-3 0.123456789\nvn 0 0 1\nf 1/1/1 2/2/1 \\\n 3/1/1 4/1/1\n") +
                           "usemtl red\ns 1\nf -1 -2 -3\nv 5 5 5\nf -1//-1 1 2\n\n# end \xff\nusemtl blue\nusemtl "
                           "red\ns off\nf 1 2 5\nf 1 2\n" +
                           "usemtl green\nf 2 3 6\nf 1/9 2/2 -1//-7\nmtllib b.mtl\nv 6 0 0\nf 5 1 2\n";
  const TemporaryFile file("mesh.obj", text), wrong("wrong.obj", text + "f 1 2 x\n");
  const auto read_in_pieces = [&](std::size_t bytes) {
    return read_obj_with_materials(file.path(), false, BadFaces::kDrop, bytes);
  };
  const ObjFile whole = read_in_pieces(text.size());
  CHECK(whole.file.mesh.triangles.size() == 8);
  CHECK(whole.materials == std::vector<std::string>{"", "red", "green"});
  CHECK(whole.material_lines == std::vector<int>{0, 11, 23});
  CHECK(whole.smoothing_of == std::vector<std::uint32_t>{0, 0, 1, 1, 0, 0, 0, 0});
  for (std::size_t bytes = 1; bytes < text.size(); bytes = bytes < 100 ? bytes + 1 : bytes + 37) {
    CAPTURE(bytes);
    const ObjFile pieces = read_in_pieces(bytes);
    CHECK(are_equal(pieces.file.mesh, whole.file.mesh));
    CHECK(pieces.file.warnings == whole.file.warnings);
    CHECK(pieces.materials == whole.materials);
    CHECK(pieces.material_lines == whole.material_lines);
    CHECK(pieces.material_of == whole.material_of);
    CHECK(pieces.smoothing_of == whole.smoothing_of);
    REQUIRE(pieces.libraries.size() == 2);
    CHECK(pieces.libraries[1].where.line == 26);
    const std::string message = error_of([&] { read_obj_with_materials(wrong.path(), false, BadFaces::kDrop, bytes); });
    CHECK(contains(message, "wrong.obj:29: expected a face corner"));
    CHECK(contains(error_of([&] { read_obj_with_materials(file.path(), false, BadFaces::kError, bytes); }),
                   "mesh.obj:25: a face refers to normal -7, but there are 1"));
  }
}

TEST_CASE("obj: pieces end at line ends that are far away") {
  // Longer than the blocks in which the file is searched, so that line ends of both bytes lie across their boundaries
  for (std::size_t length = 4085; length < 4110; ++length) {
    CAPTURE(length);
    const std::string comment = "#" + std::string(length, ' ');
    const std::string text = comment + "\r\n" +
                             with_square(comment + "\\\r\nf 1 2 \\\r\n" + std::string(length, ' ') + "\\\r\n 3\r" +
                                         comment + "\r\nusemtl far\nf 2 3 4\n");
    const TemporaryFile file("mesh.obj", text), bad("bad.obj", text + comment + "\r\n\r\nf 1 2 x\n");
    for (const std::size_t bytes : {std::size_t{1}, std::size_t{100}, length, length + 2, 2 * length + 100}) {
      CAPTURE(bytes);
      const ObjFile obj = read_obj_with_materials(file.path(), false, BadFaces::kError, bytes);
      CHECK(obj.file.mesh.triangles.size() == 2);
      CHECK(obj.material_lines == std::vector<int>{0, 11});
      CHECK(contains(error_of([&] { read_obj_with_materials(bad.path(), false, BadFaces::kError, bytes); }),
                     "bad.obj:15: expected a face corner"));
    }
  }
}

TEST_CASE("obj: byte order marks and compressed files are read in pieces") {
  const std::string text = with_square("f 1 2 3 4\nf 1 2 x\n"), plain = with_square("f 1 2 3 4\n");
  const Mesh expected = read(plain).mesh;
  const auto read_in_pieces = [](const std::string& name, const std::string& content) {
    const TemporaryFile file(name, content);
    return read_obj_with_materials(file.path(), true, BadFaces::kError, 5).file.mesh;
  };
  CHECK(are_equal(read_in_pieces("a.obj", "\xef\xbb\xbf" + plain), expected));
  CHECK(are_equal(read_in_pieces("a.obj.gz", gzipped(plain)), expected));
  const auto error_in_pieces = [&](const std::string& name, const std::string& content) {
    return error_of([&] { read_in_pieces(name, content); });
  };
  CHECK(contains(error_in_pieces("a.obj", "\xef\xbb\xbf" + text), ":6: expected a face corner"));
  CHECK(contains(error_in_pieces("a.obj.gz", gzipped(text)), ":6: expected a face corner"));
  CHECK(contains(error_in_pieces("a.obj", "\xff\xfe" + plain), "UTF-16"));
  CHECK(contains(error_in_pieces("a.obj.gz", plain), "not a gzip file"));
  CHECK(contains(error_in_pieces("a.obj.gz", gzipped("")), "empty file"));
}

TEST_CASE("obj: every truncated file gives a mesh or an error") {
  const std::string text = with_square("vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 \\\n4/1/1\nf -1 -2 -3\n");
  int meshes = 0;
  for (std::size_t size = 0; size <= text.size(); ++size) {
    const std::string message = error_of([&] {
      const MeshFile file = read(text.substr(0, size));
      CHECK_FALSE(file.mesh.triangles.empty());
      ++meshes;
    });
    CHECK((message.empty() || contains(message, "mesh.obj")));
  }
  CHECK(meshes > 5);
}

TEST_CASE("obj: random bytes and random edits never crash") {
  std::mt19937 random(7);
  const std::string valid = with_square("vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4//1\nf -1 -2 -3\n");
  constexpr std::string_view kBytes = "0123456789 /-+.eEvftn\\\r\n#\t";
  for (int round = 0; round < 300; ++round) {
    std::string text = valid;
    for (int edit = 0; edit < 4; ++edit) text[random() % text.size()] = kBytes[random() % kBytes.size()];
    error_of([&] {
      const Mesh mesh = read(text).mesh;
      for (const auto& t : mesh.triangles) CHECK(std::max({t[0], t[1], t[2]}) < mesh.positions.size());
    });
  }
}

TEST_CASE("obj: materials of triangles and libraries are recorded") {
  const TemporaryFile file("mesh.obj", with_square("mtllib  a.mtl b.mtl \nf 1 2 3\nusemtl  red paint \nf 1 2 3 4\n"
                                                   "usemtl blue\nf 1 2\nusemtl green\nf 1 2 3\nusemtl red paint\n"
                                                   "f 2 3 4\nmtllib c.mtl\nusemtl nothing\n"));
  const ObjFile obj = read_obj_with_materials(file.path(), false);
  CHECK(obj.materials == std::vector<std::string>{"", "red paint", "green"});
  CHECK(obj.material_of == std::vector<std::uint32_t>{0, 1, 1, 2, 1});
  REQUIRE(obj.libraries.size() == 2);
  CHECK(obj.libraries[0].names == "a.mtl b.mtl");
  CHECK(obj.libraries[0].where.line == 5);
  CHECK(obj.libraries[1].names == "c.mtl");
  CHECK(are_equal(obj.file.mesh, read_obj(file.path(), false).mesh));
}

TEST_CASE("obj: smoothing groups are recorded and triangles before the first are flat") {
  const auto groups = [](const std::string& text) {
    const TemporaryFile file("mesh.obj", with_square(text));
    return read_obj_with_materials(file.path(), false).smoothing_of;
  };
  CHECK(groups("f 1 2 3 4\n").empty());
  using SlotTable = std::vector<std::uint32_t>;
  CHECK(groups("f 1 2 3\ns 1\nf 1 2 3 4\ns off\nf 1 2 3\ns 4294967295 # all\nf 1 2 3\ns 0\nf 1 2 3\n") ==
        SlotTable{0, 1, 1, 0, 4294967295u, 0});
  CHECK(groups("s on\nf 1 2 3\n\ts\t7\t\nf 1 2 3\ns\nf 1 2 3\n") == SlotTable{1, 7, 0});
  CHECK(contains(error_in(with_square("s smooth\nf 1 2 3\n")),
                 "mesh.obj:5: expected a smoothing group after 's', a number or 'off', found 'smooth'"));
  CHECK(groups("s off\nusemtl a\nf 1 2 3\nshadow_obj x\n") == SlotTable{0});
}

}  // namespace sheaf::test_obj
