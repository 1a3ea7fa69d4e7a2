// Photon maps: the search around a point, independence of the number of threads, and SIMD lanes against single photons.
#include "kernels/photons/photon_map.h"

#include "core/octahedral.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/wave/wave_snapshot.h"
#include "tests/support/capture.h"
#include "tests/support/stages_testing.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <set>

namespace sheaf::test_photon_map {

namespace {

std::vector<std::vector<Photon>> random_photons(int tasks, int each, float size, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<std::vector<Photon>> out(static_cast<std::size_t>(tasks));
  for (auto& task : out)
    for (int i = 0; i < each; ++i) {
      Photon photon;
      photon.p = {size * u(random), size * u(random), size * u(random)};
      photon.power = {1 + u(random), 1 + u(random), 1 + u(random), 0};
      photon.direction = encode_octahedral<Scalar>(normalize(Vec3f{u(random), u(random), u(random)}));
      photon.surface = photon_surface(encode_octahedral<Scalar>(Vec3f{0, 1, 0}), 1 + static_cast<std::uint32_t>(i % 5));
      photon.order = static_cast<std::uint32_t>(i);
      task.push_back(photon);
    }
  return out;
}

bool same_columns(const PhotonMapView& a, const PhotonMapView& b, std::size_t size) {
  bool same = true;
  for (const auto& [x, y] : {std::pair{a.x, b.x}, std::pair{a.y, b.y}, std::pair{a.z, b.z},
                             std::pair{a.power[0], b.power[0]}, std::pair{a.power[2], b.power[2]}})
    same = same && std::memcmp(x, y, size * sizeof(float)) == 0;
  return same && std::memcmp(a.direction, b.direction, size * sizeof(float)) == 0;
}

}  // namespace

TEST_CASE("photon map: every photon within the radius of a point is found once") {
  for (const float radius : {0.1f, 0.3f, 5.0f}) {
    CAPTURE(radius);
    const auto tasks = random_photons(7, 301, 1.5f);
    const PhotonMap map(tasks, 2107, radius, PhotonKernel::kDisc);
    const PhotonMapView view = map.view();
    CHECK(map.size() == 2107);
    std::mt19937 random(9);
    std::uniform_real_distribution<float> u(-1.7f, 1.7f);
    std::size_t found_in_all = 0;
    for (int i = 0; i < 200; ++i) {
      const Vec3f at{u(random), u(random), u(random)};
      std::multiset<float> expected, found;
      for (const auto& task : tasks)
        for (const Photon& photon : task)
          if (length(photon.p - at) < radius) expected.insert(photon.p.x);
      std::uint32_t buckets[8];
      const int count = view.buckets_around(at, buckets);
      for (int b = 0; b < count; ++b)
        for (std::uint32_t k = view.bucket_begin[buckets[b]]; k < view.bucket_begin[buckets[b] + 1]; ++k)
          if (length(Vec3f{view.x[k], view.y[k], view.z[k]} - at) < radius) found.insert(view.x[k]);
      CHECK(found == expected);
      found_in_all += found.size();
    }
    CHECK(found_in_all > 10);
  }
}

TEST_CASE("photon map: powers are divided by the number of emitted photons and columns do not depend on threads") {
  const auto tasks = random_photons(20, 5000, 3);
  const PhotonMap map(tasks, 400'000, 0.1f, PhotonKernel::kDisc);
  double expected = 0, found = 0;
  for (const auto& task : tasks)
    for (const Photon& photon : task) expected += static_cast<double>(photon.power.c1) / 400'000;
  for (std::size_t i = 0; i < map.size(); ++i) found += static_cast<double>(map.view().power[1][i]);
  CHECK(found == doctest::Approx(expected).epsilon(1e-5));
  for (const std::size_t threads : {std::size_t{1}, std::size_t{3}}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const PhotonMap again(tasks, 400'000, 0.1f, PhotonKernel::kDisc);
    CHECK(same_columns(map.view(), again.view(), map.size()));
  }
  CHECK(PhotonMap({}, 1, 1, PhotonKernel::kDisc).view().empty());
}

namespace {

/// The radius of the maps of the test below, m.
constexpr double kLookupRadius = 0.4;

/// Red radiance that the photons around a diffuse vertex reflect, over its reflectance.
double gathered_by_hand(const VertexItem<Scalar>& item, const std::vector<std::vector<Photon>>& tasks,
                        PhotonKernel kernel, int lookup_size) {
  std::vector<std::pair<double, const Photon*>> near;
  for (const auto& task : tasks)
    for (const Photon& photon : task) {
      const double distance = static_cast<double>(length(photon.p - item.p));
      if (distance < kLookupRadius && std::fabs(item.ng.y) > 0.5f && (photon.surface & kMaxPhotonEdges) <= 3)
        near.emplace_back(distance, &photon);
    }
  double radius = kLookupRadius;
  if (lookup_size > 0 && near.size() >= static_cast<std::size_t>(lookup_size)) {
    std::sort(near.begin(), near.end());
    near.resize(static_cast<std::size_t>(lookup_size));
    radius = near.back().first;
    near.pop_back();
  }
  double sum = 0;
  for (const auto& [distance, photon] : near) {
    const double x = distance / radius;
    const Vec3f wi = decode_octahedral<Scalar>(photon->direction);
    if (item.wo.z <= 0 || dot(wi, item.ns) <= 0) continue;
    const double k = kernel == PhotonKernel::kDisc ? 1 : kernel == PhotonKernel::kCone ? 3 * (1 - x) : 2 * (1 - x * x);
    const double shading = std::fabs(static_cast<double>(dot(wi, item.ns)) / static_cast<double>(dot(wi, item.ng)));
    sum += k * shading * static_cast<double>(photon->power.c0) / 1000;
  }
  const double pi = 3.14159265358979;
  return sum / pi / (pi * radius * radius);
}

}  // namespace

TEST_CASE("gather: SIMD results equal scalar ones and the sum over all photons") {
  Description d = mixed_scene();
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.max_depth = 4;
  // A floor whose shading normals differ from its geometric normal.
  Mesh tilted;
  tilted.positions = {{-3, -1.4f, 2}, {3, -1.4f, 2}, {3, -1.4f, 6}, {-3, -1.4f, 6}};
  tilted.normals.assign(4, normalize(Vec3f{0.4f, 1, 0.1f}));
  tilted.triangles = {{0, 2, 1}, {0, 3, 2}};
  add_shape(d, tilted, Transform(), add_diffuse(d, 0.6f));
  const auto scene = compile_scene(d);
  std::vector<std::vector<Photon>> tasks = random_photons(4, 20000, 3);
  for (auto& task : tasks)
    for (Photon& photon : task) photon.p = photon.p + Vec3f{0, 0, 4};
  for (const auto& [kernel, lookup_size] :
       {std::pair{PhotonKernel::kDisc, 0}, std::pair{PhotonKernel::kCone, 0}, std::pair{PhotonKernel::kEpanechnikov, 0},
        std::pair{PhotonKernel::kDisc, 20}, std::pair{PhotonKernel::kCone, 5}}) {
    CAPTURE_BINDING(kernel);
    CAPTURE_BINDING(lookup_size);
    const PhotonMap map(tasks, 1000, static_cast<float>(kLookupRadius), kernel, lookup_size);
    const PhotonMaps maps{map.view(), {}, PhotonGathering::kAll};
    TestWave wide(120, 0), scalar(120, 0);
    wide.begin({2, 7, 14, 15}, 0, 2, 16);
    StageContext context = wide.context(*scene);
    context.gather_from(maps);
    for (const Stage stage : {stage_named("camera_rays"), stage_named("intersect"), stage_named("sort_surfaces"),
                              stage_named("surface_inputs")})
      kStages<Wide>[static_cast<std::size_t>(stage)].run(context, wide.wave);
    WaveSnapshot(wide.wave).restore(scalar.wave);
    gather<Wide>(context, wide.wave);
    gather<Single>(context, scalar.wave);
    int lit = 0;
    for (const Slot slot : wide.wave.sorted.span()) {
      const Spectrum4 a = wide.wave.radiance.row(slot).radiance, b = scalar.wave.radiance.row(slot).radiance;
      CHECK(a.c0 == doctest::Approx(b.c0).epsilon(1e-4));
      CHECK(a.c2 == doctest::Approx(b.c2).epsilon(1e-4));
      lit += a.c0 > 0 ? 1 : 0;
    }
    CHECK(lit >= 20);
    // A diffuse vertex, calculated by hand.
    const VertexRun& run = wide.wave.runs[static_cast<int>(kClosureKind<DiffuseClosure>)];
    REQUIRE(run.count > 0);
    for (int i = 0; i < run.count; ++i) {
      const auto item = wide.wave.vertices.load<Scalar>(run.column_begin + i);
      const Slot slot = wide.wave.sorted[run.slot_begin + i];
      const float reflectance = wide.wave.closures.columns().words[0][run.column_begin + i];
      const double expected = static_cast<double>(reflectance) * gathered_by_hand(item, tasks, kernel, lookup_size);
      INFO("item " << i);
      CHECK(static_cast<double>(scalar.wave.radiance.row(slot).radiance.c0) == doctest::Approx(expected).epsilon(2e-3));
    }
  }
}

}  // namespace sheaf::test_photon_map
