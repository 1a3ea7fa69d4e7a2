// PLY files, written byte by byte: encodings, layouts and wrong headers.
#include "scene/formats/mesh_io.h"
#include "tests/support/mesh_files.h"

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>
#include <tuple>

namespace sheaf::test_ply {

using namespace test;

namespace {

MeshFile read(const std::string& bytes, bool flip = false) {
  const TemporaryFile file("mesh.ply", bytes);
  return read_ply(file.path(), flip);
}

std::string error_in(const std::string& bytes) {
  return error_of([&] { read(bytes); });
}

/// Writes numbers as text or as bytes in one of two byte orders.
class Body {
 public:
  enum class Encoding { kAscii, kLittle, kBig };
  explicit Body(Encoding encoding) : encoding_(encoding) {}

  template <class T> Body& put(T value) {
    if (encoding_ == Encoding::kAscii) {
      text_ += (text_.empty() ? "" : " ") + std::to_string(value);
      return *this;
    }
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    const bool is_little = std::endian::native == std::endian::little;
    if (is_little != (encoding_ == Encoding::kLittle)) std::reverse(raw.begin(), raw.end());
    text_.append(raw.data(), raw.size());
    return *this;
  }
  const std::string& text() const { return text_; }
  std::string format() const {
    return encoding_ == Encoding::kAscii    ? "format ascii 1.0\n"
           : encoding_ == Encoding::kLittle ? "format binary_little_endian 1.0\n"
                                            : "format binary_big_endian 1.0\n";
  }

 private:
  Encoding encoding_;
  std::string text_;
};

constexpr std::array<Body::Encoding, 3> kEncodings{Body::Encoding::kAscii, Body::Encoding::kLittle,
                                                   Body::Encoding::kBig};

/// Every number type, unknown elements and properties, lists between numbers, a quadrangle and a triangle.
std::string rich_file(Body::Encoding encoding) {
  using std::int16_t, std::int8_t, std::uint16_t, std::uint32_t, std::uint8_t;
  Body body(encoding);
  body.put<uint8_t>(2).put(1.5).put(2.5).put<int16_t>(-7);  // element 'junk'
  const double corners[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.25}, {-3, 0.5, -2}};
  for (int i = 0; i < 5; ++i) {
    const double* c = corners[i];
    body.put(c[0]).put<uint8_t>(255).put(float(c[1])).put<uint16_t>(3).put<int8_t>(1).put<int8_t>(-2).put<int8_t>(3);
    body.put(float(c[2])).put(0.0f).put(0.0f).put(1.0f).put(float(i)).put(0.5f).put<uint32_t>(4000000000u);
  }
  body.put<int8_t>(9).put<int16_t>(4).put<uint16_t>(0).put<uint16_t>(1).put<uint16_t>(2).put<uint16_t>(3);
  body.put<uint8_t>(1).put(0.5f);
  body.put<int8_t>(9).put<int16_t>(3).put<uint16_t>(4).put<uint16_t>(1).put<uint16_t>(0);
  body.put<uint8_t>(0);
  return "ply\n" + body.format() +
         "comment element vertex 99\nobj_info property float x\n"
         "element junk 1\nproperty list uchar double values\nproperty short other\n"
         "element vertex 5\nproperty double x\nproperty uchar red\nproperty float32 y\n"
         "property list ushort int8 tags\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
         "property float s\nproperty float t\nproperty uint id\n"
         "element face 2\nproperty char flag\nproperty list int16 uint16 vertex_indices\n"
         "property list uint8 float weights\nend_header\n" +
         body.text();
}

std::string header(const std::string& elements, const std::string& format = "ascii") {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

const std::string kTriangle =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\n";
const std::string kTriangleBody = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

}  // namespace

TEST_CASE("ply: all encodings give the same correct mesh") {
  const MeshFile ascii = read(rich_file(Body::Encoding::kAscii));
  REQUIRE(ascii.warnings.size() == 3);
  CHECK(contains(ascii.warnings[0], "element 'junk' not understood: left out"));
  CHECK(contains(ascii.warnings[1], "element 'vertex': properties 'red', 'tags', 'id' not understood: left out"));
  CHECK(contains(ascii.warnings[2], "element 'face': properties 'flag', 'weights' not understood: left out"));
  const Mesh& mesh = ascii.mesh;
  CHECK(mesh.positions == std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.25f}, {-3, 0.5f, -2}});
  CHECK(mesh.normals == std::vector<Vec3f>(5, {0, 0, 1}));
  REQUIRE(mesh.uvs.size() == 5);
  CHECK(mesh.uvs[3].x == 3.0f);
  CHECK(mesh.uvs[3].y == 0.5f);
  using Triangle = std::array<std::uint32_t, 3>;
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {4, 1, 0}});
  for (const Body::Encoding encoding : kEncodings) CHECK(are_equal(read(rich_file(encoding)).mesh, mesh));
}

