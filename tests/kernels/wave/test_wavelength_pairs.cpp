// Spectral mode: connections of a camera path, a vertex and a photon, each of which may have kept only one wavelength.
// The factor 4 of the remaining wavelength must count once. Also tests the wavelength flags of photons, and the lane
// that samples their flight distances.
#include "core/sampling/octahedral.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/wave/path_wavelengths.h"
#include "scene/data/glasses.h"
#include "tests/support/capture.h"
#include "tests/support/gathering_testing.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

namespace sheaf::test_wavelength_pairs {

namespace {

const CompileOptions kSpectral{.color = ColorMode::kSpectral};

/// Rescaled path pdfs that differ between lanes.
const Spectrum4 kUnequal{2, 1, 0.5f, 3.5f};
constexpr double kUnequalMean = 1.75, kUnequalFirst = 2;

void keep_one_wavelength(Wave& wave, Slot slot) {
  wave.wavelength_samples[slot] = bits_float(float_bits(wave.wavelength_samples[slot]) | kSingleWavelength);
}

/// A sheet of rough flint glass beside a gray wall, both at z = 4 in front of the camera, and a medium out of sight.
Description sheet_and_wall() {
  Description d = empty_scene(16, 16);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  DielectricDescription flint;
  flint.int_dispersion = *find_dispersion("sf11");
  flint.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.4f, 0.4f};
  const auto at = [](float x) { return Transform::translate({x, 0, 4}) * Transform::rotate({0, 1, 0}, 180); };
  add_rectangle(d, at(-1), add_material(d, flint));
  add_rectangle(d, at(1), add_diffuse(d, 0.5f));
  fill(d, add_sphere(d, {0, 0, -9}, 1), add_medium(d, fog(1, 0.5f)));
  return d;
}

/// Photons around the sheet and the wall that arrive from behind them, or from the camera's side.
std::vector<Photon> photons_at_sheet(bool from_behind, bool single_wavelength) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<Photon> photons(20'000);
  for (Photon& photon : photons) {
    photon.p = {2 * u(random), u(random), 4};
    photon.power = Spectrum4(1.0f);
    const Vec3f from = normalize(Vec3f{0.5f * u(random), 0.5f * u(random), from_behind ? 1.0f : -1.0f});
    photon.direction = encode_octahedral<Scalar>(from);
    photon.surface = photon_surface(encode_octahedral<Scalar>(Vec3f{0, 0, 1}), 1, single_wavelength);
  }
  return photons;
}

struct Gathered {
  ClosureKind kind;
  Spectrum4 radiance;
};

/// Results of the gather stage at each path's vertex, in a fixed order.
template <class L>
std::vector<Gathered> gather_at_sheet(const Scene& scene, const PhotonMap& map, bool single_path, Spectrum4 r_u) {
  const PhotonMaps maps{map.view(), {}, PhotonGathering::kAll};
  TestWave test(256, 0);
  test.begin({0, 0, 16, 16}, 0, 1, 16);
  StageContext context = test.context(scene);
  context.gather_from(maps);
  const auto run = [&](Stage stage) { kStages<L>[static_cast<std::size_t>(stage)].run(context, test.wave); };
  run(stage_named("camera_rays"));
  run(stage_named("intersect"));
  for (const Slot slot : test.wave.surface.span()) {
    if (single_path) keep_one_wavelength(test.wave, slot);
    test.wave.rescaled_pdfs.row(slot).r_u = r_u;
  }
  run(stage_named("sort_surfaces"));
  run(stage_named("surface_inputs"));
  gather<L>(context, test.wave);
  std::vector<Gathered> found;
  for (const ClosureKind kind : {kClosureKind<DispersiveRoughDielectricGgxClosure>, kClosureKind<DiffuseClosure>}) {
    const VertexRun& vertices = test.wave.runs[static_cast<int>(kind)];
    for (int i = 0; i < vertices.count; ++i)
      found.push_back({kind, test.wave.radiance.row(test.wave.sorted[vertices.slot_begin + i]).radiance});
  }
  return found;
}

std::array<double, 4> lanes(const Spectrum4& s) {
  return {static_cast<double>(s.c0), static_cast<double>(s.c1), static_cast<double>(s.c2), static_cast<double>(s.c3)};
}

}  // namespace

