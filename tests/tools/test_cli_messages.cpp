// Messages of commands at each verbosity.
#include "core/image/exr.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <regex>

namespace sheaf::test_cli_messages {

using test::kScene;

namespace {

/// A folder with a scene.
struct Workplace {
  Workplace() { write_bytes(folder / "scene.xml", kScene); }
  std::string messages(const std::string& arguments) const {
    const Outcome outcome = run(folder, arguments);
    CHECK(outcome.code == 0);
    CHECK(outcome.out.empty());
    return outcome.err;
  }
  TemporaryFolder folder;
};

std::ptrdiff_t line_count(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

/// The scene without its light, and with a sampler that another one replaces: one warning and one note.
std::string dark_scene() {
  std::string scene = kScene;
  const std::size_t begin = scene.find("<emitter"), end = scene.find("</emitter>") + 10;
  scene.erase(begin, end - begin);
  scene.replace(scene.find("independent"), 11, "halton");
  return scene;
}

}  // namespace

TEST_CASE("messages: a render prints one line with size, samples, time, noise and files") {
  const Workplace workplace;
  const std::string text = workplace.messages("render scene.xml --replicates 4 -o out.exr -o out.png");
  CHECK(line_count(text) == 1);
  std::smatch found;
  const std::regex expected(
      R"(sheaf: rendered 24x16, 16 spp in [0-9.]+ m?s, noise ([0-9.]+) %; wrote out\.exr, out\.png\n)");
  REQUIRE(std::regex_match(text, found, expected));
  // The header records the same noise
  for (const ExrMetadata::Attribute& each : read_exr_attributes(workplace.folder / "out.exr"))
    if (each.name == "sheaf/noise") {
      const auto noise = static_cast<double>(std::get<float>(each.value));
      CHECK(std::atof(found[1].str().c_str()) == near(noise * 100, 0.06));
    }
}

TEST_CASE("messages: of similar warnings, the first three are printed and the others counted") {
  const Workplace workplace;
  write_bytes(workplace.folder / "flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n");
  const auto with_shapes = [](int count) {
    std::string scene = kScene, shapes;
    for (int i = 0; i < count; ++i)
      shapes += "<shape type=\"obj\"><string name=\"filename\" value=\"flat.obj\"/></shape>\n";
    return scene.insert(scene.find("<emitter"), shapes);
  };
  const std::string warning = "degenerate or non-finite triangles left out";
  const auto count_warnings = [&](const std::string& text) {
    int count = 0;
    for (std::size_t at = 0; (at = text.find(warning, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  write_bytes(workplace.folder / "few.xml", with_shapes(4));
  write_bytes(workplace.folder / "many.xml", with_shapes(6));
  const std::string few = workplace.messages("render few.xml -q"), many = workplace.messages("render many.xml -q");
  CHECK(count_warnings(few) == 4);
  CHECK_FALSE(contains(few, "more like"));
  CHECK(line_count(many) == 4);
  CHECK(contains(many, "sheaf: warning: 3 more like \"1 " + warning + "\"; -v prints them\n"));
  CHECK(count_warnings(workplace.messages("render many.xml -v")) == 6);
}

TEST_CASE("messages: each verbosity adds to the one below") {
  const Workplace workplace;
  write_bytes(workplace.folder / "dark.xml", dark_scene());
  const std::string errors = workplace.messages("render dark.xml -qq"),
                    warnings = workplace.messages("render dark.xml -q"), normal = workplace.messages("render dark.xml"),
                    details = workplace.messages("render dark.xml -v");
  CHECK(errors.empty());
  CHECK(warnings == "sheaf: warning: the scene has no lights: the image will be black\n");
  CHECK(contains(normal, warnings));
  CHECK(contains(normal, "'halton' is rendered with 'sobol'"));
  CHECK(contains(normal, "sheaf: rendered 24x16"));
  CHECK_FALSE(contains(normal, "camera_rays"));
  CHECK(contains(details, "camera_rays"));
  CHECK(contains(details, "sheaf: rendered 24x16"));
  CHECK(workplace.messages("render dark.xml --quiet") == warnings);
  CHECK(workplace.messages("render dark.xml --quiet --quiet").empty());
  // Errors are printed at every verbosity
  const Outcome failed = run(workplace.folder, "render nowhere.xml -qq");
  CHECK(failed.code == 3);
  CHECK(contains(failed.err, "nowhere.xml"));
}

TEST_CASE("messages: other commands print one line or none") {
  const Workplace workplace;
  REQUIRE(workplace.messages("render scene.xml -q -o noisy.exr --replicates 4 --aov albedo,normal,depth,half").empty());
  const std::string denoised = workplace.messages("denoise noisy.exr -o a.exr -o a.png");
  CHECK(line_count(denoised) == 1);
  CHECK(contains(denoised, "sheaf: denoised in "));
  CHECK(contains(denoised, "; wrote a.exr, a.png"));
  CHECK(workplace.messages("denoise noisy.exr -o a.exr -q").empty());
  for (const char* const crop : {"0,0,12,16 -o left.exr", "12,0,24,16 -o right.exr"})
    REQUIRE(workplace.messages("render scene.xml -q --crop " + std::string(crop)).empty());
  CHECK(workplace.messages("merge left.exr right.exr -o whole.exr") == "sheaf: merged 2 parts; wrote whole.exr\n");
  CHECK(workplace.messages("merge left.exr right.exr -o whole.exr -q").empty());
  CHECK(workplace.messages("farm scene.xml --parts 2 -q").empty());
}

TEST_CASE("messages: adaptive and interrupted renders report the samples taken") {
  const Workplace workplace;
  CHECK(contains(workplace.messages("render scene.xml --noise-target 40%"), " spp on average in "));
  const std::string stop = "timeout --foreground --preserve-status -s INT 2 ";
  const Outcome stopped = run(workplace.folder, "render scene.xml -D size=512 --spp 16000000 --threads 1", stop);
  CHECK(stopped.code == 130);
  const std::regex expected(
      R"(sheaf: interrupted: 512x16, [0-9.e+]+ of 16000000 spp in [0-9.]+ s(, noise [0-9.]+ %)?; wrote scene\.exr\n)");
  CAPTURE(stopped.err);
  CHECK(std::regex_match(stopped.err, expected));
}

TEST_CASE("messages: a terminal shows a progress bar that the summary replaces") {
  if (std::system("command -v script >/dev/null") != 0) {
    MESSAGE("skipped: script is missing (Debian package bsdutils)");
    return;
  }
  const Workplace workplace;
  const std::string command = SHEAF_EXECUTABLE " render scene.xml --spp 20000";
  const Outcome outcome = run(workplace.folder, "--version", "script -qec '" + command + "' typed.txt >/dev/null; ");
  CHECK(outcome.code == 0);
  const std::string typed = read_bytes(workplace.folder / "typed.txt");
  CHECK(contains(typed, " % "));
  CHECK(contains(typed, " elapsed, "));
  CHECK(contains(typed, "\r\x1b[Ksheaf: rendered 24x16"));
}

}  // namespace sheaf::test_cli_messages
