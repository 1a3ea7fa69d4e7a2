// Polygons of imported models: concave ones, and those with holes.
#include "scene/formats/model_import.h"
#include "tests/support/files/import_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace sheaf::test_import_polygons {

using namespace test;

namespace {

using Outline = std::vector<std::array<double, 2>>;

/// Simple outlines, counter-clockwise, some with corners on straight edges.
std::vector<Outline> outlines() {
  Outline comb = {{0, 0}, {9, 0}};
  for (int i = 4; i >= 0; --i)
    comb.insert(comb.end(), {{2.0 * i + 1, 3}, {2.0 * i, 3}, {2.0 * i, 1}, {2.0 * i - 1, 1}});
  comb.resize(comb.size() - 2);
  return {{{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}},
          {{0, 0}, {4, 2}, {0, 4}, {1, 2}},
          {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 3}, {0, 3}},
          {{0, 0}, {2, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 3}, {4, 3}, {4, 4}, {0, 4}, {0, 2}},
          comb};
}

double area(const Outline& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto &a = outline[i], &b = outline[(i + 1) % outline.size()];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum / 2;
}

/// Every outline from every first corner and in both senses.
std::vector<Outline> variants() {
  std::vector<Outline> out;
  for (const Outline& outline : outlines())
    for (std::size_t first = 0; first < outline.size(); ++first)
      for (const bool reversed : {false, true}) {
        Outline variant = outline;
        std::rotate(variant.begin(), variant.begin() + static_cast<std::ptrdiff_t>(first), variant.end());
        if (reversed) std::reverse(variant.begin(), variant.end());
        out.push_back(std::move(variant));
      }
  return out;
}

/// A point of the plane of polygon i: y and x of the outline are in the plane z = 4 i + 0.5 y.
std::vector<double> lifted(const std::array<double, 2>& p, std::size_t i) {
  return {p[0], p[1], 4.0 * static_cast<double>(i) + 0.5 * p[1]};
}

/// Triangles of a read file, in world space and file units, by polygon. Checks that normals and texture coordinates
/// belong to the corners.
struct Coverage {
  double area = 0;       ///< signed, in the plane of x and y
  double magnitude = 0;  ///< sum of absolute areas
};
std::map<int, Coverage> coverage_of(const Description& d, double scale, bool has_uvs) {
  std::map<int, Coverage> out;
  for (const ShapeDescription& shape : d.shapes) {
    const auto* mesh = std::get_if<Mesh>(&shape.geometry);
    if (mesh == nullptr) continue;
    for (const auto& t : mesh->triangles) {
      std::array<std::array<double, 3>, 3> p;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f world = shape.to_world.point(mesh->positions[t[k]]);
        p[k] = {scale * world.x, scale * world.y, scale * world.z};
        if (!has_uvs) continue;
        CHECK(mesh->uvs[t[k]].x == within(p[k][0] / 16, 1e-5));
        CHECK(mesh->uvs[t[k]].y == within(p[k][1] / 16, 1e-5));
      }
      const double twice = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
      for (std::size_t k = 0; k < 3; ++k)
        if (!mesh->normals.empty()) CHECK(shape.to_world.normal(mesh->normals[t[k]]).z * twice >= 0);
      Coverage& polygon = out[static_cast<int>(std::lround((p[0][2] - 0.5 * p[0][1]) / 4))];
      polygon.area += twice / 2;
      polygon.magnitude += std::abs(twice) / 2;
    }
  }
  return out;
}

/// A file whose polygons are the given <polygons> or <polylist> elements; corners have texture coordinates x/16, y/16.
std::string polygon_file(const std::vector<std::array<double, 3>>& corners, const std::string& elements) {
  std::vector<double> positions, uvs;
  for (const auto& c : corners) {
    positions.insert(positions.end(), c.begin(), c.end());
    uvs.insert(uvs.end(), {c[0] / 16, c[1] / 16});
  }
  return collada_file("<geometry id='g'><mesh>" + collada_source("p", positions, 3) + collada_source("t", uvs, 2) +
                          "<vertices id='v'><input semantic='POSITION' source='#p'/></vertices>" + elements +
                          "</mesh></geometry>",
                      "<node id='n'><instance_geometry url='#g'/></node>");
}
constexpr const char* kInputs =
    "<input semantic='VERTEX' source='#v' offset='0'/><input semantic='TEXCOORD' source='#t' offset='1' set='0'/>";

