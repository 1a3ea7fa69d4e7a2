// Light tracing against path tracing: two estimators that share no formula for lights' emission, for the direction in
// which a BSDF is asked, and for the camera must have the same mean, whatever emits, scatters and lies in between.
#include "core/exr.h"
#include "kernels/passes/render.h"
#include "scene/compile/compile.h"
#include "scene/compile/compile_camera.h"
#include "scene/data/glasses.h"
#include "tests/support/media_testing.h"
#include "tests/support/picture_files.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace sheaf::test_light_tracing {

namespace {

/// All comparisons of this file together fail with probability kSignificance if every estimator is sound.
const double kLevel = significance_of_each(8000);
constexpr int kSide = 20, kRepeats = 7;
/// What is compared of a picture: the mean of each of 16 blocks and of each colour.
constexpr std::size_t kMeans = 19;

std::array<double, kMeans> means_of(const Image& image) {
  std::array<double, kMeans> means{};
  const double pixels = image.width * image.height;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double value = static_cast<double>(image.at(x, y, c)) / pixels;
        const int block = 4 * (4 * y / image.height) + 4 * x / image.width;
        means[static_cast<std::size_t>(block)] += value;
        means[static_cast<std::size_t>(16 + c)] += value;
      }
  return means;
}

std::array<MeanVariance, kMeans> repeat(Description d, IntegratorKind kind, ColorMode color) {
  d.integrator.kind = kind;
  const auto scene = compile_scene(d, {false, color});
  std::array<MeanVariance, kMeans> out;
  for (int i = 0; i < kRepeats; ++i) {
    RenderOptions options;
    options.seed = static_cast<std::uint32_t>(100 + 2 * i + (kind == IntegratorKind::kPath ? 0 : 1));
    const std::array<double, kMeans> means = means_of(render(*scene, options).to_image());
    for (std::size_t k = 0; k < kMeans; ++k) out[k].add(means[k]);
  }
  return out;
}

void check_agree(const Description& d, ColorMode color = ColorMode::kRgb) {
  const auto path = repeat(d, IntegratorKind::kPath, color), light = repeat(d, IntegratorKind::kLightTracer, color);
  for (std::size_t k = 0; k < kMeans; ++k) {
    const double error = std::sqrt((path[k].variance() + light[k].variance()) / kRepeats);
    // What no number of samples averages out: single precision, tables of filters and wavelengths; and a filter's tails
    // in blocks that see nothing, where few camera samples ever come.
    const double allowed = 2e-4 * std::fabs(path[k].mean()) + 1e-4 * path[kMeans - 2].mean();
    const double distance = std::max(0.0, std::fabs(path[k].mean() - light[k].mean()) - allowed);
    CAPTURE(k);
    INFO("path " << path[k].mean() << ", ptracer " << light[k].mean() << ", standard error " << error);
    if (distance > 0) CHECK(student_t_p_value(distance / error, 2 * kRepeats - 2) >= kLevel);
  }
}

TextureId add_board(Description& d, Vec3f first, Vec3f second) {
  const auto rgb = [](Vec3f v) { return SpectrumDescription{SpectrumDescription::Rgb{v}}; };
  d.textures.push_back({CheckerboardDescription{rgb(first), rgb(second)}, {}, {}, {}});
  return static_cast<TextureId>(d.textures.size() - 1);
}

/// Heights between 0 and 1: a picture of 16 x 16 pixels, looked up in between.
TextureId add_hills(Description& d) {
  static const TemporaryFolder folder;
  static const std::filesystem::path file = [] {
    Image image(16, 16, {"R", "G", "B"});
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(x, y, c) = static_cast<float>(0.5 + 0.25 * std::sin(1.1 * x) + 0.25 * std::cos(0.8 * y));
    write_exr(folder / "hills.exr", image);
    return folder / "hills.exr";
  }();
  d.textures.push_back({BitmapDescription{file}, {1, 0, 0, 0, 1, 0}, {}, {}});
  return static_cast<TextureId>(d.textures.size() - 1);
}

