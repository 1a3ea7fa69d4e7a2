// Output formats, exposure, tone maps and compression on the command line; and continued renders.
#include "core/color/color.h"
#include "core/color/tone_map.h"
#include "core/image/exr.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>

namespace sheaf::test_cli_display {

namespace {

using test::kScene;

/// A folder with the scene and its render as in.exr.
struct Rendered {
  Rendered() {
    write_bytes(folder / "scene.xml", kScene);
    REQUIRE(run(folder, "render scene.xml --quiet --spp 4 -o in.exr").code == 0);
    linear = read_exr(folder / "in.exr");
  }

  /// Largest difference between the file and the colors of in.exr after `map`, in encoded values.
  template <class Map> float error(const std::string& file, Map map) const {
    const Image displayed = read_image(folder / file);
    REQUIRE(displayed.channels.size() == 3);
    const int r = linear.find_channel("R"), g = linear.find_channel("G"), b = linear.find_channel("B");
    float largest = 0;
    for (int y = 0; y < linear.height; ++y)
      for (int x = 0; x < linear.width; ++x) {
        const Vec3f color = map(Vec3f{linear.at(x, y, r), linear.at(x, y, g), linear.at(x, y, b)});
        const float expected[] = {color.x, color.y, color.z};
        for (int c = 0; c < 3; ++c)
          largest = std::max(largest, std::abs(displayed.at(x, y, c) - linear_to_srgb(std::min(expected[c], 1.0f))));
      }
    return largest;
  }

  TemporaryFolder folder;
  Image linear;
};

constexpr float kByte = 0.51f / 255, kJpegError = 0.06f;

}  // namespace

TEST_CASE("display: every output format of render, denoise and convert") {
  const Rendered workplace;
  const Outcome rendered =
      run(workplace.folder, "render scene.xml --spp 4 -o a.exr -o a.png -o a.jpg -o a.JPEG -o a.tif -o a.tiff");
  REQUIRE(rendered.code == 0);
  const auto same = [](Vec3f color) { return color; };
  for (const char* const file : {"a.png", "a.tif", "a.tiff"}) CHECK(workplace.error(file, same) < kByte);
  for (const char* const file : {"a.jpg", "a.JPEG"}) CHECK(workplace.error(file, same) < kJpegError);
  CHECK(workplace.error("a.tif", same) < 0.01f * kByte);
  CHECK(run(workplace.folder, "convert in.exr -o b.jpg -o b.tif --quiet").code == 0);
  CHECK(read_bytes(workplace.folder / "b.tif") == read_bytes(workplace.folder / "a.tif"));
  CHECK(read_bytes(workplace.folder / "b.jpg") == read_bytes(workplace.folder / "a.jpg"));
  CHECK(run(workplace.folder, "convert in.exr -o c.jpg --jpeg-quality 20 --quiet").code == 0);
  CHECK(std::filesystem::file_size(workplace.folder / "c.jpg") <
        std::filesystem::file_size(workplace.folder / "a.jpg"));
  const Outcome unknown = run(workplace.folder, "convert in.exr -o b.webp");
  CHECK(unknown.code == 2);
  CHECK(contains(unknown.err, "must end in .exr, .png, .jpg, .jpeg, .tif or .tiff"));
  CHECK(run(workplace.folder, "convert in.exr -o in.exr").code == 2);
}

TEST_CASE("display: exposure and tone maps change displayed files, not the EXR") {
  const Rendered workplace;
  for (const char* const name : {"none", "filmic", "aces", "agx"}) {
    CAPTURE(name);
    const std::string options = std::string(" --quiet --exposure 1.5 --tone-map ") + name;
    REQUIRE(run(workplace.folder, "render scene.xml --spp 4 --no-timestamps -o a.exr -o a.png" + options).code == 0);
    REQUIRE(run(workplace.folder, "convert in.exr -o b.png" + options).code == 0);
    const auto map = [&](Vec3f color) { return tone_mapped(*kToneMaps.find(name), color * std::exp2(1.5f)); };
    CHECK(workplace.error("a.png", map) < kByte);
    CHECK(read_bytes(workplace.folder / "a.png") == read_bytes(workplace.folder / "b.png"));
    CHECK(read_exr(workplace.folder / "a.exr").data == workplace.linear.data);
  }
  const Outcome automatic = run(workplace.folder, "convert in.exr -o c.png --exposure auto");
  REQUIRE(automatic.code == 0);
  const std::size_t at = automatic.err.find("exposure ");
  REQUIRE(at != std::string::npos);
  const float stops = std::strtof(automatic.err.c_str() + at + 9, nullptr);
  CHECK(stops < 0);  // the scene is brighter than middle gray
  CHECK(workplace.error("c.png", [&](Vec3f color) { return color * std::exp2(stops); }) < 2 * kByte);
}

TEST_CASE("display: malformed options are usage errors") {
  const Rendered workplace;
  const std::pair<const char*, const char*> cases[] = {
      {"--exposure bright", "expected a number of stops from -100 to 100, or auto"},
      {"--exposure 1e9", "expected a number of stops"},
      {"--exposure nan", "expected a number of stops"},
      {"--tone-map acess", "aces"},
      {"--compression zipp", "unknown compression 'zipp', did you mean 'zip'"},
      {"--compression zip:3", "expected a level"},
      {"--compression dwaa:", "expected a level"},
      {"--compression dwaa:-1", "expected a level"},
      {"--jpeg-quality 0", "--jpeg-quality"},
      {"--ocio-config none.ocio", "cannot use the OpenColorIO configuration 'none.ocio'"},
      {"--ocio-config raw --tone-map agx", "exclude each other"},
      {"--ocio-view Film", "cannot use the OpenColorIO configuration"}};
  for (const auto& [options, message] : cases) {
    const std::string words = options;
    CAPTURE(words);
    const Outcome outcome = run(workplace.folder, "convert in.exr -o out.png " + words, "unset OCIO && ");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, message));
    CHECK_FALSE(std::filesystem::exists(workplace.folder / "out.png"));
  }
}

