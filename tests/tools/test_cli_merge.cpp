// Parts of images, rendered and merged on the command line.
#include "core/image/exr.h"
#include "tests/support/capture.h"
#include "tests/support/parts_testing.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_cli_merge {

namespace {

constexpr const char* kScene = R"(<scene version="3.0.0">
  <default name="height" value="18"/><default name="sampler" value="sobol"/><default name="filter" value="gaussian"/>
  <integrator type="path"><integer name="max_depth" value="5"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="27"/><integer name="height" value="$height"/><rfilter type="$filter"/>
    </film>
    <sampler type="$sampler"><integer name="sample_count" value="32"/></sampler>
  </sensor>
  <shape type="sphere" id="ball"><bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.5,0.1,0.1"/></bsdf></shape>
  <shape type="cube" id="box"><transform name="to_world"><scale value="0.5"/><translate x="0.9" y="0.3" z="0.9"/></transform>
    <bsdf type="plastic"/></shape>
  <emitter type="constant"><rgb name="radiance" value="1"/></emitter>
  <emitter type="point" id="lamp"><point name="position" x="2" y="3" z="4"/><rgb name="intensity" value="20"/></emitter>
</scene>)";

constexpr std::string_view kIntegrator =
    R"(<integrator type="path"><integer name="max_depth" value="5"/></integrator>)";

/// A folder with the scene.
struct Scene {
  /// A non-empty `integrator` replaces the one of the scene.
  explicit Scene(const std::string& integrator = "") {
    std::string text = kScene;
    if (!integrator.empty()) text.replace(text.find(kIntegrator), kIntegrator.size(), integrator);
    write_bytes(folder / "scene.xml", text);
  }
  /// Renders to a file.
  void render(const std::string& file, const std::string& options) const {
    const Outcome outcome = run(folder, "render scene.xml --quiet --no-timestamps -o " + file + " " + options);
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
  }
  /// The message of a merge that fails.
  std::string refused(const std::string& arguments) const {
    const Outcome outcome = run(folder, "merge -o refused.exr " + arguments);
    CHECK(outcome.code == 3);
    CHECK(!std::filesystem::exists(folder / "refused.exr"));
    return outcome.err;
  }
  TemporaryFolder folder;
};

/// The text attributes of a file except for the noise, which is rounded.
std::string header_of(const Scene& scene, const std::string& file) {
  std::string text;
  for (const auto& attribute : read_exr_attributes(scene.folder / file)) {
    text += attribute.name + "=";
    const auto* value = std::get_if<std::string>(&attribute.value);
    text += (attribute.name != "sheaf/noise" && value != nullptr ? *value : "") + "\n";
  }
  return text;
}

const std::string kAll = "--aov all --light-groups --replicates 8 --float ";

}  // namespace

TEST_CASE("merged tiles have the bytes of the whole") {
  const Scene scene;
  for (const std::string options :
       {"--replicates 4 --aov all --light-groups", "--spp 5", "--float --spp 8 -D filter=box"}) {
    CAPTURE(options);
    scene.render("whole.exr -o whole.png", options);
    scene.render("a.exr", options + " --crop 0,0,10,7");
    scene.render("b.exr", options + " --crop 10,0,27,7");
    scene.render("c.exr", options + " --crop 0,7,15,18");
    scene.render("d.exr", options + " --crop 15,7,27,18");
    const Outcome outcome = run(scene.folder, "merge d.exr a.exr c.exr b.exr -o joined.exr -o joined.png");
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.err, "merged 4 parts"));
    CHECK(read_bytes(scene.folder / "joined.exr") == read_bytes(scene.folder / "whole.exr"));
    CHECK(read_bytes(scene.folder / "joined.png") == read_bytes(scene.folder / "whole.png"));
  }
}

