// Interruption and resumption of renders: signals and checkpoints.
#include "core/image/exr.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <tuple>
#include <utility>

namespace sheaf::test_cli_signals {

using test::kScene;

namespace {

/// An attribute of a file; none if it has none of the name and type.
template <class T> std::optional<T> attribute(const std::filesystem::path& file, const std::string& name) {
  for (const ExrMetadata::Attribute& each : read_exr_attributes(file))
    if (each.name == name)
      if (const T* value = std::get_if<T>(&each.value)) return *value;
  return std::nullopt;
}

double mean_samples(const Image& image) {
  const int count = image.find_channel("sampleCount");
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += double{image.at(x, y, count)};
  return sum / static_cast<double>(image.pixel_count());
}

/// The header records the interruption and the sample count.
void check_marked(const TemporaryFolder& folder, const std::string& file, const Image& image, int planned) {
  const double taken = mean_samples(image);
  CHECK(attribute<int>(folder / file, "sheaf/interrupted") == 1);
  CHECK(double{attribute<float>(folder / file, "sheaf/samplesTaken").value_or(-1.0f)} == near(taken, 1e-5));
  CHECK(attribute<int>(folder / file, "sheaf/samplesPlanned") == planned);
  CHECK(attribute<int>(folder / file, "sheaf/samplesPerPixel") == static_cast<int>(std::lround(taken)));
  CHECK(attribute<std::string>(folder / file, "sheaf/integrator") == "path");
  CHECK(contains(run(folder, "info " + file).out, "warning     the render was interrupted after "));
}

}  // namespace

TEST_CASE("an interrupted render writes its image and reports the interruption") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const auto& [name, code] : {std::pair{"INT", 130}, std::pair{"TERM", 143}, std::pair{"HUP", 129}}) {
    CAPTURE_BINDING(name);
    const std::string kill = "(sleep 2; kill -" + std::string(name) + " $$) & exec ";
    write_bytes(folder / "go.sh",
                kill + SHEAF_EXECUTABLE " render scene.xml -o out.exr -D size=512 --spp 16000000 --threads 1\n");
    // The script becomes the renderer, because shells start background jobs with SIGINT ignored.
    const int status = std::system(("cd '" + folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == code);
    const Image image = read_exr(folder / "out.exr");
    CHECK(image.width == 512);
    CHECK(contains(read_bytes(folder / "log.txt"), "interrupted"));
    check_marked(folder, "out.exr", image, 16'000'000);
    std::filesystem::remove(folder / "out.exr");
  }
}

TEST_CASE("an interrupted image is marked in every file and reported by its readers") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  // Stopped half a second after the first checkpoint, also on a busy machine. The rest would take hours.
  const auto render = [&](const std::string& options) {
    std::filesystem::remove(folder / "c.state");
    write_bytes(folder / "go.sh",
                SHEAF_EXECUTABLE " render scene.xml --quiet --checkpoint c.state --checkpoint-every 0.2 " + options +
                    " &\nuntil [[ -e c.state ]]; do sleep 0.05; done\nsleep 0.5\nkill -TERM $!\nwait $!\n");
    const int status = std::system(("cd '" + folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 143);
  };
  const std::string layers = "--aov variance,half,albedo,normal,depth ";
  render("-D size=64 --spp 16000000 --replicates 1000 --sampler independent --filter-mode importance " + layers +
         "-o a.exr -o a.png --stats a.json");
  const Image image = read_exr(folder / "a.exr");
  check_marked(folder, "a.exr", image, 16'000'000);
  // Independent samples: the noise is known although no replicate is complete.
  const double noise = static_cast<double>(attribute<float>(folder / "a.exr", "sheaf/noise").value_or(-1.0f));
  CHECK(noise > 0);
  CHECK(noise < 1);
  CHECK(contains(read_bytes(folder / "a.png"), "the render was interrupted after "));
  const std::string stats = read_bytes(folder / "a.json");
  CHECK(contains(stats, "\"interrupted\": true"));
  CHECK(contains(stats, "\"mean_samples\": "));
  const Outcome denoised = run(folder, "denoise a.exr -o b.exr -o b.png");
  CHECK(denoised.code == 0);
  CHECK(contains(denoised.err, "sheaf: warning: the render was interrupted after "));
  CHECK(contains(denoised.err, " of 16000000 samples per pixel, at a noise of "));
  check_marked(folder, "b.exr", image, 16'000'000);
  CHECK(contains(read_bytes(folder / "b.png"), "the render was interrupted after "));
  // The noise is unknown before a replicate is complete. The header of a part names its range.
  render("-D size=64 --spp 16000000 --replicates 2 --crop 0,0,64,8 -o part.exr");
  CHECK_FALSE(attribute<float>(folder / "part.exr", "sheaf/noise").has_value());
  const Image part = read_exr(folder / "part.exr");
  check_marked(folder, "part.exr", part, 16'000'000);
  const Outcome merged = run(folder, "merge part.exr -o whole.exr --incomplete --crop 0,0,64,8");
  CHECK(merged.code == 0);
  CHECK(contains(merged.err, "sheaf: warning: the render was interrupted after "));
  check_marked(folder, "whole.exr", part, 16'000'000);
  // A finished render has no such attributes.
  REQUIRE(run(folder, "render scene.xml --spp 2 --quiet -o c.exr -o c.png --stats c.json").code == 0);
  CHECK_FALSE(attribute<int>(folder / "c.exr", "sheaf/interrupted").has_value());
  CHECK_FALSE(attribute<float>(folder / "c.exr", "sheaf/samplesTaken").has_value());
  CHECK_FALSE(contains(read_bytes(folder / "c.png"), "interrupted"));
  CHECK(contains(read_bytes(folder / "c.json"), "\"interrupted\": false"));
  CHECK_FALSE(contains(run(folder, "info c.exr").out, "interrupted"));
}

