// Photons in media: the search near a ray, and their contribution in the gather_volume stage.
#include "kernels/photons/volume_photon_map.h"

#include "core/sampling/octahedral.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/wave/wave_snapshot.h"
#include "tests/support/capture.h"
#include "tests/support/gathering_testing.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <set>

namespace sheaf::test_volume_photons {

namespace {

constexpr double kExactPi = 3.14159265358979;

/// A box 4 wide and high from z = 2 to z = 10, filled with `medium`, in front of a floor; the camera is outside.
Description filled_box(const MediumDescription& medium) {
  Description d = empty_scene(16, 16);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  fill(d, add_shape(d, CubeShape{}, Transform::translate({0, 0, 6}) * Transform::scale({2, 2, 4})),
       add_medium(d, medium));
  add_point_light(d, {0, 1, 6}, 1);
  return d;
}

std::vector<Photon> random_photons(int count, std::uint32_t medium) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<Photon> photons;
  for (int i = 0; i < count; ++i) {
    Photon photon;
    photon.p = {2 * u(random), 2 * u(random), 6 + 4 * u(random)};
    photon.power = {1 + u(random), 1 + u(random), 1 + u(random), 0};
    photon.direction = encode_octahedral<Scalar>(normalize(Vec3f{u(random), u(random), u(random)}));
    photon.surface = photon_medium_key(i % 7 == 0 ? medium + 1 : medium, 1 + static_cast<std::uint32_t>(i % 5), false);
    photons.push_back(photon);
  }
  return photons;
}

}  // namespace

TEST_CASE("point query: every point near a ray is found once") {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<AccelPoint> points;
  for (int i = 0; i < 3000; ++i) points.push_back({u(random), u(random), u(random), 0.02f + 0.05f * (1 + u(random))});
  const PointAccel accel{std::vector(points)};
  std::size_t in_all = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3f origin{u(random), u(random), u(random)}, direction = normalize(Vec3f{u(random), u(random), u(random)});
    const float length = 1 + u(random);
    std::vector<NearPoint> found;
    accel.near_ray(origin, direction, length, found);
    std::multiset<std::uint32_t> indices;
    for (const NearPoint& point : found) indices.insert(point.index);
    for (std::uint32_t k = 0; k < points.size(); ++k) {
      const Vec3f from = Vec3f{points[k].x, points[k].y, points[k].z} - origin;
      const float t = dot(from, direction);
      const Vec3f across = from - direction * t;
      const float away = std::sqrt(dot(across, across));
      // Skip photons at the limit of the search range.
      if (std::min({std::fabs(t), std::fabs(t - length), std::fabs(away - points[k].radius)}) < 1e-5f) continue;
      CHECK(indices.count(k) == (t > 0 && t < length && away < points[k].radius ? 1 : 0));
    }
    for (const NearPoint& point : found) {
      const AccelPoint& p = points[point.index];
      const Vec3f from = Vec3f{p.x, p.y, p.z} - origin;
      CHECK(point.t == near(dot(from, direction), 1e-4));
      const Vec3f across = from - direction * point.t;
      CHECK(point.squared == near(dot(across, across) / (p.radius * p.radius), 1e-3));
    }
    in_all += found.size();
  }
  CHECK(in_all > 1000);
  std::vector<NearPoint> none;
  PointAccel().near_ray({0, 0, 0}, {0, 0, 1}, 1, none);
  CHECK(none.empty());
}

