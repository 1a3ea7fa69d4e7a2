// Memory on the command line: the estimate of `info`, the peak of a render, and out-of-memory errors.
#include "core/image/exr.h"
#include "core/sampling/rng.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

#include <sys/resource.h>

#include <algorithm>
#include <regex>

namespace sheaf::test_cli_memory {

namespace {

std::string scene(int width, int height, const std::string& inside = "<emitter type='constant'/>") {
  return "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><film type='hdrfilm'>"
         "<integer name='width' value='" +
         std::to_string(width) + "'/><integer name='height' value='" + std::to_string(height) +
         "'/></film><sampler type='independent'><integer name='sample_count' value='1'/>"
         "</sampler></sensor>\n<shape type='sphere'/>\n" +
         inside + "</scene>";
}

std::string envmap(const char* file) {
  return "<emitter type='envmap'><string name='filename' value='" + std::string(file) + "'/></emitter>";
}

void write_map(const std::filesystem::path& file, int width, int height) {
  Image map(width, height, {"B", "G", "R"});
  for (std::size_t i = 0; i < map.data.size(); ++i)
    map.data[i] = random4<Scalar>(3, static_cast<std::uint32_t>(i / 1024), 0, 0).x;
  write_exr(file, map);
}

/// A bumpy square of 2 x side^2 triangles.
void write_mesh(const std::filesystem::path& file, int side) {
  std::string mesh;
  for (int i = 0; i <= side; ++i)
    for (int k = 0; k <= side; ++k)
      mesh += "v " + std::to_string(i * 2.0 / side - 1) + " " + std::to_string(k * 2.0 / side - 1) + " " +
              std::to_string(3 + 0.1 * ((i * k) % 7)) + "\n";
  for (int i = 0; i < side; ++i)
    for (int k = 1; k <= side; ++k) {
      const int a = i * (side + 1) + k, b = a + side + 1;
      for (const int corner : {a, a + 1, b}) mesh += (corner == a ? "f " : " ") + std::to_string(corner);
      for (const int corner : {a + 1, b + 1, b}) mesh += (corner == a + 1 ? "\nf " : " ") + std::to_string(corner);
      mesh += "\n";
    }
  write_bytes(file, mesh);
}

/// Bytes of the number and unit in the first match.
double bytes_in(const std::string& text, const char* pattern) {
  std::smatch match;
  if (!std::regex_search(text, match, std::regex(std::string("([0-9.]+) (MB|GB)") + pattern))) return 0;
  return std::stod(match[1]) * (match[2] == "GB" ? 1e9 : 1e6);
}

/// The highest peak that `info` estimates over the peak of `render`.
double expected_over_real(const TemporaryFolder& folder) {
  const Outcome info = run(folder, "info scene.xml");
  CAPTURE(info.out);
  const double loading = bytes_in(info.out, " while loading"), rendering = bytes_in(info.out, " while rendering");
  CHECK(loading > 0);
  CHECK(rendering > 0);
  REQUIRE(run(folder, "render scene.xml -o out.exr --stats stats.json --quiet").code == 0);
  std::smatch peak;
  const std::string stats = read_bytes(folder / "stats.json");
  REQUIRE(std::regex_search(stats, peak, std::regex("\"peak_rss_bytes\": ([0-9]+)")));
  return std::max(loading, rendering) / std::stod(peak[1]);
}

}  // namespace

TEST_CASE("memory: info predicts the memory of a large environment map") {
  const TemporaryFolder folder;
  constexpr int kWidth = 4096, kHeight = 2048;
  write_map(folder / "sky.exr", kWidth, kHeight);
  write_bytes(folder / "scene.xml", scene(64, 48, envmap("sky.exr")));
  const double ratio = expected_over_real(folder);
  CHECK(ratio > 0.8);
  CHECK(ratio < 1.2);
  const std::string info = run(folder, "info scene.xml").out;
  CHECK(contains(info, "environment 4096 x 2048 pixels, 13"));
  // The image (12 bytes per pixel) is freed while the tables (16, and those of rows and columns) are built.
  write_map(folder / "dot.exr", 4, 2);
  write_bytes(folder / "scene.xml", scene(64, 48, envmap("dot.exr")));
  const double with = bytes_in(info, " while loading"),
               without = bytes_in(run(folder, "info scene.xml").out, " while loading");
  CHECK(with - without > 0.9 * 16 * kWidth * kHeight);
  CHECK(with - without < 1.4 * 16 * kWidth * kHeight);
}

TEST_CASE("memory: info predicts the memory of a large film") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", scene(2400, 1600));
  const double ratio = expected_over_real(folder);
  CHECK(ratio > 0.8);
  CHECK(ratio < 1.2);
}