/// A floor, and above it whatever a test adds; z is up.
Description room(std::uint32_t samples = 25) {
  Description d = empty_scene(kSide, kSide);
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = samples;
  d.film.filter = {PixelFilter::Kind::kGaussian, 2.0f, 0.5f};
  look_at(d, {0, -4, 2.5f}, {0, 0, 0.6f}, {0, 0, 1}, 40);
  d.integrator.max_depth = 6;
  const MaterialId floor = add_material(d, DiffuseDescription{add_board(d, {0.7f, 0.5f, 0.3f}, {0.3f, 0.5f, 0.8f})});
  add_rectangle(d, Transform::scale({3, 3, 1}), add_two_sided(d, floor));
  return d;
}

/// A ball of few triangles with smooth normals: shading and geometric normals differ all over.
Mesh smooth_ball(Vec3f center, float radius) {
  constexpr int kRings = 5, kSegments = 8;
  Mesh mesh;
  for (int j = 0; j <= kRings; ++j)
    for (int i = 0; i <= kSegments; ++i) {
      const double theta = 3.14159265358979 * j / kRings, phi = 2 * 3.14159265358979 * i / kSegments;
      const Vec3f n{static_cast<float>(std::sin(theta) * std::cos(phi)),
                    static_cast<float>(std::sin(theta) * std::sin(phi)), static_cast<float>(std::cos(theta))};
      mesh.positions.push_back(center + n * radius);
      mesh.normals.push_back(n);
      mesh.uvs.push_back({static_cast<float>(i) / kSegments, static_cast<float>(j) / kRings});
    }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(j * (kSegments + 1) + i); };
  for (int j = 0; j < kRings; ++j)
    for (int i = 0; i < kSegments; ++i) {
      if (j > 0) mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      if (j + 1 < kRings) mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return mesh;
}

using Change = std::function<void(Description&)>;
struct Named {
  std::string name;
  Change add;
};

Transform aim(Vec3f from, Vec3f to) { return Transform::look_at(from, to, {0, 1, 0}); }

const std::vector<Named>& emitters() {
  static const std::vector<Named> list = {
      {"rectangle",
       [](Description& d) {
         add_area_light_rectangle(d, aim({1, -1, 3}, {0, 0, 0}) * Transform::scale({0.6f, 0.4f, 1}), 12);
       }},
      {"textured rectangle",
       [](Description& d) {
         add_rectangle(d, aim({-1, -1, 3}, {0, 0, 0}), add_diffuse(d, 0)).radiance =
             add_board(d, {12, 2, 1}, {1, 4, 9});
       }},
      {"sphere",
       [](Description& d) {
         add_area_light_sphere(d, {-1, -1, 2.5f}, 0.4f, 15);
       }},
      {"cylinder",
       [](Description& d) {
         emit(add_shape(d, CylinderShape{{-1, -1, 2.5f}, {1, 0, 2.5f}, 0.2f}, Transform(), add_diffuse(d, 0)), 9);
       }},
      {"mesh that reflects",
       [](Description& d) {
         emit(add_shape(d, smooth_ball({1, -1, 2.5f}, 0.5f), Transform(), add_diffuse(d, 0.6f)), 9);
       }},
      {"point",
       [](Description& d) {
         add_point_light(d, {1, -1, 2.5f}, 12);
       }},
      {"spot",
       [](Description& d) {
         SpotLightDescription spot;
         spot.to_world = aim({1.5f, -1, 3}, {0, 0, 0.3f});
         spot.intensity = SpectrumDescription::rgb(40, 60, 30);
         spot.cutoff_angle = 25;
         d.lights.push_back({spot, {}});
       }},
      {"smooth spot",
       [](Description& d) {
         SpotLightDescription spot;
         spot.falloff = SpotLightDescription::Falloff::kSmooth;
         spot.to_world = aim({1.5f, -1, 3}, {0, 0, 0.3f});
         spot.intensity = SpectrumDescription::constant(40);
         d.lights.push_back({spot, {}});
       }},
      {"textured spot",
       [](Description& d) {
         SpotLightDescription spot;
         spot.to_world = aim({1.5f, -1, 3}, {0, 0, 0.3f});
         spot.intensity = SpectrumDescription::constant(40);
         spot.texture = add_board(d, {1, 0.2f, 0.1f}, {0.1f, 0.7f, 1});
         d.lights.push_back({spot, {}});
       }},
      {"projector",
       [](Description& d) {
         ProjectorDescription projector;
         projector.to_world = aim({1.5f, -1, 3}, {0, 0, 0.3f});
         projector.irradiance = add_board(d, {3, 1, 0.5f}, {0.5f, 2, 3});
         projector.scale = 4;
         d.lights.push_back({projector, {}});
       }},
      {"directional",
       [](Description& d) {
         d.lights.push_back({DirectionalLightDescription{{0.3f, 0.5f, -1}, SpectrumDescription::rgb(3, 2, 4)}, {}});
       }},
      {"constant", [](Description& d) { add_constant_light(d, 1); }},
  };
  return list;
}

