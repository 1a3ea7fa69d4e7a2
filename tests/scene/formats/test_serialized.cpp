// Serialized meshes of Mitsuba, written byte by byte: versions, flags, dictionaries, and inconsistent files.
#include "scene/formats/serialized.h"
#include "tests/support/files/deflate.h"
#include "tests/support/files/mesh_files.h"

#include <doctest/doctest.h>

#include <cstring>
#include <limits>
#include <random>

namespace sheaf::test_serialized {

using namespace test;

namespace {

template <class T> std::string raw(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

/// One mesh of a file, by default a square of two triangles.
struct Written {
  std::uint32_t flags = 0;
  std::uint16_t version = 4, magic = 0x041c;
  std::uint64_t vertices = 4, triangles = 2;
  std::vector<std::uint32_t> indices{0, 1, 2, 0, 2, 3};
  float x = 1;  ///< right side of the square

  std::string numbers(const std::vector<double>& values) const {
    std::string bytes;
    for (const double v : values) bytes += (flags & 0x2000) != 0 ? raw(v) : raw(static_cast<float>(v));
    return bytes;
  }
  std::string content() const {
    std::string bytes = raw(flags) + (version == 4 ? std::string("name") + '\0' : "") + raw(vertices) + raw(triangles);
    bytes += numbers({0, 0, 0, x, 0, 0, x, 1, 0, 0, 1, 0.25});
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    if ((flags & 0x1) != 0) bytes += numbers({0, 0, 1, 0, 0, 1, 0, 0, 2, 0, 0, kNan});
    if ((flags & 0x2) != 0) bytes += numbers({0, 0, 1, 0, 1, 0.75, 0, 1});
    if ((flags & 0x8) != 0) bytes += numbers({1, 0, 0, 0, 1, 0, 0, 0, 1, 0.25, 0.5, 0.75});
    for (const std::uint32_t index : indices) bytes += raw(index);
    return bytes;
  }
  std::string bytes() const { return raw(magic) + raw(version) + deflated(content()); }
};

std::string file_of(const std::vector<Written>& meshes) {
  std::string bytes, dictionary;
  for (const Written& mesh : meshes) {
    const std::uint64_t offset = bytes.size();
    dictionary += meshes[0].version == 4 ? raw(offset) : raw(static_cast<std::uint32_t>(offset));
    bytes += mesh.bytes();
  }
  return bytes + dictionary + raw(static_cast<std::uint32_t>(meshes.size()));
}

MeshFile read(const std::string& bytes, int index = 0) {
  const TemporaryFile file("mesh.serialized", bytes);
  return read_serialized(file.path(), index);
}

std::string error_in(const std::string& bytes, int index = 0) {
  return error_of([&] { read(bytes, index); });
}

}  // namespace

TEST_CASE("serialized: every combination of version and precision and arrays is read") {
  for (const std::uint16_t version : {std::uint16_t{3}, std::uint16_t{4}}) {
    for (const std::uint32_t precision : {0x1000u, 0x2000u, 0u}) {
      for (std::uint32_t arrays = 0; arrays < 16; ++arrays) {
        const std::uint32_t flags = precision | (arrays & 3) | ((arrays & 4) << 1) | ((arrays & 8) << 1);
        const MeshFile file = read(file_of({{flags, version}}));
        const Mesh& mesh = file.mesh;
        CHECK(mesh.positions == std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.25f}});
        CHECK(mesh.triangles == decltype(mesh.triangles){{0, 1, 2}, {0, 2, 3}});
        CHECK(file.face_normals == ((flags & 0x10) != 0));
        CHECK(file.warnings.empty());
        REQUIRE(mesh.normals.size() == ((flags & 1) != 0 ? 4 : 0));
        REQUIRE(mesh.uvs.size() == ((flags & 2) != 0 ? 4 : 0));
        REQUIRE(mesh.attributes.size() == ((flags & 8) != 0 ? 1 : 0));
        const std::vector<Vec3f> normals{{0, 0, 1}, {0, 0, 1}, {0, 0, 2}, {0, 0, 0}};
        if (!mesh.normals.empty()) CHECK(mesh.normals == normals);
        if (!mesh.uvs.empty()) CHECK(mesh.uvs[2].y == 0.75f);
        if (mesh.attributes.empty()) continue;
        CHECK(mesh.attributes[0].name == "vertex_color");
        CHECK(mesh.attributes[0].channels == 3);
        CHECK(mesh.attributes[0].values == std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0.25f, 0.5f, 0.75f});
      }
    }
  }
}

TEST_CASE("serialized: meshes are selected by index") {
  for (const std::uint16_t version : {std::uint16_t{3}, std::uint16_t{4}}) {
    std::vector<Written> meshes(5);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      meshes[i].version = version;
      meshes[i].x = float(i + 1);
    }
    const std::string bytes = file_of(meshes);
    for (int i = 0; i < 5; ++i) CHECK(read(bytes, i).mesh.positions[1].x == float(i + 1));
    CHECK(contains(error_in(bytes, 5), "no mesh 5 (counted from 0), the file holds 5 meshes"));
    CHECK(contains(error_in(bytes, -1), "no mesh -1"));
    CHECK(contains(error_in(bytes, std::numeric_limits<int>::max()), "the file holds 5 meshes"));
  }
  CHECK(read(Written{}.bytes()).mesh.triangles.size() == 2);  // without a dictionary
}

