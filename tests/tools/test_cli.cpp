// The command line as a user runs it: exit codes, messages, files.
#include "core/exr.h"
#include "tests/support/media_testing.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

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

TEST_CASE("wrong usage has exit code 2") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const char* arguments :
       {"", "paint", "render", "render scene.xml --no-such-option", "render scene.xml -o out.jpeg",
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

TEST_CASE("a scene without lights gives a warning") {
  const TemporaryFolder folder;
  write_bytes(folder / "dark.xml", R"(<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm">
    <integer name="width" value="4"/><integer name="height" value="4"/></film></sensor><shape type="sphere"/></scene>)");
  CHECK(contains(run(folder, "render dark.xml -o out.exr").err, "the scene has no lights"));
  CHECK_FALSE(contains(run(folder, "render dark.xml --integrator normals -o out.exr").err, "no lights"));
}

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
  // A saturated red: after two reflections it differs between the colour modes.
  write_bytes(folder / "scene.pbrt", R"(Film "rgb" "integer xresolution" 8 "integer yresolution" 8
Sampler "independent" "integer pixelsamples" 4
WorldBegin
LightSource "infinite"
Material "diffuse" "rgb reflectance" [0.8 0.1 0.1]
Translate 0 0 3 Shape "sphere")");
  const auto render = [&](const std::string& scene, const std::string& options) {
    const Outcome outcome = run(folder, "render " + scene + " --no-timestamps -o out.exr " + options);
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

TEST_CASE("an output that cannot be written has exit code 4 before the scene is read") {
  const TemporaryFolder folder;
  CHECK(run(folder, "render nowhere.xml -o no/folder/out.exr").code == 4);
  CHECK(run(folder, "render nowhere.xml -o out.exr --stats no/folder/stats.json").code == 4);
  CHECK(folder.entry_count() == 0);
}

TEST_CASE("a full disk has exit code 4 and the old file is kept and other outputs are written") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const std::string full = "ulimit -f 2 && ";  // 1 kB
  const std::string common = "render scene.xml --quiet --no-timestamps --spp 2 ";
  REQUIRE(run(folder, common + "-o whole.exr -o whole.png").code == 0);
  const std::string png = read_bytes(folder / "whole.png");
  REQUIRE(png.size() < 1024);
  const std::size_t exr = read_bytes(folder / "whole.exr").size();
  CAPTURE(exr);
  REQUIRE(exr > 1024);
  for (const char* name : {"a.exr", "s.json"}) write_bytes(folder / name, "old");
  const Outcome outcome = run(folder, common + "-o a.exr -o b.png --stats s.json", full);
  CHECK(outcome.code == 4);
  CHECK(contains(outcome.err, "cannot write 'a.exr'"));
  CHECK(contains(outcome.err, "cannot write 's.json'"));
  CHECK(read_bytes(folder / "a.exr") == "old");
  CHECK(read_bytes(folder / "s.json") == "old");
  CHECK(read_bytes(folder / "b.png") == png);
  CHECK(folder.entry_count() == 6);
}

TEST_CASE("outputs never overwrite each other or an input") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "assets");
  std::filesystem::create_directory_symlink("assets", folder / "alias");
  const auto asset = [&](const std::string& name) { return folder / ("assets/" + name); };
  const std::string quad = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  write_bytes(asset("plain.obj"), quad + "f 1 2 3\n");
  write_bytes(asset("rich.obj"), "mtllib rich.mtl\n" + quad + "usemtl red\nf 1 2 3\n");
  write_bytes(asset("rich.mtl"), "newmtl red\nmap_Kd mtl.png\n");
  write_bytes(asset("tin.spd"), "400 0.5\n700 0.5\n");
  write_bytes(asset("more.xml"), "<scene version='3.0.0'><bsdf type='diffuse' id='more'/></scene>");
  write_vol(asset("smoke.vol"), 2, 1, [](Vec3f, int) { return 1.0f; });
  Image picture(4, 4, {"R", "G", "B"});
  for (const char* name : {"sky.exr", "mtl.png", "cloth.png"})
    if (asset(name).extension() == ".exr")
      write_exr(asset(name), picture);
    else
      write_png(asset(name), picture);
  const std::string text = R"(<include filename="assets/more.xml"/>
    <shape type="obj"><string name="filename" value="assets/plain.obj"/><bsdf type="diffuse">
      <texture name="reflectance" type="bitmap"><string name="filename" value="assets/cloth.png"/></texture>
    </bsdf></shape>
    <shape type="obj"><string name="filename" value="assets/rich.obj"/></shape>
    <shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" filename="assets/tin.spd"/></bsdf></shape>
    <shape type="cube"><bsdf type="null"/><medium name="interior" type="heterogeneous"><volume name="sigma_t"
      type="gridvolume"><string name="filename" value="assets/smoke.vol"/></volume></medium></shape>
    <emitter type="envmap"><string name="filename" value="assets/sky.exr"/></emitter></scene>)";
  std::string scene = kScene;
  scene.replace(scene.find("<emitter"), scene.npos, text);
  write_bytes(folder / "scene.xml", scene);
  std::filesystem::create_symlink("assets/sky.exr", folder / "link.exr");
  const std::string common = "render scene.xml --quiet --spp 1 ";
  const Outcome plain = run(folder, common + "-o out.exr");
  CAPTURE(plain.err);
  REQUIRE(plain.code == 0);
  for (const char* arguments :
       {"-o assets/sky.exr", "-o alias/../assets/./sky.exr", "-o link.exr", "-o assets/cloth.png", "-o alias/mtl.png",
        "--stats scene.xml", "--stats ./alias/../scene.xml", "--stats assets/more.xml", "--stats assets/plain.obj",
        "--stats assets/rich.obj", "--stats assets/rich.mtl", "--stats alias/tin.spd", "--stats alias/smoke.vol",
        "-o b.exr --stats b.exr", "-o b.exr --stats ./b.exr", "-o out.exr --stats alias/../out.exr",
        "-o b.exr -o alias/../b.exr", "-o b.png -o b.exr -o ./b.png"}) {
    CAPTURE(std::string(arguments));
    std::vector<std::string> before, after;
    const auto contents = [&] {
      std::vector<std::string> all;
      for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
        if (entry.is_regular_file()) all.push_back(entry.path().string() + read_bytes(entry.path()));
      return all;
    };
    before = contents();
    const Outcome outcome = run(folder, common + arguments);
    after = contents();
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "would overwrite"));
    CHECK(before == after);
  }
  CHECK(run(folder, common + "-o out.exr -o b.png --stats b.json").code == 0);
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

