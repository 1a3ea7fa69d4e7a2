// The command line as a user runs it: usage errors, malformed scenes, info, compare, and warnings.
#include "core/image/exr.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/media_testing.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <utility>

namespace sheaf::test_cli {

using test::kScene;

TEST_CASE("version and help are printed") {
  const TemporaryFolder folder;
  const Outcome version = run(folder, "--version");
  CHECK(version.code == 0);
  CHECK(contains(version.out, "sheaf "));
  // The version includes the instruction set, as images record it.
  write_bytes(folder / "scene.xml", kScene);
  REQUIRE(run(folder, "render scene.xml --quiet -o out.exr").code == 0);
  for (const auto& attribute : read_exr_attributes(folder / "out.exr"))
    if (attribute.name == "sheaf/isa")
      CHECK(contains(version.out, " " + std::get<std::string>(attribute.value) + "\n"));
  const Outcome help = run(folder, "render --help");
  CHECK(help.code == 0);
  CHECK(contains(run(folder, "--help").out, "129, 130, 143"));
  for (const char* option : {"--spp", "--seed", "--threads", "--crop", "--stats", "--wave-size", "--no-timestamps"}) {
    CHECK(contains(help.out, option));
  }
  CHECK(run(folder, "--help").code == 0);
}

TEST_CASE("version: -v lists the libraries, the image formats and the optional parts") {
  const TemporaryFolder folder;
  const std::string version = run(folder, "--version").out, details = run(folder, "--version -v").out;
  CHECK(details.starts_with(version + "libraries: libpng 1."));
  for (const char* const library :
       {"libjpeg-turbo ", "Embree ", "oneTBB 20", "OpenEXR 3.", "xsimd ", "libtiff 4.", "libwebp 1.", "fmt "})
    CHECK(contains(details, library));
  CHECK(contains(details, "\nimages: OpenEXR, PNG, JPEG, TIFF; read only: WebP, Radiance HDR, BMP, "));
  CHECK(contains(details, "\nOpenColorIO by sheaf_color_io.so ("));
  CHECK(contains(details, " models by sheaf_import_model ("));
  CHECK(run(folder, "render --verbose --version").out == details);
  std::filesystem::copy_file(SHEAF_EXECUTABLE, folder / "alone");
  REQUIRE(std::system(("'" + (folder / "alone").string() + "' --version -v >'" + (folder / "out.txt").string() + "'")
                          .c_str()) == 0);
  CHECK(contains(read_bytes(folder / "out.txt"), "\nOpenColorIO by sheaf_color_io.so (missing)\n"));
  // The option belongs to --version
  CHECK(contains(run(folder, "--help").out, "With --version: also print the libraries"));
  const Outcome misplaced = run(folder, "-v render scene.xml");
  CHECK(misplaced.code == 2);
  CHECK(contains(misplaced.err, "requires --version"));
}

TEST_CASE("wrong usage has exit code 2") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const char* arguments :
       {"", "paint", "render", "render scene.xml --no-such-option", "render scene.xml -o out.webp",
        "render scene.xml --spp 0", "render scene.xml --spp many", "render scene.xml --color cmyk",
        "render scene.xml --crop 0,0,100,16", "render scene.xml --crop 4,4,4,8", "render scene.xml --crop 1,2,3",
        "render scene.xml -D novalue", "render scene.xml --integrator pathh", "render scene.xml --max-depth -2",
        "compare one.exr"}) {
    CAPTURE(std::string(arguments));
    const Outcome outcome = run(folder, arguments);
    CHECK(outcome.code == 2);
    CHECK(outcome.err.size() > 10);
  }
  CHECK(folder.entry_count() == 1);
}

TEST_CASE("unknown names are errors that suggest the nearest") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const auto& [arguments, message] :
       {std::pair{"rendr scene.xml", "unknown command 'rendr', did you mean 'render'?"},
        {"render scene.xml --sp 4", "unknown option '--sp', did you mean '--spp'?"},
        {"render scene.xml other.xml", "unexpected argument 'other.xml'"},
        {"render scene.xml --step-size nan", "'nan' is not a finite number"},
        {"render scene.xml --scale -1", "--scale: '-1' is not a positive number"},
        {"render scene.xml --sampler foo", "(known: independent, stratified, multijitter, sobol, zsobol, "},
        {"render scene.xml --light-sampler foo", "(known: uniform, power, bvh)"},
        {"render scene.xml --integrator foo", "direct_ris, "},
        {"render scene.xml --seed -1", "--seed: Value -1 not in range 0 to 4294967295"},
        {"render scene.xml --scale inf", "'inf' is not a finite number"}}) {
    const Outcome outcome = run(folder, arguments);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, message));
  }
}

TEST_CASE("unknown integrators have their own message") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  CHECK(contains(run(folder, "render scene.xml --integrator pathh").err, "did you mean 'path'?"));
}

