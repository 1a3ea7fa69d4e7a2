// Renders by the command line: color modes, spectral layers, samplers, crops, sizes and models.
#include "core/image/exr.h"
#include "tests/support/near.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"
#include "tools/job/read_options.h"

#include <doctest/doctest.h>

#include <string>
#include <utility>

namespace sheaf::test_cli_render {

using test::kScene;

TEST_CASE("spectral mode is rendered and recorded in the image") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  REQUIRE(run(folder, "render scene.xml --color spectral -o out.exr --quiet").code == 0);
  std::string color;
  for (const auto& attribute : read_exr_attributes(folder / "out.exr"))
    if (attribute.name == "sheaf/color") color = std::get<std::string>(attribute.value);
  CHECK(color == "spectral");
}

TEST_CASE("scenes of pbrt are rendered spectrally with a note unless --color rgb is given") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  // A saturated red: after two reflections it differs between the color modes.
  write_bytes(folder / "scene.pbrt", R"(Film "rgb" "integer xresolution" 8 "integer yresolution" 8
Sampler "independent" "integer pixelsamples" 4
WorldBegin
LightSource "infinite"
Material "diffuse" "rgb reflectance" [0.8 0.1 0.1]
Translate 0 0 3 Shape "sphere")");
  const auto render = [&](const std::string& scene, const std::string& options) {
    const Outcome outcome = run(folder, "render " + scene + " --no-timestamps -v -o out.exr " + options);
    REQUIRE(outcome.code == 0);
    std::string color;
    for (const auto& attribute : read_exr_attributes(folder / "out.exr"))
      if (attribute.name == "sheaf/color") color = std::get<std::string>(attribute.value);
    return std::pair{color, contains(outcome.err, "rendered with --color spectral, as pbrt does")};
  };
  CHECK(render("scene.xml", "") == std::pair{std::string("rgb"), false});
  CHECK(render("scene.pbrt", "--color rgb") == std::pair{std::string("rgb"), false});
  const std::string rgb = read_bytes(folder / "out.exr");
  CHECK(render("scene.pbrt", "--color spectral") == std::pair{std::string("spectral"), false});
  const std::string spectral = read_bytes(folder / "out.exr");
  CHECK(render("scene.pbrt", "") == std::pair{std::string("spectral"), true});
  CHECK(read_bytes(folder / "out.exr") == spectral);
  CHECK(spectral != rgb);
  CHECK(render("scene.pbrt", "--spectral-bins 4").first == "spectral");
  CHECK(run(folder, "render scene.pbrt --color rgb --spectral-bins 4 -o out.exr").code == 2);
}

TEST_CASE("spectral bins are written as layers of the published layout") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  REQUIRE(run(folder, "render scene.xml --color spectral --spectral-bins 47 -o out.exr --quiet").code == 0);
  const Image image = read_exr(folder / "out.exr");
  CHECK(image.channels.size() == 5 + 47);
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
  CHECK(without.channels.size() == 5);
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

TEST_CASE("--sampler overrides the sampler of the scene and grids round up the sample count") {
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

TEST_CASE("the independent sampler of a scene becomes sobol unless requested and zsobol rounds up to powers of two") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const std::string note = "sampler 'independent' is rendered with 'sobol'";
  const auto pixels = [&](const std::string& arguments, bool noted) {
    const Outcome outcome = run(folder, "render scene.xml -v -o a.exr --spp 3 " + arguments);
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.err, note) == noted);
    const Image image = read_image(folder / "a.exr");
    std::vector<float> values;
    for (int x = 0; x < image.width; ++x) values.push_back(image.at(x, 7, image.find_channel("R")));
    return values;
  };
  const auto as_it_is = pixels("", true);
  CHECK(as_it_is == pixels("--sampler sobol", false));
  CHECK(as_it_is != pixels("--sampler independent", false));
  CHECK(contains(run(folder, "info scene.xml").out, "sampler     sobol for independent, 16 samples per pixel"));
  CHECK(contains(run(folder, "render scene.xml -o a.exr --spp 3 --sampler zsobol").err,
                 "sampler 'zsobol': 3 samples per pixel become 4, a power of two"));
}