TEST_CASE("ply: every number type can be coordinate and index") {
  const auto check = [](const std::string& type, auto zero) {
    using T = decltype(zero);
    for (const Body::Encoding encoding : kEncodings) {
      Body body(encoding);
      for (const int c : {0, 0, 0, 100, 0, 0, 0, 100, 0}) body.put(static_cast<T>(c));
      body.put<std::uint8_t>(3).put(static_cast<T>(2)).put(static_cast<T>(0)).put(static_cast<T>(1));
      const std::string columns = "property " + type + " x\nproperty " + type + " y\nproperty " + type + " z\n";
      const Mesh mesh =
          read("ply\n" + body.format() + "element vertex 3\n" + columns + "element face 1\nproperty list uchar " +
               type + " vertex_index\nend_header\n" + body.text())
              .mesh;
      CHECK_MESSAGE((mesh.positions[1] == Vec3f{100, 0, 0}), type);
      CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{2, 0, 1});
    }
  };
  check("char", std::int8_t{});
  check("uint8", std::uint8_t{});
  check("short", std::int16_t{});
  check("uint16", std::uint16_t{});
  check("int", std::int32_t{});
  check("uint32", std::uint32_t{});
  check("float", float{});
  check("float64", double{});
}

TEST_CASE("ply: faces may precede vertices") {
  const Mesh mesh = read(header("element face 1\nproperty list uchar int vertex_index\nelement vertex 3\n"
                                "property float x\nproperty float y\nproperty float z\n") +
                         "3 2 1 0\n0 0 0\n1 0 0\n0 1 0\n")
                        .mesh;
  CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{2, 1, 0});
}

TEST_CASE("ply: texture coordinates have several names and are flipped on request") {
  for (const std::string_view names : {"uv", "st"}) {
    for (const std::string prefix : {"", "texture_"}) {
      std::string columns;
      for (const char name : names) columns += "property float " + prefix + name + "\n";
      const std::string text = header("element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" +
                                      columns + "element face 1\nproperty list uchar int vertex_indices\n") +
                               "0 0 0 .1 .2\n1 0 0 .3 .25\n0 1 0 nan .6\n3 0 1 2\n";
      const Mesh mesh = read(text).mesh;
      REQUIRE(mesh.uvs.size() == 3);
      CHECK(mesh.uvs[1].x == 0.3f);
      CHECK(mesh.uvs[1].y == 0.25f);
      CHECK(mesh.uvs[2].x == 0.0f);
      CHECK(read(text, true).mesh.uvs[1].y == 0.75f);
    }
  }
}

TEST_CASE("ply: incomplete normals are ignored and non-finite ones are missing") {
  const std::string position = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  CHECK(read(header(position + "property float nx\nproperty float nz\n" + face) +
             "0 0 0 1 1\n1 0 0 1 1\n0 1 0 1 1\n3 0 1 2\n")
            .mesh.normals.empty());
  const Mesh mesh = read(header(position + "property float nx\nproperty float ny\nproperty float nz\n" + face) +
                         "0 0 0 0 0 1\n1 0 0 nan 0 0\n0 1 0 0 0 1\n3 0 1 2\n")
                        .mesh;
  CHECK(mesh.normals[1] == Vec3f{0, 0, 0});
}

