// Identical bits for any number of threads, wave size and crop, and identical files at any time of writing.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <fcntl.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

namespace sheaf::test_determinism {

namespace {

/// All closures, kinds of light and kinds of shape in a room with one open side.
Description room(int width, int height) {
  Description d = empty_scene(width, height);
  look_at(d, {0.1f, 0.2f, -3.5f}, {0, 0, 0}, {0, 1, 0}, 50);
  d.sampler.sample_count = 6;
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  const MaterialId white = add_diffuse(d, 0.7f), red = add_diffuse_rgb(d, 0.6f, 0.1f, 0.05f);
  const MaterialId both = add_material(d, TwoSidedDescription{white, red});
  for (const Vec3f axis : {Vec3f{1, 0, 0}, Vec3f{-1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, -1, 0}})
    add_rectangle(d, Transform::rotate(axis, 90) * Transform::translate({0, 0, -1}), axis.x > 0 ? white : red);
  add_rectangle(d, Transform::translate({0, 0, 1}), both);
  add_sphere(d, {-0.4f, -0.6f, 0.2f}, 0.4f, add_mirror(d, 0.9f));
  add_sphere(d, {0.4f, -0.6f, -0.2f}, 0.4f, add_glass(d));
  add_shape(d, CylinderShape{{-0.9f, -0.9f, -0.5f}, {0.9f, -0.9f, -0.5f}, 0.1f}, Transform(), both);
  Curves curves{Curves::Basis::kBspline, {}, {0}};
  for (int i = 0; i < 6; ++i)
    curves.points.push_back({{0.4f * static_cast<float>(i) - 1, i % 2 == 0 ? 0.1f : 0.5f, 0.3f}, 0.05f});
  add_shape(d, curves, Transform(), red);
  curves.basis = Curves::Basis::kLinear;
  add_shape(d, curves, Transform::translate({0, -0.5f, 0.2f}), white);
  emit(add_shape(
           d, DiskShape{},
           Transform::translate({0, 0.98f, 0}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({0.4f, 0.4f, 1})),
       8);
  emit(add_sphere(d, {0.6f, 0.5f, 0.5f}, 0.15f), 4);
  emit(add_rectangle(d, Transform::translate({-0.95f, 0, 0}) * Transform::rotate({0, 1, 0}, 90) *
                            Transform::scale({0.2f, 0.3f, 1})),
       2);
  add_point_light(d, {0, 0.2f, -1}, 0.5f);
  add_constant_light(d, 0.3f);
  return d;
}

/// Quadrics of one kind of closure, some with a texture and some without, so that both share registers.
Description half_textured(int width, int height) {
  Description d = empty_scene(width, height);
  look_at(d, {0, 0, -4}, {0, 0, 0}, {0, 1, 0}, 40);
  d.sampler.sample_count = 6;
  TextureDescription squares;
  squares.model =
      CheckerboardDescription{SpectrumDescription::rgb(0.9f, 0.2f, 0.1f), SpectrumDescription::rgb(0.1f, 0.5f, 0.8f)};
  d.textures.push_back(squares);
  const MaterialId plain = add_diffuse(d, 0.6f), textured = add_material(d, DiffuseDescription{TextureId{0}});
  for (int i = 0; i < 5; ++i) {
    const float x = 0.5f * static_cast<float>(i) - 1;
    add_sphere(d, {x, 0.3f, 0}, 0.3f, i % 2 == 0 ? plain : textured);
    add_sphere(d, {x, -0.3f, 0.1f}, 0.3f, i % 2 == 1 ? plain : textured);
  }
  add_rectangle(
      d, Transform::translate({0, -0.7f, 0}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}), plain);
  add_point_light(d, {1, 2, -2}, 6);
  add_constant_light(d, 0.3f);
  return d;
}

/// The room with media of several kinds.
Description smoky_room(int width, int height, const std::filesystem::path& folder) {
  Description d = room(width, height);
  const auto lumps = write_vol(folder / "lumps.vol", 12, 1, [](Vec3f p, int) {
    return 4 * p.x * (1 - p.x) + std::sin(9 * p.y) * std::sin(9 * p.y) * p.z;
  });
  MediumDescription fog_medium = fog(0.2f, 0.9f), cloud = fog(6, 0.8f), gas = fog(2, 0.3f);
  std::get<ExtinctionAlbedoDescription>(gas.coefficients).sigma_t = SpectrumDescription::rgb(0.5f, 1, 4);
  gas.emission = VolumeInput(SpectrumDescription::rgb(3, 2, 0.5f));
  cloud.density = vol(lumps, Transform::translate({-0.6f, -0.2f, -0.5f}) * Transform::scale({0.8f, 0.8f, 0.8f}));
  cloud.phase = add_phase(d, 0.7f);
  d.camera.medium = add_medium(d, fog_medium);
  const MediumId of_cloud = add_medium(d, cloud), of_gas = add_medium(d, gas);
  fill(d, add_sphere(d, {-0.2f, 0.2f, -0.1f}, 0.4f), of_cloud).exterior_is_surrounding = true;
  fill(d, add_sphere(d, {0.5f, 0.1f, -0.4f}, 0.2f), of_gas).exterior_is_surrounding = true;
  add_rectangle(
      d, Transform::translate({0, 0.7f, 0}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({0.4f, 0.4f, 1}),
      add_material(d, MaskDescription{0.4f, add_diffuse(d, 0.1f)}));
  return d;
}

/// Triangles that share all their edges, twice in the same place with different materials, every other one also as a
/// light, so that rays meet equal distances everywhere.
Description ties(int side, float relief) {
  Description d = empty_scene(side, side);
  look_at(d, {0, 0, 2}, {0, 0, 0});
  d.sampler.sample_count = 4;
  d.integrator.max_depth = 4;
  constexpr int kSide = 96;
  for (int layer = 0; layer < 3; ++layer) {
    Mesh mesh;
    for (int y = 0; y <= kSide; ++y)
      for (int x = 0; x <= kSide; ++x)
        mesh.positions.push_back({4.0f * static_cast<float>(x) / kSide - 2, 4.0f * static_cast<float>(y) / kSide - 2,
                                  relief * static_cast<float>((x * 7 + y * 3) % 5)});
    for (std::uint32_t y = 0; y < kSide; ++y)
      for (std::uint32_t x = 0; x < kSide; ++x) {
        const std::uint32_t a = y * (kSide + 1) + x;
        mesh.triangles.push_back({a, a + 1, a + kSide + 2});
        mesh.triangles.push_back({a, a + kSide + 2, a + kSide + 1});
        if (layer == 2) std::swap(mesh.triangles.back()[0], mesh.triangles.back()[2]);
      }
    const MaterialId material = add_diffuse_rgb(d, layer == 0 ? 0.9f : 0.1f, layer == 1 ? 0.9f : 0.1f, 0.5f);
    add_shape(d, mesh, Transform(), material);
    if (layer == 1) emit(d.shapes.back(), 0.5f);
  }
  add_constant_light(d, 1);
  return d;
}

std::vector<float> pixels(const Scene& scene, const RenderOptions& options) {
  return render(scene, options).film.to_image().data;
}

bool same_bytes(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// Silences stderr: oneTBB reports when it gets fewer threads than requested.
class Silence {
 public:
  Silence() : kept_(dup(STDERR_FILENO)), nowhere_(open("/dev/null", O_WRONLY)) { dup2(nowhere_, STDERR_FILENO); }
  ~Silence() {
    dup2(kept_, STDERR_FILENO);
    close(kept_);
    close(nowhere_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  int kept_, nowhere_;
};

/// Compiles with at most `threads` threads, then renders.
std::vector<float> build_and_render(const Description& d, int threads, int wave_size) {
  const Silence silence;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  std::unique_ptr<Scene> scene;
  tbb::task_arena(threads).execute([&] { scene = compile_scene(d); });
  RenderOptions options;
  options.threads = threads;
  options.wave_size = wave_size;
  return pixels(*scene, options);
}

/// Returns whether most values are positive. An image of zeros would be reproducible trivially.
bool is_mostly_positive(const std::vector<float>& data) {
  std::size_t positive = 0;
  for (const float value : data) positive += value > 0 ? 1 : 0;
  return 2 * positive > data.size();
}

int run_sheaf(const TemporaryFolder& folder, const std::string& arguments) {
  const std::string command =
      "cd '" + folder.path().string() + "' && '" SHEAF_EXECUTABLE "' " + arguments + " >/dev/null 2>&1 </dev/null";
  return std::system(command.c_str());
}

}  // namespace

TEST_CASE("the bits do not depend on threads or wave size" * doctest::test_suite("slow")) {
  const auto scene = compile_scene(room(70, 50));
  RenderOptions options;
  options.threads = 1;
  options.wave_size = 256;
  const std::vector<float> expected = pixels(*scene, options);
  REQUIRE(is_mostly_positive(expected));
  for (const int threads : {1, 2, 7})
    for (const int wave_size : {1, 256, 1024, 1600}) {
      CAPTURE(threads);
      CAPTURE(wave_size);
      options.threads = threads;
      options.wave_size = wave_size;
      CHECK(same_bytes(pixels(*scene, options), expected));
    }
  for (const int wave_size : {2, 7, 63, 65, 255, kMaxWaveSize}) {
    CAPTURE(wave_size);
    options.wave_size = wave_size;
    CHECK(same_bytes(pixels(*scene, options), expected));
  }
}

TEST_CASE("the bits do not depend on which materials and media share registers" * doctest::test_suite("slow")) {
  const TemporaryFolder folder;
  for (const bool media : {false, true})
    for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
      CAPTURE(media);
      CAPTURE(static_cast<int>(color));
      CompileOptions compile;
      compile.color = color;
      const auto scene = compile_scene(media ? smoky_room(40, 30, folder.path()) : half_textured(40, 30), compile);
      RenderOptions options;
      options.threads = 1;
      options.wave_size = 256;
      const std::vector<float> expected = pixels(*scene, options);
      for (const int wave_size : {1, 65, 1024, 1600}) {
        CAPTURE(wave_size);
        options.threads = wave_size == 1024 ? 1 : 2;
        options.wave_size = wave_size;
        CHECK(same_bytes(pixels(*scene, options), expected));
      }
    }
}

TEST_CASE("the bits are the same for more samples than one pass can hold") {
  const auto scene = compile_scene(room(6, 5));
  RenderOptions options;
  options.samples_per_pixel = 600;
  options.threads = 1;
  const std::vector<float> expected = pixels(*scene, options);
  options.threads = 7;
  options.wave_size = 320;
  CHECK(same_bytes(pixels(*scene, options), expected));
}

TEST_CASE("a crop equals that part of the whole image") {
  const auto scene = compile_scene(room(70, 50));
  const Image whole = render(*scene, {}).film.to_image();
  for (const PixelRect crop : {PixelRect{0, 0, 70, 50}, {69, 49, 70, 50}, {13, 7, 30, 41}, {0, 20, 70, 21}}) {
    CAPTURE(crop.x0);
    CAPTURE(crop.y0);
    RenderOptions options;
    options.crop = crop;
    const Image part = render(*scene, options).film.to_image();
    REQUIRE(part.width == crop.width());
    REQUIRE(part.height == crop.height());
    REQUIRE(part.x0 == crop.x0);
    REQUIRE(part.frame_width == 70);
    const std::size_t row = static_cast<std::size_t>(part.width) * part.channels.size() * sizeof(float);
    int equal_rows = 0;
    for (int y = 0; y < part.height; ++y)
      equal_rows +=
          std::memcmp(&part.data[static_cast<std::size_t>(y) * row / sizeof(float)],
                      &whole.data[(static_cast<std::size_t>(y + crop.y0) * 70 + static_cast<std::size_t>(crop.x0)) *
                                  whole.channels.size()],
                      row) == 0;
    CHECK(equal_rows == part.height);
  }
}

TEST_CASE("the bits do not depend on threads or wave size or crop with any sampler") {
  for (const SamplerKind kind : {SamplerKind::kIndependent, SamplerKind::kStratified, SamplerKind::kMultijitter,
                                 SamplerKind::kSobol, SamplerKind::kZSobol}) {
    CAPTURE(static_cast<int>(kind));
    Description d = room(20, 14);
    d.sampler.kind = kind;
    const auto scene = compile_scene(d);
    RenderOptions options;
    options.threads = 1;
    options.wave_size = 256;
    const Image whole = render(*scene, options).film.to_image();
    options.threads = 3;
    options.wave_size = 1600;
    CHECK(same_bytes(pixels(*scene, options), whole.data));
    options.crop = PixelRect{7, 5, 16, 12};
    const Image part = render(*scene, options).film.to_image();
    const std::size_t row = static_cast<std::size_t>(part.width) * part.channels.size() * sizeof(float);
    for (int y = 0; y < part.height; ++y)
      CHECK(std::memcmp(&part.data[static_cast<std::size_t>(y) * row / sizeof(float)],
                        &whole.data[(static_cast<std::size_t>(y + 5) * 20 + 7) * part.channels.size()], row) == 0);
  }
}

TEST_CASE("another seed gives another image and the same seed the same") {
  const auto scene = compile_scene(room(20, 20));
  RenderOptions options;
  options.seed = 1;
  const std::vector<float> one = pixels(*scene, options);
  CHECK(same_bytes(pixels(*scene, options), one));
  for (const std::uint32_t seed : {0u, 2u, 1u << 31, 0xffffffffu}) {
    options.seed = seed;
    CHECK_FALSE(same_bytes(pixels(*scene, options), one));
  }
}

TEST_CASE("equal hit distances are resolved the same way in every build of the BVH") {
  const Description d = ties(64, 0.125f);
  const std::vector<float> expected = build_and_render(d, 1, 1024);
  REQUIRE(is_mostly_positive(expected));
  for (const int threads : {1, 2, 3, 7, 2, 7}) {
    CAPTURE(threads);
    CHECK(same_bytes(build_and_render(d, threads, 1600), expected));
  }
  CHECK(same_bytes(build_and_render(d, 7, 1), expected));
}

TEST_CASE("rays through vertices and edges hit the same triangles in every build of the BVH" *
          doctest::test_suite("slow")) {
  Description d = ties(193, 0);
  d.film.filter.radius = 1e-6f;  // through the centers of pixels, which are half a cell of the grid apart
  look_at(d, {0, 0, 193.0f / 96}, {0, 0, 0});
  const std::vector<float> expected = build_and_render(d, 1, 256);
  for (const int threads : {2, 7}) CHECK(same_bytes(build_and_render(d, threads, 1), expected));
}

TEST_CASE("files without time stamps have the same bytes") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", R"(<scene version="3.0.0">
    <sensor type="perspective"><transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
      <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
      <sampler type="independent"><integer name="sample_count" value="4"/></sampler></sensor>
    <shape type="sphere"/><emitter type="constant"/></scene>)");
  const char* variants[] = {"--threads 1 --wave-size 256", "--threads 7 --wave-size 1600", "--threads 2 --wave-size 1"};
  std::string expected;
  for (const char* variant : variants) {
    CAPTURE(std::string(variant));
    REQUIRE(run_sheaf(folder,
                      std::string("render scene.xml --quiet --no-timestamps -o out.exr -o out.png ") + variant) == 0);
    const std::string bytes = read_bytes(folder / "out.exr") + read_bytes(folder / "out.png");
    REQUIRE(bytes.size() > 1000);
    if (expected.empty()) expected = bytes;
    CHECK(bytes == expected);
  }
}

}  // namespace sheaf::test_determinism