TEST_CASE("missing and malformed scenes have exit code 3 with file and line") {
  const TemporaryFolder folder;
  CHECK(run(folder, "render nowhere.xml").code == 3);
  CHECK(run(folder, "info nowhere.xml").code == 3);
  write_bytes(folder / "broken.xml", "<scene version=\"3.0.0\">\n<sensor type=\"perspektive\"/>\n</scene>");
  const Outcome broken = run(folder, "render broken.xml");
  CHECK(broken.code == 3);
  CHECK(contains(broken.err, "broken.xml:2: "));
  CHECK(contains(broken.err, "perspective"));
  CHECK(run(folder, "compare a.exr b.exr").code == 3);
  // Escape sequences are not passed on to the terminal.
  write_bytes(folder / "\x1b[2J.xml", "<scene");
  const Outcome escaped = run(folder, "render *2J.xml");
  CHECK(escaped.code == 3);
  CHECK(contains(escaped.err, "?[2J.xml"));
}

TEST_CASE("escape sequences in file names and contents do not reach the terminal") {
  const TemporaryFolder folder;
  Image image(2, 2, {"R\x1b[31m"});
  ExrMetadata metadata;
  metadata.attributes = {{"ke\x07y", std::string("\x1b]0;title\x07")}};
  write_exr(folder / "a.exr", image, metadata);
  const Outcome outcome = run(folder, "info a.exr");
  CHECK(outcome.code == 0);
  CHECK(contains(outcome.out, "channel     R?[31m (float)\n"));
  CHECK(contains(outcome.out, "attribute   ke?y = ?]0;title?\n"));
  write_bytes(folder / "scene.xml", "<scene version=\"3.0.0\"><shape type=\"\x1b[2J\"/></scene>");
  const Outcome refused = run(folder, "info scene.xml");
  CHECK(refused.code == 3);
  CHECK(refused.err.find('\x1b') == std::string::npos);
}

TEST_CASE("media beyond the float range are errors with file and line") {
  const TemporaryFolder folder;
  write_vol(folder / "far.vol", 2, 1, [](Vec3f p, int) { return p.x < 0.5f ? 3e38f : 0.0f; });
  const std::string medium = R"(<shape type="cube"><bsdf type="null"/>
<medium name="interior" type="heterogeneous">
  <volume name="sigma_t" type="gridvolume"><string name="filename" value="far.vol"/></volume>
  <float name="scale" value="3"/></medium></shape>
<emitter type="constant"/></scene>)";
  std::string scene = kScene;
  scene.replace(scene.find("<emitter"), scene.npos, medium);
  write_bytes(folder / "scene.xml", scene);
  const std::string above = scene.substr(0, scene.find("<medium"));
  const auto line = 1 + std::count(above.begin(), above.end(), '\n');
  for (const char* color : {"rgb", "spectral"}) {
    const Outcome outcome =
        run(folder, "render scene.xml --quiet --spp 1 --color " + std::string(color), "timeout -s KILL 20 ");
    CHECK(outcome.code == 3);
    CAPTURE(outcome.err);
    CHECK(
        contains(outcome.err, "scene.xml:" + std::to_string(line) + ": the medium's extinction exceeds 32-bit floats"));
  }
}

TEST_CASE("a scene without lights gives a warning") {
  const TemporaryFolder folder;
  write_bytes(folder / "dark.xml", R"(<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm">
    <integer name="width" value="4"/><integer name="height" value="4"/></film></sensor><shape type="sphere"/></scene>)");
  CHECK(contains(run(folder, "render dark.xml -o out.exr").err, "the scene has no lights"));
  CHECK_FALSE(contains(run(folder, "render dark.xml --integrator normals -o out.exr").err, "no lights"));
}

TEST_CASE("--lenient renders invalid scenes with a warning for each problem and a summary") {
  const TemporaryFolder folder;
  std::string text = kScene;
  text.insert(text.find("<shape"), "<mode type=\"final\"/><shape type=\"torus\"/>");
  write_bytes(folder / "scene.xml", text);
  CHECK(run(folder, "render scene.xml").code == 3);
  const Outcome outcome = run(folder, "render scene.xml --lenient --spp 1 -o out.exr");
  CHECK(outcome.code == 0);
  CHECK(contains(outcome.err, "warning: scene.xml:12: unknown element <mode>"));
  CHECK(contains(outcome.err, "unknown shape plugin 'torus'"));
  CHECK(contains(outcome.err, "2 scene elements could not be read"));
  CHECK(contains(run(folder, "info scene.xml --lenient").out, "unknown shape plugin 'torus'"));
}

TEST_CASE("all errors of a scene are printed, and a line that names --lenient") {
  const TemporaryFolder folder;
  std::string text = kScene;
  text.insert(text.find("<shape"), "<mode type=\"final\"/><shape type=\"torus\"/>");
  write_bytes(folder / "scene.xml", text);
  for (const char* command : {"render scene.xml", "info scene.xml"}) {
    const Outcome outcome = run(folder, command);
    CHECK(outcome.code == 3);
    CHECK(contains(outcome.err, "sheaf: scene.xml:12: unknown element <mode>"));
    CHECK(contains(outcome.err, "\nsheaf: scene.xml:12: unknown shape plugin 'torus'"));
    CHECK(outcome.err.ends_with("\nsheaf: 2 errors; --lenient substitutes or drops what cannot be read\n"));
  }
}