TEST_CASE("one render writes several images and the statistics") {
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
  for (const char* key : {"scene",
                          "integrator",
                          "color",
                          "width",
                          "height",
                          "spp",
                          "threads",
                          "isa",
                          "wave_size",
                          "seed",
                          "load_seconds",
                          "build_seconds",
                          "render_seconds",
                          "photons",
                          "trace_seconds",
                          "peak_rss_bytes",
                          "peak_private_bytes",
                          "samples",
                          "rays",
                          "camera",
                          "scatter",
                          "shadow",
                          "rays_per_second",
                          "trace_share",
                          "stages",
                          "name",
                          "items",
                          "calls",
                          "seconds",
                          "ns_per_item",
                          "lane_fill",
                          "dropped"}) {
    CAPTURE(std::string(key));
    CHECK(contains(stats, "\"" + std::string(key) + "\":"));
  }
  CHECK(contains(stats, "\"samples\": 1536"));
  CHECK(contains(stats, "\"seed\": 7"));
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
    const Outcome outcome = run(folder, "render scene.xml -o a.exr --spp 3 " + arguments);
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

TEST_CASE("an image without a name is named after the scene and written to the current folder") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "scenes");
  write_bytes(folder / "scenes/ball.xml", kScene);
  const Outcome outcome = run(folder, "render scenes/ball.xml --quiet --spp 1");
  CHECK(outcome.code == 0);
  CHECK(outcome.err.empty());
  CHECK(is_exr(folder / "ball.exr"));
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

TEST_CASE("info lists the contents of a scene") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome outcome = run(folder, "info scene.xml");
  CHECK(outcome.code == 0);
  CHECK(contains(outcome.out, "24 x 16 pixels"));
  CHECK(contains(outcome.out, "1 quadrics"));
  CHECK(contains(outcome.out, "(-1, -1, -1) to (1, 1, 1)"));
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
  REQUIRE(run(folder, "render model.obj --size 32x24 --spp 4 --view 40,10 --up z --fov 50 --quiet -o out.exr").code ==
          0);
  const Image image = read_exr(folder / "out.exr");
  // The floor and the sky above it.
  CHECK(image.at(16, 23, image.find_channel("R")) > 0.1f);
  CHECK(image.at(16, 0, image.find_channel("R")) == doctest::Approx(0.52f).epsilon(0.01));
  CHECK(run(folder, "info model.obj").code == 0);
  const Outcome scene = run(folder, "render scene.xml --view 40,10");
  CHECK(scene.code == 2);
  CHECK(contains(scene.err, "apply to models"));
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

}  // namespace sheaf::test_cli
