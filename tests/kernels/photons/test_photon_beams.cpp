// Photon beams in media: the search for lines near a ray, and their contribution in the gather_volume stage.
#include "core/sampling/octahedral.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/wave/wave_snapshot.h"
#include "tests/support/capture.h"
#include "tests/support/gathering_testing.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <map>
#include <random>

namespace sheaf::test_photon_beams {

namespace {

constexpr double kExactPi = 3.14159265358979;

using Double3 = std::array<double, 3>;
Double3 to_double(Vec3f a) { return {static_cast<double>(a.x), static_cast<double>(a.y), static_cast<double>(a.z)}; }
double product(const Double3& a, const Double3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Closest approach of a line and a ray, from the condition that the connecting segment is perpendicular to both.
struct Nearest {
  double t, along, distance, cosine, sine;
};
Nearest nearest(Vec3f origin, Vec3f direction, const AccelLine& line) {
  const Double3 o = to_double(origin), d = to_double(direction), s = to_double(line.start),
                e = to_double(line.direction);
  const Double3 w = {s[0] - o[0], s[1] - o[1], s[2] - o[2]};
  const double c = product(d, e), wd = product(w, d), we = product(w, e), dd = product(d, d), ee = product(e, e);
  const double determinant = dd * ee - c * c;
  const double t = (wd * ee - we * c) / determinant, along = (wd * c - we * dd) / determinant;
  Double3 between;
  for (std::size_t i = 0; i < 3; ++i) between[i] = w[i] + along * e[i] - t * d[i];
  return {t, along, std::sqrt(product(between, between)), c, std::sqrt(determinant)};
}

class Randoms {
 public:
  explicit Randoms(unsigned seed) : random_(seed) {}
  float operator()() { return u_(random_); }
  Vec3f vector() { return {(*this)(), (*this)(), (*this)()}; }
  Vec3f direction() { return normalize(vector()); }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<float> u_{-1, 1};
};

/// A box 4 wide and high from z = 2 to z = 10, filled with `medium`; the camera is outside.
Description filled_box(const MediumDescription& medium) {
  Description d = empty_scene(16, 16);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.medium_photons = MediumPhotons::kBeams;
  fill(d, add_shape(d, CubeShape{}, Transform::translate({0, 0, 6}) * Transform::scale({2, 2, 4})),
       add_medium(d, medium));
  add_point_light(d, {0, 1, 6}, 1);
  return d;
}

std::vector<PhotonBeam> random_beams(int count, std::uint32_t medium) {
  Randoms u(5);
  std::vector<PhotonBeam> beams;
  for (int i = 0; i < count; ++i) {
    PhotonBeam beam;
    beam.start = {2 * u(), 2 * u(), 6 + 4 * u()};
    beam.direction = u.direction();
    beam.length = 1 + u();
    beam.power = {1 + u(), 1 + u(), 1 + u(), 0};
    beam.pdf_ratio = {1 + 0.9f * u(), 1 + 0.9f * u(), 1 + 0.9f * u(), 1};
    beam.pdf_ratio = beam.pdf_ratio * (3 / (beam.pdf_ratio.c0 + beam.pdf_ratio.c1 + beam.pdf_ratio.c2));
    beam.medium_key = photon_medium_key(i % 7 == 0 ? medium + 1 : medium, 1 + static_cast<std::uint32_t>(i % 5), false);
    beams.push_back(beam);
  }
  return beams;
}

Double3 colors(const Spectrum4& s) {
  return {static_cast<double>(s.c0), static_cast<double>(s.c1), static_cast<double>(s.c2)};
}

/// The kernel on [-r, r] at distance `away` * r, times r.
double kernel_across(PhotonKernel kernel, double away) {
  switch (kernel) {
    case PhotonKernel::kDisc:
      return 0.5;
    case PhotonKernel::kCone:
      return 1 - away;
    case PhotonKernel::kEpanechnikov:
      return 0.75 * (1 - away * away);
  }
  return 0;
}

}  // namespace

TEST_CASE("line query: every beam near a ray is found once however beams are split") {
  Randoms u(1);
  std::vector<AccelLine> lines;
  for (int i = 0; i < 1500; ++i) lines.push_back({u.vector(), u.direction(), i % 10 == 0 ? 0.01f : 1.5f * (1 + u())});
  constexpr float kRadius = 0.05f;
  const LineAccel whole(lines, kRadius, 100), cut(lines, kRadius, 0.1f), shreds(lines, kRadius, 1e-3f);
  std::size_t in_all = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3f origin = u.vector(), direction = u.direction();
    const float length = 1 + u();
    std::map<std::uint32_t, NearLine> found[3];
    for (int variant = 0; variant < 3; ++variant) {
      std::vector<NearLine> near;
      (variant == 0 ? whole : variant == 1 ? cut : shreds).near_ray(origin, direction, length, near);
      for (const NearLine& line : near) CHECK(found[variant].emplace(line.index, line).second);
      CHECK(found[variant].size() == found[0].size());
      for (const auto& [index, line] : found[variant]) {
        REQUIRE(found[0].count(index) == 1);
        CHECK(found[0][index].t == line.t);
        CHECK(found[0][index].along == line.along);
        CHECK(found[0][index].squared == line.squared);
      }
    }
    for (std::uint32_t k = 0; k < lines.size(); ++k) {
      const Nearest n = nearest(origin, direction, lines[k]);
      const double radius = static_cast<double>(kRadius), far = static_cast<double>(length),
                   end = static_cast<double>(lines[k].length);
      // Skip lines at the limit of the search range.
      if (std::min({std::fabs(n.t), std::fabs(n.t - far), std::fabs(n.along), std::fabs(n.along - end),
                    std::fabs(n.distance - radius)}) < 1e-5 / n.sine)
        continue;
      const bool is_within = n.t > 0 && n.t < far && n.along > 0 && n.along < end && n.distance < radius;
      CHECK(found[0].count(k) == (is_within ? 1 : 0));
      if (!is_within || found[0].count(k) == 0) continue;
      const NearLine& line = found[0][k];
      CHECK(static_cast<double>(line.t) == near(n.t, 1e-3));
      CHECK(static_cast<double>(line.along) == near(n.along, 1e-3));
      CHECK(std::sqrt(static_cast<double>(line.squared)) == near(n.distance / radius, 2e-3));
      CHECK(static_cast<double>(line.cosine) == within(n.cosine, 1e-4 * std::fabs(n.cosine) + 1e-7));
      CHECK(static_cast<double>(line.sine) == near(n.sine, 1e-4));
    }
    in_all += found[0].size();
  }
  CHECK(in_all > 1000);
  std::vector<NearLine> none;
  LineAccel().near_ray({0, 0, 0}, {0, 0, 1}, 1, none);
  // Parallel lines have no unique closest point.
  LineAccel({{{0.01f, 0, 0}, {0, 0, 1}, 1}}, kRadius, 1).near_ray({0, 0, 0}, {0, 0, 1}, 1, none);
  CHECK(none.empty());
}

namespace {

/// A medium and how its beams are gathered.
struct BeamCase {
  std::array<float, 3> extinction;
  float g;
  PhotonKernel kernel;
  int max_depth;
  MediumEstimator estimator;
};

constexpr double kBeamRadius = 0.1;
constexpr Double3 kAlbedo = {0.8, 0.6, 0.9};

/// Radiance that beams scatter towards a ray along z from `origin`.
Double3 gathered_by_hand(const BeamCase& c, Vec3f origin, const std::vector<PhotonBeam>& beams) {
  Double3 sum{}, sigma;
  for (std::size_t k = 0; k < 3; ++k) sigma[k] = static_cast<double>(c.extinction[k]);
  for (const PhotonBeam& beam : beams) {
    const Nearest n = nearest(origin, {0, 0, 1}, {beam.start, beam.direction, beam.length});
    const auto edges = static_cast<int>(beam.medium_key & kMaxPhotonEdges);
    if (n.t <= 0 || n.t >= 7.5 || n.along < 0 || n.along >= static_cast<double>(beam.length) ||
        n.distance >= kBeamRadius || (c.max_depth > 0 && edges > c.max_depth - 1) || beam.medium_key >> 8 != 1)
      continue;
    const double g = static_cast<double>(c.g);
    // Light continues along the beam; the ray is traced backwards.
    const double phase = (1 - g * g) / (4 * kExactPi * std::pow(1 + g * g + 2 * g * n.cosine, 1.5));
    const Double3 power = colors(beam.power), pdf_ratio = colors(beam.pdf_ratio);
    // Probability that the beam reaches this distance, with each lane's extinction or with the maximum one.
    double comes = 0;
    for (std::size_t k = 0; k < 3; ++k)
      comes += pdf_ratio[k] / 3 * std::exp(-n.along * (c.estimator == MediumEstimator::kRatio ? sigma[1] : sigma[k]));
    for (std::size_t k = 0; k < 3; ++k)
      sum[k] += std::exp(-sigma[k] * (n.t + n.along)) / comes * power[k] / 1000 * sigma[k] * kAlbedo[k] * phase *
                kernel_across(c.kernel, n.distance / kBeamRadius) / kBeamRadius / n.sine;
  }
  return sum;
}

}  // namespace

TEST_CASE("gather volume: SIMD beam results equal scalar ones and the sum over all beams") {
  for (const BeamCase& c :
       {BeamCase{{0.2f, 0.2f, 0.2f}, 0.0f, PhotonKernel::kDisc, -1, MediumEstimator::kNullMis},
        BeamCase{{0.3f, 0.6f, 0.1f}, 0.7f, PhotonKernel::kCone, 4, MediumEstimator::kNullMis},
        BeamCase{{0.3f, 0.6f, 0.1f}, -0.4f, PhotonKernel::kEpanechnikov, 3, MediumEstimator::kRatio}}) {
    CAPTURE(c.g);
    MediumDescription medium;
    medium.coefficients =
        ExtinctionAlbedoDescription{SpectrumDescription::rgb(c.extinction[0], c.extinction[1], c.extinction[2]),
                                    SpectrumDescription::rgb(0.8f, 0.6f, 0.9f)};
    Description d = filled_box(medium);
    d.integrator.max_depth = c.max_depth;
    d.integrator.medium_estimator = c.estimator;
    d.media[0].phase = add_phase(d, c.g);
    const auto scene = compile_scene(d);
    const std::vector<PhotonBeam> beams = random_beams(3000, 1);
    const VolumePhotonMaps volume{{}, PhotonBeamMap({beams}, 1000, static_cast<float>(kBeamRadius), 0.4f, c.kernel)};
    const PhotonMaps maps{{}, {}, PhotonGathering::kAll, &volume};
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
    for (const Slot slot : slots) {
      const Double3 sum = gathered_by_hand(c, wide.wave.rays.get(slot).origin, beams);
      CHECK(sum[0] > 0);
      const Double3 by_wide = colors(wide.wave.radiance.row(slot).radiance),
                    by_scalar = colors(scalar.wave.radiance.row(slot).radiance),
                    left = colors(wide.wave.paths.get(slot).beta);
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(by_wide[k] == near(sum[k], 3e-3));
        CHECK(by_scalar[k] == near(sum[k], 3e-3));
        CHECK(left[k] == near(std::exp(-static_cast<double>(c.extinction[k]) * 7.5), 1e-4));
      }
    }
  }
}