/// Balls on the floor of a material that light tracing can see.
const std::vector<Named>& balls() {
  const auto ball = [](auto model) {
    return [model](Description& d) {
      add_shape(d, smooth_ball({0, 0, 0.8f}, 0.75f), Transform(), add_material(d, model));
    };
  };
  static const RoughnessDescription rough{RoughnessDescription::Distribution::kGgx, 0.4f, 0.25f};
  static const std::vector<Named> list = {
      {"diffuse", ball(DiffuseDescription{SpectrumDescription::rgb(0.8f, 0.5f, 0.2f)})},
      {"rough conductor",
       [=](Description& d) {
         ConductorDescription metal;
         metal.roughness = rough;
         ball(metal)(d);
       }},
      {"rough dielectric",
       [=](Description& d) {
         DielectricDescription glass;
         glass.roughness = rough;
         ball(glass)(d);
       }},
      {"rough dielectric, Beckmann, dense",
       [=](Description& d) {
         DielectricDescription glass;
         glass.int_ior = 2.2f;
         glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kBeckmann, 0.5f, 0.5f};
         ball(glass)(d);
       }},
      {"rough plastic",
       [=](Description& d) {
         PlasticDescription plastic;
         plastic.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.3f, 0.3f};
         ball(plastic)(d);
       }},
      {"principled",
       [=](Description& d) {
         PrincipledDescription p;
         p.roughness = 0.5f, p.metallic = 0.3f, p.sheen = 0.5f, p.clearcoat = 0.7f, p.clearcoat_gloss = 0.3f;
         ball(p)(d);
       }},
      {"principled glass",
       [=](Description& d) {
         PrincipledDescription p;
         p.roughness = 0.5f, p.spec_trans = 0.9f, p.eta = 1.4f;
         ball(p)(d);
       }},
      {"thin principled",
       [=](Description& d) {
         PrincipledThinDescription p;
         p.roughness = 0.5f, p.spec_trans = 0.5f, p.diff_trans = 1.0f;
         ball(p)(d);
       }},
      {"Disney",
       [=](Description& d) {
         DisneyDescription p;
         p.metallic = 0.3f, p.subsurface = 0.5f, p.sheen = 0.5f, p.clearcoat = 0.5f, p.clearcoat_gloss = 0.2f;
         ball(p)(d);
       }},
      {"Nori's microfacet",
       [=](Description& d) {
         NoriMicrofacetDescription p;
         p.alpha = 0.4f;
         ball(p)(d);
       }},
      {"bump map",
       [=](Description& d) {
         ball(BumpMapDescription{add_hills(d), 0.15f, add_diffuse(d, 0.8f)})(d);
       }},
      {"bumpy glass",
       [=](Description& d) {
         DielectricDescription glass;
         glass.roughness = rough;
         ball(BumpMapDescription{add_hills(d), 0.15f, add_material(d, glass)})(d);
       }},
      {"normal map",
       [=](Description& d) {
         const TextureId normals = add_board(d, {0.65f, 0.4f, 0.95f}, {0.3f, 0.55f, 0.9f});
         ball(NormalMapDescription{normals, false, add_diffuse(d, 0.8f)})(d);
       }},
      {"mask",
       [=](Description& d) {
         ball(MaskDescription{0.4f, add_diffuse(d, 0.8f)})(d);
       }},
      {"blend",
       [=](Description& d) {
         const MaterialId parts[2] = {add_diffuse(d, 0.8f), add_two_sided(d, add_diffuse(d, 0.2f))};
         BlendDescription blend{0.3f, {parts[0], parts[1]}};
         ball(blend)(d);
       }},
  };
  return list;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("light tracing: every emitter with every BSDF has the path tracer's mean") {
  for (const Named& emitter : emitters())
    for (const Named& ball : balls()) {
      CAPTURE(emitter.name);
      CAPTURE(ball.name);
      Description d = room();
      emitter.add(d);
      ball.add(d);
      check_agree(d);
    }
}

