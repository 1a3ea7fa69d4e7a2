// The jobs that `sheaf farm` writes, run by a replacement for sbatch that runs each job at once. test_slurm.cpp uses
// Slurm.
#include "core/image/exr.h"
#include "tests/support/files/rising_triangle.h"
#include "tests/support/parts_testing.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_cli_farm {

namespace {

constexpr const char* kScene = R"(<scene version="3.0.0">
  <default name="frame" value="0"/>
  <integrator type="path"/>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="$frame,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film>
    <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
  </sensor>
  <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
  <emitter type="constant"><rgb name="radiance" value="1"/></emitter>
</scene>)";

/// Understands --parsable, --array=0-N and --dependency=..., and writes all other arguments to a file.
constexpr const char* kSbatch = R"sh(#!/usr/bin/env bash
printf '%s\n' "$*" >>"$SBATCH_LOG"
last=0
while [[ $1 == --* ]]; do
  [[ $1 == --array=0-* ]] && last=${1#--array=0-}
  shift
done
export SLURM_ARRAY_JOB_ID=7 SLURM_CPUS_PER_TASK=1
for ((SLURM_ARRAY_TASK_ID = 0; SLURM_ARRAY_TASK_ID <= last; ++SLURM_ARRAY_TASK_ID)); do
  export SLURM_ARRAY_TASK_ID
  bash "$@" </dev/null >/dev/null || exit
done
echo '7;cluster'
)sh";

/// A folder whose name scripts must quote, with a scene and an sbatch.
struct FarmFolder {
  FarmFolder() {
    std::filesystem::create_directories(folder / "bin");
    std::filesystem::create_directories(here);
    write_bytes(here / kSceneName, kScene);
    write_bytes(folder / "bin/sbatch", kSbatch);
    std::filesystem::permissions(folder / "bin/sbatch", std::filesystem::perms::owner_all);
  }
  /// Runs the program in the folder. `arguments` are words for the shell.
  Outcome sheaf(const std::string& arguments) const {
    return run(folder, arguments,
               "cd ./*here* && export PATH='" + (folder / "bin").string() + "':\"$PATH\" SBATCH_LOG='" +
                   (folder / "sbatch.log").string() + "' && ");
  }
  TemporaryFolder folder;
  std::filesystem::path here = folder / "it's \"here\"\n$(touch gone) %j \\";
  static constexpr const char* kSceneName = "a scene's $frame;`x`.xml";
};

constexpr const char* kQuotedScene = "\"a scene's \\$frame;\\`x\\`.xml\"";

}  // namespace

TEST_CASE("farm: frames are rendered in parts and merged whatever the file names") {
  const FarmFolder farm;
  const std::string scene = kQuotedScene, options = "--spp 60 --no-timestamps --float";
  struct Cut {
    const char* parts;
    const char* of_part;
  };
  for (const Cut& cut : {Cut{"--parts 3", "--samples"}, Cut{"--parts 5 --tiles", "--crop"}}) {
    CAPTURE(cut.parts);
    const Outcome made =
        farm.sheaf("farm " + scene + " --frames 9:10 --folder 'its jobs' -o 'o %a####.exr' -o 'p'\\''.png' " +
                   cut.parts + " --submit --time 1:00 --partition 'a b' -- " + options);
    INFO(made.err);
    REQUIRE(made.code == 0);
    CHECK(contains(made.out, "frame 9: parts are job 7, merging is job 7"));
    for (const std::string frame : {"9", "10"}) {
      const std::string number = frame == "9" ? "0009" : "0010";
      REQUIRE(farm.sheaf("render " + scene + " --quiet -o whole.exr -o whole.png --replicates 3 -D frame=" + frame +
                         " " + "--spp 60 --no-timestamps --float")
                  .code == 0);
      const auto found = farm.here / ("o %a" + number + ".exr");
      REQUIRE(std::filesystem::exists(found));
      if (std::string(cut.of_part) == "--samples") check_near(read_exr(found), read_exr(farm.here / "whole.exr"));
      CHECK(std::filesystem::exists(farm.here / ("p'_" + number + ".png")));
      CHECK(std::filesystem::exists(farm.here / "its jobs/parts" / number / "2.exr"));
      CHECK(!std::filesystem::exists(farm.here / "its jobs/parts" / number / "2.state"));
      std::filesystem::remove(found);
    }
    CHECK(contains(read_bytes(farm.here / "its jobs/render.sh"), cut.of_part));
    std::filesystem::remove_all(farm.here / "its jobs");
  }
  const std::string log = read_bytes(farm.folder / "sbatch.log");
  CHECK(contains(log, "--parsable --array=0-2 "));
  for (const char* option : {"--requeue", "--signal=B:TERM@60", "--time=1:00", "--partition=a b", "--cpus-per-task=1",
                             "--dependency=afterok:7 --kill-on-invalid-dep=yes"})
    CHECK(contains(log, option));
  CHECK(!std::filesystem::exists(farm.here / "gone"));
}

