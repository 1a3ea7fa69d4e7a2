// Tables of names: lookup in both directions, lists and errors.
#include "core/io/name_table.h"

#include <doctest/doctest.h>

namespace sheaf::test_name_table {

enum class Shape { kRound, kSquare };
constexpr NameTable<Shape> kShapes{{{"round", Shape::kRound}, {"square", Shape::kSquare}, {"ball", Shape::kRound}}};

TEST_CASE("name table: each name has one value and the first name of a value is its own") {
  static_assert(*kShapes.find("ball") == Shape::kRound);
  static_assert(kShapes.find("cube") == nullptr);
  CHECK(std::string(kShapes.name_of(Shape::kRound)) == "round");
  CHECK(std::string(kShapes.name_of(static_cast<Shape>(7))).empty());
  CHECK(kShapes.names() == std::vector<std::string>{"round", "square", "ball"});
}

TEST_CASE("name table: an unknown option is a usage error with the nearest name") {
  CHECK(kShapes.option("shape", "square") == Shape::kSquare);
  CHECK_THROWS_WITH_AS(kShapes.option("shape", "sqare"),
                       "unknown shape 'sqare', did you mean 'square'? (known: round, square, ball)", Error);
  try {
    kShapes.option("shape", "cube");
  } catch (const Error& error) { CHECK(error.exit_code() == ExitCode::kUsage); }
}

TEST_CASE("name table: messages list the names") {
  CHECK(joined({"a", "b"}) == "a, b");
  CHECK(known_names({"a", "b"}) == " (known: a, b)");
  CHECK(known_names({}) == " (known: none)");
  CHECK(one_of({"a"}) == "a");
  CHECK(one_of({"a", "b"}) == "a or b");
  CHECK(one_of({"a", "b", "c"}) == "a, b or c");
}

}  // namespace sheaf::test_name_table
