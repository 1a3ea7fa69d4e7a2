// sheaf render --frames: the frames of an animation, their names, and what happens to existing and unfinished ones.
#include "core/image/exr.h"
#include "core/image/image.h"
#include "core/io/error.h"
#include "core/io/inflate.h"
#include "scene/formats/nanovdb.h"
#include "scene/formats/openvdb.h"
#include "tests/support/files/rising_triangle.h"
#include "tests/support/program_testing.h"
#include "tools/farm/frame_names.h"

#include <doctest/doctest.h>

#include <sys/wait.h>

#include <cstdlib>

namespace sheaf::test_cli_frames {

namespace {

namespace fs = std::filesystem;

/// The mesh stands still, `frame` moves one of `camera`, `sphere` and the reflectance `gray`.
std::string scene_with(const std::string& camera, const std::string& sphere, const std::string& gray) {
  return R"(<scene version="3.0.0">
  <default name="frame" value="0"/> <default name="size" value="24"/>
  <integrator type="path"/>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin=")" +
         camera + R"(, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="$size"/><integer name="height" value="16"/></film>
    <sampler type="independent"><integer name="sample_count" value="8"/></sampler>
  </sensor>
  <shape type="obj">
    <string name="filename" value="mesh.obj"/>
    <bsdf type="diffuse"><texture name="reflectance" type="bitmap"><string name="filename" value="image.png"/></texture></bsdf>
  </shape>
  <shape type="sphere">
    <transform name="to_world"><scale value="0.5"/><translate x=")" +
         sphere + R"("/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value=")" +
         gray + R"("/></bsdf>
  </shape>
  <emitter type="constant"/>
</scene>)";
}

void write_mesh(const fs::path& file, const char* top) {
  write_bytes(file, std::string("v -1 -1 0\nv 1 -1 0\nv 0 ") + top + " 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
}

/// A folder with scenes whose camera, sphere or reflectance moves, and their files.
struct FrameFolder {
  FrameFolder() {
    write_bytes(folder / "camera.xml", scene_with("$(frame - 4)", "1", "0.5"));
    write_bytes(folder / "sphere.xml", scene_with("0", "$(sin(frame * pi / 8))", "0.5"));
    write_bytes(folder / "grey.xml", scene_with("0", "1", "$(frame / 10)"));
    write_mesh(folder / "mesh.obj", "1");
    write_bytes(folder / "image.png", read_bytes(SHEAF_SOURCE_DIR "/scenes/textures/images/quilt.png"));
  }
  Outcome sheaf(const std::string& arguments) const { return run(folder, arguments); }
  std::string bytes(const std::string& name) const { return read_bytes(folder / name); }
  bool has(const std::string& name) const { return fs::exists(folder / name); }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("frames: ranges") {
  CHECK(parse_frames("3:5").frames() == std::vector<int>{3, 4, 5});
  CHECK(parse_frames("0:0").frames() == std::vector<int>{0});
  CHECK(parse_frames("1:8:3").frames() == std::vector<int>{1, 4, 7});
  CHECK(parse_frames("9999998:9999999:9999999").frames() == std::vector<int>{9999998});
  for (const char* text : {"", "1", "1:", ":1", "5:1", "-1:2", "1:2:0", "1:2:-1", "1:2:", "1:2:3:4", "a:b", "1:2x",
                           "1:99999999", "1:2:99999999", "1:99999999999"}) {
    CAPTURE(std::string(text));
    CHECK_THROWS_AS(parse_frames(text), Error);
  }
}

TEST_CASE("frames: file names") {
  const auto name = [](const char* pattern) { return frame_name(pattern).at(37); };
  CHECK(name("a_####.exr") == "a_0037.exr");
  CHECK(name("a_$frame4.exr") == "a_0037.exr");
  CHECK(name("a$frame.exr") == "a37.exr");
  CHECK(name("$frame1.png") == "37.png");
  CHECK(name("$frame6_$frame/####.png") == "000037_37/0037.png");
  CHECK(name("$frame0.png") == "370.png");
  CHECK(name("folder.d/a.png") == "folder.d/a_0037.png");
  CHECK(name("folder.d/a") == "folder.d/a_0037");
  CHECK(name("a#$.png") == "a#$_0037.png");
  CHECK(frame_name("####").at(123456) == "123456");
}

TEST_CASE("frames: files are those of single renders") {
  const FrameFolder frames;
  for (const std::string moving : {"camera", "sphere", "grey"}) {
    CAPTURE(moving);
    const std::string scene = "render " + moving + ".xml --no-timestamps --spp 4 --aov albedo ";
    const Outcome made = frames.sheaf(scene + "--frames 2:8:3 -o '" + moving + "_$frame4.exr' -o " + moving + ".png");
    INFO(made.err);
    REQUIRE(made.code == 0);
    CHECK(contains(made.err, "frame 2 (1 of 3): rendered 24x16, 4 spp in "));
    CHECK(contains(made.err, "; wrote " + moving + "_0008.exr, " + moving + "_0008.png\n"));
    CHECK(contains(made.err, "sheaf: rendered 3 frames in "));
    for (const std::string frame : {"2", "5", "8"}) {
      REQUIRE(frames.sheaf(scene + "--quiet -D frame=" + frame + " -o one.exr -o one.png").code == 0);
      CHECK(frames.bytes(moving + "_000" + frame + ".exr") == frames.bytes("one.exr"));
      CHECK(frames.bytes(moving + "_000" + frame + ".png") == frames.bytes("one.png"));
    }
    CHECK(frames.bytes(moving + "_0002.exr") != frames.bytes(moving + "_0005.exr"));
  }
}

TEST_CASE("frames: a mesh that changes between frames is read again") {
  const FrameFolder frames;
  // A numbered mesh per frame
  write_mesh(frames.folder / "mesh_1.obj", "1");
  write_mesh(frames.folder / "mesh_2.obj", "0.5");
  std::string text = frames.bytes("grey.xml");
  text.replace(text.find("mesh.obj"), 8, "mesh_$frame.obj");
  write_bytes(frames.folder / "grey.xml", text);
  REQUIRE(frames.sheaf("render grey.xml --quiet --no-timestamps --frames 1:2 -o 'a$frame.exr'").code == 0);
  REQUIRE(frames.sheaf("render grey.xml --quiet --no-timestamps -D frame=2 -o one.exr").code == 0);
  CHECK(frames.bytes("a2.exr") == frames.bytes("one.exr"));
}

namespace {

/// A grid in a sphere; `$kind` is the extension of its files.
constexpr char kSmoke[] = R"(<scene version="3.0.0">
  <default name="frame" value="0"/> <default name="kind" value="vdb"/>
  <integrator type="volpath"/>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="30, 20, 60" target="4, 4, 2" up="0, 1, 0"/></transform>
    <float name="fov" value="15"/>
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film>
    <sampler type="independent"><integer name="sample_count" value="8"/></sampler>
  </sensor>
  <medium type="heterogeneous" id="smoke">
    <volume type="gridvolume" name="sigma_t">
      <string name="filename" value="smoke_$frame4.$kind"/> <string name="grid_name" value="density"/>
    </volume>
    <volume type="gridvolume" name="albedo">
      <string name="filename" value="smoke_$frame4.$kind"/> <string name="grid_name" value="heat"/>
    </volume>
  </medium>
  <shape type="sphere">
    <float name="radius" value="20"/> <bsdf type="null"/> <ref name="interior" id="smoke"/>
  </shape>
  <emitter type="constant"/>
</scene>)";

}  // namespace

TEST_CASE("frames: volumes of numbered files, in OpenVDB and NanoVDB files, give the same images") {
  const TemporaryFolder folder;
  write_bytes(folder / "smoke.xml", kSmoke);
  for (const int frame : {8, 9}) {
    const std::string name = folder / fmt::format("smoke_{:04}", frame);
    const std::string stored = read_bytes(
        fmt::format("{}/tests/scene/formats/vdb/small_{}.vdb.gz", SHEAF_SOURCE_DIR, frame == 8 ? "zip" : "blosc"));
    std::string bytes(std::size_t{1} << 20, '\0');
    bytes.resize(Inflater(stored).read(bytes));
    write_bytes(name + ".vdb", bytes);
    const SparseVolume density = read_openvdb(name + ".vdb", "density"), heat = read_openvdb(name + ".vdb", "heat");
    const NanoVdbGrid grids[] = {{"density", &density.voxels, density.grid_to_local},
                                 {"heat", &heat.voxels, heat.grid_to_local}};
    write_nanovdb(name + ".nvdb", grids);
  }
  for (const std::string kind : {"vdb", "nvdb"}) {
    const Outcome made =
        run(folder, "render smoke.xml --quiet --frames 8:9 -D kind=" + kind + " -o '" + kind + "_$frame4.exr'");
    INFO(made.err);
    REQUIRE(made.code == 0);
  }
  for (const char* const frame : {"0008", "0009"}) {
    const Image a = read_exr(folder / fmt::format("vdb_{}.exr", frame)),
                b = read_exr(folder / fmt::format("nvdb_{}.exr", frame));
    CHECK(a.data == b.data);
  }
  CHECK(read_exr(folder / "vdb_0008.exr").data != read_exr(folder / "vdb_0009.exr").data);
  const Outcome missing = run(folder, "render smoke.xml --quiet --frames 10:10 -o a.exr");
  CHECK(missing.code == 3);
  CHECK(contains(missing.err, "smoke_0010.vdb"));
}

TEST_CASE("frames: parts and checkpoints are those of single renders") {
  const FrameFolder frames;
  const std::string scene = "render camera.xml --quiet --no-timestamps --spp 8 ";
  // A part names its settings in the header
  for (const std::string other : {"", "-D size=16 "}) {
    REQUIRE(frames.sheaf(scene + other + "--samples 0:4 --frames 3:3 -o a.exr").code == 0);
    REQUIRE(frames.sheaf(scene + other + "--samples 0:4 -D frame=3 -o one.exr").code == 0);
    CHECK(frames.bytes("a_0003.exr") == frames.bytes("one.exr"));
  }
  // A checkpoint per frame
  REQUIRE(frames.sheaf(scene + "--frames 3:4 --checkpoint c.state -o b.exr --stats s.json").code == 0);
  for (const char* name : {"c_0003.state", "c_0004.state", "s_0003.json", "s_0004.json"}) CHECK(frames.has(name));
  const Outcome again = frames.sheaf(scene + "--frames 3:4 --checkpoint c.state -o b.exr");
  CHECK(again.code == 2);
  CHECK(contains(again.err, "the checkpoint 'c_0003.state' already exists"));
  const std::string before = frames.bytes("b_0004.exr");
  REQUIRE(frames.sheaf(scene + "--frames 3:4 --checkpoint c.state --resume -o b.exr").code == 0);
  CHECK(frames.bytes("b_0004.exr") == before);
  CHECK(frames.sheaf(scene + "-D frame=3 --checkpoint c_0003.state --resume -o one.exr").code == 0);
}

TEST_CASE("frames: existing images are overwritten or skipped") {
  const FrameFolder frames;
  const std::string scene = "render camera.xml --spp 1 --frames 1:3 -o a.exr -o a.png ";
  REQUIRE(frames.sheaf(scene + "--quiet").code == 0);
  write_bytes(frames.folder / "a_0001.png", "text");
  write_bytes(frames.folder / "a_0002.png", "zTXt the render was interrupted after 3 samples");
  fs::remove(frames.folder / "a_0003.exr");
  const Outcome made = frames.sheaf(scene + "--skip-existing");
  CHECK(made.code == 0);
  CHECK(frames.bytes("a_0001.png") == "text");
  CHECK(frames.bytes("a_0002.png").size() > 100);
  CHECK(frames.has("a_0003.exr"));
  CHECK(contains(made.err, "frame 2 (1 of 2)"));
  CHECK(contains(made.err, "rendered 2 frames in "));
  CHECK(contains(made.err, "; skipped 1 frame with images"));
  REQUIRE(frames.sheaf(scene + "--quiet").code == 0);
  CHECK(frames.bytes("a_0001.png") != "text");
}

TEST_CASE("frames: an interruption marks the current frame and ends the run") {
  const FrameFolder frames;
  write_bytes(frames.folder / "go.sh", "(sleep 2; kill -INT $$) & exec " SHEAF_EXECUTABLE
                                       " render camera.xml --frames 1:3 -o a.exr --spp 16000000 -D size=512\n");
  const int status = std::system(("cd '" + frames.folder.path().string() + "' && bash go.sh >log.txt 2>&1").c_str());
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 130);
  CHECK(contains(frames.bytes("log.txt"), "frame 1 (1 of 3): interrupted"));
  CHECK(contains(frames.bytes("log.txt"), "rendered 0 frames of 3"));
  CHECK(contains(frames.bytes("a_0001.exr"), "sheaf/interrupted"));
  CHECK_FALSE(frames.has("a_0002.exr"));
  // The interrupted frame is not skipped
  REQUIRE(frames.sheaf("render camera.xml --quiet --frames 1:1 -o a.exr --spp 1 --skip-existing").code == 0);
  CHECK_FALSE(contains(frames.bytes("a_0001.exr"), "sheaf/interrupted"));
}

TEST_CASE("frames: errors come before any work or name their cause") {
  const FrameFolder frames;
  const auto error = [&](const std::string& options, int code) {
    CAPTURE(options);
    const Outcome made = frames.sheaf("render " + options);
    CHECK(made.code == code);
    return made.err;
  };
  CHECK(contains(error("camera.xml --frames 1", 2), "expected FIRST:LAST or FIRST:LAST:STEP"));
  CHECK(contains(error("camera.xml --frames 1:2 -D frame=3", 2), "-D frame=3 and --frames exclude each other"));
  CHECK(contains(error("camera.xml --frames 1:2 --serve 0", 2), "--serve shows a single render"));
  CHECK(contains(error("camera.xml --skip-existing", 2), "--skip-existing needs --frames"));
  CHECK(contains(error("camera.xml --frames 1:2 -o -", 2), "-o - writes a single image"));
  CHECK(contains(error("camera.xml --frames 1:2 -o none/a.exr", 4), "none"));
  CHECK(contains(error("camera.xml --frames 1000:1000 -o 'a$frame.png' -o 'a####.png'", 2), "would overwrite"));
  CHECK(contains(error("mesh.obj --frames 1:2", 2), "not to models"));
  CHECK_FALSE(frames.has("camera_0001.exr"));
  // An error in a later frame
  write_bytes(frames.folder / "late.xml", scene_with("$(1 / (3 - frame))", "1", "0.5"));
  const std::string late = error("late.xml --frames 2:4 --spp 1", 3);
  CHECK(contains(late, "column"));
  CHECK(contains(late, "division by zero"));
  CHECK(contains(late, "rendered 1 frame of 3"));
  CHECK(frames.has("late_0002.exr"));
  // A scene without the parameter
  write_bytes(frames.folder / "still.xml", "<scene version='3.0.0'><sensor type='perspective'/></scene>");
  CHECK(contains(error("still.xml --frames 1:2", 3), "the scene has no parameter 'frame' for -D or --frames to set"));
}

TEST_CASE("frames: a glTF file is rendered at the time of each frame") {
  const FrameFolder f;
  write_bytes(f.folder / "model.glb", test::rising_triangle().binary());
  const std::string quick = "render model.glb --size 24x16 --spp 4 --no-timestamps -q ";
  REQUIRE(f.sheaf(quick + "--frames 0:1 --fps 2 -o f####.png").code == 0);
  REQUIRE(f.sheaf(quick + "--time 0.5 -o half.png").code == 0);
  CHECK(f.bytes("f0001.png") == f.bytes("half.png"));
  CHECK(f.bytes("f0000.png") != f.bytes("half.png"));
  CHECK(contains(f.sheaf(quick + "--frames 0:1 --time 1 -o f.png").err, "exclude each other"));
  // The shutter is relative to the time of the frame
  REQUIRE(f.sheaf(quick + "--frames 0:1 --fps 2 --shutter 0.5:0.5 -o g####.png").code == 0);
  REQUIRE(f.sheaf(quick + "--time 1 -o end.png").code == 0);
  CHECK(f.bytes("g0000.png") == f.bytes("half.png"));
  CHECK(f.bytes("g0001.png") == f.bytes("end.png"));
  CHECK(contains(f.sheaf(quick + "--shutter 0:1 -o g.png").err, "--shutter requires --time or --frames"));
}

}  // namespace sheaf::test_cli_frames
