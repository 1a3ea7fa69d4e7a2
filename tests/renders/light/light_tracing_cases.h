// Scenes with every emitter and BSDF that light tracing supports, and the comparison of light tracing with path
// tracing. The two estimators share no formula for the emission of lights, the direction of BSDFs or the camera.
#pragma once

#include "core/image/exr.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf::light_tracing_cases {

/// All comparisons of light tracing together fail with probability kSignificance if every estimator is unbiased.
inline const double kLevel = significance_of_each(8000);
/// Width and height of images, in pixels, and number of renders with different seeds per estimator.
inline constexpr int kSide = 20, kRepeats = 7;
/// Compared values: the means of 16 blocks and of the 3 colors.
inline constexpr std::size_t kMeans = 19;

/// The compared values of an image.
inline std::array<double, kMeans> means_of(const Image& image) {
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

/// Statistics of the compared values over kRepeats renders.
inline std::array<MeanVariance, kMeans> repeat(Description d, IntegratorKind kind, ColorMode color) {
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

/// Tests whether the means of kRepeats renders by path tracing and by light tracing differ by more than `allowed`.
inline void check_means_agree(const MeanVariance& path, const MeanVariance& light, double allowed) {
  const double error = std::sqrt((path.variance() + light.variance()) / kRepeats);
  const double distance = std::max(0.0, std::fabs(path.mean() - light.mean()) - allowed);
  INFO("path " << path.mean() << ", ptracer " << light.mean() << ", standard error " << error);
  if (distance > 0) CHECK(student_t_p_value(distance / error, 2 * kRepeats - 2) >= kLevel);
}

/// Tests whether path tracing and light tracing have the same mean.
inline void check_agree(const Description& d, ColorMode color = ColorMode::kRgb) {
  const auto path = repeat(d, IntegratorKind::kPath, color), light = repeat(d, IntegratorKind::kLightTracer, color);
  for (std::size_t k = 0; k < kMeans; ++k) {
    // Errors that no number of samples averages out: single precision, tables of filters and wavelengths, and tails of
    // filters in empty blocks, where few camera samples lie.
    const double allowed = 2e-4 * std::fabs(path[k].mean()) + 1e-4 * path[kMeans - 2].mean();
    CAPTURE(k);
    check_means_agree(path[k], light[k], allowed);
  }
}

/// An interpolated texture of 16 x 16 heights between 0 and 1.
inline TextureId add_hills(Description& d) {
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

/// A floor, with z up. Tests add objects above it.
inline Description room(std::uint32_t samples = 25) {
  Description d = empty_scene(kSide, kSide);
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = samples;
  d.film.filter = {PixelFilter::Kind::kGaussian, 2.0f, 0.5f};
  look_at(d, {0, -4, 2.5f}, {0, 0, 0.6f}, {0, 0, 1}, 40);
  d.integrator.max_depth = 6;
  const MaterialId floor =
      add_material(d, DiffuseDescription{add_checkerboard(d, {0.7f, 0.5f, 0.3f}, {0.3f, 0.5f, 0.8f})});
  add_rectangle(d, Transform::scale({3, 3, 1}), add_two_sided(d, floor));
  return d;
}

/// A sphere of few triangles with smooth normals, so that shading and geometric normals differ everywhere.
inline Mesh smooth_ball(Vec3f center, float radius) {
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

/// A change to a scene, and what it adds.
struct NamedChange {
  std::string name;
  std::function<void(Description&)> add;
};

/// Applies the change of the given name.
inline void add_named(Description& d, const std::vector<NamedChange>& changes, std::string_view name) {
  for (const NamedChange& change : changes)
    if (change.name == name) return change.add(d);
  FAIL("no change is named " << name);
}

/// The changes of several lists, in order.
inline std::vector<NamedChange> joined(std::initializer_list<std::vector<NamedChange>> lists) {
  std::vector<NamedChange> all;
  for (const std::vector<NamedChange>& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

/// The matrix of an emitter at `from` that points towards `to`.
inline Transform aim(Vec3f from, Vec3f to) { return Transform::look_at(from, to, {0, 1, 0}); }

/// Area lights of every shape.
inline std::vector<NamedChange> area_emitters() {
  return {
      {"rectangle",
       [](Description& d) {
         add_area_light_rectangle(d, aim({1, -1, 3}, {0, 0, 0}) * Transform::scale({0.6f, 0.4f, 1}), 12);
       }},
      {"textured rectangle",
       [](Description& d) {
         add_rectangle(d, aim({-1, -1, 3}, {0, 0, 0}), add_diffuse(d, 0)).radiance =
             add_checkerboard(d, {12, 2, 1}, {1, 4, 9});
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
  };
}

/// Lights at a point, and infinite lights.
inline std::vector<NamedChange> other_emitters() {
  return {
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
         spot.texture = add_checkerboard(d, {1, 0.2f, 0.1f}, {0.1f, 0.7f, 1});
         d.lights.push_back({spot, {}});
       }},
      {"projector",
       [](Description& d) {
         ProjectorDescription projector;
         projector.to_world = aim({1.5f, -1, 3}, {0, 0, 0.3f});
         projector.irradiance = add_checkerboard(d, {3, 1, 0.5f}, {0.5f, 2, 3});
         projector.scale = 4;
         d.lights.push_back({projector, {}});
       }},
      {"directional",
       [](Description& d) {
         d.lights.push_back({DirectionalLightDescription{{0.3f, 0.5f, -1}, SpectrumDescription::rgb(3, 2, 4)}, {}});
       }},
      {"constant", [](Description& d) { add_constant_light(d, 1); }},
  };
}

/// Emitters of every kind.
inline std::vector<NamedChange> emitters() { return joined({area_emitters(), other_emitters()}); }

/// Adds a sphere of the given material on the floor.
template <class Model> void add_ball(Description& d, const Model& model) {
  add_shape(d, smooth_ball({0, 0, 0.8f}, 0.75f), Transform(), add_material(d, model));
}

/// The roughness of anisotropic balls.
inline constexpr RoughnessDescription kBallRoughness{RoughnessDescription::Distribution::kGgx, 0.4f, 0.25f};

/// Balls of diffuse materials, metals, dielectrics and plastics.
inline std::vector<NamedChange> basic_balls() {
  return {
      {"diffuse", [](Description& d) { add_ball(d, DiffuseDescription{SpectrumDescription::rgb(0.8f, 0.5f, 0.2f)}); }},
      {"rough conductor",
       [](Description& d) {
         ConductorDescription metal;
         metal.roughness = kBallRoughness;
         add_ball(d, metal);
       }},
      {"rough dielectric",
       [](Description& d) {
         DielectricDescription glass;
         glass.roughness = kBallRoughness;
         add_ball(d, glass);
       }},
      {"rough dielectric, Beckmann, dense",
       [](Description& d) {
         DielectricDescription glass;
         glass.int_ior = 2.2f;
         glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kBeckmann, 0.5f, 0.5f};
         add_ball(d, glass);
       }},
      {"rough plastic",
       [](Description& d) {
         PlasticDescription plastic;
         plastic.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.3f, 0.3f};
         add_ball(d, plastic);
       }},
  };
}

/// Balls of layered materials.
inline std::vector<NamedChange> layered_balls() {
  return {
      {"principled",
       [](Description& d) {
         PrincipledDescription p;
         p.roughness = 0.5f, p.metallic = 0.3f, p.sheen = 0.5f, p.clearcoat = 0.7f, p.clearcoat_gloss = 0.3f;
         add_ball(d, p);
       }},
      {"principled glass",
       [](Description& d) {
         PrincipledDescription p;
         p.roughness = 0.5f, p.spec_trans = 0.9f, p.eta = 1.4f;
         add_ball(d, p);
       }},
      {"thin principled",
       [](Description& d) {
         PrincipledThinDescription p;
         p.roughness = 0.5f, p.spec_trans = 0.5f, p.diff_trans = 1.0f;
         add_ball(d, p);
       }},
      {"Disney",
       [](Description& d) {
         DisneyDescription p;
         p.metallic = 0.3f, p.subsurface = 0.5f, p.sheen = 0.5f, p.clearcoat = 0.5f, p.clearcoat_gloss = 0.2f;
         add_ball(d, p);
       }},
      {"metallic-roughness",
       [](Description& d) {
         MetallicRoughnessDescription p;
         p.metallic = 0.3f, p.roughness = 0.5f, p.sheen_color = SpectrumDescription::rgb(0.2f, 0.4f, 0.3f);
         p.sheen_roughness = 0.5f, p.clearcoat = 0.5f, p.clearcoat_roughness = 0.4f;
         add_ball(d, p);
       }},
      {"thin metallic-roughness",
       [](Description& d) {
         MetallicRoughnessDescription p;
         p.base_color = SpectrumDescription::rgb(0.9f, 0.6f, 0.3f), p.metallic = 0.2f, p.roughness = 0.5f;
         p.transmission = 0.7f, p.specular = 0.5f;
         add_ball(d, p);
       }},
      {"Nori's microfacet",
       [](Description& d) {
         NoriMicrofacetDescription p;
         p.alpha = 0.4f;
         add_ball(d, p);
       }},
  };
}

/// Balls of materials that modify or combine others.
inline std::vector<NamedChange> composite_balls() {
  return {
      {"bump map",
       [](Description& d) {
         add_ball(d, BumpMapDescription{add_hills(d), 0.15f, add_diffuse(d, 0.8f)});
       }},
      {"bumpy glass",
       [](Description& d) {
         DielectricDescription glass;
         glass.roughness = kBallRoughness;
         add_ball(d, BumpMapDescription{add_hills(d), 0.15f, add_material(d, glass)});
       }},
      {"normal map",
       [](Description& d) {
         const TextureId normals = add_checkerboard(d, {0.65f, 0.4f, 0.95f}, {0.3f, 0.55f, 0.9f});
         add_ball(d, NormalMapDescription{normals, false, add_diffuse(d, 0.8f)});
       }},
      {"mask",
       [](Description& d) {
         add_ball(d, MaskDescription{0.4f, add_diffuse(d, 0.8f)});
       }},
      {"blend",
       [](Description& d) {
         const MaterialId parts[2] = {add_diffuse(d, 0.8f), add_two_sided(d, add_diffuse(d, 0.2f))};
         BlendDescription blend{0.3f, {parts[0], parts[1]}};
         add_ball(d, blend);
       }},
  };
}

/// Spheres on the floor, of every material that light tracing supports.
inline std::vector<NamedChange> balls() { return joined({basic_balls(), layered_balls(), composite_balls()}); }

}  // namespace sheaf::light_tracing_cases