TEST_CASE("a second signal ends a render that does not stop") {
  const TemporaryFolder folder;
  // Paths in a closed white sphere without roulette are as long as paths can be.
  write_bytes(folder / "scene.xml", R"(<scene version="3.0.0">
    <integrator type="path"><integer name="rr_depth" value="1000000"/></integrator>
    <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/>
      </film></sensor>
    <shape type="sphere"><boolean name="flip_normals" value="true"/>
      <bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></shape></scene>)");
  using Signals = std::tuple<const char*, const char*, int>;
  for (const auto& [first, second, code] : {Signals{"TERM", "TERM", 143}, {"INT", "TERM", 143}, {"HUP", "INT", 130}}) {
    CAPTURE_BINDING(first);
    write_bytes(folder / "go.sh", "(sleep 1.5; kill -" + std::string(first) + " $$; sleep 0.5; kill -" + second +
                                      " $$) & exec " SHEAF_EXECUTABLE
                                      " render scene.xml -o out.exr --spp 65536 --threads 1\n");
    const int status = std::system(
        ("cd '" + folder.path().string() + "' && timeout -s KILL 60 bash go.sh >log.txt 2>&1; exit $?").c_str());
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == code);
    CHECK_FALSE(std::filesystem::exists(folder / "out.exr"));
  }
}

TEST_CASE("a killed or interrupted render resumes from its checkpoint to the same bits") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const std::string render = SHEAF_EXECUTABLE " render scene.xml -D size=64 --spp 3000 --quiet --no-timestamps ";
  const auto run_script = [&](const std::string& script) {
    write_bytes(folder / "go.sh", script);
    const int status = std::system(("cd '" + folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
    REQUIRE(WIFEXITED(status));
    return WEXITSTATUS(status);
  };
  REQUIRE(run_script(render + "-o whole.exr\n") == 0);
  const std::string part = render + "-o part.exr --checkpoint part.state --checkpoint-every 0.02 --resume --threads 1";
  for (const char* delay : {"0.6", "0.9", "0.7"})
    run_script("timeout -s KILL " + std::string(delay) + " " + part + "\n");
  run_script("timeout --foreground -s INT 1 " + part + "\n");
  REQUIRE(std::filesystem::exists(folder / "part.state"));
  CHECK(run(folder, "render scene.xml -D size=64 --spp 2999 --checkpoint part.state --resume").code == 5);
  CHECK(contains(run(folder, "render scene.xml -D size=64 --spp 2999 --checkpoint part.state --resume").err,
                 "part.state: cannot be continued: --spp 3000 in the checkpoint, 2999 now"));
  CHECK(run(folder, "render scene.xml -D size=64 --spp 3000 --checkpoint part.state").code == 2);
  CHECK(run(folder, "render scene.xml --resume").code == 2);
  CHECK(run(folder, "render scene.xml --checkpoint scene.xml --resume").code == 2);
  CHECK(run(folder, "render scene.xml --checkpoint no/such.state").code == 4);
  for (const bool again : {false, true}) {
    CAPTURE(again);
    std::filesystem::remove(folder / "part.exr");
    REQUIRE(run_script(part + "\n") == 0);
    CHECK(read_bytes(folder / "part.exr") == read_bytes(folder / "whole.exr"));
  }
  // A scene that has changed.
  std::string scene = kScene;
  write_bytes(folder / "scene.xml", scene + " ");
  CHECK(run_script(part + "\n") == 5);
}

TEST_CASE("SIGUSR1 writes the current image and the render continues") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  write_bytes(folder / "go.sh",
              "(sleep 1; kill -USR1 $$; sleep 1; cp out.exr preview.exr; kill -INT $$) & "
              "exec " SHEAF_EXECUTABLE " render scene.xml -o out.exr -D size=128 --spp 16000000\n");
  const int status = std::system(("cd '" + folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 130);
  CHECK(contains(read_bytes(folder / "log.txt"), "wrote the unfinished image to out.exr"));
  const Image preview = read_exr(folder / "preview.exr"), end = read_exr(folder / "out.exr");
  CHECK(preview.width == 128);
  check_marked(folder, "preview.exr", preview, 16'000'000);
  check_marked(folder, "out.exr", end, 16'000'000);
  const int count = preview.find_channel("sampleCount");
  CHECK(preview.at(5, 5, count) > 0);
  CHECK(end.at(5, 5, count) > preview.at(5, 5, count));
}

}  // namespace sheaf::test_cli_signals