TEST_CASE("memory: info lists the memory of grids") {
  const TemporaryFolder folder;
  const auto word = [](auto value) { return std::string(reinterpret_cast<const char*>(&value), 4); };
  std::string vol = "VOL\x03";
  for (const int number : {1, 3, 2, 5, 1}) vol += word(number);
  for (const float bound : {0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f}) vol += word(bound);
  for (int i = 0; i < 30; ++i) vol += word(0.5f);
  write_bytes(folder / "smoke.vol", vol);
  const std::string grid = "type='gridvolume'><string name='filename' value='smoke.vol'/>";
  write_bytes(folder / "scene.xml",
              scene(4, 4,
                    "<medium id='m' type='heterogeneous'><volume name='sigma_t' " + grid +
                        "<transform name='to_world'><scale x='2' y='3' z='4'/><translate x='10'/></transform>"
                        "</volume></medium><shape type='cube'><ref name='interior' id='m'/></shape>"
                        "<shape type='sphere'><bsdf type='diffuse'><texture name='reflectance' type='volume'>"
                        "<volume name='volume' " +
                        grid + "</volume></texture></bsdf></shape>"));
  const std::string info = run(folder, "info scene.xml").out;
  CAPTURE(info);
  CHECK(contains(info, "grid        smoke.vol: (10, 0, 0) to (12, 3, 4), 3 x 2 x 5 voxels, "));
  CHECK(contains(info, "grid        smoke.vol: (0, 0, 0) to (1, 1, 1), 3 x 2 x 5 voxels, "));
  CHECK_FALSE(contains(info, "environment "));
}

TEST_CASE("memory: -v lists the times of loading and the memory by cause, and --bvh keeps the image") {
  const TemporaryFolder folder;
  write_mesh(folder / "mesh.obj", 60);
  write_bytes(folder / "scene.xml",
              scene(64, 48,
                    "<emitter type='constant'/><shape type='obj'><string name='filename' value='mesh.obj'/>"
                    "</shape>"));
  const auto render = [&](const std::string& options) {
    const Outcome outcome = run(folder, "render scene.xml -v --no-timestamps -o out.exr --stats s.json " + options);
    REQUIRE(outcome.code == 0);
    return std::pair(outcome.err, read_bytes(folder / "out.exr"));
  };
  const auto [fast, fast_image] = render("--bvh fast");
  CAPTURE_BINDING(fast);
  CHECK(std::regex_search(fast, std::regex("loading: reading .*, textures .*, compiling .*, BVH .*\n")));
  CHECK(contains(fast, "memory (BVH: fast)"));
  CHECK(contains(fast, "bytes/triangle"));
  CHECK(std::regex_search(fast, std::regex("BVH +[0-9.]+ MB +[0-9.]+\n")));
  CHECK(std::regex_search(fast, std::regex("rays +[0-9.]+ MB")));
  CHECK(contains(read_bytes(folder / "s.json"), "\"triangles\": 7200"));
  const auto [compact, compact_image] = render("--bvh compact");
  CHECK(contains(compact, "memory (BVH: compact)"));
  CHECK(compact_image == fast_image);
  CHECK(contains(render("").first, "memory (BVH: fast)"));
  // 1 sample for each of 64 x 48 pixels with at most 9 rays
  CHECK(contains(render("").first, " (with spatial splits, at most 3.8 rays per triangle)\n"));
  CHECK(contains(render("--crop 0,0,1,1").first, " (with spatial splits, at most 3.8 rays per triangle)\n"));
  CHECK(contains(render("--spp 32").first, " (with spatial splits)\n"));
  CHECK(run(folder, "render scene.xml --bvh small").code == 2);
}