TEST_CASE("info leaves the surroundings out of the bounds of a model and lists cameras and animations") {
  test::GltfBuilder gltf;
  gltf.add_triangle();
  const int times = gltf.add<float>({0.5f, 2}, "SCALAR"), positions = gltf.add<float>({0, 0, 0, 0, 0.5f, 0}, "VEC3");
  gltf.json["animations"].push_back(
      {{"name", "Rise"},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
       {"samplers", {{{"input", times}, {"output", positions}}}}});
  const TemporaryFolder folder;
  write_bytes(folder / "model.glb", gltf.binary());
  const auto info = [&](const std::string& file) { return run(folder, "info " + file).out; };
  const std::string bare = info("model.glb");
  CAPTURE(bare);
  CHECK(contains(bare, "camera      none, placed automatically\n"));
  CHECK(contains(bare, "animation   0: Rise, 0.5 to 2 s\n"));
  const nlohmann::json json = nlohmann::json::parse(info("model.glb --json")),
                       floorless = nlohmann::json::parse(info("model.glb --json --no-floor"));
  CHECK(json["bounds"] == floorless["bounds"]);
  CHECK(json["bounds"]["max"][0] < 10);
  CHECK(json["cameras"].is_null());
  CHECK(json["animations"] == nlohmann::json{{{"name", "Rise"}, {"start", 0.5}, {"end", 2.0}}});
  // The same for a mesh
  write_bytes(folder / "mesh.obj", "v 0 0 0\nv 2 0 0\nv 0 3 0\nf 1 2 3\n");
  CHECK(contains(info("mesh.obj"), "bounds      (0, 0, 0) to (2, 3, 0) (of the model alone)\n"));
  CHECK(contains(info("mesh.obj"), "shapes      1 (1 triangles, 3 vertices, 0 quadrics)\n"));
  // Cameras
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}};
  gltf.json["nodes"].push_back({{"camera", 0}, {"name", "front"}, {"translation", {0, 0, 4}}});
  gltf.json["nodes"].push_back({{"camera", 0}});
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
  write_bytes(folder / "model.glb", gltf.binary());
  CHECK(contains(info("model.glb"), "camera      0: front\ncamera      1: (no name)\n"));
  CHECK(nlohmann::json::parse(info("model.glb --json"))["cameras"] == nlohmann::json{"front", ""});
  write_bytes(folder / "scene.xml",
              "<scene version='3.0.0'><sensor type='perspective' id='a'/><sensor type='perspective' id='b'/></scene>");
  CHECK(contains(info("scene.xml"), "camera      0: a\ncamera      1: b\n"));
  // A scene that has no camera yet
  write_bytes(folder / "shape.xml", "<scene version='3.0.0'><shape type='sphere'/></scene>");
  const Outcome unfinished = run(folder, "info shape.xml");
  CHECK(unfinished.code == 0);
  CHECK(contains(unfinished.out, "camera      none\n"));
  CHECK(contains(unfinished.out, "bounds      (-1, -1, -1) to (1, 1, 1)\n"));
  CHECK(contains(run(folder, "render shape.xml").err, "the scene has no <sensor>"));
}

TEST_CASE("info lists the contents of a scene") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome outcome = run(folder, "info scene.xml");
  CHECK(outcome.code == 0);
  CHECK(contains(outcome.out, "24 x 16 pixels"));
  CHECK(contains(outcome.out, "1 quadrics"));
  CHECK(contains(outcome.out, "(-1, -1, -1) to (1, 1, 1)"));
}

TEST_CASE("compare fails by each of its thresholds") {
  const TemporaryFolder folder;
  Image image(16, 16, {"R", "G", "B", "variance.R", "variance.G", "variance.B"});
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      for (int c = 0; c < 3; ++c) {
        image.at(x, y, c) = 1;
        image.at(x, y, c + 3) = 1e-4f;
      }
    }
  }
  write_exr(folder / "a.exr", image);
  for (float& value : image.data) value *= value > 0.5f ? 1.1f : 1.0f;
  write_exr(folder / "b.exr", image);
  CHECK(run(folder, "compare a.exr a.exr --max-mse 0 --min-accepted 1 --min-mean-p 0.5").code == 0);
  CHECK(run(folder, "compare a.exr b.exr").code == 0);
  CHECK(run(folder, "compare a.exr b.exr --max-mse 0.011 --max-relmse 0.01 --max-mean-ratio-error 0.1").code == 0);
  CHECK(run(folder, "compare a.exr b.exr --max-mse 0.009").code == 1);
  CHECK(run(folder, "compare a.exr b.exr --max-relmse 0.005").code == 1);
  CHECK(run(folder, "compare a.exr b.exr --max-mean-ratio-error 0.05").code == 1);
  CHECK(run(folder, "compare a.exr b.exr --min-accepted 0.9").code == 1);
  CHECK(run(folder, "compare a.exr b.exr --min-mean-p 0.001").code == 1);
  CHECK(contains(run(folder, "compare a.exr b.exr").out, "0.000 %"));
}

}  // namespace sheaf::test_cli
