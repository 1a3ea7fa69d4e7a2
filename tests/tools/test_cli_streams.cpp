// Scenes from the standard input, images to the standard output, and the JSON of `info`.
#include "core/image/exr.h"
#include "scene/formats/model_import.h"
#include "tests/support/capture.h"
#include "tests/support/files/model_files.h"
#include "tests/support/near.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>

namespace sheaf::test_cli_streams {

using test::kScene;

namespace {

constexpr const char* kPbrtScene = R"(# A sphere in a white environment
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "rgb" "integer xresolution" 12 "integer yresolution" 8
Sampler "independent" "integer pixelsamples" 4
WorldBegin
LightSource "infinite"
Include "part.pbrt"
)";
constexpr const char* kObjModel = "# A triangle\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
constexpr const char* kStlModel =
    "solid triangle\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    "endsolid triangle\n";
constexpr const char* kPlyModel =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// Runs a shell command with the program as $SHEAF. Returns its exit status and both streams of the command.
Outcome shell(const TemporaryFolder& folder, const std::string& command) {
  write_bytes(folder / "go.sh", "SHEAF='" SHEAF_EXECUTABLE "'\n" + command + "\n");
  Outcome outcome = run(folder, "--version", "bash go.sh >shell.out 2>shell.err; echo $? >shell.code; ");
  outcome.code = std::atoi(read_bytes(folder / "shell.code").c_str());
  outcome.out = read_bytes(folder / "shell.out");
  outcome.err = read_bytes(folder / "shell.err");
  return outcome;
}

}  // namespace

TEST_CASE("streams: the content of the standard input determines the dialect") {
  const TemporaryFolder folder;
  const std::string sphere = "Shape \"sphere\"\n";
  write_bytes(folder / "part.pbrt", sphere);
  for (const auto& [name, content, options] : {std::tuple{"scene.xml", kScene, "--spp 2"},
                                               {"scene.pbrt", kPbrtScene, "--spp 2"},
                                               {"model.stl", kStlModel, "--spp 2 --size 12x8"},
                                               {"model.obj", kObjModel, "--spp 2 --size 12x8 --up z"},
                                               {"model.ply", kPlyModel, "--spp 2 --size 12x8"}}) {
    CAPTURE_BINDING(name);
    write_bytes(folder / name, content);
    const std::string common = std::string(" --no-timestamps -q ") + options + " -o ";
    const Outcome file = run(folder, "render " + std::string(name) + common + "file.exr");
    CAPTURE(file.err);
    REQUIRE(file.code == 0);
    const Outcome piped = shell(folder, "cat " + std::string(name) + " | $SHEAF render -" + common + "piped.exr");
    CAPTURE(piped.err);
    CHECK(piped.code == 0);
    CHECK(read_exr(folder / "piped.exr").data == read_exr(folder / "file.exr").data);
  }
}

TEST_CASE("streams: models of other programs are recognized by their content") {
  const TemporaryFolder folder;
  std::vector<std::array<std::string, 2>> models;
  if (can_import_models())
    models = {{"cube.dae", test::cube_dae()},
              {"cube.fbx", test::cube_fbx()},
              {"cube.3ds", test::cube_3ds()},
              {"cube.off", test::cube_off()}};
  for (const auto& [name, bytes] : models) {
    CAPTURE_BINDING(name);
    write_bytes(folder / name, bytes);
    const std::string common = " --no-timestamps -q --spp 2 --size 12x8 -o ";
    const Outcome file = run(folder, "render " + name + common + "file.exr");
    CAPTURE(file.err);
    REQUIRE(file.code == 0);
    const Outcome piped = shell(folder, "cat " + name + " | $SHEAF render -" + common + "piped.exr");
    CAPTURE(piped.err);
    CHECK(piped.code == 0);
    CHECK(read_exr(folder / "piped.exr").data == read_exr(folder / "file.exr").data);
  }
}

TEST_CASE("streams: errors name the standard input and its line") {
  const TemporaryFolder folder;
  const Outcome broken = shell(folder, "printf '<scene>\\n<sensor type=\"none\"/>\\n</scene>' | $SHEAF render -");
  CHECK(broken.code == 3);
  CHECK(broken.err.starts_with("sheaf: standard input:2: "));
  CHECK(contains(shell(folder, "$SHEAF render - </dev/null").err, "standard input:1: the file has no XML element"));
  const Outcome dark = shell(folder, "printf '<scene version=\"3.0.0\"/>' | $SHEAF info - --lenient");
  CAPTURE(dark.err);
  CHECK_FALSE(contains(dark.err, "/tmp/"));
}