TEST_CASE("display: compressions of EXR files") {
  const Rendered workplace;
  for (const char* const name : {"zip", "zips", "piz", "rle", "none", "dwaa", "dwab:200"}) {
    CAPTURE(name);
    REQUIRE(run(workplace.folder, std::string("convert in.exr -o out.exr --quiet --compression ") + name).code == 0);
    const Image out = read_exr(workplace.folder / "out.exr");
    REQUIRE(out.channels == workplace.linear.channels);
    CHECK((out.data == workplace.linear.data) == (name[0] != 'd'));
  }
  // Parts that hold sample ranges are stored without loss.
  const std::string part = "render scene.xml --quiet --no-timestamps --spp 4 --replicates 1 --samples 0:2 -o ";
  REQUIRE(run(workplace.folder, part + "exact.exr").code == 0);
  REQUIRE(run(workplace.folder, part + "part.exr --compression dwaa").code == 0);
  CHECK(read_bytes(workplace.folder / "exact.exr") == read_bytes(workplace.folder / "part.exr"));
}

TEST_CASE("display: header fields have types, and vary between runs only with timestamps") {
  const Rendered workplace;
  const auto find = [&](const char* file, const char* name) -> std::optional<ExrMetadata::Attribute> {
    for (ExrMetadata::Attribute& attribute : read_exr_attributes(workplace.folder / file))
      if (attribute.name == name) return attribute;
    return std::nullopt;
  };
  REQUIRE(
      run(workplace.folder, "render ./scene.xml --quiet --spp 8 --replicates 4 --seed 4294967295 -o 'a b.exr'").code ==
      0);
  CHECK(std::get<double>(find("a b.exr", "sheaf/seed")->value) == 4294967295.0);
  CHECK(std::get<int>(find("in.exr", "sheaf/seed")->value) == 0);
  CHECK(std::get<int>(find("in.exr", "sheaf/droppedRays")->value) == 0);
  CHECK(std::get<int>(find("in.exr", "sheaf/droppedSamples")->value) == 0);
  CHECK(std::get<float>(find("a b.exr", "sheaf/noise")->value) > 0);
  CHECK(std::get<float>(find("a b.exr", "sheaf/renderSeconds")->value) > 0);
  CHECK(std::get<std::string>(find("a b.exr", "sheaf/scene")->value) == "scene.xml");
  CHECK(contains(std::get<std::string>(find("a b.exr", "sheaf/commandLine")->value),
                 " render ./scene.xml --quiet --spp 8 --replicates 4 --seed 4294967295 -o 'a b.exr'"));
  CHECK_FALSE(find("in.exr", "sheaf/noise").has_value());  // unknown with one sample set
  for (const char* const file : {"b.exr", "c.exr"})
    REQUIRE(run(workplace.folder, std::string("render scene.xml --no-timestamps --spp 2 -o ") + file).code == 0);
  CHECK(read_bytes(workplace.folder / "b.exr") == read_bytes(workplace.folder / "c.exr"));
}