TEST_CASE("gather: the factor four of single wavelengths is applied once over path and vertex and photon") {
  const auto scene = compile_scene(sheet_and_wall(), kSpectral);
  for (const bool from_behind : {false, true}) {
    const PhotonMap whole({photons_at_sheet(from_behind, false)}, 1000, 0.3f, PhotonKernel::kDisc);
    const PhotonMap single({photons_at_sheet(from_behind, true)}, 1000, 0.3f, PhotonKernel::kDisc);
    const auto base = gather_at_sheet<Wide>(*scene, whole, false, Spectrum4(1.0f));
    int checked[2] = {0, 0};
    for (const bool single_path : {false, true})
      for (const bool single_photon : {false, true})
        for (const bool unequal : {false, true}) {
          if (single_path && unequal) continue;  // the pdfs of the other lanes are no longer used
          CAPTURE(from_behind);
          CAPTURE(single_path);
          CAPTURE(single_photon);
          CAPTURE(unequal);
          const PhotonMap& map = single_photon ? single : whole;
          const Spectrum4 r_u = unequal ? kUnequal : Spectrum4(1.0f);
          const auto by_wide = gather_at_sheet<Wide>(*scene, map, single_path, r_u);
          const auto by_single = gather_at_sheet<Single>(*scene, map, single_path, r_u);
          REQUIRE(by_wide.size() == base.size());
          for (std::size_t i = 0; i < base.size(); ++i) {
            const bool disperses = base[i].kind == kClosureKind<DispersiveRoughDielectricGgxClosure>;
            if (!(base[i].radiance.c0 > 0)) continue;
            ++checked[disperses ? 0 : 1];
            const bool single_vertex = disperses && from_behind && !single_path;
            double factor = (single_path || single_vertex) && single_photon ? 0.25 : 1;
            // If the vertex keeps only the first wavelength, the base value already has the factor 4.
            if (disperses && from_behind && single_path) factor *= 0.25;
            if (unequal) factor /= single_vertex || single_photon ? kUnequalFirst : kUnequalMean;
            const auto expected = lanes(base[i].radiance), wide = lanes(by_wide[i].radiance),
                       narrow = lanes(by_single[i].radiance);
            for (std::size_t c = 0; c < (single_path ? 1 : 4); ++c) {
              if (!(expected[c] > 0)) {
                CHECK(wide[c] == 0);
                continue;
              }
              CHECK(wide[c] / expected[c] == near(factor, 2e-3));
              CHECK(narrow[c] / expected[c] == near(factor, 2e-3));
            }
          }
        }
    // Only the sheet transmits light.
    CHECK(checked[0] > 80);
    CHECK((from_behind ? checked[1] == 0 : checked[1] > 80));
  }
}

namespace {

/// Colored fog from z = 2 to z = 10 with albedo 0.8 at all wavelengths.
Description colored_box(MediumPhotons kept) {
  Description d = empty_scene(16, 16);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.medium_photons = kept;
  MediumDescription medium;
  medium.coefficients =
      ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.5f, 0.2f, 0.05f), SpectrumDescription::constant(0.8f)};
  fill(d, add_shape(d, CubeShape{}, Transform::translate({0, 0, 6}) * Transform::scale({2, 2, 4})),
       add_medium(d, medium));
  add_point_light(d, {0, 1, 6}, 1);
  return d;
}

constexpr std::array<double, 4> kRelativePdfs = {0.4, 1.6, 0.8, 1.2};  // their mean is 1

struct InMedium {
  std::array<double, 4> radiance, sigma_t;
};

