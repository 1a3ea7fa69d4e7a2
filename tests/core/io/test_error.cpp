// User messages: source locations, exit codes, nearest names.
#include "core/io/error.h"

#include <doctest/doctest.h>

namespace sheaf::test_error {

TEST_CASE("error: messages begin with their file and line") {
  CHECK(std::string(Error(ExitCode::kUsage, "no input").what()) == "no input");
  CHECK(std::string(SceneError(SourceLocation{"a.xml", 12}, "bad").what()) == "a.xml:12: bad");
  CHECK(std::string(SceneError(SourceLocation{"a.xml", 0}, "bad").what()) == "a.xml: bad");
  CHECK(std::string(SceneError(SourceLocation{"", 7}, "bad").what()) == "bad");
}

TEST_CASE("error: locations share the name of their file") {
  const SourceLocation first{"a.xml", 1}, copy = first;
  CHECK(&copy.file.string() == &first.file.string());
  CHECK(copy == first);
  CHECK(SourceLocation{std::string("a.xml"), 1} == first);
  CHECK_FALSE(SourceLocation{"b.xml", 1} == first);
  CHECK_FALSE(SourceLocation{"", 1} == first);
  CHECK(SourceLocation{}.file.empty());
  CHECK(SourceLocation{}.file.string().empty());
  CHECK(SourceLocation{"", 2} == SourceLocation{{}, 2});
}

TEST_CASE("error: errors of scenes carry their place and element and code") {
  using Code = SceneErrorCode;
  const SceneError plain("bad");
  CHECK(plain.where() == SourceLocation{});
  CHECK(plain.element().empty());
  CHECK(plain.code() == Code::kInvalid);
  const SceneError error = SceneError(SourceLocation{"a.ply", 12}, "bad", Code::kTooLarge).about("<shape>");
  CHECK(error.where() == SourceLocation{"a.ply", 12});
  CHECK(error.about("<scene>").element() == "<shape>");
  // Another place precedes the message
  const SourceLocation scene{"a.xml", 3};
  const SceneError placed = at_location(scene, error);
  CHECK(std::string(placed.what()) == "a.xml:3: a.ply:12: bad");
  CHECK(placed.where() == scene);
  CHECK(placed.element() == "<shape>");
  CHECK(placed.code() == Code::kTooLarge);
  CHECK(std::string(at_location(scene, placed).what()) == placed.what());
  CHECK(std::string(at_location(scene, plain).what()) == "a.xml:3: bad");
}

TEST_CASE("error: exit codes match the documented ones") {
  CHECK(SceneError("x").exit_code() == ExitCode::kScene);
  CHECK(Error(ExitCode::kOutput, "x").exit_code() == ExitCode::kOutput);
  CHECK(static_cast<int>(ExitCode::kDone) == 0);
  CHECK(static_cast<int>(ExitCode::kRuntime) == 1);
  CHECK(static_cast<int>(ExitCode::kUsage) == 2);
  CHECK(static_cast<int>(ExitCode::kScene) == 3);
  CHECK(static_cast<int>(ExitCode::kOutput) == 4);
  CHECK(static_cast<int>(ExitCode::kCheckpoint) == 5);
  CHECK(static_cast<int>(ExitCode::kInterrupted) == 130);
  CHECK(static_cast<int>(ExitCode::kTerminated) == 143);
}

TEST_CASE("error: the suggested name is the one with the fewest edits") {
  const std::vector<std::string> names = {"diffuse", "dielectric", "conductor", "roughconductor", "twosided", "area"};
  CHECK(nearest_name("difuse", names) == "diffuse");
  CHECK(nearest_name("difusse", names) == "diffuse");
  CHECK(nearest_name("Diffuse", names) == "diffuse");
  CHECK(nearest_name("dielectrik", names) == "dielectric");
  CHECK(nearest_name("rough_conductor", names) == "roughconductor");
  CHECK(nearest_name("conductor", names) == "conductor");
  CHECK(nearest_name("two-sided", names) == "twosided");
  CHECK(nearest_name("aera", names) == "area");
  CHECK(nearest_name("DIFFUSE", names) == "diffuse");
  CHECK(nearest_name("--ara", {"--area", "--are-you"}) == "--area");
  // No name is similar, but one starts with it.
  CHECK(nearest_name("conduc", names) == "conductor");
}

TEST_CASE("error: nothing is suggested for dissimilar names") {
  const std::vector<std::string> names = {"diffuse", "area"};
  CHECK(nearest_name("xyzzyplugh", names).empty());
  CHECK(nearest_name("diffuse", {}).empty());
  CHECK(nearest_name("", names).empty());
  CHECK(nearest_name("--env", {"--aov", "--fov"}).empty());
  CHECK(nearest_name("spot", {"hdr", "png", "point"}).empty());
  CHECK(nearest_name("di", {"diffuse"}).empty());
  CHECK(nearest_name(std::string(1u << 20, 'a'), names).empty());
  CHECK(did_you_mean("xyzzyplugh", names).empty());
  CHECK(did_you_mean("difuse", names) == ", did you mean 'diffuse'?");
}

}  // namespace sheaf::test_error