TEST_CASE("streams: the standard output gets the bytes of the file") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const std::string common = " render scene.xml --spp 2 --no-timestamps ";
  REQUIRE(shell(folder, "$SHEAF" + common + "-q -o out.png -o out.exr").code == 0);
  const Outcome png = shell(folder, "$SHEAF" + common + "-o -");
  CHECK(png.code == 0);
  CHECK(png.out == read_bytes(folder / "out.png"));
  CHECK(contains(png.err, "; wrote standard output\n"));
  const Outcome exr = shell(folder, "$SHEAF" + common + "-q -o - --format exr -o second.png");
  CHECK(exr.out == read_bytes(folder / "out.exr"));
  CHECK(read_bytes(folder / "second.png") == read_bytes(folder / "out.png"));
  CHECK(shell(folder, "cat scene.xml | $SHEAF render - --spp 2 --no-timestamps -o -").out == png.out);
  // No temporary file remains
  REQUIRE(shell(folder, "mkdir temporary && TMPDIR=$PWD/temporary $SHEAF" + common + "-q -o - >a.png").code == 0);
  CHECK(std::filesystem::is_empty(folder / "temporary"));
}

TEST_CASE("streams: an image is not written twice, to a terminal or to a full device") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome twice = shell(folder, "$SHEAF render scene.xml -o - -o -");
  CHECK(twice.code == 2);
  CHECK(contains(twice.err, "would overwrite"));
  const Outcome full = shell(folder, "$SHEAF render scene.xml -q --spp 1 -o - >/dev/full");
  CHECK(full.code == 4);
  CHECK(contains(full.err, "cannot write the image to the standard output: No space left on device"));
  if (std::system("command -v script >/dev/null") != 0) return;
  const Outcome typed = shell(folder, "script -qec \"$SHEAF render scene.xml -o -\" /dev/null");
  CHECK(typed.code == 2);
  CHECK(contains(typed.out, "-o - would write an image to the terminal"));
}

TEST_CASE("streams: --stats - prints the statistics") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome one = shell(folder, "$SHEAF render scene.xml -q --spp 1 -o a.exr --stats -");
  CHECK(one.code == 0);
  CHECK(nlohmann::json::parse(one.out)["spp"] == 1);
  CHECK_FALSE(std::filesystem::exists(folder / "-"));
  const Outcome full = shell(folder, "$SHEAF render scene.xml -q --spp 1 -o a.exr --stats - >/dev/full");
  CHECK(full.code == 4);
  CHECK(contains(full.err, "cannot write to the standard output: No space left on device"));
  const Outcome both = shell(folder, "$SHEAF render scene.xml -q --spp 1 -o - --stats -");
  CHECK(both.code == 2);
  CHECK(contains(both.err, "-o - and --stats - exclude each other"));
}

TEST_CASE("streams: output that nobody reads causes no message") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const char* const command : {"--help", "info scene.xml", "completion bash", "render scene.xml -q --spp 1 -o -",
                                    "render scene.xml -q --spp 1 -o a.exr --stats -"}) {
    CAPTURE(std::string(command));
    CHECK(shell(folder, "$SHEAF " + std::string(command) + " | true").err.empty());
  }
}

TEST_CASE("streams: info prints JSON of scenes and images") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const nlohmann::json scene = nlohmann::json::parse(run(folder, "info scene.xml --json").out);
  CHECK(scene["width"] == 24);
  CHECK(scene["height"] == 16);
  CHECK(scene["spp"] == 16);
  CHECK(scene["integrator"] == "path");
  CHECK(scene["max_depth"] == 6);
  CHECK(scene["quadrics"] == 1);
  CHECK(scene["lights"] == 1);
  CHECK(scene["bounds"]["min"][0].get<double>() == near(-1, 1e-4));
  CHECK(scene["memory"]["loaded"].get<double>() > 1e6);
  CHECK(scene["files"] == nlohmann::json{"scene.xml"});
  CHECK(nlohmann::json::parse(shell(folder, "$SHEAF info - --json <scene.xml").out)["width"] == 24);
  REQUIRE(run(folder, "render scene.xml -q --spp 3 --seed 5 -o out.exr --crop 2,3,10,12").code == 0);
  const nlohmann::json image = nlohmann::json::parse(run(folder, "info out.exr --json").out);
  CHECK(image["width"] == 8);
  CHECK(image["data_window"] == nlohmann::json{2, 3, 10, 12});
  CHECK(image["display_window"] == nlohmann::json{0, 0, 24, 16});
  CHECK(image["attributes"]["sheaf/integrator"] == "path");
  CHECK(contains(image["channels"].dump(), "\"name\":\"sampleCount\""));
}

}  // namespace sheaf::test_cli_streams
