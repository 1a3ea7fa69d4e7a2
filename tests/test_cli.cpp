// The command line, run as a user runs it: exit codes, messages, files.
#include "core/exr.h"
#include "tests/temporary_folder.h"

#include <doctest/doctest.h>

#include <sys/wait.h>

#include <cstdlib>
#include <utility>

using namespace sheaf;

namespace {

constexpr const char* kScene = R"(<scene version="3.0.0">
  <default name="size" value="24"/>
  <integrator type="path"><integer name="max_depth" value="6"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="$size"/><integer name="height" value="16"/><rfilter type="box"/>
    </film>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  </sensor>
  <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
  <emitter type="constant"><rgb name="radiance" value="1"/></emitter>
</scene>)";

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Runs the program with these arguments (words for the shell) in the folder.
Outcome run(const TemporaryFolder& folder, const std::string& arguments) {
  const std::string streams = " >'" + (folder / "out.txt").string() + "' 2>'" + (folder / "err.txt").string() + "'";
  const std::string command =
      "cd '" + folder.path().string() + "' && '" SHEAF_EXECUTABLE "' " + arguments + streams + " </dev/null";
  const int status = std::system(command.c_str());
  Outcome outcome;
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.out = read_bytes(folder / "out.txt");
  outcome.err = read_bytes(folder / "err.txt");
  std::filesystem::remove(folder / "out.txt");
  std::filesystem::remove(folder / "err.txt");
  return outcome;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("version and help") {
  const TemporaryFolder folder;
  const Outcome version = run(folder, "--version");
  CHECK(version.code == 0);
  CHECK(contains(version.out, "sheaf "));
  const Outcome help = run(folder, "render --help");
  CHECK(help.code == 0);
  for (const char* option : {"--spp", "--seed", "--threads", "--crop", "--stats", "--wave-size", "--no-timestamps"}) {
    CHECK(contains(help.out, option));
  }
  CHECK(run(folder, "--help").code == 0);
}

TEST_CASE("wrong usage is exit code 2") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const char* arguments :
       {"", "paint", "render", "render scene.xml --no-such-option", "render scene.xml -o out.jpeg",
        "render scene.xml --spp 0", "render scene.xml --spp many",
        "render scene.xml --color cmyk", "render scene.xml --crop 0,0,100,16", "render scene.xml --crop 4,4,4,8",
        "render scene.xml --crop 1,2,3", "render scene.xml -D novalue", "render scene.xml --integrator pathh",
        "render scene.xml --max-depth -2", "compare one.exr"}) {
    CAPTURE(std::string(arguments));
    const Outcome outcome = run(folder, arguments);
    CHECK(outcome.code == 2);
    CHECK(outcome.err.size() > 10);
  }
  CHECK(folder.entry_count() == 1);
}

TEST_CASE("spectral mode is rendered, and the picture says so") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  REQUIRE(run(folder, "render scene.xml --color spectral -o out.exr --quiet").code == 0);
  std::string color;
  for (const auto& attribute : read_exr_attributes(folder / "out.exr"))
    if (attribute.name == "sheaf/color") color = std::get<std::string>(attribute.value);
  CHECK(color == "spectral");
}

TEST_CASE("spectral bins are written as layers of the published layout") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  REQUIRE(run(folder, "render scene.xml --color spectral --spectral-bins 47 -o out.exr --quiet").code == 0);
  const Image image = read_exr(folder / "out.exr");
  CHECK(image.channels.size() == 8 + 47);
  CHECK(image.find_channel("S0.365,000000nm") >= 0);
  CHECK(image.find_channel("S0.825,000000nm") >= 0);
  std::string version, units;
  for (const auto& attribute : read_exr_attributes(folder / "out.exr")) {
    if (attribute.name == "spectralLayoutVersion") version = std::get<std::string>(attribute.value);
    if (attribute.name == "emissiveUnits") units = std::get<std::string>(attribute.value);
  }
  CHECK(version == "1.0");
  CHECK(units == "W.m^-2.sr^-1");

  REQUIRE(run(folder, "render scene.xml --color spectral -o without.exr --quiet").code == 0);
  const Image without = read_exr(folder / "without.exr");
  CHECK(without.channels.size() == 8);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (const char* channel : {"R", "G", "B"})
        CHECK(image.at(x, y, image.find_channel(channel)) == without.at(x, y, without.find_channel(channel)));

  for (const char* arguments :
       {"--spectral-bins 8", "--color rgb --spectral-bins 8", "--color spectral --spectral-bins 0",
        "--color spectral --spectral-bins 472", "--color spectral --integrator normals --spectral-bins 8"}) {
    CAPTURE(std::string(arguments));
    const Outcome outcome = run(folder, "render scene.xml -o no.exr --quiet " + std::string(arguments));
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "spectral"));
  }
}

TEST_CASE("misspelt integrators get their message") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  CHECK(contains(run(folder, "render scene.xml --integrator pathh").err, "did you mean 'path'?"));
}

TEST_CASE("missing and broken scenes are exit code 3, with file and line") {
  const TemporaryFolder folder;
  CHECK(run(folder, "render nowhere.xml").code == 3);
  CHECK(run(folder, "info nowhere.xml").code == 3);
  write_bytes(folder / "broken.xml", "<scene version=\"3.0.0\">\n<sensor type=\"perspektive\"/>\n</scene>");
  const Outcome broken = run(folder, "render broken.xml");
  CHECK(broken.code == 3);
  CHECK(contains(broken.err, "broken.xml:2: "));
  CHECK(contains(broken.err, "perspective"));
  CHECK(run(folder, "compare a.exr b.exr").code == 3);
}