TEST_CASE("light tracing: every emitter in and around media has the path tracer's mean") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 8, 1, [](Vec3f p, int) {
    return 1 + 0.9f * std::sin(17 * p.x) * std::sin(13 * p.y + 1) * std::cos(11 * p.z);
  });
  const Transform around = Transform::translate({-1.5f, -1.5f, 0.1f}) * Transform::scale({3, 3, 3.2f});
  const auto with_density = [&](MediumDescription m) {
    m.density = vol(lumps, around);
    return m;
  };
  MediumDescription colored = fog(1, 1);
  colored.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.3f, 0.6f, 1.2f),
                                                     SpectrumDescription::rgb(0.9f, 0.5f, 0.7f)};
  const std::vector<Named> media = {
      {"fog in a ball, forwards",
       [&](Description& d) {
         MediumDescription m = fog(0.8f, 0.9f);
         m.phase = add_phase(d, 0.7f);
         fill(d, add_sphere(d, {0, 0, 1.5f}, 1.4f), add_medium(d, m));
       }},
      {"coloured fog in a ball",
       [&](Description& d) {
         fill(d, add_sphere(d, {0, 0, 1.5f}, 1.4f), add_medium(d, colored));
       }},
      {"lumpy fog in a cube",
       [&](Description& d) {
         fill(d, add_shape(d, CubeShape{}, Transform::translate({0, 0, 1.7f}) * Transform::scale({1.5f, 1.5f, 1.6f})),
              add_medium(d, with_density(colored)));
       }},
      {"fog around everything", [&](Description& d) { d.camera.medium = add_medium(d, fog(0.1f, 0.8f)); }},
      {"fog in rough glass",
       [&](Description& d) {
         DielectricDescription glass;
         glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.4f, 0.4f};
         const MaterialId material = add_material(d, glass);
         const MediumId inside = add_medium(d, colored);
         add_sphere(d, {0, 0, 0.8f}, 0.75f, material).interior = inside;
       }},
      {"a pane and a mask",
       [&](Description& d) {
         DielectricDescription pane;
         pane.thin = true;
         pane.specular_reflectance = SpectrumDescription::constant(0);  // light tracing cannot see what it reflects
         add_rectangle(d, Transform::translate({0.3f, -0.5f, 1.2f}) * Transform::scale({0.6f, 0.6f, 1}),
                       add_material(d, pane));
         add_rectangle(d, Transform::translate({-0.5f, 0.5f, 0.9f}) * Transform::scale({0.6f, 0.6f, 1}),
                       add_material(d, MaskDescription{0.5f, add_two_sided(d, add_diffuse(d, 0.7f))}));
         d.integrator.thin_dielectrics_are_free = true;
       }},
  };
  for (const Named& emitter : emitters())
    for (const Named& medium : media) {
      CAPTURE(emitter.name);
      CAPTURE(medium.name);
      Description d = room();
      emitter.add(d);
      medium.add(d);
      check_agree(d);
    }
}

TEST_CASE("light tracing: light from outside on its way through fog without end, far from the middle of the scene") {
  for (const std::size_t emitter : {emitters().size() - 2, emitters().size() - 1}) {
    CAPTURE(emitters()[emitter].name);
    Description d = room(100);
    add_sphere(d, {16, 0, 0}, 0.5f, add_diffuse(d, 0.5f));
    d.camera.medium = add_medium(d, fog(0.15f, 0.5f));
    emitters()[emitter].add(d);
    check_agree(d);
  }
}

