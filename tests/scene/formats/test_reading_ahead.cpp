// Meshes and images read by all threads: the tables, the warnings and the error are those of one thread.
#include "scene/compile/compile.h"
#include "tests/support/files/image_files.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <fstream>

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

/// The messages of the errors of strict compilation, in order.
std::vector<std::string> errors_with(int threads, const Description& description) {
  std::vector<std::string> messages;
  try {
    compile_with(threads, description);
  } catch (const SceneErrors& errors) {
    for (const SceneError& error : errors.all()) messages.emplace_back(error.what());
  }
  return messages;
}

/// Bytes that the process has read from files so far.
double bytes_read() {
  std::ifstream counters("/proc/self/io");
  std::string name;
  double bytes = 0;
  while (counters >> name >> bytes && name != "rchar:") {}
  return bytes;
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
    for (int image = 0; image < 8; ++image)
      CHECK(same_bytes(view.textures.images[image].tiles, expected.textures.images[image].tiles, 1));
  }
}

TEST_CASE("reading ahead: errors are reported in the order of the scene") {
  const TemporaryFolder folder;
  const Description description = read_scene(write_scene(folder));
  // Broken later files are read first if earlier ones take longer.
  write_bytes(folder / name_of(20), "v 1 2\n" + std::string(4'000'000, '\n'));
  std::string late = std::string(4'000'000, '\n') + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n";
  write_bytes(folder / name_of(12), late);
  write_bytes(folder / name_of(13), "not a ply file");
  const std::vector<std::string> expected = errors_with(1, description);
  REQUIRE(expected.size() == 3);
  CHECK(contains(expected[0], "mesh12.obj:4000004: expected a face corner"));
  CHECK(contains(expected[1], name_of(13)));
  CHECK(contains(expected[2], name_of(20)));
  for (int repetition = 0; repetition < 5; ++repetition) CHECK(errors_with(8, description) == expected);
  // Textures come before shapes.
  write_bytes(folder / "image6.ppm", "broken");
  const std::vector<std::string> all = errors_with(1, description);
  REQUIRE(all.size() == 4);
  CHECK(contains(all[0], "image6.ppm"));
  CHECK(std::equal(all.begin() + 1, all.end(), expected.begin()));
  for (int repetition = 0; repetition < 5; ++repetition) CHECK(errors_with(8, description) == all);
}

TEST_CASE("reading ahead: lenient compilation leaves out the same shapes") {
  const TemporaryFolder folder;
  const Description description = read_scene(write_scene(folder));
  for (const int i : {3, 31, 32}) write_bytes(folder / name_of(i), "broken");
  const auto leniently = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    std::vector<std::string> substitutions;
    ErrorSink errors(true, substitutions);
    CompileOptions options;
    options.errors = &errors;
    tbb::task_arena(threads).execute([&] { CHECK(compile_scene(description, options)->info().shapes == kMeshes - 3); });
    return substitutions;
  };
  const std::vector<std::string> alone = leniently(1);
  REQUIRE(alone.size() == 3);
  CHECK(contains(alone[0], name_of(3)));
  CHECK(leniently(8) == alone);
}

TEST_CASE("reading ahead: a scene with many broken elements is compiled once") {
  constexpr std::size_t kBroken = 50;
  const TemporaryFolder folder;
  const std::string large = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + std::string(1'000'000, '\n');
  write_bytes(folder / "large.obj", large);
  std::string inside = "<shape type='obj'><string name='filename' value='large.obj'/></shape>\n";
  for (std::size_t i = 0; i < kBroken; ++i) {
    const std::string name = "broken" + std::to_string(i) + (i % 2 == 0 ? ".obj" : ".png");
    write_bytes(folder / name, i % 2 == 0 ? "v 1 2\n" : "no image");
    const std::string file = "<string name='filename' value='" + name + "'/>";
    inside += i % 2 == 0 ? "<shape type='obj'>" + file + "</shape>\n"
                         : "<shape type='cube'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'>" + file +
                               "</texture></bsdf></shape>\n";
  }
  const Description description = read_scene(write_below(folder, "scene.xml", mitsuba_scene(inside)));
  std::vector<std::string> substitutions;
  ErrorSink errors(true, substitutions);
  CompileOptions options;
  options.errors = &errors;
  const double before = bytes_read();
  CHECK(compile_scene(description, options)->info().shapes == 1 + kBroken / 2);
  CHECK(bytes_read() - before < 2.5 * static_cast<double>(large.size()));
  REQUIRE(errors.errors().size() == kBroken);
  // Textures come before shapes
  for (std::size_t i = 0; i < kBroken; ++i) {
    const std::size_t element = i < kBroken / 2 ? 2 * i + 1 : 2 * (i - kBroken / 2);
    CHECK(errors.errors()[i].where().line == static_cast<int>(element) + 5);
  }
  // In strict mode, the first 20 are reported
  CHECK(errors_with(8, description).size() == ErrorSink::kMaxErrors);
}

}  // namespace sheaf::test_reading_ahead
