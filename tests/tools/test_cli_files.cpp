// Files that a render writes: images and statistics, their names, and outputs that cannot be written or would overwrite
// others.
#include "core/image/exr.h"
#include "tests/support/media_testing.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace sheaf::test_cli_files {

using test::kScene;

TEST_CASE("one render writes several images and the statistics") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome outcome = run(
      folder, "render scene.xml -o a.exr -o b.png --spp 4 --seed 7 --integrator path_mis --max-depth 2 --stats s.json");
  CAPTURE(outcome.err);
  REQUIRE(outcome.code == 0);
  CHECK(outcome.out.empty());
  CHECK(contains(outcome.err, "rendered 24x16, 4 spp"));
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
                          "loading",
                          "reading_seconds",
                          "texture_seconds",
                          "compile_seconds",
                          "accel_seconds",
                          "triangles",
                          "bvh",
                          "memory",
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
  CHECK(contains(stats, "\"integrator\": \"path_mis\""));
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
  Image image(4, 4, {"R", "G", "B"});
  for (const char* name : {"sky.exr", "mtl.png", "cloth.png"})
    if (asset(name).extension() == ".exr")
      write_exr(asset(name), image);
    else
      write_png(asset(name), image);
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

}  // namespace sheaf::test_cli_files