TEST_CASE("light tracing: media that glow, by every estimator of media") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 8, 1, [](Vec3f p, int) { return 1 + 0.9f * std::sin(17 * p.x); });
  for (const MediumEstimator estimator : {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio})
    for (const bool grid : {false, true})
      for (const float albedo : {0.0f, 0.6f}) {
        CAPTURE(static_cast<int>(estimator));
        CAPTURE(grid);
        CAPTURE(albedo);
        Description d = room();
        d.integrator.medium_estimator = estimator;
        MediumDescription m = fog(0.7f, albedo);
        if (grid) m.density = vol(lumps, Transform::translate({-1, -1, 0.5f}) * Transform::scale({2, 2, 2}));
        m.emission = SpectrumDescription::rgb(2, 3, 1);
        fill(d, add_sphere(d, {0, 0, 1.5f}, 0.8f), add_medium(d, m));
        check_agree(d);
      }
}

TEST_CASE("light tracing: lenses, cameras without perspective, clip planes, depths, filters and hidden lights") {
  const std::vector<Named> changes = {
      {"lens", [](Description& d) { d.camera.aperture_radius = 0.2f, d.camera.focus_distance = 3.5f; }},
      {"lens, inside fog",
       [](Description& d) {
         d.camera.aperture_radius = 0.2f, d.camera.focus_distance = 3.5f;
         d.camera.medium = add_medium(d, fog(0.1f, 0.8f));
       }},
      {"orthographic",
       [](Description& d) {
         d.camera.projection = CameraDescription::Projection::kOrthographic;
         d.camera.to_world = d.camera.to_world * Transform::scale({1.5f, 1.5f, 1});
       }},
      {"shifted, not square",
       [](Description& d) {
         d.film.width = 28;
         d.camera.principal_point_x = 0.2f, d.camera.principal_point_y = -0.1f;
       }},
      {"clip planes", [](Description& d) { d.camera.near_clip = 3.6f, d.camera.far_clip = 4.6f; }},
      {"direct light", [](Description& d) { d.integrator.max_depth = 2; }},
      {"two reflections", [](Description& d) { d.integrator.max_depth = 3; }},
      {"roulette", [](Description& d) { d.integrator.max_depth = -1, d.integrator.rr_depth = 1; }},
      {"box", [](Description& d) { d.film.filter = {}; }},
      {"Mitchell", [](Description& d) { d.film.filter.kind = PixelFilter::Kind::kMitchell; }},
      {"Lanczos", [](Description& d) { d.film.filter.kind = PixelFilter::Kind::kLanczos; }},
      {"hidden lights before and behind",
       [](Description& d) {
         d.integrator.hide_emitters = true;
         emit(add_sphere(d, {0, -3, 2}, 0.15f, add_diffuse(d, 0.5f)), 20);
       }},
  };
  for (const Named& change : changes) {
    CAPTURE(change.name);
    Description d = room(256);
    emitters()[0].add(d);
    emitters()[2].add(d);
    balls()[1].add(d);
    add_sphere(d, {0.2f, -2.9f, 2.1f}, 0.05f, add_diffuse(d, 0.9f));  // too near to be sharp
    change.add(d);
    check_agree(d);
  }
}

TEST_CASE("light tracing: spectral mode, with dispersion") {
  for (const bool dispersion : {false, true}) {
    CAPTURE(dispersion);
    Description d = room(128);
    emitters()[1].add(d);
    DielectricDescription glass;
    if (dispersion)
      glass.int_dispersion = *find_dispersion("diamond");
    else
      glass.int_ior = 1.6f;
    glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.3f, 0.3f};
    add_shape(d, smooth_ball({0, 0, 0.8f}, 0.75f), Transform(), add_material(d, glass));
    check_agree(d, ColorMode::kSpectral);
    MediumDescription colored;
    colored.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.1f, 0.2f, 0.4f),
                                                       SpectrumDescription::rgb(0.9f, 0.5f, 0.7f)};
    d.camera.medium = add_medium(d, colored);
    check_agree(d, ColorMode::kSpectral);
  }
}

TEST_SUITE_END();