TEST_CASE("memory: info predicts the BVH of a short render") {
  const TemporaryFolder folder;
  write_mesh(folder / "mesh.obj", 80);
  const std::string mesh =
      "<emitter type='constant'/><shape type='obj'><string name='filename' value='mesh.obj'/></shape>";
  const auto accel_bytes = [&](int width) {
    write_bytes(folder / "scene.xml", scene(width, width, mesh));
    const Outcome info = run(folder, "info scene.xml");
    CAPTURE(info.out);
    const Outcome render = run(folder, "render scene.xml -v -o out.exr");
    REQUIRE(render.code == 0);
    std::smatch built;
    REQUIRE(std::regex_search(render.err, built, std::regex("BVH +([0-9.]+) (MB)")));
    const double expected = bytes_in(info.out, " of acceleration structure"), real = 1e6 * std::stod(built[1]);
    CHECK(expected == near(real, 0.02));
    return expected;
  };
  // Fewer rays than triangles, for a compact layout built along a Morton curve: 52 instead of 60 bytes per triangle
  CHECK(accel_bytes(16) < 0.9 * accel_bytes(128));
}

TEST_CASE("memory: renders beyond the available memory have exit code 1 and leave no files") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", scene(24, 16));
  const std::string whole = "render scene.xml --quiet -o out.exr --size 46000x46000";
  const Outcome film = run(folder, whole);
  CHECK(film.code == 1);
  CHECK(contains(film.err, "not enough memory for an image of 46000 x 46000 pixels: it takes "));
  CHECK(contains(film.err, " GB for the film, "));
  CHECK(contains(film.err, "--crop"));
  CHECK(folder.entry_count() == 1);
  // A crop at the far corner fits. Larger frames have no pixel indices.
  CHECK(run(folder, whole + " --crop 45984,45984,46000,46000").code == 0);
  std::filesystem::remove(folder / "out.exr");
  const Outcome frame = run(folder, "render scene.xml --quiet -o out.exr --size 200000x200000 --crop 0,0,16,16");
  CHECK(frame.code == 2);
  CHECK(contains(frame.err, "a frame of 200000 x 200000 pixels is too large"));
  // A scene that cannot be rendered can be inspected.
  std::string text = scene(24, 16);
  text.replace(text.find("sample_count' value='1'"), 23, "sample_count' value='1024'");
  text.replace(text.find("<integrator type='path'/>"), 25,
               "<integrator type='photonmapper'><boolean name='final_gather' value='true'/>"
               "<integer name='num_gather_rays' value='65536'/></integrator>");
  write_bytes(folder / "scene.xml", text);
  CHECK(run(folder, "render scene.xml --quiet -o out.exr").code == 2);
  const Outcome info = run(folder, "info scene.xml");
  CHECK(info.code == 0);
  CHECK(contains(info.out, "while loading; the scene cannot be rendered: samples per pixel"));
  CHECK(folder.entry_count() == 1);
}

TEST_CASE("memory: an address space limit is reported when memory runs out") {
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  const TemporaryFolder folder;
  write_map(folder / "sky.exr", 4096, 2048);
  write_bytes(folder / "scene.xml", scene(24, 16, envmap("sky.exr")));
  write_bytes(folder / "image.xml",
              scene(24, 16,
                    "<shape type='sphere'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>"
                    "<string name='filename' value='sky.exr'/></texture></bsdf></shape>"));
  write_bytes(folder / "small.xml", scene(24, 16));
  // The address space of libraries depends on the system: the smallest limit under which a small scene renders.
  const auto limited = [](int megabytes) { return "ulimit -v " + std::to_string(megabytes * 1024) + "; "; };
  int megabytes = 60;
  bool told = false;
  for (; megabytes < 8000; megabytes += 20) {
    const Outcome outcome = run(folder, "render small.xml --quiet -o out.exr", limited(megabytes));
    told = told || contains(outcome.err, "not enough memory for building the acceleration structure");
    if (outcome.code == 0) break;
  }
  CHECK(told);
  if (megabytes >= 8000) {
    MESSAGE("skipped: no render succeeds under an address space limit");
    return;
  }
  for (const char* name : {"scene.xml", "image.xml"}) {
    CAPTURE(std::string(name));
    const Outcome outcome = run(folder, "render " + std::string(name) + " --quiet -o big.exr", limited(megabytes));
    CAPTURE(outcome.err);
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.err, "sky.exr"));
    CHECK(contains(outcome.err, "not enough memory for "));
    CHECK_FALSE(std::filesystem::exists(folder / "big.exr"));
  }
  CHECK(folder.entry_count() == 5);
}

}  // namespace sheaf::test_cli_memory