TEST_CASE("serialized: shapes read their mesh by file name and index") {
  const TemporaryFile file("mesh.serialized", file_of({{}, {0, 4, 0x041c, 4, 2, {0, 1, 2, 0, 2, 3}, 7}}));
  MeshFileShape shape;
  shape.file = file.path();
  shape.format = "serialized";
  shape.shape_index = 1;
  CHECK(read_mesh(shape).mesh.positions[1].x == 7.0f);
}

TEST_CASE("serialized: malformed headers and dictionaries are errors") {
  CHECK(contains(error_of([] { read_serialized("/nowhere/at/all.serialized", 0); }), "not found"));
  CHECK(contains(error_in(""), "begins with the bytes 1c 04"));
  CHECK(contains(error_in("ply\nformat"), "begins with the bytes 1c 04"));
  Written old;
  old.version = 2;
  CHECK(contains(error_in(old.bytes()), "mesh.serialized: expected version 3 or 4 of the serialized format, found 2"));
  const std::string valid = file_of({{}, {}});
  CHECK(contains(error_in(valid.substr(0, valid.size() - 4) + raw(0xffffffffu), 1), "to hold 4294967295 meshes"));
  CHECK(contains(error_in(valid.substr(0, valid.size() - 4) + raw(0u), 1), "holds 0 meshes"));
  const std::string headless = valid.substr(0, valid.size() - 12);  // without the second offset and the count
  CHECK(contains(error_in(headless + raw(std::uint64_t{1} << 62) + raw(2u), 1), "beyond the end"));
  CHECK(contains(error_in(headless + raw(std::uint64_t{valid.size() - 20}) + raw(2u), 1), "beyond the end"));
  CHECK(contains(error_in(headless + raw(std::uint64_t{5}) + raw(2u), 1), "at byte 5"));
  // A mesh whose header reaches into the dictionary, where the number 4 is read as its version.
  const std::string first = Written{}.bytes();
  const std::string short_header = first + "\x1c\x04" + raw(std::uint64_t{4}) + raw(std::uint64_t{first.size()});
  CHECK(contains(error_in(short_header + raw(2u), 1), "beyond the end"));
  CHECK(contains(error_in(raw(std::uint16_t{0x041c}) + raw(std::uint16_t{4}) + raw(2u), 1), "truncated"));
}

TEST_CASE("serialized: counts that the file cannot hold are errors and not allocations") {
  for (const std::uint64_t count : {std::uint64_t{100'000'000}, std::uint64_t{0xffffffff}, std::uint64_t{1} << 32,
                                    std::numeric_limits<std::uint64_t>::max()}) {
    Written many;
    many.vertices = count;
    const bool is_beyond = count > 0xffffffff;
    CHECK(contains(error_in(many.bytes()), is_beyond ? "more than 2^32 - 1 vertices" : "size allows: truncated?"));
    many.vertices = 4;
    many.triangles = count;
    CHECK(contains(error_in(many.bytes()), is_beyond ? "more than 2^32 - 1 triangles" : "size allows: truncated?"));
  }
  Written few;
  few.vertices = 1000;  // plausible but missing
  CHECK(contains(error_in(few.bytes()), "truncated"));
  few.vertices = 4;
  few.triangles = 0;
  CHECK(contains(error_in(few.bytes()), "no triangles"));
  few.triangles = 2;
  few.indices = {0, 1, 2, 0, 2, 4};
  CHECK(contains(error_in(few.bytes()), "triangle 1 refers to vertex 4 (counted from 0), but there are 4"));
  // In lenient mode such triangles are dropped, unless none remains.
  const TemporaryFile file("mesh.serialized", few.bytes());
  const MeshFile whole = read_serialized(file.path(), 0, BadFaces::kDrop);
  CHECK(whole.mesh.triangles == decltype(whole.mesh.triangles){{0, 1, 2}});
  REQUIRE(whole.warnings.size() == 1);
  CHECK(contains(whole.warnings[0], "faces left out: 1 (triangle 1 refers to vertex 4"));
  few.indices = {9, 1, 2, 0, 2, 4};
  const TemporaryFile none("mesh.serialized", few.bytes());
  CHECK(contains(error_of([&] { read_serialized(none.path(), 0, BadFaces::kDrop); }), "no triangle is complete"));
  const std::string endless = raw(std::uint32_t{0}) + std::string(10'000'000, 'x');
  CHECK(contains(error_in(raw(std::uint16_t{0x041c}) + raw(std::uint16_t{4}) + deflated(endless)), "does not end"));
}

TEST_CASE("serialized: truncated files are errors and randomly edited ones give a mesh or an error") {
  const std::string valid = Written{0x200b}.bytes();
  for (std::size_t size = 0; size + 5 < valid.size(); ++size) CHECK_FALSE(error_in(valid.substr(0, size)).empty());
  std::mt19937 random(17);
  const std::string pair = file_of({{0x100b}, {0x200b, 3}});
  for (int round = 0; round < 500; ++round) {
    std::string bytes = pair;
    for (int edit = 0; edit < 2; ++edit) bytes[random() % bytes.size()] = static_cast<char>(random());
    error_of([&] {
      const Mesh mesh = read(bytes, round % 2).mesh;
      for (const auto& t : mesh.triangles) CHECK(std::max({t[0], t[1], t[2]}) < mesh.positions.size());
    });
  }
  for (int round = 0; round < 500; ++round) {  // a valid stream of random bytes
    std::string content = Written{0x100b}.content();
    for (int edit = 0; edit < 2; ++edit) content[random() % content.size()] = static_cast<char>(random());
    error_of([&] { read(raw(std::uint16_t{0x041c}) + raw(std::uint16_t{4}) + deflated(content)); });
  }
}

}  // namespace sheaf::test_serialized
