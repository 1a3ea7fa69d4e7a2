// Spellings of ASCII STL files: white space, capitals, names, numbers, several solids; and truncated files.
#include "scene/formats/stl.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace sheaf::test_stl_spelling {

using namespace test;

namespace {

const std::string kFacets =
    " facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 3 0 0\n   vertex 3 2 0\n  endloop\n endfacet\n"
    " facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 3 2 0\n   vertex 0 2 1.5\n  endloop\n endfacet\n";

std::string solid(const std::string& name, const std::string& facets = kFacets) {
  return "solid" + name + "\n" + facets + "endsolid" + name + "\n";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

MeshFile read(const std::string& bytes) {
  const TemporaryFolder folder;
  return read_stl(write_below(folder, "model.stl", bytes));
}

/// The message of the error, without the folder; empty without an error.
std::string message_of(const std::string& bytes) {
  const TemporaryFolder folder;
  return error_of(write_below(folder, "model.stl", bytes));
}

/// Whether the file is read as the two facets, without a warning.
bool is_read(const std::string& bytes, std::size_t solids = 1) {
  const MeshFile file = read(bytes);
  const Mesh expected = read(solid("")).mesh;
  return file.warnings.empty() && file.mesh.positions.size() == 4 && file.mesh.triangles.size() == 2 * solids &&
         file.mesh.positions[2].x == 3 && file.mesh.positions[3].z == 1.5f &&
         std::equal(expected.triangles.begin(), expected.triangles.end(), file.mesh.triangles.begin());
}

}  // namespace

TEST_CASE("stl: white space, byte order marks and capitals do not matter") {
  const std::string plain = solid(" plate");
  CHECK(is_read(plain));
  for (const char* const before : {" ", "\t", "\n\n", "\r\n  ", "\xef\xbb\xbf", "\xef\xbb\xbf \n"}) {
    CAPTURE(before);
    CHECK(is_read(before + plain));
  }
  CHECK(is_read(replaced(plain, "\n", "\r\n")));
  CHECK(is_read(replaced(plain, "\n", "\r")));
  CHECK(is_read(replaced(plain, "\n", " ")));
  CHECK(is_read(replaced(plain, " ", "  \t\v\f ")));
  CHECK(is_read(plain.substr(0, plain.size() - 1)));
  CHECK(is_read(plain + "\n \n\t"));
  std::string capitals = plain, mixed = plain;
  std::transform(plain.begin(), plain.end(), capitals.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  for (std::size_t i = 0; i < mixed.size(); i += 2)
    mixed[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(plain[i])));
  CHECK(is_read(capitals));
  CHECK(is_read(mixed));
  for (const char* const word : {"facet", "loop", "solid"})
    CHECK(is_read(replaced(plain, std::string("end") + word, std::string("end ") + word)));
  CHECK(contains(message_of(std::string("\xff\xfes\0o\0l\0i\0d\0", 12)), "UTF-16"));
}

TEST_CASE("stl: solids have any names, and several of them make one mesh") {
  for (const char* const name :
       {"", " ", " facet", " solid", " endsolid", " vertex", " vertex 1 2 3", " facet normal", " facet normal 0 0 1",
        " outer loop", " end", " made by a program (2.1), 5 parts", " \xc3\xa4 \xe2\x82\xac", "_with_underscore"}) {
    CAPTURE(name);
    CHECK(is_read(solid(name)));
    CHECK(is_read(replaced(solid(name), "\n", "\r\n")));
    CHECK(is_read(solid(name) + solid(" b") + solid(name), 3));
  }
  CHECK(is_read("solid\n" + kFacets + "endsolid other name\n"));
  CHECK(is_read(replaced(solid(" several words") + solid(" facet"), "\n", " "), 2));
  // Many solids in one line
  std::string many;
  for (int i = 0; i < 20000; ++i) many += replaced(solid(" a"), "\n", "\r");
  CHECK(is_read(many, 20000));
  // An empty solid beside others
  CHECK(is_read("solid a\nendsolid a\n" + solid(" b")));
}

TEST_CASE("stl: numbers have signs and exponents") {
  const auto first = [](const std::string& number) {
    const Mesh mesh = read(replaced(solid(""), "vertex 3 0 0", "vertex " + number + " 0 0")).mesh;
    return mesh.positions.at(mesh.triangles.at(0)[1]).x;
  };
  CHECK(first("+3") == 3);
  CHECK(first("+3.25e+00") == 3.25f);
  CHECK(first("-1.5E-02") == -0.015f);
  CHECK(first("3.") == 3);
  CHECK(first(".5") == 0.5f);
  CHECK(first("000.5e1") == 5);
  CHECK(first("1e-300") == 0);
  CHECK(first("1e-9999") == 0);
  CHECK(first("1.0000000001") == near(1, 1e-6));
  for (const char* const number : {"++3", "+-3", "3x", "0x3", "1,5", "e5", "+", "-"}) {
    CAPTURE(number);
    CHECK(contains(message_of(replaced(solid(""), "vertex 3 0 0", std::string("vertex ") + number + " 0 0")),
                   "model.stl:5: " + std::string("'") + number + "' is not a number"));
  }
  for (const char* const number : {"1e39", "-4e38", "1e9999"})
    CHECK(contains(message_of(replaced(solid(""), "vertex 3 0 0", std::string("vertex ") + number + " 0 0")),
                   "model.stl:5: '" + std::string(number) + "' is too large"));
  // Normals are ignored, whatever they are
  CHECK(is_read(replaced(solid(" a"), "normal 0 0 1", "normal nan -nan(ind) 1.#QNAN")));
}

TEST_CASE("stl: truncated and malformed text") {
  const std::string whole = solid(" plate");
  // Anywhere inside a facet, but for a number that is shorter than it was
  for (const char* const last : {"vertex 3 2", "vertex 0 2 1.5\n", "endloop", "outer loop", "vertex"}) {
    CAPTURE(last);
    const std::string part = whole.substr(0, whole.rfind(last) + std::strlen(last));
    CHECK(contains(message_of(part), "ends inside a triangle: the file is truncated"));
  }
  const MeshFile open = read(whole.substr(0, whole.rfind("endsolid")));
  CHECK(open.mesh.triangles.size() == 2);
  REQUIRE(open.warnings.size() == 1);
  CHECK(contains(open.warnings[0], "ends without 'endsolid'"));
  CHECK(read(replaced(whole.substr(0, whole.rfind("endsolid")), "endfacet", "end facet")).mesh.triangles.size() == 2);
  CHECK(
      contains(message_of(replaced(whole, "   vertex 3 0 0\n", "")), "model.stl:7: a facet does not have 3 vertices"));
  CHECK(contains(message_of(replaced(whole, "vertex 3 0 0", "vertex 3 0 0 vertex 4 0 0")),
                 "model.stl:8: a facet does not have 3 vertices"));
}

TEST_CASE("stl: truncated binary files say what is missing") {
  std::string bytes(84 + 2 * 50, '\0');
  bytes[80] = 2;
  std::memcpy(bytes.data() + 84 + 24, "\0\0\x80\x3f", 4);   // x of a corner: 1
  std::memcpy(bytes.data() + 134 + 28, "\0\0\x80\x3f", 4);  // y of a corner: 1
  CHECK(read(bytes).mesh.triangles.size() == 2);
  for (const char* const header : {"", "solid part", " SOLID part"}) {
    CAPTURE(header);
    std::memcpy(bytes.data(), header, std::strlen(header));
    CHECK(read(bytes).mesh.triangles.size() == 2);
    CHECK(
        contains(message_of(bytes.substr(0, 183)),
                 "model.stl: is a truncated binary STL file, or not an STL file: its header announces 2 triangles (184 "
                 "bytes), but the file has 183 bytes"));
  }
  CHECK(contains(message_of("nothing"), "model.stl: is not an STL file (ASCII files begin with 'solid'"));
  CHECK(contains(message_of(""), "is not an STL file"));
}

}  // namespace sheaf::test_stl_spelling