/// The contribution of one photon to a ray from (0, 0, 2) along z: a point at z = 6 and a beam from (0, -1, 7) upwards.
template <class L> InMedium gather_in_medium(MediumPhotons kept, bool single_ray, bool single_photon) {
  const auto scene = compile_scene(colored_box(kept), kSpectral);
  Photon photon;
  photon.p = {0, 0, 6};
  photon.power = {1, 2, 3, 4};
  photon.direction = encode_octahedral<Scalar>({0, 1, 0});
  photon.surface = photon_medium_key(1, 1, single_photon);
  PhotonBeam beam;
  beam.start = {0, -1, 7}, beam.direction = {0, 1, 0}, beam.length = 2;
  beam.power = photon.power;
  beam.pdf_ratio = {static_cast<float>(kRelativePdfs[0]), static_cast<float>(kRelativePdfs[1]),
                    static_cast<float>(kRelativePdfs[2]), static_cast<float>(kRelativePdfs[3])};
  beam.medium_key = photon.surface;
  const VolumePhotonMaps volume{VolumePhotonMap({{photon}}, 1, 0.5f, PhotonKernel::kDisc),
                                PhotonBeamMap({{beam}}, 1, 0.5f, 1, PhotonKernel::kDisc)};
  const PhotonMaps maps{{}, {}, PhotonGathering::kAll, &volume};
  TestWave test(20, 0);
  StageContext context = test.context(*scene);
  context.gather_from(maps);
  const Slot slot = add_ray_in_medium(test, {0, 0, 2});
  test.wave.wavelength_samples[slot] = 0.3f;
  if (single_ray) keep_one_wavelength(test.wave, slot);
  gather_volume<L>(context, test.wave);
  InMedium out{lanes(test.wave.radiance.row(slot).radiance), lanes(test.wave.paths.get(slot).beta)};
  for (double& passed : out.sigma_t) passed = -std::log(passed) / 8;
  return out;
}

}  // namespace

TEST_CASE_TEMPLATE("gather volume: the factor four of single wavelengths is applied once over ray and photon", L,
                   SHEAF_STAGE_LANES) {
  constexpr double kPi = 3.14159265358979, kPhase = 1 / (4 * kPi);
  const std::array<double, 4> sigma = gather_in_medium<L>(MediumPhotons::kPoints, false, false).sigma_t;
  REQUIRE(std::fabs(sigma[0] - sigma[2]) > 0.05 * sigma[0]);
  for (const bool single_ray : {false, true})
    for (const bool single_photon : {false, true}) {
      CAPTURE(single_ray);
      CAPTURE(single_photon);
      const double once = single_ray && single_photon ? 0.25 : 1;
      const auto points = gather_in_medium<L>(MediumPhotons::kPoints, single_ray, single_photon).radiance;
      const auto beams = gather_in_medium<L>(MediumPhotons::kBeams, single_ray, single_photon).radiance;
      double comes = 0;  // probability that the beam reaches the ray, averaged over the sampling lanes
      for (std::size_t c = 0; c < 4; ++c) comes += 0.25 * kRelativePdfs[c] * std::exp(-sigma[c]);
      // For rays and photons of one wavelength the other lanes are empty.
      for (std::size_t c = 0; c < (single_ray || single_photon ? 1 : 4); ++c) {
        CAPTURE(c);
        const double power = static_cast<double>(c + 1);
        const double by_point = std::exp(-4 * sigma[c]) * power * kPhase / (kPi * 0.25);
        const double fraction = single_photon ? 1 : std::exp(-sigma[c]) / comes;
        const double by_beam = std::exp(-5 * sigma[c]) * power * fraction * 0.8 * sigma[c] * kPhase * 0.5 / 0.5;
        CHECK(points[c] / (by_point * once) == near(1, 2e-3));
        CHECK(beams[c] / (by_beam * once) == near(1, 2e-3));
      }
    }
}

TEST_CASE_TEMPLATE("photons in media record whether one wavelength is left as points and as beams", L,
                   SHEAF_STAGE_LANES) {
  for (const MediumPhotons kept : {MediumPhotons::kPoints, MediumPhotons::kBeams}) {
    const auto scene = compile_scene(colored_box(kept), kSpectral);
    TestWave test(400, 0);
    StageContext context = test.photon_context(*scene, 400);
    test.photons.begin(7, 400, PhotonKind::kVolume);
    std::vector<bool> is_single(400);
    for (std::uint32_t i = 0; i < 400; ++i) {
      const Slot slot = add_ray_in_medium(test, {0, 0, 2});
      test.wave.paths.row(slot).pixel = kPhotonPixel;
      test.wave.paths.row(slot).sample = i;
      test.wave.wavelength_samples[slot] = 0.3f;
      is_single[i] = i % 3 == 0;
      if (is_single[i]) keep_one_wavelength(test.wave, slot);
    }
    for (const Stage stage : {stage_named("medium"), stage_named("sort_surfaces"), stage_named("surface_inputs"),
                              stage_named("store_photons")})
      kStages<L>[static_cast<std::size_t>(stage)].run(context, test.wave);
    int seen[2] = {0, 0};
    const auto check = [&](std::uint32_t medium_key, std::uint32_t order) {
      const bool single = is_single[order >> kVertexBits];
      CHECK(((medium_key & kPhotonSingleWavelength) != 0) == single);
      ++seen[single ? 1 : 0];
    };
    for (const Photon& photon : test.photons.stored) check(photon.surface, photon.order);
    for (const PhotonBeam& beam : test.photons.beams) check(beam.medium_key, beam.order);
    CHECK(test.photons.stored.empty() == (kept == MediumPhotons::kBeams));
    CHECK(test.photons.beams.empty() == (kept == MediumPhotons::kPoints));
    CHECK(std::min(seen[0], seen[1]) > 50);
  }
}