TEST_CASE("merged sample ranges equal the whole except for rounding and may be mixed with tiles") {
  const std::string few = R"(<integer name="globalPhotons" value="4000"/><integer name="causticPhotons" value="0"/>)"
                          R"(<integer name="volumePhotons" value="0"/></integrator>)";
  const std::pair<std::string, std::string> variants[] = {
      {"", ""},
      {"-D filter=box", ""},
      {"-D filter=box --sampler independent", ""},
      {"--filter-mode importance", ""},
      {"--guiding", ""},
      {"-D filter=mitchell --spp 8", ""},
      {"--spp 32", R"(<integrator type="photonmapper"><boolean name="finalGather" value="true"/>)"
                   R"(<integer name="numGatherRays" value="3"/>)" +
                       few},
      {"--spp 8", R"(<integrator type="sppm">)" + few}};
  for (const auto& [more, integrator] : variants) {
    const Scene scene(integrator);
    CAPTURE_BINDING(more);
    CAPTURE_BINDING(integrator);
    const std::string options = kAll + more;
    const int spp = contains(more, "--spp 8") ? 8 : 32, quarter = spp / 4;
    const auto samples = [&](int first, int count) {
      return options + " --samples " + std::to_string(first) + ":" + std::to_string(count);
    };
    scene.render("whole.exr", options);
    for (int i = 0; i < 4; ++i) scene.render("range" + std::to_string(i) + ".exr", samples(i * quarter, quarter));
    REQUIRE(run(scene.folder, "merge range*.exr -o joined.exr --float").code == 0);
    const Image whole = read_exr(scene.folder / "whole.exr");
    check_near(read_exr(scene.folder / "joined.exr"), whole);
    CHECK(header_of(scene, "joined.exr") == header_of(scene, "whole.exr"));
    if (more.starts_with("--")) continue;
    scene.render("left.exr", options + " --crop 0,0,12,18");
    scene.render("first.exr", samples(0, quarter) + " --crop 12,0,27,18");
    scene.render("last.exr", samples(quarter, 3 * quarter) + " --crop 12,0,27,18");
    REQUIRE(run(scene.folder, "merge first.exr left.exr last.exr -o mixed.exr").code == 0);
    check_near(read_exr(scene.folder / "mixed.exr"), whole);
  }
}

TEST_CASE("replicates and independent samples may be split at any sample") {
  const Scene scene;
  for (const std::string options : {"--spp 31 --replicates 1", "--sampler independent -D filter=box --spp 31"}) {
    scene.render("whole.exr", options);
    scene.render("a.exr", options + " --samples 0:7");
    scene.render("b.exr", options + " --samples 7:1");
    scene.render("c.exr", options + " --samples 8:23");
    REQUIRE(run(scene.folder, "merge a.exr b.exr c.exr -o joined.exr").code == 0);
    check_near(read_exr(scene.folder / "joined.exr"), read_exr(scene.folder / "whole.exr"));
  }
}

TEST_CASE("samples that cannot be split are usage errors with the reason") {
  const Scene scene;
  const auto error = [&](const std::string& options) {
    const Outcome outcome = run(scene.folder, "render scene.xml --quiet -o no.exr " + options);
    CHECK(outcome.code == 2);
    return outcome.err;
  };
  CHECK(contains(error("--spp 64 --replicates 4 --samples 8:16"), "multiples of 16; --replicates"));
  CHECK(contains(error("--spp 64 --replicates 4 --samples 0:17"), "multiples of 16; --replicates"));
  CHECK(contains(error("--samples 30:3"), "out of range (expected samples from 0 to 31"));
  CHECK(contains(error("--samples 0:0"), "FIRST:COUNT"));
  CHECK(contains(error("--samples 4294967295:2"), "FIRST:COUNT"));
  for (const char* text : {"3", "3:", ":3", "-1:3", "0x1:3", "1:2:3", "1:2 "})
    CHECK(contains(error("--samples '" + std::string(text) + "'"), "FIRST:COUNT"));
  CHECK(contains(error("--samples 0:16 --integrator ptracer"), "ptracer"));
  CHECK(contains(error("--samples 0:16 --noise-target 0.1"), "noise target"));
  // A checkpoint of other samples.
  scene.render("a.exr", "--replicates 4 --samples 0:8 --checkpoint a.state");
  const Outcome other =
      run(scene.folder, "render scene.xml -o a.exr --replicates 4 --samples 8:8 --checkpoint a.state --resume");
  CHECK(other.code == 5);
  CHECK(contains(other.err, "--samples 0:8 in the checkpoint, 8:8 now"));
}