TEST_CASE("gather volume: homogeneous media use beams where enabled and grids use points") {
  const TemporaryFolder folder;
  const auto file = write_vol(folder.path() / "even.vol", 4, 1, [](Vec3f, int) { return 1.0f; });
  MediumDescription even = fog(0.3f, 0.8f), grid = even;
  grid.density = vol(file, Transform::translate({-2, -2, 2}) * Transform::scale({4, 4, 8}));
  Photon photon;
  photon.p = {0, 0, 8};
  photon.power = Spectrum4(1.0f);
  photon.direction = encode_octahedral<Scalar>({0, 1, 0});
  photon.surface = photon_medium_key(1, 1, false);
  PhotonBeam beam;
  beam.start = {0, -1, 7}, beam.direction = {0, 1, 0}, beam.length = 2;
  beam.power = beam.pdf_ratio = Spectrum4(1.0f);
  beam.medium_key = photon.surface;
  const VolumePhotonMaps volume{VolumePhotonMap({{photon}}, 1, 0.5f, PhotonKernel::kDisc),
                                PhotonBeamMap({{beam}}, 1, 0.5f, 1, PhotonKernel::kDisc)};
  const PhotonMaps maps{{}, {}, PhotonGathering::kAll, &volume};
  const auto found = [&](const MediumDescription& medium, MediumPhotons kept, float y) {
    Description d = filled_box(medium);
    d.integrator.photons.medium_photons = kept;
    const auto scene = compile_scene(d);
    TestWave test(20, 0);
    StageContext context = test.context(*scene);
    context.gather_from(maps);
    double sum = 0;
    for (context.sampler.seed = 0; context.sampler.seed < 20; ++context.sampler.seed) {
      const Slot slot = add_ray_in_medium(test, {0, y, 2});
      gather_volume<Wide>(context, test.wave);
      sum += static_cast<double>(test.wave.radiance.row(slot).radiance.c1) / 20;
    }
    return sum;
  };
  const double phase = 1 / (4 * kExactPi), by_beam = std::exp(-0.3 * 5) * 0.24 * phase;
  const double by_point = std::exp(-0.3 * 6) * phase / (kExactPi * 0.25);
  // One ray passes only the beam, the other passes the photon too.
  constexpr float kBeamAlone = 0.8f, kBoth = 0.1f;
  for (const float y : {kBeamAlone, kBoth}) {
    CHECK(found(even, MediumPhotons::kBeams, y) / by_beam == near(1, 1e-4));
    for (const MediumPhotons kept : {MediumPhotons::kPoints, MediumPhotons::kAuto})
      CHECK(found(even, kept, y) / by_point == near(y == kBoth ? 1 : 0, 1e-4));
  }
  CHECK(found(grid, MediumPhotons::kBeams, kBeamAlone) == 0);
  // Transmittance is random in grids.
  CHECK(found(grid, MediumPhotons::kBeams, kBoth) > 0.3 * by_point);
}

}  // namespace sheaf::test_photon_beams