TEST_CASE("ply: all line ends of the header are accepted") {
  const Mesh expected = read(header(kTriangle) + kTriangleBody).mesh;
  for (const std::string line_end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : header(kTriangle) + kTriangleBody) text += c == '\n' ? line_end : std::string(1, c);
    CHECK(are_equal(read(text).mesh, expected));
    Body body(Body::Encoding::kLittle);
    body.put(10.0f);  // the byte after a header that ends in CR may look like LF
    for (const int c : {0, 0, 1, 0, 0, 0, 1, 0}) body.put(static_cast<float>(c));
    body.put<std::uint8_t>(3).put(0).put(1).put(2);
    std::string binary;
    for (const char c : header(kTriangle, "binary_little_endian")) binary += c == '\n' ? line_end : std::string(1, c);
    CHECK(read(binary + body.text()).mesh.positions[0].x == 10.0f);
  }
}

TEST_CASE("ply: concave polygons keep their area and those of fewer than three corners are dropped") {
  const MeshFile file = read(header("element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                                    "element face 3\nproperty list uchar int vertex_indices\n") +
                             "-1 0 0\n0 9 0\n1 0 0\n0 10 0\n4 0 1 2 3\n2 0 1\n0\n");
  CHECK(file.mesh.triangles.size() == 2);
  CHECK(total_area(file.mesh) == doctest::Approx(1.0));
  REQUIRE(file.warnings.size() == 1);
  CHECK(contains(file.warnings[0], "2 faces"));
}

TEST_CASE("ply: triangle strips reverse every other triangle") {
  const Mesh mesh = read(header("element vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
                                "element tristrips 1\nproperty list int int vertex_indices\n") +
                         "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n10 0 1 2 3 4 -1 0 1 2 -1\n")
                        .mesh;
  REQUIRE(mesh.triangles.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(area_normal(mesh, i).z == 1.0f);
}

TEST_CASE("ply: infinite numbers are kept") {
  const Mesh mesh = read(header(kTriangle) + "nan inf -inf\n1e400 -1e400 1e-400\n+0.5 1e39 0\n3 0 1 2\n").mesh;
  CHECK(std::isnan(mesh.positions[0].x));
  CHECK(mesh.positions[0].z == -INFINITY);
  CHECK(mesh.positions[1].x == INFINITY);
  CHECK(mesh.positions[1].y == -INFINITY);
  CHECK(mesh.positions[1].z == 0.0f);
  CHECK(mesh.positions[2].x == 0.5f);
}

TEST_CASE("ply: malformed headers are errors") {
  const auto in_header = [](const std::string& elements) { return error_in(header(elements) + kTriangleBody); };
  CHECK(contains(error_of([] { read_ply("/nowhere/at/all.ply"); }), "not found"));
  CHECK(contains(error_in(""), "begins with 'ply'"));
  CHECK(contains(error_in("plyx\nformat ascii 1.0\n"), "begins with 'ply'"));
  CHECK(contains(error_in("obj\n"), "begins with 'ply'"));
  CHECK(contains(error_in("ply"), "without 'end_header'"));
  CHECK(contains(error_in("ply\nformat ascii 1.0\nelement vertex 3\n"), "without 'end_header'"));
  CHECK(contains(error_in("ply\nelement vertex 0\nend_header\n"), "no 'format' line"));
  CHECK(contains(error_in("ply\nformat ascii 2.0\nend_header\n"), "mesh.ply:2: expected version 1.0"));
  CHECK(contains(error_in("ply\nformat binary_litle_endian 1.0\nend_header\n"), "mean 'binary_little_endian'"));
  CHECK(contains(in_header("elemnt vertex 3\n"), ":3: expected a PLY header line, found 'elemnt', did you mean 'elem"));
  CHECK(contains(in_header("property float x\n"), "before the first element"));
  CHECK(contains(in_header("element vertex 3\nproperty flot x\n"), ":4: unknown PLY type 'flot', did you mean 'floa"));
  CHECK(contains(in_header("element vertex 3\nproperty list float int a\n"), "integer type for the length"));
  CHECK(contains(in_header("element vertex three\n"), "found 'three'"));
  CHECK(contains(in_header("element vertex -3\n"), "found '-3'"));
  CHECK(contains(in_header("element vertex 99999999999999999999999\n"), "found '999"));
  CHECK(contains(in_header(kTriangle + kTriangle), "appears twice"));
  CHECK(contains(in_header("element face 1\nproperty list uchar int vertex_indices\n"), "no element 'vertex'"));
  CHECK(contains(in_header("element vertex 1\nproperty float x\nproperty float y\n"), "without 'x', 'y' and 'z'"));
  CHECK(contains(in_header("element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"), "no faces"));
  CHECK(contains(in_header("element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                           "element face 1\nproperty list uchar int corners\n"),
                 "no list 'vertex_indices'"));
}

TEST_CASE("ply: counts that the file cannot hold are errors and not allocations") {
  for (const std::string count : {"1000000000000000000", "18446744073709551615", "4000000000", "400"}) {
    for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      const std::string claims = "element vertex " + count +
                                 "\nproperty float x\nproperty float y\nproperty float z\n"
                                 "element face 1\nproperty list uchar int vertex_indices\n";
      CHECK(contains(error_in(header(claims, format) + std::string(1000, ' ')), "claims " + count + " rows"));
      const std::string faces =
          "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
          "element face " +
          count + "\nproperty list int int vertex_indices\n";
      CHECK_FALSE(error_in(header(faces, format) + std::string(1000, ' ')).empty());
    }
  }
  CHECK(read(header("element nothing 1000000000000000000\n" + kTriangle) + kTriangleBody).mesh.triangles.size() == 1);
  const std::string list =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list int int vertex_indices\n";
  CHECK(contains(error_in(header(list) + "0 0 0\n2000000000 0 0 0\n"), "truncated"));
  CHECK(contains(error_in(header(list) + "0 0 0\n-1 0 0 0\n"), "impossible length"));
  CHECK(contains(error_in(header(list) + "0 0 0\n1.5 0 0 0\n"), "impossible length"));
  Body body(Body::Encoding::kBig);
  body.put(0.0f).put(0.0f).put(0.0f).put(2000000000).put(0);
  CHECK(contains(error_in(header(list, "binary_big_endian") + body.text()), "truncated"));
}

TEST_CASE("ply: malformed bodies are errors with their position") {
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
                 "mesh.ply:13: row 0 of element 'face' (1 rows): expected the index of one of 3 vertices, found 3"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n"), "found -1"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n"), "found 1.5"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 nan 1\n"), "found nan"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n"),
                 "mesh.ply:11: row 1 of element 'vertex' (3 rows): expected a number, found 'x'"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0,5 0\n0 1 0\n3 0 1 2\n"), "found '0,5'"));
  CHECK(contains(error_in(header(kTriangle) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 "), "truncated"));
}

TEST_CASE("ply: truncated and randomly edited files give a mesh or an error") {
  std::mt19937 random(11);
  for (const Body::Encoding encoding : kEncodings) {
    const std::string valid = rich_file(encoding);
    for (std::size_t size = 0; size + 1 < valid.size(); size += size < 300 ? 7 : 1) {
      CHECK_FALSE(error_in(valid.substr(0, size)).empty());
    }
    for (int round = 0; round < 300; ++round) {
      std::string bytes = valid;
      for (int edit = 0; edit < 3; ++edit) bytes[random() % bytes.size()] = static_cast<char>(random());
      error_of([&] {
        const Mesh mesh = read(bytes).mesh;
        for (const auto& t : mesh.triangles) CHECK(std::max({t[0], t[1], t[2]}) < mesh.positions.size());
      });
    }
  }
}

namespace {

/// A triangle whose vertices and face have additional properties. All rows have equal `values`.
template <class... V, class... F>
MeshFile with_attributes(const std::string& vertex_columns, std::tuple<V...> vertex, const std::string& face_columns,
                         std::tuple<F...> face, Body::Encoding encoding = Body::Encoding::kAscii) {
  Body body(encoding);
  for (const int corner : {0, 1, 2}) {
    body.put(float(corner == 1)).put(float(corner == 2)).put(0.0f);
    std::apply([&](auto... value) { (body.put(value), ...); }, vertex);
  }
  body.put<std::uint8_t>(3).put(0).put(1).put(2);
  std::apply([&](auto... value) { (body.put(value), ...); }, face);
  return read("ply\n" + body.format() + "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" +
              vertex_columns + "element face 1\nproperty list uchar int vertex_indices\n" + face_columns +
              "end_header\n" + body.text());
}

/// "property T a", "property T b" ... for the names in "a b ...".
std::string columns(const std::string& type, const std::string& names) {
  std::string text;
  std::istringstream words(names);
  for (std::string name; words >> name;) text += "property " + type + " " + name + "\n";
  return text;
}

}  // namespace

TEST_CASE("ply: attributes are named after their properties") {
  const auto names = [](const std::string& first, const std::string& second, const std::string& third) {
    const MeshFile file = with_attributes(columns("float", first + " " + second + " " + third),
                                          std::tuple(0.25f, 0.5f, 0.75f), "", std::tuple());
    std::string found;
    for (const Mesh::Attribute& a : file.mesh.attributes) {
      found += (found.empty() ? "" : " ") + a.name + ":" + std::to_string(a.channels);
      CHECK(a.values.size() == 3 * static_cast<std::size_t>(a.channels));
      CHECK(a.values[0] == a.values[static_cast<std::size_t>(a.channels)]);
    }
    return found;
  };
  CHECK(names("r", "g", "b") == "vertex_color:3");
  CHECK(names("red", "green", "blue") == "vertex_color:3");
  CHECK(names("b", "r", "g") == "vertex_color:3");
  CHECK(names("foo_r", "foo_g", "foo_b") == "vertex_foo_color:3");
  CHECK(names("foo_x", "foo_y", "foo_z") == "vertex_foo:3");
  CHECK(names("my_long_0", "my_long_1", "my_long_2") == "vertex_my_long:3");
  CHECK(names("a_1", "a_2", "a_3") == "vertex_a:3");
  CHECK(names("a_0", "b_x", "c_r") == "vertex_a:1 vertex_b:1 vertex_c_color:1");
  CHECK(names("a_x", "b_x", "a_y") == "vertex_a:1 vertex_b:1");
  CHECK(names("quality", "flags", "a_q") == "");
  CHECK(names("red", "green", "alpha") == "");
  CHECK(names("s", "t", "a_x") == "vertex_a:1");
  CHECK(names("_x", "x_", "a_xy") == "");
}

TEST_CASE("ply: attributes of vertices and faces are read in every encoding") {
  for (const Body::Encoding encoding : kEncodings) {
    const MeshFile file = with_attributes(
        columns("float", "b g") + columns("double", "r temperature_0") + "property list uchar int tags\n",
        std::tuple(0.75f, 0.5f, 0.25, 300.0, std::uint8_t{2}, 7, 8), columns("float", "q_x q_y q_z r g b"),
        std::tuple(1.0f, 2.0f, 3.0f, 0.125f, 0.25f, 0.5f), encoding);
    REQUIRE(file.warnings.size() == 1);
    CHECK(contains(file.warnings[0], "element 'vertex': property 'tags' not understood: left out"));
    REQUIRE(file.mesh.attributes.size() == 4);
    CHECK(file.mesh.attributes[0].values == std::vector<float>{.25f, .5f, .75f, .25f, .5f, .75f, .25f, .5f, .75f});
    CHECK(file.mesh.attributes[1].name == "vertex_temperature");
    CHECK(file.mesh.attributes[1].values == std::vector<float>{300, 300, 300});
    CHECK(file.mesh.attributes[2].name == "face_color");
    CHECK(file.mesh.attributes[2].values == std::vector<float>{0.125f, 0.25f, 0.5f});
    CHECK(file.mesh.attributes[3].name == "face_q");
    CHECK(file.mesh.attributes[3].values == std::vector<float>{1, 2, 3});
  }
}

TEST_CASE("ply: integer attributes are sRGB fractions of their maximum and non-finite ones are zero") {
  const auto first = [](const std::string& type, auto value) {
    const MeshFile file = with_attributes(columns(type, "r g b"), std::tuple(value, value, value), "", std::tuple());
    return double(file.mesh.attributes.at(0).values.at(0));
  };
  CHECK(first("uchar", std::uint8_t{255}) == 1.0);
  CHECK(first("uchar", std::uint8_t{128}) == doctest::Approx(0.21586).epsilon(1e-4));
  CHECK(first("ushort", std::uint16_t{32768}) == doctest::Approx(0.21404809).epsilon(1e-6));  // value of Mitsuba 3.9
  CHECK(first("int", 32768) == doctest::Approx(1.1810208e-06).epsilon(1e-6));                 // value of Mitsuba 3.9
  CHECK(first("char", std::int8_t{-100}) == doctest::Approx(-0.06094439).epsilon(1e-6));      // value of Mitsuba 3.9
  CHECK(first("float", 7.5f) == 7.5);
  CHECK(first("float", std::numeric_limits<float>::quiet_NaN()) == 0.0);
  CHECK(first("double", 1e300) == 0.0);
}

TEST_CASE("ply: unusable attributes are dropped with a warning") {
  const MeshFile two = with_attributes(columns("float", "a_x a_y"), std::tuple(1.0f, 2.0f), "", std::tuple());
  CHECK(two.mesh.attributes.empty());
  REQUIRE(two.warnings.size() == 1);
  CHECK(contains(two.warnings[0], "attribute 'vertex_a' has 2 channels, expected 1 or 3"));
  const MeshFile twice =
      with_attributes(columns("float", "a_x b_x a_0"), std::tuple(1.0f, 2.0f, 3.0f), "", std::tuple());
  REQUIRE(twice.mesh.attributes.size() == 2);
  CHECK(twice.mesh.attributes[0].values[0] == 1.0f);
  REQUIRE(twice.warnings.size() == 1);
  CHECK(contains(twice.warnings[0], "'vertex_a' appears twice"));
}

TEST_CASE("ply: attributes of polygons are copied to their triangles") {
  const std::string points = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "property list uchar int vertex_indices\nproperty float id_0\n";
  const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const MeshFile file =
      read(header(points + "element face 4\n" + faces) + square + "4 0 1 2 3 5\n2 0 1 6\n3 0 1 2 7\n3 1 2 3 8\n");
  REQUIRE(file.mesh.attributes.size() == 1);
  CHECK(file.mesh.attributes[0].values == std::vector<float>{5, 5, 7, 8});
  for (const bool strips_first : {true, false}) {
    const std::string strips = "element tristrips 1\nproperty list uchar int vertex_indices\n";
    const std::string face = "element face 1\n" + faces;
    const MeshFile mixed = read(header(points + (strips_first ? strips + face : face + strips)) + square +
                                (strips_first ? "4 0 1 2 3\n3 0 1 2 9\n" : "3 0 1 2 9\n4 0 1 2 3\n"));
    CHECK(mixed.mesh.attributes.at(0).values ==
          (strips_first ? std::vector<float>{0, 0, 9} : std::vector<float>{9, 0, 0}));
  }
}

TEST_CASE("ply: unknown properties are listed in one warning for each element") {
  CHECK(read(header(kTriangle) + kTriangleBody).warnings.empty());
  std::string elements = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n", row = "0 0 0";
  for (int i = 0; i < 100; ++i) {
    elements += "property float quality" + std::to_string(i) + std::string(200, 'q') + "\n";
    row += " 1";
  }
  elements += "element face 1\nproperty list uchar int vertex_indices\n";
  const MeshFile many = read(header(elements) + row + "\n" + row + "\n" + row + "\n3 0 1 2\n");
  REQUIRE(many.warnings.size() == 1);
  CHECK(contains(many.warnings[0], "'quality0qqq"));
  CHECK(contains(many.warnings[0], " and 88 more not understood"));
  CHECK(many.warnings[0].size() < 700);
}

namespace {

const std::string kCornerUvs = "property list uchar float texcoord\n";

/// A square of two triangles with the lists of texture coordinates `first` and `second` after their corners.
std::string square(const std::string& first, const std::string& second, const std::string& vertex_uvs = "") {
  const bool has_uvs = !vertex_uvs.empty();
  return header("element vertex 4\nproperty float x\nproperty float y\nproperty float z\n" +
                (has_uvs ? std::string("property float u\nproperty float v\n") : "") +
                "element face 2\nproperty list uchar int vertex_indices\n" + kCornerUvs) +
         "0 0 0" + vertex_uvs + "\n1 0 0" + vertex_uvs + "\n1 1 0" + vertex_uvs + "\n0 1 0" + vertex_uvs +
         "\n3 0 1 2 " + first + "\n3 0 2 3 " + second + "\n";
}

/// u and v of the corners of a triangle.
std::vector<float> corner_uvs(const Mesh& mesh, std::size_t triangle) {
  std::vector<float> uvs;
  for (const std::uint32_t vertex : mesh.triangles.at(triangle)) {
    uvs.push_back(mesh.uvs.at(vertex).x);
    uvs.push_back(mesh.uvs.at(vertex).y);
  }
  return uvs;
}

}  // namespace

TEST_CASE("ply: vertices are shared where texture coordinates of corners agree and split elsewhere") {
  const MeshFile same = read(square("6 0 0 1 0 1 1", "6 0 0 1 1 0 1"));
  CHECK(same.mesh.positions.size() == 4);
  CHECK(corner_uvs(same.mesh, 0) == std::vector<float>{0, 0, 1, 0, 1, 1});
  CHECK(corner_uvs(same.mesh, 1) == std::vector<float>{0, 0, 1, 1, 0, 1});
  CHECK(same.warnings.empty());
  const MeshFile seam = read(square("6 0 0 .5 0 .5 1", "6 .5 0 1 1 .5 1"), true);
  CHECK(seam.mesh.positions.size() == 6);
  CHECK(corner_uvs(seam.mesh, 0) == std::vector<float>{0, 1, 0.5f, 1, 0.5f, 0});
  CHECK(corner_uvs(seam.mesh, 1) == std::vector<float>{0.5f, 1, 1, 0, 0.5f, 0});
  CHECK(seam.is_split);
  for (std::size_t t = 0; t < 2; ++t) CHECK(area_normal(seam.mesh, t) == Vec3f{0, 0, 1});
  CHECK(seam.mesh.positions[seam.mesh.triangles[1][1]] == Vec3f{1, 1, 0});
}

TEST_CASE("ply: texture coordinates of corners override those of vertices unless no face has any") {
  CHECK(corner_uvs(read(square("6 0 0 1 0 1 1", "0", " 7 7")).mesh, 1) == std::vector<float>(6, 0));
  CHECK(corner_uvs(read(square("6 0 0 1 0 1 1", "0", " 7 7")).mesh, 0) == std::vector<float>{0, 0, 1, 0, 1, 1});
  const MeshFile none = read(square("0", "0", " 7 7"));
  CHECK(corner_uvs(none.mesh, 0) == std::vector<float>(6, 7));
  CHECK_FALSE(none.is_split);
  CHECK(read(square("0", "0")).mesh.uvs.empty());
}

TEST_CASE(
    "ply: texture coordinates of corners are read in binary and before the indices and with attributes and strips") {
  for (const Body::Encoding encoding : kEncodings) {
    Body body(encoding);
    for (const float c : {0.f, 0.f, 0.f, 10.f, 1.f, 0.f, 0.f, 11.f, 1.f, 1.f, 0.f, 12.f, 0.f, 1.f, 0.f, 13.f})
      body.put(c);
    body.put<std::uint8_t>(4).put(1).put(0).put(3).put(2);  // a strip
    body.put<std::uint8_t>(8);
    for (const double uv : {0., 0., 1., 0., 1., 1., 0., 1.}) body.put(uv);
    body.put<std::uint8_t>(4).put(0).put(1).put(2).put(3);
    body.put<std::uint8_t>(4);
    for (const double uv : {9., 9., 9., 9.}) body.put(uv);
    body.put<std::uint8_t>(2).put(0).put(1);  // too short: dropped with its coordinates
    body.put<std::uint8_t>(6);
    for (const double uv : {0.25, 0., 1., 1., 0., 1.}) body.put(uv);
    body.put<std::uint8_t>(3).put(0).put(2).put(3);
    const MeshFile file = read(
        "ply\n" + body.format() +
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float id_0\n"
        "element tristrips 1\nproperty list uchar int vertex_indices\n"
        "element face 3\nproperty list uchar double texcoord\nproperty list uchar int vertex_indices\nend_header\n" +
        body.text());
    const Mesh& mesh = file.mesh;
    REQUIRE(mesh.triangles.size() == 5);
    CHECK(corner_uvs(mesh, 0) == std::vector<float>(6, 0));
    CHECK(corner_uvs(mesh, 2) == std::vector<float>{0, 0, 1, 0, 1, 1});
    CHECK(corner_uvs(mesh, 3) == std::vector<float>{0, 0, 1, 1, 0, 1});
    CHECK(corner_uvs(mesh, 4) == std::vector<float>{0.25f, 0, 1, 1, 0, 1});
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const Vec3f p = mesh.positions[i];
      const float id = p.y > 0 ? (p.x > 0 ? 12.0f : 13.0f) : (p.x > 0 ? 11.0f : 10.0f);
      CHECK(mesh.attributes.at(0).values.at(i) == id);
    }
  }
}

TEST_CASE("ply: lists of texture coordinates of the wrong length are errors and NaN counts as 0") {
  CHECK(contains(
      error_in(square("6 0 0 1 0 1 1", "4 0 0 1 1")),
      "mesh.ply:16: row 1 of element 'face' (2 rows): list 'texcoord' has 4 numbers, expected two for each of 3 "
      "corners"));
  CHECK(contains(error_in(square("5 0 0 1 0 1", "0")), "has 5 numbers, expected two for each corner"));
  CHECK(contains(error_in(square("6 0 0 1 0 1 1", "200 0 0")), "truncated"));
  CHECK(corner_uvs(read(square("6 0 0 nan 0 1 inf", "0")).mesh, 0) == std::vector<float>{0, 0, 0, 0, 0, 0});
}

TEST_CASE("ply: the comment TextureFile names a texture and may contain spaces") {
  const auto texture = [](const std::string& comment) {
    return read(header(comment + kTriangle) + kTriangleBody).texture;
  };
  CHECK(texture("comment TextureFile my picture.png\ncomment TextureFile other.png\n") == "my picture.png");
  CHECK(texture("comment TextureFile\n").empty());
  CHECK(texture("comment texture a.png\n").empty());
}

}  // namespace sheaf::test_ply