TEST_CASE("mismatched parts are rejected by name") {
  const Scene scene;
  const std::string common = "--spp 16 --replicates 4 ";
  scene.render("a.exr", common + "--samples 0:8");
  scene.render("b.exr", common + "--samples 8:8 --aov cryptomatte_object");
  const Outcome info = run(scene.folder, "info b.exr");
  CHECK(contains(info.out, "\nsetting     --replicates 4\n"));
  CHECK(contains(info.out, "\nattribute   sheaf/samples = 8:8\n"));
  CHECK(contains(info.out, "\nids         sheaf/ids/CryptoObject: 2 entries\n"));
  scene.render("b.exr", common + "--samples 8:8");
  REQUIRE(run(scene.folder, "merge a.exr b.exr -o whole.exr").code == 0);
  CHECK(contains(scene.refused("a.exr"), "pixels 0,0,27,18 lack samples 8:8 of 16"));
  CHECK(contains(scene.refused("b.exr a.exr b.exr"), "b.exr: shares samples with 'b.exr': 8:8"));
  scene.render("plain.exr", common);
  CHECK(contains(scene.refused("a.exr plain.exr"), "plain.exr: is not a part of an image"));
  CHECK(contains(scene.refused("a.exr whole.exr"), "whole.exr: is not a part of an image"));
  CHECK(contains(scene.refused("a.exr none.exr"), "none.exr"));
  CHECK(contains(scene.refused("a.exr scene.xml"), "scene.xml: has an unknown format"));
  const auto other = [&](const std::string& options) {
    scene.render("other.exr", options);
    return scene.refused("a.exr other.exr");
  };
  CHECK(contains(other("--spp 16 --replicates 4 --samples 8:8 --seed 3"), "the seed is '3' here and '0' there"));
  CHECK(contains(other("--spp 32 --replicates 4 --samples 8:8"), "samples per pixel is '32' here and '16' there"));
  CHECK(contains(other(common + "--samples 8:8 -D height=19"), "the frame is '27x19' here and '27x18' there"));
  CHECK(contains(other(common + "--samples 8:8 --aov albedo"), "--aov albedo"));
  CHECK(contains(other("--spp 16 --replicates 2 --samples 8:8"),
                 "a setting is '--replicates 2' here and '--replicates 4' there"));
  write_bytes(scene.folder / "scene.xml", std::string(kScene) + " ");
  CHECK(contains(other(common + "--samples 8:8"), "a setting is 'scene.xml: "));
  // Invalid outputs.
  CHECK(run(scene.folder, "merge a.exr b.exr -o a.exr").code == 2);
  CHECK(run(scene.folder, "merge a.exr b.exr -o c.exr -o ./c.exr").code == 2);
  CHECK(run(scene.folder, "merge a.exr b.exr -o c.webp").code == 2);
  CHECK(run(scene.folder, "merge a.exr b.exr").code == 2);
  CHECK(run(scene.folder, "merge -o c.exr").code == 2);
  CHECK(run(scene.folder, "merge a.exr b.exr -o none/c.exr").code == 4);
}

TEST_CASE("missing parts are rejected unless allowed and then recorded in the header") {
  const Scene scene;
  const std::string common = "--spp 16 --replicates 4 ";
  scene.render("a.exr", common + "--samples 0:8");
  scene.render("tile.exr", common + "--crop 3,4,20,10");
  const Outcome half = run(scene.folder, "merge a.exr -o half.exr --incomplete");
  CHECK(half.code == 0);
  CHECK(contains(half.err, "50 % of the samples"));
  const auto note = [&](const std::string& file) {
    for (const auto& attribute : read_exr_attributes(scene.folder / file))
      if (attribute.name == "sheaf/incomplete") return std::get<std::string>(attribute.value);
    return std::string();
  };
  CHECK(note("half.exr") == "0.5 of the samples");
  CHECK(contains(scene.refused("tile.exr"), "pixels 0,0,3,4 lack all samples"));
  CHECK(run(scene.folder, "merge tile.exr -o crop.exr --crop 3,4,20,10").code == 0);
  CHECK(note("crop.exr").empty());
  CHECK(run(scene.folder, "merge tile.exr -o crop.exr --crop 3,4,28,10").code == 2);
  const Image crop = read_exr(scene.folder / "crop.exr"), tile = read_exr(scene.folder / "tile.exr");
  CHECK(crop.x0 == 3);
  CHECK(crop.frame_width == 27);
  CHECK(crop.data == tile.data);
  // The header of an interrupted part records the interruption.
  write_bytes(scene.folder / "go.sh", SHEAF_EXECUTABLE
              " render scene.xml -o cut.exr --spp 16000000 --crop 0,0,27,18 --quiet --checkpoint cut.state "
              "--checkpoint-every 0.05 &\n"
              "until [[ -e cut.state ]]; do sleep 0.05; done\nkill -TERM $!\nwait $!\n");
  REQUIRE(std::system(("cd '" + scene.folder.path().string() + "' && bash go.sh").c_str()) != 0);
  CHECK(contains(scene.refused("cut.exr"), "cut.exr: was interrupted"));
  CHECK(run(scene.folder, "merge cut.exr -o cut_whole.exr --incomplete").code == 0);
  CHECK(contains(note("cut_whole.exr"), "interrupted"));
}