Description read_as(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  ReadOptions options;
  options.surroundings.default_studio = Studio::kNone;
  return read_scene(write_below(folder, name, bytes), options);
}

/// The indices of corners [begin, end), each twice: for position and texture coordinate.
std::string indices(std::size_t begin, std::size_t end, bool reversed = false) {
  std::string out;
  for (std::size_t i = begin; i < end; ++i) {
    const std::string number = std::to_string(reversed ? begin + end - 1 - i : i);
    out += number + " " + number + " ";
  }
  return out;
}

}  // namespace

TEST_CASE("import: concave polygons are covered exactly for every first corner and both senses") {
  if (!can_import_models()) return;
  const std::vector<Outline> all = variants();
  std::vector<std::array<double, 3>> corners;
  std::string counts, list;
  FbxFile fbx;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t begin = corners.size();
    std::vector<double> vertices;
    for (const auto& p : all[i]) {
      const std::vector<double> v = lifted(p, i);
      corners.push_back({v[0], v[1], v[2]});
      vertices.insert(vertices.end(), v.begin(), v.end());
    }
    counts += std::to_string(all[i].size()) + " ";
    list += indices(begin, corners.size());
    fbx.add_polygon(vertices, fbx.add_model("m" + std::to_string(i), "Mesh", {}));
  }
  const std::string dae = polygon_file(corners, "<polylist count='" + std::to_string(all.size()) + "'>" + kInputs +
                                                    "<vcount>" + counts + "</vcount><p>" + list + "</p></polylist>");
  struct File {
    const char* name;
    std::string bytes;
    double scale;  ///< file units per meter
  };
  for (const File& file : {File{"a.dae", dae, 1}, {"a.fbx", fbx.text(), 100}, {"b.fbx", fbx.binary(7400), 100}}) {
    CAPTURE(file.name);
    const Description d = read_as(file.name, file.bytes);
    CHECK(d.notes.empty());
    const std::map<int, Coverage> covered = coverage_of(d, file.scale, file.name[2] == 'd');
    REQUIRE(covered.size() == all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      CAPTURE(i);
      const Coverage& polygon = covered.at(static_cast<int>(i));
      CHECK(polygon.area == near(area(all[i]), 1e-4));
      CHECK(polygon.magnitude == near(std::abs(area(all[i])), 1e-4));
    }
  }
}

TEST_CASE("import: holes of COLLADA polygons stay open") {
  if (!can_import_models()) return;
  struct Case {
    Outline outline;
    std::vector<Outline> holes;
  };
  const auto square = [](double x, double y, double half) {
    return Outline{{x - half, y - half}, {x + half, y - half}, {x + half, y + half}, {x - half, y + half}};
  };
  std::vector<Case> cases = {
      {square(0, 0, 1), {square(0, 0, 0.5)}},
      {square(0, 0, 4), {square(-2, 0, 1), square(2, 0, 1), square(0, 3, 0.5)}},
      {square(0, 0, 4), {square(-2, -2, 1), square(-2, 2, 1), square(2, -2, 1), square(2, 2, 1)}},
      {outlines()[0], {{{-0.5, -0.5}, {-0.25, -0.75}, {-0.25, -0.5}}}},
      {outlines()[4], {square(1, 0.5, 0.25), square(4.5, 0.5, 0.25), {{0.25, 2}, {0.75, 1.5}, {0.75, 2.5}}}},
      {{{0, 0}, {8, 0}, {8, 8}, {0, 8}}, {{{1, 1}, {7, 1}, {7, 7}, {6, 7}, {6, 2}, {1, 2}}, square(3, 5, 1)}}};
  std::vector<std::array<double, 3>> corners;
  std::string elements;
  std::vector<double> expected;
  for (const Case& c : cases)
    for (int sense = 0; sense < 4; ++sense) {
      const std::size_t number = expected.size();
      const auto add = [&](const Outline& outline, bool reversed) {
        const std::size_t begin = corners.size();
        for (const auto& p : outline) {
          const std::vector<double> v = lifted(p, number);
          corners.push_back({v[0], v[1], v[2]});
        }
        return indices(begin, corners.size(), reversed);
      };
      const bool is_reversed = (sense & 1) != 0;
      expected.push_back((is_reversed ? -1 : 1) * area(c.outline));
      std::string ph = "<p>" + add(c.outline, is_reversed) + "</p>";
      for (const Outline& hole : c.holes) {
        ph += "<h>" + add(hole, (sense & 2) != 0) + "</h>";
        expected.back() -= (is_reversed ? -1 : 1) * area(hole);
      }
      elements += std::string("<polygons count='1'>") + kInputs + "<ph>" + ph + "</ph></polygons>";
    }
  const Description d = read_as("a.dae", polygon_file(corners, elements));
  CHECK(d.notes.empty());
  const std::map<int, Coverage> covered = coverage_of(d, 1, true);
  REQUIRE(covered.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CAPTURE(i);
    CHECK(covered.at(static_cast<int>(i)).area == near(expected[i], 1e-4));
    CHECK(covered.at(static_cast<int>(i)).magnitude == near(std::abs(expected[i]), 1e-4));
  }
}