TEST_CASE("farm: merged tiles have the bytes of the whole, also with a film that has a crop window") {
  for (const bool has_crop : {false, true}) {
    CAPTURE(has_crop);
    const FarmFolder farm;
    const std::string scene = kQuotedScene;
    if (has_crop) {
      std::string text = kScene;
      const std::string film = "<film type=\"hdrfilm\">";
      text.insert(text.find(film) + film.size(),
                  "<integer name='crop_offset_x' value='5'/><integer name='crop_offset_y' value='3'/>"
                  "<integer name='crop_width' value='11'/><integer name='crop_height' value='9'/>");
      write_bytes(farm.here / FarmFolder::kSceneName, text);
    }
    const Outcome made =
        farm.sheaf("farm " + scene + " --parts 4 --tiles -o joined.exr --submit -- --spp 5 --no-timestamps");
    INFO(made.err);
    REQUIRE(made.code == 0);
    REQUIRE(farm.sheaf("render " + scene + " --quiet -o whole.exr --spp 5 --no-timestamps").code == 0);
    CHECK(read_bytes(farm.here / "joined.exr") == read_bytes(farm.here / "whole.exr"));
    const Image joined = read_exr(farm.here / "joined.exr");
    CHECK(joined.width == (has_crop ? 11 : 24));
    CHECK(joined.height == (has_crop ? 9 : 16));
    CHECK(joined.y0 == (has_crop ? 3 : 0));
  }
}

TEST_CASE("farm: samples are split into ranges") {
  const FarmFolder farm;
  const std::string scene = kQuotedScene;
  const auto script = [&](const std::string& options) {
    const Outcome made = farm.sheaf("farm " + scene + " --folder jobs " + options);
    INFO(made.err);
    CHECK(made.code == 0);
    return read_bytes(farm.here / "jobs/render.sh");
  };
  // Below 32 samples there is one replicate, which can be split anywhere.
  std::string text = script("--parts 3 -- --spp 16");
  CHECK(contains(text, "values=('0:5' '5:5' '10:6')"));
  CHECK(contains(text, "'--replicates' '1'"));
  // The number of replicates becomes a multiple of the parts.
  text = script("--parts 3 -- --spp 128");
  CHECK(contains(text, "values=('0:44' '44:44' '88:40')"));
  CHECK(contains(text, "'--replicates' '6'"));
  text = script("--parts 3 -- --spp 16 --aov variance");
  CHECK(contains(text, "'--replicates' '3'"));
  // Replicates are made smaller where parts would be empty otherwise.
  text = script("--parts 16 -- --spp 36");
  CHECK(contains(text, "values=('0:2' '2:2' '4:2' '6:2' '8:2' '10:2' '12:2' '14:4' '18:2'"));
  CHECK(contains(text, "'32:4')"));
  CHECK(contains(text, "'--replicates' '18'"));
  text = script("--parts 3 -- --spp 16 --sampler independent");
  CHECK(contains(text, "values=('0:4' '4:6' '10:6')"));
  CHECK(contains(text, "'--replicates' '9'"));
  // An explicit number of replicates is kept.
  text = script("--parts 3 -- --spp 128 --replicates 4");
  CHECK(contains(text, "values=('0:32' '32:32' '64:64')"));
  CHECK(!contains(text, "'--replicates' '6'"));
  CHECK(contains(script("--parts 1 -- --crop 1,2,10,12"), "values=('0:64')"));
  CHECK(contains(read_bytes(farm.here / "jobs/merge.sh"), "options=('--crop' '1,2,10,12')"));
}

TEST_CASE("farm: the merged image is denoised") {
  const FarmFolder farm;
  const std::string scene = kQuotedScene, options = " --spp 64 --no-timestamps --replicates 4 --exposure 1 --aov ";
  for (const char* const parts : {"--parts 2 --tiles", "--parts 4"}) {
    CAPTURE(std::string(parts));
    const Outcome made = farm.sheaf("farm " + scene + " --folder jobs -o out.exr -o out.png --submit --denoise nlm " +
                                    parts + " --" + options + "uv");
    INFO(made.err);
    REQUIRE(made.code == 0);
    REQUIRE(
        farm.sheaf("render " + scene + " -q -o whole.exr" + options + "uv,albedo,normal,depth,variance,half").code ==
        0);
    REQUIRE(farm.sheaf("denoise whole.exr --exposure 1 -o out2.exr -o out2.png").code == 0);
    const Image image = read_exr(farm.here / "out.exr");
    CHECK(image.find_channel("denoised.R") >= 0);
    CHECK(image.find_channel("uv.U") >= 0);
    check_near(image, read_exr(farm.here / "out2.exr"));
    if (std::string(parts) == "--parts 2 --tiles")
      CHECK(read_bytes(farm.here / "out.png") == read_bytes(farm.here / "out2.png"));
    CHECK_FALSE(std::filesystem::exists(farm.here / "jobs/parts/merged.exr"));
  }
  CHECK(contains(read_bytes(farm.here / "jobs/merge.sh"), "denoise_options=('--exposure' '1')"));
}