TEST_CASE("an output that cannot be written is exit code 4, before the scene is read") {
  const TemporaryFolder folder;
  CHECK(run(folder, "render nowhere.xml -o no/folder/out.exr").code == 4);
  CHECK(run(folder, "render nowhere.xml -o out.exr --stats no/folder/stats.json").code == 4);
  CHECK(folder.entry_count() == 0);
}

TEST_CASE("one render writes several pictures and the statistics") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome outcome = run(folder, "render scene.xml -o a.exr -o b.png --spp 4 --seed 7 --stats s.json");
  CAPTURE(outcome.err);
  REQUIRE(outcome.code == 0);
  CHECK(outcome.out.empty());
  CHECK(contains(outcome.err, "100 %"));
  const Image image = read_image(folder / "a.exr");
  CHECK(image.width == 24);
  CHECK(image.height == 16);
  CHECK(image.at(0, 0, image.find_channel("G")) == 1.0f);
  CHECK(image.at(3, 3, image.find_channel("sampleCount")) == 4.0f);
  CHECK(read_image(folder / "b.png").width == 24);
  const std::string stats = read_bytes(folder / "s.json");
  for (const char* key : {"scene", "integrator", "color", "width", "height", "spp", "threads", "isa", "wave_size",
                          "seed", "load_seconds", "build_seconds", "render_seconds", "peak_rss_bytes", "samples",
                          "rays", "camera", "scatter", "shadow", "rays_per_second", "trace_share", "stages", "name",
                          "items", "calls", "seconds", "ns_per_item", "lane_fill", "dropped"}) {
    CAPTURE(std::string(key));
    CHECK(contains(stats, "\"" + std::string(key) + "\":"));
  }
  CHECK(contains(stats, "\"samples\": 1536"));
  CHECK(contains(stats, "\"seed\": 7"));
}

TEST_CASE("--sampler overrides the scene's sampler, and grids round the samples up") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome rounded = run(folder, "render scene.xml -o a.exr --spp 5 --sampler stratified");
  CAPTURE(rounded.err);
  REQUIRE(rounded.code == 0);
  CHECK(contains(rounded.err, "sampler 'stratified': 5 samples per pixel become 6, a grid of 3 x 2"));
  const Image image = read_image(folder / "a.exr");
  CHECK(image.at(3, 3, image.find_channel("sampleCount")) == 6.0f);
  const Outcome sobol = run(folder, "render scene.xml -o b.exr --spp 5 --sampler sobol");
  CHECK(sobol.code == 0);
  CHECK(!contains(sobol.err, "become"));
  const Outcome unknown = run(folder, "render scene.xml -o a.exr --sampler sobl");
  CHECK(unknown.code == 2);
  CHECK(contains(unknown.err, "unknown sampler 'sobl', did you mean 'sobol'?"));
}

TEST_CASE("without a name the picture is called after the scene, in the current folder") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "scenes");
  write_bytes(folder / "scenes/ball.xml", kScene);
  const Outcome outcome = run(folder, "render scenes/ball.xml --quiet --spp 1");
  CHECK(outcome.code == 0);
  CHECK(outcome.err.empty());
  CHECK(is_exr(folder / "ball.exr"));
}

TEST_CASE("definitions, crops and equal bytes") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const std::string common = "render scene.xml --quiet --no-timestamps -D size=32 ";
  REQUIRE(run(folder, common + "-o whole.exr").code == 0);
  REQUIRE(run(folder, common + "-o again.exr --threads 1 --wave-size 256").code == 0);
  REQUIRE(run(folder, common + "-o crop.exr --crop 5,3,20,11").code == 0);
  CHECK(read_bytes(folder / "whole.exr") == read_bytes(folder / "again.exr"));
  const Image crop = read_exr(folder / "crop.exr");
  CHECK(crop.x0 == 5);
  CHECK(crop.y0 == 3);
  CHECK(crop.width == 15);
  CHECK(crop.frame_width == 32);
  const Outcome outcome = run(folder, "compare crop.exr whole.exr --max-mse 0");
  CHECK(outcome.code == 0);
  CHECK(contains(outcome.out, "15 x 8 pixels"));
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

TEST_CASE("info says what a scene holds") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome outcome = run(folder, "info scene.xml");
  CHECK(outcome.code == 0);
  CHECK(contains(outcome.out, "24 x 16 pixels"));
  CHECK(contains(outcome.out, "1 quadrics"));
  CHECK(contains(outcome.out, "(-1, -1, -1) to (1, 1, 1)"));
}

TEST_CASE("an interrupted render writes what there is and says so") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const auto& [name, code] : {std::pair{"INT", 130}, std::pair{"TERM", 143}}) {
    CAPTURE(std::string(name));
    const std::string kill = "(sleep 2; kill -" + std::string(name) + " $$) & exec ";
    write_bytes(folder / "go.sh", kill + SHEAF_EXECUTABLE " render scene.xml -o out.exr -D size=512 --spp 16000000\n");
    // The script becomes the renderer, since shells start background jobs with SIGINT ignored.
    const int status = std::system(("cd '" + folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == code);
    CHECK(read_exr(folder / "out.exr").width == 512);
    CHECK(contains(read_bytes(folder / "log.txt"), "interrupted"));
    std::filesystem::remove(folder / "out.exr");
  }
}