TEST_CASE("gather volume: SIMD photon results equal scalar ones and the sum over all photons") {
  MediumDescription medium;
  medium.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.1f, 0.2f, 0.05f),
                                                    SpectrumDescription::rgb(0.8f, 0.6f, 0.9f)};
  for (const auto& [g, kernel, max_depth] :
       {std::tuple{0.0f, PhotonKernel::kDisc, -1}, std::tuple{0.7f, PhotonKernel::kCone, 4},
        std::tuple{-0.4f, PhotonKernel::kEpanechnikov, 3}}) {
    CAPTURE_BINDING(g);
    Description d = filled_box(medium);
    d.integrator.max_depth = max_depth;
    d.media[0].phase = add_phase(d, g);
    const auto scene = compile_scene(d);
    const std::vector<Photon> photons = random_photons(20000, 1);
    const VolumePhotonMaps map{VolumePhotonMap({photons}, 1000, 0.3f, kernel), {}};
    const PhotonMaps maps{{}, {}, PhotonGathering::kAll, &map};
    TestWave wide(24, 0), scalar(24, 0);
    StageContext context = wide.context(*scene);
    context.gather_from(maps);
    std::vector<Slot> slots;
    for (int i = 0; i < 20; ++i)
      slots.push_back(add_ray_in_medium(wide, {-1.5f + 0.15f * static_cast<float>(i), 0.3f, 2.5f}));
    WaveSnapshot(wide.wave).restore(scalar.wave);
    gather_volume<Wide>(context, wide.wave);
    gather_volume<Single>(context, scalar.wave);
    CHECK(wide.wave.medium.empty());
    const auto extinction = std::array{0.1, 0.2, 0.05};
    for (const Slot slot : slots) {
      const Spectrum4 a = wide.wave.radiance.row(slot).radiance, b = scalar.wave.radiance.row(slot).radiance;
      const Vec3f origin = wide.wave.rays.get(slot).origin;
      std::array<double, 3> sum{};
      for (const Photon& photon : photons) {
        const double x = static_cast<double>(photon.p.x - origin.x), y = static_cast<double>(photon.p.y - origin.y),
                     t = static_cast<double>(photon.p.z - origin.z), away = std::hypot(x, y) / 0.3;
        const auto edges = static_cast<int>(photon.surface & kMaxPhotonEdges);
        if (t <= 0 || away >= 1 || (max_depth > 0 && edges > max_depth - 1) || photon.surface >> 8 != 1) continue;
        const double k = kernel == PhotonKernel::kDisc   ? 1
                         : kernel == PhotonKernel::kCone ? 3 * (1 - away)
                                                         : 2 * (1 - away * away);
        // Light continues to the camera along -z; it arrives from direction `from`.
        const Vec3f from = decode_octahedral<Scalar>(photon.direction);
        const double cosine = static_cast<double>(from.z), gg = static_cast<double>(g);
        const double phase = (1 - gg * gg) / (4 * kExactPi * std::pow(1 + gg * gg - 2 * gg * cosine, 1.5));
        const float power[3] = {photon.power.c0, photon.power.c1, photon.power.c2};
        for (std::size_t c = 0; c < 3; ++c)
          sum[c] += std::exp(-extinction[c] * t) * phase * k / (kExactPi * 0.09) * static_cast<double>(power[c]) / 1000;
      }
      CHECK(sum[0] > 0);
      const float wide_found[3] = {a.c0, a.c1, a.c2}, scalar_found[3] = {b.c0, b.c1, b.c2};
      const Spectrum4 beta = wide.wave.paths.get(slot).beta;
      const float left[3] = {beta.c0, beta.c1, beta.c2};
      for (std::size_t c = 0; c < 3; ++c) {
        CHECK(static_cast<double>(wide_found[c]) == near(sum[c], 2e-3));
        CHECK(static_cast<double>(scalar_found[c]) == near(sum[c], 2e-3));
        CHECK(static_cast<double>(left[c]) == near(std::exp(-extinction[c] * 7.5), 1e-4));
      }
    }
  }
}

TEST_CASE("gather volume: transmittance in a grid is unbiased up to each photon and beyond") {
  const TemporaryFolder folder;
  // Density increases along z from 0 to 1 in 32 voxels.
  const auto file = write_vol(folder.path() / "ramp.vol", 32, 1, [](Vec3f p, int) { return p.z; });
  MediumDescription medium = fog(0.3f, 0.8f);
  medium.density = vol(file, Transform::translate({-2, -2, 2}) * Transform::scale({4, 4, 8}));
  Description d = filled_box(medium);
  const auto scene = compile_scene(d);
  Photon photon;
  photon.p = {0, 0, 8};
  photon.power = {1, 2, 3, 0};
  photon.direction = encode_octahedral<Scalar>({0, 1, 0});
  photon.surface = photon_medium_key(1, 1, false);
  const VolumePhotonMaps map{VolumePhotonMap({{photon}}, 1, 0.5f, PhotonKernel::kDisc), {}};
  const PhotonMaps maps{{}, {}, PhotonGathering::kAll, &map};
  MeanVariance found, left;
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    TestWave test(32, 0);
    StageContext context = test.context(*scene);
    context.gather_from(maps);
    context.sampler.seed = seed;
    std::vector<Slot> slots;
    for (int i = 0; i < 32; ++i) slots.push_back(add_ray_in_medium(test, {0.1f, 0.1f, 2.0f}));
    gather_volume<Wide>(context, test.wave);
    for (const Slot slot : slots) {
      found.add(static_cast<double>(test.wave.radiance.row(slot).radiance.c1));
      left.add(static_cast<double>(test.wave.paths.get(slot).beta.c0));
    }
  }
  // The integral of the density, which is linear between voxel centers and constant in the outer half voxels.
  const auto depth = [](double z) {  // z in [0, 1] of the box
    const double half = 0.5 / 32;
    double sum = 0;
    for (int i = 0; i < 4000; ++i) {
      const double at = z * (i + 0.5) / 4000;
      sum += std::clamp(at, half, 1 - half) * z / 4000;
    }
    return 0.3 * 8 * sum;
  };
  const double expected = std::exp(-depth(0.75)) * 2 / (4 * kExactPi) / (kExactPi * 0.25);
  const double level = significance_of_each(2);
  INFO("found " << found.mean() << ", expected " << expected << "; left " << left.mean() << ", expected "
                << std::exp(-depth(1)));
  CHECK(found.p_value(expected) >= level);
  CHECK(left.p_value(std::exp(-depth(1))) >= level);
}

}  // namespace sheaf::test_volume_photons