TEST_CASE("farm: the frames of a glTF file are rendered at their times") {
  const FarmFolder farm;
  write_bytes(farm.here / "model.glb", test::rising_triangle().binary());
  const std::string options = "--size 24x16 --spp 4 --no-timestamps -q";
  const Outcome made =
      farm.sheaf("farm model.glb --frames 0:2 --fps 2.3 --parts 2 --tiles -o a.png --submit -- " + options);
  INFO(made.err);
  REQUIRE(made.code == 0);
  REQUIRE(farm.sheaf("render model.glb --frames 0:2 --fps 2.3 -o b.png " + options).code == 0);
  for (const char* const number : {"0000", "0001", "0002"})
    CHECK(read_bytes(farm.here / fmt::format("a_{}.png", number)) ==
          read_bytes(farm.here / fmt::format("b_{}.png", number)));
  CHECK(read_bytes(farm.here / "a_0000.png") != read_bytes(farm.here / "a_0001.png"));
}

TEST_CASE("farm: the help names each option of render that it does not take") {
  const FarmFolder farm;
  const std::string help = farm.sheaf("help farm").out;
  for (const char* const name : {"--noise-target", "--time-limit", "--stats", "--samples", "--threads", "ptracer"}) {
    CAPTURE(std::string(name));
    CHECK(contains(help, name));
  }
}

TEST_CASE("farm: invalid requests are usage errors and write nothing") {
  const FarmFolder farm;
  const std::string scene = kQuotedScene;
  const auto error = [&](const std::string& options, int code = 2) {
    CAPTURE(options);
    const Outcome made = farm.sheaf("farm " + scene + " --folder jobs " + options);
    CHECK(made.code == code);
    CHECK(!std::filesystem::exists(farm.here / "jobs"));
    return made.err;
  };
  CHECK(contains(error("--parts 65"), "64 samples per pixel cannot be split into 65 parts"));
  CHECK(contains(error("--parts 5 -- --replicates 4"), "4 sample sets"));
  CHECK(contains(error("--parts 17 --tiles"), "16 pixel rows"));
  CHECK(contains(error("--parts 900 -- --spp 1700"), "1700 sample sets (--replicates), expected at most 1024"));
  for (const char* frames : {"1", "1:", "5:1", "-1:2", "1:2:0", "1:2:3:4", "1:2:", "a:b", "1:99999999"})
    CHECK(contains(error("--parts 2 --frames=" + std::string(frames)), "FIRST:LAST"));
  CHECK(contains(error("--parts 2 -- --threads 3"), "--cpus"));
  CHECK(contains(error("--parts 2 -- --denoise nlm"), "the --denoise of 'sheaf farm'"));
  CHECK(contains(error("--parts 2 --denoise nlm -- --spp 1"), "at least 2 samples per pixel"));
  write_bytes(farm.here / "still.stl", "");
  CHECK(contains(farm.sheaf("farm still.stl --parts 2 --frames 1:2").err, "not to models that do not move"));
  CHECK(contains(error("--parts 2 -- --noise-target 0.1"), "rendered independently"));
  CHECK(contains(error("--parts 2 -- -o x.exr"), "the --output of 'sheaf farm'"));
  CHECK(contains(error("--parts 2 -- --integrator ptracer"), "ptracer"));
  CHECK(contains(error("--parts 2 -- --sppp 3"), "--sppp"));
  CHECK(contains(error("--parts 2 -- -D no=1", 3), "no"));
  CHECK(contains(error("--parts 2 -o none/x.exr", 4), "none"));
  error("");
  error("--parts 0");
  CHECK(contains(error("--parts 2 -o x.webp"), ".exr, .png, .jpg"));
}

TEST_CASE("farm: merged images of models have an automatic exposure unless one is given") {
  const FarmFolder farm;
  write_bytes(farm.here / "model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto scripts = [&](const std::string& options) {
    REQUIRE(farm.sheaf("farm model.obj --folder jobs -o a.png --parts 2 -- --spp 8 " + options).code == 0);
    std::string text;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(farm.here / "jobs"))
      if (entry.is_regular_file()) text += read_bytes(entry.path());
    std::filesystem::remove_all(farm.here / "jobs");
    return text;
  };
  CHECK(contains(scripts(""), "'--exposure' 'auto'"));
  CHECK_FALSE(contains(scripts("--exposure 1"), "'--exposure' 'auto'"));
}

}  // namespace sheaf::test_cli_farm
