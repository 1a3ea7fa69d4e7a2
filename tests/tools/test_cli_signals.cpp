// What ends a render early, and how it goes on: signals and checkpoints.
#include "core/exr.h"
#include "tests/support/capture.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

#include <sys/wait.h>

#include <cstdlib>
#include <tuple>
#include <utility>

namespace sheaf::test_cli_signals {

using test::kScene;

TEST_CASE("an interrupted render writes what there is and says so") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  for (const auto& [name, code] : {std::pair{"INT", 130}, std::pair{"TERM", 143}, std::pair{"HUP", 129}}) {
    CAPTURE_BINDING(name);
    const std::string kill = "(sleep 2; kill -" + std::string(name) + " $$) & exec ";
    write_bytes(folder / "go.sh",
                kill + SHEAF_EXECUTABLE " render scene.xml -o out.exr -D size=512 --spp 16000000 --threads 1\n");
    // The script becomes the renderer, since shells start background jobs with SIGINT ignored.
    const int status = std::system(("cd '" + folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == code);
    CHECK(read_exr(folder / "out.exr").width == 512);
    CHECK(contains(read_bytes(folder / "log.txt"), "interrupted"));
    std::filesystem::remove(folder / "out.exr");
  }
}

TEST_CASE("a second signal ends a render that does not come to a stop") {
  const TemporaryFolder folder;
  // Paths in a closed white ball, without roulette, are as long as paths can be.
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

TEST_CASE("a render that was killed or interrupted goes on from its checkpoint, to the same bytes") {
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
  run_script("timeout -s INT 1 " + part + "\n");
  REQUIRE(std::filesystem::exists(folder / "part.state"));
  CHECK(run(folder, "render scene.xml -D size=64 --spp 2999 --checkpoint part.state --resume").code == 5);
  CHECK(contains(run(folder, "render scene.xml -D size=64 --spp 2999 --checkpoint part.state --resume").err,
                 "--spp is '2999' now, and was '3000' then"));
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

TEST_CASE("SIGUSR1 shows what there is, and the render goes on") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  write_bytes(folder / "go.sh",
              "(sleep 1; kill -USR1 $$; sleep 1; cp out.exr preview.exr; kill -INT $$) & "
              "exec " SHEAF_EXECUTABLE " render scene.xml -o out.exr -D size=128 --spp 16000000\n");
  const int status = std::system(("cd '" + folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 130);
  CHECK(contains(read_bytes(folder / "log.txt"), "wrote what there is to out.exr"));
  const Image preview = read_exr(folder / "preview.exr"), end = read_exr(folder / "out.exr");
  CHECK(preview.width == 128);
  const int count = preview.find_channel("sampleCount");
  CHECK(preview.at(5, 5, count) > 0);
  CHECK(end.at(5, 5, count) > preview.at(5, 5, count));
}

}  // namespace sheaf::test_cli_signals
