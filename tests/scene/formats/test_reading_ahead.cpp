// Meshes and images read by all threads: the tables, the warnings and the error are those of one thread.
#include "scene/compile/compile.h"
#include "tests/support/files/image_files.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstring>

namespace sheaf::test_reading_ahead {

using namespace test;

namespace {

constexpr int kMeshes = 60;

std::string name_of(int i) { return "mesh" + std::to_string(i) + (i % 2 == 0 ? ".obj" : ".ply"); }

/// A fan of `i` + 3 triangles; one of every third file is degenerate.
std::string mesh_text(int i) {
  const int count = i + 3;
  const auto coordinate = [&](int k) {
    return std::to_string(k % 7) + "." + std::to_string(k) + " " + std::to_string(k * k % 11) + " " +
           std::to_string(i) + "\n";
  };
  std::string text;
  if (i % 2 == 1)
    text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count + 2) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(count) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int k = 0; k < count + 2; ++k) text += (i % 2 == 0 ? "v " : "") + coordinate(k);
  for (int k = 0; k < count; ++k) {
    const int first = i % 2 == 0 ? 1 : 0, last = i % 3 == 0 && k == 1 ? 0 : k + 2;
    text += (i % 2 == 0 ? "f " : "3 ") + std::to_string(first) + " " + std::to_string(k + 1 + first) + " " +
            std::to_string(last + first) + "\n";
  }
  return text;
}

/// A scene of meshes, with every tenth one in a group, and textures.
std::filesystem::path write_scene(const TemporaryFolder& folder) {
  std::string inside;
  for (int i = 0; i < 8; ++i) {
    write_bytes(folder / ("image" + std::to_string(i) + ".ppm"),
                "P6\n2 2\n255\n" + std::string(12, static_cast<char>(20 * i + 1)));
    inside += "<bsdf type='diffuse' id='b" + std::to_string(i) +
              "'><texture type='bitmap' name='reflectance'><string name='filename' value='image" + std::to_string(i) +
              ".ppm'/></texture></bsdf>\n";
  }
  for (int i = 0; i < kMeshes; ++i) {
    write_bytes(folder / name_of(i), mesh_text(i));
    const std::string shape = std::string("<shape type='") + (i % 2 == 0 ? "obj" : "ply") +
                              "'><string name='filename' value='" + name_of(i) + "'/><ref id='b" +
                              std::to_string(i % 8) + "'/></shape>\n";
    inside += i % 10 == 5 ? "<shape type='shapegroup' id='g" + std::to_string(i) + "'>" + shape +
                                "</shape><shape type='instance'><ref id='g" + std::to_string(i) + "'/></shape>\n"
                          : shape;
  }
  return write_below(folder, "scene.xml", mitsuba_scene(inside));
}

/// Compiles with this many threads of oneTBB.
std::unique_ptr<Scene> compile_with(int threads, const Description& description) {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  std::unique_ptr<Scene> scene;
  tbb::task_arena(threads).execute([&] { scene = compile_scene(description); });
  return scene;
}

std::string error_with(int threads, const Description& description) {
  try {
    compile_with(threads, description);
  } catch (const SceneError& error) { return error.what(); }
  return {};
}

template <class Row> bool same_bytes(const Row* a, const Row* b, std::size_t count) {
  return std::memcmp(static_cast<const void*>(a), static_cast<const void*>(b), count * sizeof(Row)) == 0;
}

}  // namespace

TEST_CASE("reading ahead: tables and warnings do not depend on the number of threads") {
  const TemporaryFolder folder;
  const Description description = read_scene(write_scene(folder));
  const auto alone = compile_with(1, description);
  const SceneInfo info = alone->info();
  CHECK(info.shapes == kMeshes);
  CHECK(alone->warnings().size() == kMeshes / 3);
  const SceneView& expected = alone->view();
  for (int repetition = 0; repetition < 10; ++repetition) {
    const auto scene = compile_with(8, description);
    const SceneView& view = scene->view();
    CHECK(scene->warnings() == alone->warnings());
    REQUIRE(scene->info().vertices == info.vertices);
    REQUIRE(scene->info().triangles == info.triangles);
    CHECK(same_bytes(view.geometry.vertices, expected.geometry.vertices, info.vertices));
    CHECK(same_bytes(view.geometry.triangles, expected.geometry.triangles, 3 * info.triangles));
    CHECK(same_bytes(view.geometry.shapes, expected.geometry.shapes, info.shapes));
    CHECK(same_bytes(view.textures.tiles, expected.textures.tiles, 8));
  }
}

TEST_CASE("reading ahead: the first error in the order of the scene counts") {
  const TemporaryFolder folder;
  const Description description = read_scene(write_scene(folder));
  // Broken later files are read first if earlier ones take longer.
  write_bytes(folder / name_of(20), "v 1 2\n" + std::string(4'000'000, '\n'));
  std::string late = std::string(4'000'000, '\n') + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n";
  write_bytes(folder / name_of(12), late);
  write_bytes(folder / name_of(13), "not a ply file");
  const std::string expected = error_with(1, description);
  CHECK(contains(expected, "mesh12.obj:4000004: expected a face corner"));
  for (int repetition = 0; repetition < 5; ++repetition) CHECK(error_with(8, description) == expected);
  // Textures come before shapes.
  write_bytes(folder / "image6.ppm", "broken");
  const std::string image = error_with(1, description);
  CHECK(contains(image, "image6.ppm"));
  for (int repetition = 0; repetition < 5; ++repetition) CHECK(error_with(8, description) == image);
}

TEST_CASE("reading ahead: lenient compilation leaves out the same shapes") {
  const TemporaryFolder folder;
  const Description description = read_scene(write_scene(folder));
  for (const int i : {3, 31, 32}) write_bytes(folder / name_of(i), "broken");
  const auto leniently = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    Description d = description;
    tbb::task_arena(threads).execute([&] { CHECK(compile_leniently(d)->info().shapes == kMeshes - 3); });
    return d.stand_ins;
  };
  const std::vector<std::string> alone = leniently(1);
  REQUIRE(alone.size() == 3);
  CHECK(contains(alone[0], name_of(3)));
  CHECK(leniently(8) == alone);
}

}  // namespace sheaf::test_reading_ahead