TEST_CASE("import: holes that cross the outline are left out with a note") {
  if (!can_import_models()) return;
  const std::vector<std::array<double, 3>> corners = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0},
                                                      {5, 5, 0}, {6, 5, 0}, {6, 6, 0}};
  const std::string polygons = std::string("<polygons count='1'>") + kInputs + "<ph><p>" + indices(0, 4) + "</p><h>" +
                               indices(4, 7) + "</h></ph></polygons>";
  const Description d = read_as("a.dae", polygon_file(corners, polygons));
  CHECK(coverage_of(d, 1, true).at(0).area == near(4));
  REQUIRE(d.notes.size() == 1);
  CHECK(contains(d.notes[0], "1 holes of polygons are left out"));
}

TEST_CASE("import: degenerate and self-intersecting polygons do not crash") {
  if (!can_import_models()) return;
  std::vector<std::array<double, 3>> corners;
  for (int i = 0; i < 5; ++i) corners.push_back({double(i), 0, 0});  // a line
  // An outline without ears
  corners.insert(corners.end(), {{0, 2, 4}, {3, 2, 4}, {3, 1, 4}, {2, 0, 4}, {2, 4, 4}});
  for (int i = 0; i < 5; ++i) corners.push_back({0, 0, 8});  // a point
  for (int i = 0; i < 5; ++i)
    corners.push_back({std::cos(1.257 * i), std::sin(1.257 * i), 12 + 3.0 * (i % 2)});  // not flat
  for (const char* tag : {"p", "ph"}) {
    std::string elements = std::string("<polygons count='4'>") + kInputs;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::string outline = "<p>" + indices(5 * i, 5 * i + 5) + "</p>";
      elements +=
          tag[1] == 'h' ? "<ph>" + outline + "<h>" + indices(5 * i, 5 * i + 3) + "</h><h>1</h><h/></ph>" : outline;
    }
    const Description d = read_as("a.dae", polygon_file(corners, elements + "</polygons>"));
    CHECK(!d.shapes.empty());
    CHECK(std::any_of(d.notes.begin(), d.notes.end(), [](const std::string& note) {
      return contains(note, "1 self-intersecting polygons are triangulated approximately");
    }));
  }
  // Without an outline, and with vertices that do not exist
  for (const char* ph : {"<ph/>", "<ph><h>0 0 1 1 2 2</h></ph>", "<ph><p/><h>0 0 1 1 2 2</h></ph>",
                         "<ph><p>0 0 1 1 900 900</p><h>-5 0 x 1 2 2</h></ph>"}) {
    const TemporaryFolder folder;
    error_of(write_below(folder, "a.dae",
                         polygon_file(corners, std::string("<polygons count='1'>") + kInputs + ph + "</polygons>")));
  }
}

}  // namespace sheaf::test_import_polygons