TEST_CASE("definitions and crops are applied and repeated renders have equal bytes") {
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

TEST_CASE("--size and --scale override the film") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const auto size_of = [&](const std::string& options) {
    REQUIRE(run(folder, "render scene.xml --spp 1 --quiet -o out.exr " + options).code == 0);
    const Image image = read_exr(folder / "out.exr");
    return std::pair(image.width, image.height);
  };
  CHECK(size_of("") == std::pair(24, 16));
  CHECK(size_of("--size 10x7") == std::pair(10, 7));
  CHECK(size_of("--scale 0.25") == std::pair(6, 4));
  CHECK(size_of("--size 8x6 --scale 2") == std::pair(16, 12));
  for (const char* wrong : {"--size 10", "--size 0x5", "--size 10x", "--size 10x5x", "--scale 0"}) {
    CAPTURE(wrong);
    CHECK(run(folder, std::string("render scene.xml ") + wrong).code == 2);
  }
}

TEST_CASE("a model file is rendered without a scene") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  write_bytes(folder / "model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  REQUIRE(
      run(folder, "render model.obj --studio sun --size 32x24 --spp 4 --view 40,10 --up z --fov 50 --quiet -o out.exr")
          .code == 0);
  const Image image = read_exr(folder / "out.exr");
  // The floor and the sky above it.
  CHECK(image.at(16, 23, image.find_channel("R")) > 0.1f);
  CHECK(image.at(16, 0, image.find_channel("R")) == near(0.52f, 0.01));
  CHECK(run(folder, "info model.obj").code == 0);
  const Outcome scene = run(folder, "render scene.xml --view 40,10");
  CHECK(scene.code == 2);
  CHECK(contains(scene.err, "apply to models"));
}

TEST_CASE("the studio of a model is chosen by --studio, and applies to models only") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  write_bytes(folder / "model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const auto shapes = [&](const std::string& options) {
    const std::string text = run(folder, "info model.obj " + options).out;
    return text.substr(text.find("shapes "), 32);
  };
  CHECK(contains(shapes("--studio soft"), "5 (110 triangles"));
  CHECK(contains(shapes("--studio sun"), "2 (4 triangles"));
  CHECK(contains(shapes("--studio none"), "1 (4 triangles"));
  CHECK(shapes("--no-floor") == shapes("--studio none"));
  CHECK(shapes("") == shapes("--studio none"));  // counts the model alone
  CHECK(read_options("model.obj", ReadArguments()).surroundings.chosen_studio() == Studio::kSoft);
  ReadArguments watched;
  watched.turns_camera = true;
  CHECK(read_options("model.obj", watched).surroundings.chosen_studio() == Studio::kSun);
  watched.studio = "soft";
  CHECK(read_options("model.obj", watched).surroundings.chosen_studio() == Studio::kSoft);
  for (const auto& [arguments, message] :
       {std::pair{"scene.xml --studio soft", "--env, --no-floor and --studio apply to models, not to scenes"},
        {"model.obj --studio loft", "--studio: loft not in {none,soft,sun}"},
        {"model.obj --studio soft --no-floor", "--studio soft has its own lights and backdrop and excludes --no-floor"},
        {"model.obj --studio soft --env none", "excludes --env (expected sun or none)"}}) {
    const Outcome outcome = run(folder, std::string("render -o a.png ") + arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, message));
  }
}

TEST_CASE("models without cameras and lights have an automatic exposure by default") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  write_bytes(folder / "model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto render = [&](const std::string& scene, const std::string& name, const std::string& options) {
    const Outcome outcome = run(folder, "render " + scene + " --size 32x24 --spp 4 --no-timestamps " + options +
                                            " -o " + name + ".exr -o " + name + ".png");
    REQUIRE(outcome.code == 0);
    return contains(outcome.err, "(exposure ");
  };
  CHECK(render("model.obj", "a", ""));
  CHECK(render("model.obj", "b", "--exposure auto"));
  CHECK_FALSE(render("model.obj", "c", "--exposure 0"));
  CHECK(render("model.obj", "d", "--studio sun"));
  CHECK_FALSE(render("scene.xml", "e", ""));
  CHECK(read_bytes(folder / "a.png") == read_bytes(folder / "b.png"));
  CHECK(read_bytes(folder / "a.png") != read_bytes(folder / "c.png"));
  CHECK(read_bytes(folder / "a.exr") == read_bytes(folder / "c.exr"));
}

}  // namespace sheaf::test_cli_render