TEST_CASE("light tracing: the same bits for all thread counts and wave sizes, and in a crop") {
  Description d = room(8);
  d.sampler.kind = SamplerKind::kSobol;
  d.camera.medium = add_medium(d, fog(0.1f, 0.8f));
  for (const Named& emitter : emitters()) emitter.add(d);
  balls()[2].add(d);
  d.integrator.kind = IntegratorKind::kLightTracer;
  const auto scene = compile_scene(d);
  const Image whole = render(*scene, {}).to_image();
  for (const int threads : {1, 2, 7})
    for (const int wave_size : {64, 256, 1000}) {
      CAPTURE(threads);
      CAPTURE(wave_size);
      RenderOptions options;
      options.threads = threads;
      options.wave_size = wave_size;
      CHECK(render(*scene, options).to_image().data == whole.data);
    }
  RenderOptions options;
  options.crop = PixelRect{3, 5, 11, 9};
  const Image crop = render(*scene, options).to_image();
  bool same = true;
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x)
      for (int c = 0; c < static_cast<int>(crop.channels.size()); ++c)
        same = same && crop.at(x, y, c) == whole.at(x + 3, y + 5, c);
  CHECK(same);
}

TEST_CASE("light tracing: the variance channels say how far pictures of other seeds lie") {
  Description d = room(32);
  emitters()[0].add(d);
  d.integrator.kind = IntegratorKind::kLightTracer;
  const auto scene = compile_scene(d);
  constexpr int kPictures = 40;
  std::vector<MeanVariance> pixels(std::size_t{kSide} * kSide);
  double claimed = 0;
  for (int i = 0; i < kPictures; ++i) {
    RenderOptions options;
    options.seed = static_cast<std::uint32_t>(i);
    const Image image = render(*scene, options).to_image();
    const int variance = image.find_channel("variance.G");
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        pixels[static_cast<std::size_t>(y * kSide + x)].add(image.at(x, y, 1));
        claimed += static_cast<double>(image.at(x, y, variance)) / kPictures;
      }
  }
  double found = 0;
  for (const MeanVariance& pixel : pixels) found += pixel.variance();
  CHECK(claimed / found == doctest::Approx(1).epsilon(0.06));
}