TEST_CASE_TEMPLATE("photons on surfaces record whether one wavelength is left", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(sheet_and_wall(), kSpectral);
  TestWave test(60, 0);
  StageContext context = test.photon_context(*scene, 60);
  test.photons.begin(7, 60, PhotonKind::kAll);
  for (std::uint32_t i = 0; i < 60; ++i) {
    const Slot slot = test.add_active({-1.9f + 0.06f * static_cast<float>(i), 0, 0}, {0, 0, 1});
    test.wave.paths.row(slot).pixel = kPhotonPixel;
    test.wave.paths.row(slot).sample = i;
    test.wave.rescaled_pdfs.row(slot) = {Spectrum4(1.0f), Spectrum4(1.0f)};
    test.wave.distance_since_vertex[slot] = 0;
    test.wave.wavelength_samples[slot] = 0.3f;
    if (i % 3 == 0) keep_one_wavelength(test.wave, slot);
  }
  for (const Stage stage : {stage_named("intersect"), stage_named("sort_surfaces"), stage_named("surface_inputs"),
                            stage_named("store_photons")})
    kStages<L>[static_cast<std::size_t>(stage)].run(context, test.wave);
  REQUIRE(test.photons.stored.size() > 50);
  for (const Photon& photon : test.photons.stored)
    CHECK(((photon.surface & kPhotonSingleWavelength) != 0) == ((photon.order >> kVertexBits) % 3 == 0));
}

TEST_CASE_TEMPLATE("shadow rays through dispersive surfaces keep the pdf of the hero wavelength", L,
                   SHEAF_STAGE_LANES) {
  for (const bool photons : {false, true})
    for (const bool single_path : {false, true}) {
      CAPTURE(photons);
      CAPTURE(single_path);
      Description d = sheet_and_wall();
      for (const float z : {1.0f, 7.0f}) add_point_light(d, {-1, 0, z}, 1);
      d.integrator.kind = photons ? IntegratorKind::kLightTracer : IntegratorKind::kPath;
      const auto scene = compile_scene(d, kSpectral);
      TestWave test(200, 0);
      StageContext context = photons ? test.photon_context(*scene, 200) : test.context(*scene);
      Wave& wave = test.wave;
      for (int i = 0; i < 200; ++i) {
        // Towards the sheet and the wall, every other ray from behind.
        const bool behind = i % 2 == 1;
        const float x = -1.9f + 0.019f * static_cast<float>(i);
        const Slot slot = test.add_active({x, 0.3f, behind ? 6.0f : 2.0f}, {0, 0, behind ? -1.0f : 1.0f});
        wave.rescaled_pdfs.row(slot) = {single_path ? Spectrum4(2.0f) : kUnequal, Spectrum4(1.0f)};
        wave.distance_since_vertex[slot] = 0;
        wave.wavelength_samples[slot] = 0.3f;
        if (single_path) keep_one_wavelength(wave, slot);
      }
      const auto run = [&](Stage stage) { kStages<L>[static_cast<std::size_t>(stage)].run(context, wave); };
      for (const Stage stage : {stage_named("intersect"), stage_named("sort_surfaces"), stage_named("surface_inputs")})
        run(stage);
      if (photons) {
        run(stage_named("camera_connections"));
      } else {
        run(stage_named("light_candidates"));
        run(stage_named("resample"));
      }
      int count[2] = {0, 0};
      for (int i = 0; i < wave.shadow_count; ++i) {
        const ShadowItem<Scalar> ray = wave.shadows.template load<Scalar>(i);
        const Spectrum4 r_u = wave.transmittances.template load<Scalar>(i).r_u;
        const Vec3f along = wave.rays.get(static_cast<Slot>(ray.slot)).direction;
        // Only the sheet transmits light.
        const bool single = !single_path && along.z * ray.direction.z > 0;
        const Spectrum4 before = single_path ? Spectrum4(2.0f) : kUnequal;
        const Spectrum4 expected = single ? Spectrum4{4 * before.c0, 0, 0, 0} : before;
        ++count[single ? 1 : 0];
        CHECK(lanes(r_u) == lanes(expected));
      }
      CHECK(count[0] > 20);
      CHECK((single_path ? count[1] == 0 : count[1] > 20));
    }
}