TEST_CASE("display: convert writes a layer under its name in --aov or in the file") {
  const Rendered workplace;
  const auto sheaf = [&](const std::string& arguments) { return run(workplace.folder, arguments); };
  REQUIRE(sheaf("render scene.xml -q --no-timestamps --spp 16 --denoise nlm --light-groups "
                "--aov normal,depth,uv,cryptomatte_object -o a.exr -o a.png")
              .code == 0);
  const Image all = read_exr(workplace.folder / "a.exr");
  const auto layer = [&](const std::string& name) {
    REQUIRE(sheaf("convert a.exr --layer " + name + " -o b.exr -o b.png").code == 0);
    return read_exr(workplace.folder / "b.exr");
  };
  struct Case {
    const char *name, *channel, *stored;
    std::size_t channels;
  };
  for (const Case& each : {Case{"normal", "N.Z", "B", 3},
                           {"depth", "Z", "Y", 1},
                           {"uv", "uv.V", "G", 3},
                           {"sample_count", "sampleCount", "Y", 1},
                           {"denoised", "denoised.G", "G", 3},
                           {"image", "A", "A", 4},
                           {"variance.N", "variance.N.Y", "G", 3},
                           {"CryptoObject00", "CryptoObject00.g", "G", 4}}) {
    CAPTURE(std::string(each.name));
    const Image image = layer(each.name);
    REQUIRE(image.channels.size() == each.channels);
    const int from = all.find_channel(each.channel), to = image.find_channel(each.stored);
    REQUIRE(from >= 0);
    REQUIRE(to >= 0);
    float difference = 0;
    for (int y = 0; y < all.height; ++y)
      for (int x = 0; x < all.width; ++x)
        difference = std::max(difference, std::abs(all.at(x, y, from) - image.at(x, y, to)));
    CHECK(difference == 0);
  }
  // Displayed images
  layer("denoised");
  CHECK(read_image(workplace.folder / "b.png").data == read_image(workplace.folder / "a.png").data);
  layer("image");
  CHECK(read_image(workplace.folder / "b.png").data != read_image(workplace.folder / "a.png").data);
  layer("normal");
  const Image normals = read_image(workplace.folder / "b.png");
  const int x = all.width / 2, y = all.height / 2;  // the sphere faces the camera
  CHECK(normals.at(x, y, 2) > 0.95f);
  CHECK(std::abs(normals.at(x, y, 0) - 0.5f) < 0.1f);
  CHECK(normals.at(0, 0, normals.find_channel("A")) == 0);
  // Unknown layers
  const Outcome unknown = sheaf("convert a.exr --layer normals -o c.png");
  CHECK(unknown.code == 2);
  CHECK(contains(unknown.err, "--layer normals: the image has no such layer, did you mean 'normal'? (layers: image, "));
  CHECK(contains(unknown.err, "denoised"));
  CHECK_FALSE(std::filesystem::exists(workplace.folder / "c.png"));
}

TEST_CASE("display: a finished render continues with more samples to the same bytes") {
  const Rendered workplace;
  const auto render = [&](const std::string& options) {
    return run(workplace.folder, "render scene.xml --no-timestamps --sampler sobol " + options);
  };
  REQUIRE(render("--spp 64 --quiet -o a.exr --checkpoint a.state").code == 0);
  // The same size of sample sets by default
  const Outcome more = render("--spp 128 -o b.exr --checkpoint a.state --resume");
  CHECK(more.code == 0);
  CHECK_FALSE(contains(more.err, "--replicates"));
  REQUIRE(render("--spp 128 --quiet -o whole.exr").code == 0);
  CHECK(read_bytes(workplace.folder / "b.exr") == read_bytes(workplace.folder / "whole.exr"));
  // Another size by default: the render keeps the sets of the checkpoint, and says so.
  const Outcome kept = render("--spp 2048 -o b.exr --checkpoint a.state --resume");
  CHECK(kept.code == 0);
  CHECK(contains(kept.err,
                 "continues 128 samples per pixel with sample sets of 32: the image is that of "
                 "--replicates 64"));
  REQUIRE(render("--spp 2048 --quiet --replicates 64 -o whole.exr").code == 0);
  CHECK(read_bytes(workplace.folder / "b.exr") == read_bytes(workplace.folder / "whole.exr"));
  // No continuation with the same bits
  const Outcome refused = render("--spp 4096 --replicates 2 -o c.exr --checkpoint a.state --resume");
  CHECK(refused.code == 5);
  CHECK(contains(refused.err,
                 "a.state: cannot be continued: --spp 2048 in the checkpoint, 4096 now: its samples form sets of 32"));
  // A few samples are taken again.
  REQUIRE(render("--spp 8 --quiet -o a.exr --checkpoint few.state").code == 0);
  const Outcome again = render("--spp 64 -o b.exr --checkpoint few.state --resume");
  CHECK(again.code == 0);
  CHECK(contains(again.err, "the render begins again"));
  CHECK(read_exr(workplace.folder / "b.exr").channels == read_exr(workplace.folder / "whole.exr").channels);
  REQUIRE(render("--spp 64 --quiet -o whole.exr").code == 0);
  CHECK(read_bytes(workplace.folder / "b.exr") == read_bytes(workplace.folder / "whole.exr"));
}

}  // namespace sheaf::test_cli_display