TEST_CASE("light tracing: hidden lights and what they reflect do not show, unless behind a pane") {
  // A wall, lit by a point light and by two lights that reflect and stand before it.
  const auto wall = [] {
    Description d = empty_scene(12, 12);
    d.sampler.kind = SamplerKind::kIndependent;
    d.sampler.sample_count = 64;
    d.film.filter = {};
    look_at(d, {0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 40);
    d.integrator.max_depth = 4;
    d.integrator.hide_emitters = true;
    add_rectangle(d, Transform::scale({3, 3, 1}), add_diffuse_rgb(d, 0.8f, 0.5f, 0.2f));
    const MaterialId grey = add_diffuse(d, 0.7f);
    emit(add_rectangle(d, Transform::translate({0, 0, 1}) * Transform::scale({0.4f, 0.4f, 1}), grey), 3);
    emit(add_sphere(d, {0.5f, 0.4f, 0.5f}, 0.3f, grey), 2);
    add_point_light(d, {1, 1, 3}, 3);
    return d;
  };
  const auto pane = [](Description& d, float z) {
    DielectricDescription glass;
    glass.thin = true;
    glass.specular_reflectance = SpectrumDescription::constant(0);  // light tracing cannot see what it reflects
    add_rectangle(d, Transform::translate({-0.2f, -0.2f, z}) * Transform::scale({0.5f, 0.5f, 1}),
                  add_material(d, glass));
    d.integrator.thin_dielectrics_are_free = true;
  };
  check_agree(wall());
  // Before the lights, which then show, behind all of them, and between them.
  for (const float z : {1.5f, 0.1f, 0.9f}) {
    CAPTURE(z);
    Description d = wall();
    pane(d, z);
    check_agree(d);
  }
  Description veiled = wall();
  add_rectangle(veiled, Transform::translate({0, 0, 1.3f}) * Transform::scale({0.5f, 0.5f, 1}),
                add_material(veiled, MaskDescription{0.4f, add_two_sided(veiled, add_diffuse(veiled, 0.7f))}));
  veiled.camera.medium = add_medium(veiled, fog(0.1f, 0.8f));
  check_agree(veiled);
}

TEST_CASE("light tracing: pixels at the frame's edge, also where geometry ends in them") {
  using Kind = PixelFilter::Kind;
  PixelFilter wide;
  wide.kind = Kind::kGaussian;
  PixelFilter mitchell, lanczos, box;
  mitchell.kind = Kind::kMitchell, lanczos.kind = Kind::kLanczos, box.radius = 1.3f;
  for (const PixelFilter& filter : {wide, mitchell, lanczos, box})
    for (const FilterMode mode : {FilterMode::kWeighted, FilterMode::kImportance})
      for (const bool border : {false, true}) {
        CAPTURE(static_cast<int>(filter.kind));
        CAPTURE(static_cast<int>(mode));
        CAPTURE(border);
        Description d = empty_scene(8, 8);
        d.sampler.sample_count = 256;
        d.film.filter = filter;
        d.film.filter_mode = mode;
        d.film.sample_border = border;
        d.integrator.max_depth = 2;
        look_at(d, {0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 40);
        add_point_light(d, {0.5f, 0.2f, 1.5f}, 5);
        // Ends inside of the outermost pixels on two sides of the frame, and beyond it on the others.
        add_rectangle(d, Transform::translate({0.24f, 0.24f, 0}) * Transform::scale({0.9f, 0.9f, 1}),
                      add_diffuse_rgb(d, 0.8f, 0.6f, 0.4f));
        // The outermost pixels alone, each side's apart: red, green and blue of left, right, top and bottom, corners.
        const auto edges = [&](IntegratorKind kind) {
          Description of = d;
          of.integrator.kind = kind;
          const auto scene = compile_scene(of);
          std::array<MeanVariance, 8> means;
          for (std::uint32_t i = 0; i < kRepeats; ++i) {
            RenderOptions options;
            options.seed = 2 * i + (kind == IntegratorKind::kPath ? 0u : 1u);
            const Image image = render(*scene, options).to_image();
            const int last = image.width - 1;
            double sums[4] = {};
            for (int k = 1; k < last; ++k) {
              sums[0] += double{image.at(0, k, 0)}, sums[1] += double{image.at(last, k, 0)};
              sums[2] += double{image.at(k, 0, 0)}, sums[3] += double{image.at(k, last, 0)};
            }
            for (std::size_t k = 0; k < 4; ++k) {
              means[k].add(sums[k]);
              means[4 + k].add(double{image.at(k % 2 == 0 ? 0 : last, k / 2 == 0 ? 0 : last, 0)});
            }
          }
          return means;
        };
        const auto path = edges(IntegratorKind::kPath), light = edges(IntegratorKind::kLightTracer);
        for (std::size_t k = 0; k < path.size(); ++k) {
          CAPTURE(k);
          const double error = std::sqrt((path[k].variance() + light[k].variance()) / kRepeats);
          INFO("path " << path[k].mean() << ", ptracer " << light[k].mean() << ", standard error " << error);
          const double allowed = 1e-3 * std::fabs(path[k].mean()) + 1e-4;  // single precision, tables of filters
          const double distance = std::max(0.0, std::fabs(path[k].mean() - light[k].mean()) - allowed);
          if (distance > 0) CHECK(student_t_p_value(distance / error, 2 * kRepeats - 2) >= kLevel);
        }
      }
}

TEST_CASE("light tracing: at the sides of a panorama, filters reach around it") {
  for (const FilterMode mode : {FilterMode::kWeighted, FilterMode::kImportance})
    for (const bool border : {false, true}) {
      CAPTURE(static_cast<int>(mode));
      CAPTURE(border);
      Description d = empty_scene(12, 6);
      d.sampler.sample_count = 256;
      d.film.filter.kind = PixelFilter::Kind::kGaussian;
      d.film.filter_mode = mode;
      d.film.sample_border = border;
      d.integrator.max_depth = 2;
      d.camera.projection = CameraDescription::Projection::kSpherical;
      // The frame's sides meet at the dark half of a ball around the camera.
      const TextureId board = add_board(d, {0.9f, 0.9f, 0.9f}, {0.1f, 0.1f, 0.1f});
      d.textures.back().to_uv = {1, 0, 0.06f, 0, 1, 0};
      add_shape(d, SphereShape{{0, 0, 0}, 2}, Transform::rotate({1, 0, 0}, -90),
                add_two_sided(d, add_material(d, DiffuseDescription{board})));
      add_point_light(d, {0.3f, 0.2f, -0.5f}, 5);
      const auto sides = [&](IntegratorKind kind) {
        d.integrator.kind = kind;
        const auto scene = compile_scene(d);
        std::array<MeanVariance, 4> means;
        for (std::uint32_t i = 0; i < kRepeats; ++i) {
          RenderOptions options;
          options.seed = 2 * i + (kind == IntegratorKind::kPath ? 0u : 1u);
          const Image image = render(*scene, options).to_image();
          // Rows around the horizon: beyond the poles camera rays see the pole itself.
          for (std::size_t k = 0; k < 4; ++k) {
            const int x = k < 2 ? static_cast<int>(k) : image.width - 4 + static_cast<int>(k);
            means[k].add(double{image.at(x, 2, 0)} + double{image.at(x, 3, 0)});
          }
        }
        return means;
      };
      const auto path = sides(IntegratorKind::kPath), light = sides(IntegratorKind::kLightTracer);
      for (std::size_t k = 0; k < path.size(); ++k) {
        CAPTURE(k);
        const double error = std::sqrt((path[k].variance() + light[k].variance()) / kRepeats);
        INFO("path " << path[k].mean() << ", ptracer " << light[k].mean() << ", standard error " << error);
        CHECK(error < 0.02 * path[k].mean());
        const double distance = std::max(0.0, std::fabs(path[k].mean() - light[k].mean()) - 1e-3 * path[k].mean());
        if (distance > 0) CHECK(student_t_p_value(distance / error, 2 * kRepeats - 2) >= kLevel);
      }
    }
}

TEST_CASE("camera: the view of a point is the ray that meets it, and its importance the film area of a patch there") {
  for (int kind = 0; kind < 3; ++kind) {
    CAPTURE(kind);
    CameraDescription description;
    description.to_world = Transform::look_at({1, 2, 3}, {-0.3f, 0.5f, 0.2f}, {0, 0, 1});
    description.fov = 50;
    description.principal_point_x = 0.1f;
    description.near_clip = 0.5f;
    if (kind == 1) description.projection = CameraDescription::Projection::kOrthographic;
    if (kind == 2) description.aperture_radius = 0.3f, description.focus_distance = 2;
    const Camera camera = make_camera(description, 40, 30);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> u(-1, 1);
    for (int i = 0; i < 100; ++i) {
      const float x = 20 + 20 * u(random), y = 15 + 15 * u(random), lens_u = 0.7f * u(random),
                  lens_v = 0.7f * u(random);
      const auto ray = camera.ray<Scalar>(x, y, lens_u, lens_v);
      const float t = 2 + u(random);
      const auto at = [&](float film_x, float film_y) {
        const auto r = camera.ray<Scalar>(film_x, film_y, lens_u, lens_v);
        // Where the neighbouring ray meets the plane across the ray.
        return r.origin + r.direction * (dot(ray.origin + ray.direction * t - r.origin, ray.direction) /
                                         dot(r.direction, ray.direction));
      };
      const auto view = camera.view<Scalar>(ray.origin + ray.direction * t, lens_u, lens_v);
      CHECK(view.valid);
      CHECK(view.film_x == doctest::Approx(x).epsilon(1e-4));
      CHECK(view.film_y == doctest::Approx(y).epsilon(1e-4));
      CHECK(length(view.target - ray.origin) < 1e-5f);
      constexpr float kStep = 0.05f;
      const Vec3f dx = at(x + kStep, y) - at(x - kStep, y), dy = at(x, y + kStep) - at(x, y - kStep);
      CHECK(view.importance * length(cross(dx, dy)) == doctest::Approx(4 * kStep * kStep).epsilon(2e-3));
    }
  }
}

}  // namespace sheaf::test_light_tracing