TEST_CASE_TEMPLATE("scatter: dispersed paths keep the pdf of their wavelength and stored photons the mean of all", L,
                   SHEAF_STAGE_LANES) {
  enum class Who { kPath, kTracedPhoton, kStoredPhoton };
  for (const Who who : {Who::kPath, Who::kTracedPhoton, Who::kStoredPhoton}) {
    CAPTURE(static_cast<int>(who));
    Description d = sheet_and_wall();
    d.integrator.kind = who == Who::kPath           ? IntegratorKind::kPath
                        : who == Who::kTracedPhoton ? IntegratorKind::kLightTracer
                                                    : IntegratorKind::kPhotonMapper;
    const auto scene = compile_scene(d, kSpectral);
    TestWave test(200, 0);
    StageContext context = who == Who::kPath ? test.context(*scene) : test.photon_context(*scene, 200);
    if (who == Who::kStoredPhoton) test.photons.begin(7, 200, PhotonKind::kAll);
    Wave& wave = test.wave;
    std::vector<Slot> slots;
    for (int i = 0; i < 200; ++i) {
      slots.push_back(test.add_active({-1.9f + 0.019f * static_cast<float>(i), 0.3f, 2}, {0, 0, 1}));
      wave.rescaled_pdfs.row(slots.back()) = {kUnequal, Spectrum4(1.0f)};
      wave.distance_since_vertex[slots.back()] = 0;
      wave.wavelength_samples[slots.back()] = 0.3f;
    }
    for (const Stage stage : {stage_named("intersect"), stage_named("sort_surfaces"), stage_named("surface_inputs"),
                              stage_named("scatter")})
      kStages<L>[static_cast<std::size_t>(stage)].run(context, wave);
    int count[2] = {0, 0};
    for (const Slot slot : slots) {
      if (!contains(wave.active, slot)) continue;
      const bool single = (float_bits(wave.wavelength_samples[slot]) & kSingleWavelength) != 0;
      const Spectrum4 expected =
          single ? Spectrum4(static_cast<float>(who == Who::kStoredPhoton ? kUnequalMean : kUnequalFirst)) : kUnequal;
      CHECK(lanes(wave.rescaled_pdfs.row(slot).r_u) == lanes(expected));
      ++count[single ? 1 : 0];
    }
    CHECK(std::min(count[0], count[1]) > 20);
  }
}

TEST_CASE_TEMPLATE("photon rays: stored photons sample distances by any wavelength and others by the hero wavelength",
                   L, SHEAF_STAGE_LANES) {
  const auto lanes_of = [](ColorMode color, bool stored) {
    const auto scene = compile_scene(colored_box(MediumPhotons::kPoints), {.color = color});
    TestWave test(1200, 0);
    StageContext context = test.photon_context(*scene, 1200);
    if (stored) test.photons.begin(7, 1200, PhotonKind::kAll);
    photon_rays<L>(context, test.wave);
    std::array<int, 4> count{};
    for (const Slot slot : test.wave.active.span())
      ++count[(test.wave.rays.row(slot).flags & kRayHeroMask) >> kRayHeroShift];
    return count;
  };
  const auto is_uniform = [](const std::array<int, 4>& count, int lanes) {
    for (int lane = 0; lane < 4; ++lane) {
      const double expected = lane < lanes ? 1200.0 / lanes : 0;
      // 5 standard deviations of a binomial distribution
      if (std::fabs(count[static_cast<std::size_t>(lane)] - expected) > 5 * std::sqrt(expected)) return false;
    }
    return true;
  };
  for (const bool stored : {false, true}) CHECK(is_uniform(lanes_of(ColorMode::kRgb, stored), 3));
  CHECK(is_uniform(lanes_of(ColorMode::kSpectral, true), 4));
  CHECK(lanes_of(ColorMode::kSpectral, false)[0] == 1200);
}

}  // namespace sheaf::test_wavelength_pairs