TEST_CASE("dropped samples of all parts are added up") {
  const Scene scene;
  const char* const names[] = {"sheaf/droppedRays", "sheaf/droppedSamples"};
  const std::vector<std::string> crops = {"0,0,9,18", "9,0,20,18", "20,0,27,18"};
  // All numbers differ, so that none can be mistaken for another.
  for (std::size_t i = 0; i < crops.size(); ++i) {
    const std::string file = "part" + std::to_string(i) + ".exr";
    scene.render(file, "--spp 2 --crop " + crops[i]);
    const Image image = read_exr(scene.folder / file);
    ExrMetadata metadata = read_exr_metadata(scene.folder / file);
    for (ExrMetadata::Attribute& attribute : metadata.attributes)
      for (std::size_t k = 0; k < 2; ++k)
        if (attribute.name == names[k]) {
          // Sheaf 0.2 and older store these numbers as text.
          const int count = (k == 0 ? 1 : 1000) << (2 * i);
          if (i == 1)
            attribute.value = std::to_string(count);
          else
            attribute.value = count;
        }
    write_exr(scene.folder / file, image, metadata);
  }
  REQUIRE(run(scene.folder, "merge part0.exr part1.exr part2.exr -o whole.exr").code == 0);
  for (std::size_t k = 0; k < 2; ++k)
    for (const ExrMetadata::Attribute& attribute : read_exr_attributes(scene.folder / "whole.exr"))
      if (attribute.name == names[k]) CHECK(std::get<int>(attribute.value) == (k == 0 ? 21 : 21000));
}

TEST_CASE("damaged and inconsistent parts are errors") {
  const Scene scene;
  scene.render("a.exr", "--spp 16 --replicates 4 --samples 0:8 --aov all");
  scene.render("b.exr", "--spp 16 --replicates 4 --samples 8:8 --aov all");
  const Image image = read_exr(scene.folder / "b.exr");
  const ExrMetadata metadata = read_exr_metadata(scene.folder / "b.exr");
  const auto with = [&](const std::string& name, const std::string& value, const std::string& said) {
    CAPTURE(name);
    ExrMetadata changed = metadata;
    for (ExrMetadata::Attribute& attribute : changed.attributes)
      if (attribute.name == name) attribute.value = value;
    write_exr(scene.folder / "bad.exr", image, changed);
    CHECK(contains(scene.refused("a.exr bad.exr"), said));
  };
  with("sheaf/samples", "8:9", "'8:9' of 16");
  with("sheaf/samples", "4294967295:4294967295", "invalid sample range");
  with("sheaf/samples", "many", "invalid sample range");
  with("sheaf/samplesPerPixel", "16", "lacks the number of samples per pixel");
  with("sheaf/version", "0.0.1", "was rendered by Sheaf 0.0.1");
  with("sheaf/droppedRays", "none", "'sheaf/droppedRays' in the header is not a number");
  for (const std::string& layer : {std::string("sampleCount"), std::string("part.weight"), std::string("part.cross.R"),
                                   std::string("part.object.number0")}) {
    CAPTURE(layer);
    Image less = image;
    less.channels[static_cast<std::size_t>(less.find_channel(layer))] = "other." + layer;
    write_exr(scene.folder / "bad.exr", less, metadata);
    CHECK(contains(scene.refused("a.exr bad.exr"), layer == "sampleCount" ? "sampleCount" : "other." + layer));
  }
  Image wrong = image;
  wrong.at(3, 3, wrong.find_channel("part.object.number0")) = 17;
  wrong.at(3, 3, wrong.find_channel("part.object.weight0")) = 1;
  write_exr(scene.folder / "bad.exr", wrong, metadata);
  CHECK(contains(scene.refused("a.exr bad.exr"), "number without an id"));
  const std::string bytes = read_bytes(scene.folder / "b.exr");
  for (std::size_t cut = 0; cut < bytes.size(); cut += bytes.size() / 11) {
    write_bytes(scene.folder / "bad.exr", bytes.substr(0, cut));
    scene.refused("a.exr bad.exr");
  }
}

}  // namespace sheaf::test_cli_merge
