// Photon maps: the search around a point, independence of the number of threads, and SIMD lanes against single photons.
#include "kernels/photons/photon_map.h"

#include "core/sampling/octahedral.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/photons/photon_order.h"
#include "kernels/photons/photon_search.h"
#include "kernels/wave/wave_snapshot.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <map>
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

bool same_photons(const PhotonMapView& a, const PhotonMapView& b) {
  if (a.size != b.size || a.powers != b.powers) return false;
  const std::size_t blocks = (a.size + kPhotonBlock - 1) / kPhotonBlock;
  const std::size_t groups = (blocks + kPhotonBlock - 1) / kPhotonBlock;
  const auto same_groups = [](const PhotonBlockGroup& x, const PhotonBlockGroup& y) {
    // All but the padding at the end
    const auto* end = reinterpret_cast<const std::byte*>(x.powers + 4);
    const auto bytes = static_cast<std::size_t>(end - reinterpret_cast<const std::byte*>(&x));
    return std::memcmp(&x, &y, bytes) == 0;
  };
  return std::memcmp(a.blocks, b.blocks, blocks * sizeof(PhotonBlock)) == 0 &&
         std::equal(a.block_groups, a.block_groups + groups, b.block_groups, same_groups);
}

/// The photons of a map as it stores them.
std::vector<Photon> photons_of(const PhotonMapView& map) {
  std::vector<Photon> photons;
  for (std::uint32_t i = 0; i < map.size; ++i) photons.push_back(map.photon(i));
  return photons;
}

/// Calls f(photon) for each photon that a search with registers of L finds around a vertex.
template <class L, class F>
void search(const PhotonMapView& map, Vec3f p, Vec3f normal, std::uint32_t edges, bool needs_distances,
            SummedPhotons<L>* sum, F&& f) {
  const PhotonQuery<L> query{broadcast<L>(p), broadcast<L>(normal), Uint<L>(edges)};
  const float within = map.radius * map.radius;
  std::uint32_t next = 0;
  PhotonSearchLists lists;
  for_blocks_near<L>(map, query, within, sum, lists, [&](const BlockList& list) {
    for (int i = 0; i < list.count; ++i) {
      const NearBlock<L> block(map, list, i);
      CHECK(block.index() >= next);  // ascending, each once
      next = block.index() + 1;
      for (std::uint32_t at = 0; at < kPhotonBlock; at += static_cast<std::uint32_t>(L::width)) {
        const std::uint32_t first = block.index() * kPhotonBlock + at;
        for_each_lane(mask_bits(block.near(at, query, within, needs_distances).lanes),
                      [&](int lane) { f(map.photon(first + static_cast<std::uint32_t>(lane)), block); });
      }
    }
  });
}

/// Abscissas of the photons that a search finds.
template <class L> std::multiset<float> found_by(const PhotonMapView& map, Vec3f p, Vec3f normal, bool distances) {
  std::multiset<float> found;
  search<L>(map, p, normal, kMaxPhotonEdges, distances, nullptr,
            [&](const Photon& photon, const NearBlock<L>&) { found.insert(photon.p.x); });
  return found;
}

}  // namespace

TEST_CASE("photon map: every photon within the radius of a point is found once") {
  for (const int each : {1, 301, 4000})
    for (const float radius : {0.1f, 0.3f, 5.0f}) {
      CAPTURE(each);
      CAPTURE(radius);
      const auto tasks = random_photons(7, each, 1.5f);
      const PhotonMap map(tasks, 2107, radius, PhotonKernel::kDisc);
      const PhotonMapView view = map.view();
      const std::vector<Photon> photons = photons_of(view);
      REQUIRE(photons.size() == static_cast<std::size_t>(7 * each));
      std::mt19937 random(9);
      std::uniform_real_distribution<float> u(-1.7f, 1.7f);
      std::size_t found_in_all = 0;
      for (int i = 0; i < (each > 1000 ? 20 : 200); ++i) {
        const Vec3f at{u(random), u(random), u(random)};
        std::multiset<float> expected;
        for (const Photon& photon : photons)
          if (length_squared(photon.p - at) < radius * radius) expected.insert(photon.p.x);
        for (const bool needs_distances : {false, true}) {
          CHECK(found_by<Wide>(view, at, {0, 1, 0}, needs_distances) == expected);
          CHECK(found_by<Scalar>(view, at, {0, 1, 0}, needs_distances) == expected);
        }
        CHECK(found_by<Wide>(view, at, {1, 0, 0}, false).empty());
        found_in_all += expected.size();
      }
      if (each > 1) CHECK(found_in_all > 10);
    }
}

namespace {

/// Checks each photon of a map against the traced one: positions within half a step of the block's box, and powers
/// within a step. `place`: largest absolute coordinate, m.
void check_stored(const std::vector<std::vector<Photon>>& tasks, float place, bool four_lanes) {
  constexpr float kRadius = 0.1f;
  const PhotonMap map(tasks, 10, kRadius, PhotonKernel::kDisc, 0, four_lanes);
  const PhotonMapView view = map.view();
  const PhotonOrder order(tasks, kRadius / 8);
  REQUIRE(map.size() == order.size());
  const auto coordinate = [](const Photon& photon, int axis) {
    return axis == 0 ? photon.p.x : axis == 1 ? photon.p.y : photon.p.z;
  };
  /// The extent of `count` blocks from `block` on.
  const auto extent = [&](std::uint32_t block, std::uint32_t count, int axis) {
    float low = kInfinity, high = -kInfinity;
    for (std::uint32_t i = block * kPhotonBlock; i < std::min(view.size, (block + count) * kPhotonBlock); ++i)
      low = std::min(low, coordinate(order[i], axis)), high = std::max(high, coordinate(order[i], axis));
    return high - low;
  };
  for (std::uint32_t block = 0; block * kPhotonBlock < view.size; ++block)
    for (int axis = 0; axis < 3; ++axis) {
      // Steps divide the block's box, which exceeds that of its photons by less than two steps of the group
      const float of_group = extent(block / kPhotonBlock * kPhotonBlock, kPhotonBlock, axis);
      const float box = extent(block, 1, axis) + 2.1f / kBoxSteps * of_group;
      const float step = view.group_of(block).position_step(block % kPhotonBlock, axis);
      CHECK(step <= box / (axis == 2 ? 1000.0f : 2000.0f) + 4e-7f * place);
      for (std::uint32_t i = block * kPhotonBlock; i < std::min(view.size, (block + 1) * kPhotonBlock); ++i)
        CHECK(std::fabs(coordinate(view.photon(i), axis) - coordinate(order[i], axis)) <= 0.51f * step + 4e-7f * place);
    }
  for (std::uint32_t i = 0; i < view.size; ++i) {
    const Photon stored = view.photon(i), &traced = order[i];
    const std::uint32_t block = i / kPhotonBlock, node = block % kPhotonBlock;
    const PhotonBlockGroup& group = view.group_of(block);
    const float power_step = group.power_step(node);
    CHECK(std::fabs(stored.power.c0 - 0.1f * traced.power.c0) <= 1.001f * power_step);
    CHECK(std::fabs(stored.power.c2 - 0.1f * traced.power.c2) <= 1.001f * power_step);
    CHECK(stored.direction == traced.direction);
    CHECK(stored.surface == traced.surface);
  }
  // Sums of a block are those of its photons as stored, and wrong by less than a step
  for (std::uint32_t block = 0; block * kPhotonBlock < view.size; ++block) {
    const PhotonBlockGroup& group = view.group_of(block);
    const float step = group.power_step(block % kPhotonBlock);
    double stored = 0, traced = 0, largest = 0;
    for (std::uint32_t i = block * kPhotonBlock; i < std::min(view.size, (block + 1) * kPhotonBlock); ++i) {
      const Spectrum4& power = order[i].power;
      stored += static_cast<double>(view.photon(i).power.c1), traced += 0.1 * static_cast<double>(power.c1);
      const float last = four_lanes ? power.c3 : 0;
      largest = std::max(largest, 0.1 * static_cast<double>(std::max({power.c0, power.c1, power.c2, last})));
    }
    CHECK(std::fabs(stored - traced) <= 1.001 * static_cast<double>(step));
    CHECK(stored == near(static_cast<double>(step) * group.powers[1][block % kPhotonBlock], 1e-6));
    CHECK(static_cast<double>(step) <= largest / (four_lanes ? 250 : 1000));
  }
}

}  // namespace

TEST_CASE("photon map: stored photons differ from traced ones by at most a step") {
  for (const bool four_lanes : {false, true}) check_stored(random_photons(3, 2000, 2), 2, four_lanes);
}

TEST_CASE("photon map: photons of extreme extents, places and powers are stored within a step") {
  const auto photons_with = [](int each, float size, Vec3f center, auto&& change) {
    auto tasks = random_photons(2, each, size);
    std::uint32_t i = 0;
    for (auto& task : tasks)
      for (Photon& photon : task) photon.p = photon.p + center, change(photon, i++);
    return tasks;
  };
  const auto nothing = [](Photon&, std::uint32_t) {};
  for (const bool four_lanes : {false, true}) {
    check_stored(photons_with(3000, 1e-3f, {1e4f, -1e4f, 3e3f}, nothing), 1e4f, four_lanes);  // few floats apart
    check_stored(photons_with(3000, 1e8f, {}, nothing), 1e8f, four_lanes);
    check_stored(photons_with(3000, 1e-12f, {}, nothing), 1e-12f, four_lanes);
    check_stored(photons_with(500, 0, {1, 2, 3}, nothing), 3, four_lanes);  // no extent
    check_stored(photons_with(3000, 1, {}, [](Photon& photon, std::uint32_t) { photon.p.y = 0.3f; }), 1, four_lanes);
    check_stored({{random_photons(1, 1, 1)[0][0]}}, 1, four_lanes);
    // Single photons far from dense ones
    check_stored(photons_with(3000, 1e-2f, {},
                              [](Photon& photon, std::uint32_t i) {
                                if (i % 97 == 0) photon.p = photon.p * 1e6f;
                              }),
                 1e4f, four_lanes);
    for (const float power : {1e-20f, 1e20f})
      check_stored(
          photons_with(3000, 1, {}, [power](Photon& photon, std::uint32_t) { photon.power = photon.power * power; }), 1,
          four_lanes);
    check_stored(photons_with(3000, 1, {},
                              [](Photon& photon, std::uint32_t i) {
                                photon.power = photon.power * std::pow(10.0f, static_cast<float>(i % 41) - 20);
                              }),
                 1, four_lanes);
    check_stored(photons_with(3000, 1, {}, [](Photon& photon, std::uint32_t) { photon.power = {}; }), 1, four_lanes);
  }
}

TEST_CASE("photon map: rounded powers are unbiased") {
  // Powers of one color: the same error in each block would add up
  for (const bool four_lanes : {false, true})
    for (const int each : {16, 4001}) {
      auto tasks = random_photons(5, each, 1);
      for (auto& task : tasks)
        for (Photon& photon : task) photon.power = {1, 0.3331f, 0.012345f, four_lanes ? 0.00123f : 0.0f};
      const PhotonMap map(tasks, 1, 0.1f, PhotonKernel::kDisc, 0, four_lanes);
      double sums[4] = {};
      for (const Photon& photon : photons_of(map.view())) {
        const float power[4] = {photon.power.c0, photon.power.c1, photon.power.c2, photon.power.c3};
        for (std::size_t k = 0; k < 4; ++k) sums[k] += static_cast<double>(power[k]);
      }
      const double count = 5.0 * each, blocks = std::ceil(count / kPhotonBlock), step = four_lanes ? 1.0 / 250 : 1e-3;
      const double expected[4] = {count, count * 0.3331, count * 0.012345, four_lanes ? count * 0.00123 : 0.0};
      // Offsets of low discrepancy: errors of single blocks of up to one step cancel
      for (std::size_t k = 0; k < 4; ++k) CHECK(std::fabs(sums[k] - expected[k]) <= step * (1 + std::log2(blocks)));
      if (each > 1000) {
        CHECK(sums[0] == near(expected[0], 1e-5));
        CHECK(sums[1] == near(expected[1], 1e-5));
        CHECK(sums[2] == near(expected[2], 1e-4));
      }
    }
}

/// Photons on a plane with two normals and, on one half, from both sides.
std::vector<std::vector<Photon>> photons_on_plane() {
  const Vec3f tilted = normalize(Vec3f{0.3f, 1, 0}), across = normalize(Vec3f{1, 0.2f, 0});
  std::vector<std::vector<Photon>> tasks = random_photons(3, 5000, 1);
  std::mt19937 random(4);
  for (auto& task : tasks)
    for (Photon& photon : task) {
      photon.p.y = 0;
      const Vec3f wi = decode_octahedral<Scalar>(photon.direction);
      if (photon.p.x < 0) photon.direction = encode_octahedral<Scalar>(Vec3f{wi.x, std::fabs(wi.y), wi.z});
      if (photon.p.x < 0 && photon.p.z < -0.5f)
        photon.direction = encode_octahedral<Scalar>(Vec3f{wi.x, -std::fabs(wi.y), wi.z});
      if (photon.p.z > 0)
        photon.surface = photon_surface(encode_octahedral<Scalar>(random() % 3 == 0 ? across : tilted),
                                        photon.surface & kMaxPhotonEdges);
    }
  return tasks;
}

TEST_CASE("photon map: photons of other normals and longer paths are not found") {
  const PhotonMap map(photons_on_plane(), 1, 0.8f, PhotonKernel::kDisc);
  const std::vector<Photon> photons = photons_of(map.view());
  for (const std::uint32_t edges : {0u, 2u, 5u}) {
    int expected = 0;
    double expected_sum = 0;
    for (const Photon& photon : photons) {
      const Vec3f n = decode_octahedral<Scalar>(photon.surface);
      if (length_squared(photon.p) >= 0.64f || std::fabs(n.y) <= kSameSide) continue;
      if ((photon.surface & kMaxPhotonEdges) > edges) continue;
      ++expected, expected_sum += static_cast<double>(photon.p.x);
    }
    const auto check = [&]<class L>(L) {
      int found = 0;
      double sum = 0;
      search<L>(map.view(), {}, {0, -1, 0}, edges, false, nullptr,
                [&](const Photon& photon, const NearBlock<L>&) { ++found, sum += static_cast<double>(photon.p.x); });
      CHECK(found == expected);
      CHECK(sum == near(expected_sum, 1e-6));
    };
    check(Wide());
    check(Scalar());
    CHECK((edges == 0 || expected > 2000));
  }
}

TEST_CASE("photon map: sums of blocks inside the sphere and photons on its boundary add up to all photons") {
  for (const bool four_lanes : {false, true}) {
    const PhotonMap map(photons_on_plane(), 1, 0.8f, PhotonKernel::kDisc, 0, four_lanes);
    const std::vector<Photon> photons = photons_of(map.view());
    for (const Vec3f normal : {Vec3f{0, 1, 0}, Vec3f{0, -1, 0}, normalize(Vec3f{0.3f, 1, 0})})
      for (const std::uint32_t edges : {3u, kMaxPhotonEdges}) {
        CAPTURE(normal.y);
        CAPTURE(edges);
        int expected = 0;
        double power = 0, last = 0;
        for (const Photon& photon : photons) {
          const Vec3f n = decode_octahedral<Scalar>(photon.surface);
          if (length_squared(photon.p) >= 0.64f || std::fabs(dot(n, normal)) <= kSameSide) continue;
          if ((photon.surface & kMaxPhotonEdges) > edges) continue;
          ++expected;
          if (dot(decode_octahedral<Scalar>(photon.direction), normal) <= 0) continue;
          power += static_cast<double>(photon.power.c1), last += static_cast<double>(photon.power.c3);
        }
        const auto check = [&]<class L>(L) {
          SummedPhotons<L> summed{Spectrum<L>(Float<L>(0.0f))};
          int found = 0, lit = 0;
          double sum = 0;
          search<L>(map.view(), {}, normal, edges, false, &summed,
                    [&](const Photon& photon, const NearBlock<L>& block) {
                      const bool arrives = dot(decode_octahedral<Scalar>(photon.direction), normal) > 0;
                      ++found;
                      if (block.is_lit()) CHECK(arrives);
                      lit += block.is_lit() ? 1 : 0;
                      if (arrives) sum += static_cast<double>(photon.power.c1);
                    });
          double sums = 0, sums_last = 0;
          for (const float lane : LaneArray<Float<L>>(summed.power.c1)) sums += static_cast<double>(lane);
          for (const float lane : LaneArray<Float<L>>(summed.power.c3)) sums_last += static_cast<double>(lane);
          CHECK(found + static_cast<int>(summed.photons) == expected);
          CHECK(sum + sums == near(power, 1e-5));
          if (edges == kMaxPhotonEdges && normal.x == 0) {
            CHECK(summed.photons > 1000);
            CHECK(lit > 10);
          }
          if (!four_lanes) CHECK(sums_last == 0);
        };
        check(Wide());
        check(Scalar());
        CHECK(last == 0);
      }
  }
}

TEST_CASE("photon map: photons follow the curve and keep the order of the tasks within its cells") {
  const auto tasks = random_photons(5, 20'000, 2);
  constexpr int kCells = 8;  // along each axis
  const PhotonOrder order(tasks, 0.5f);
  REQUIRE(order.size() == 100'000);
  Vec3f low = order[0].p;
  std::map<const Photon*, std::size_t> position;
  for (const auto& task : tasks)
    for (const Photon& photon : task) {
      low = {min(low.x, photon.p.x), min(low.y, photon.p.y), min(low.z, photon.p.z)};
      position.emplace(&photon, position.size());
    }
  const auto cell_of = [&](const Photon& photon) {
    const Vec3f d = photon.p - low;
    const auto along = [](float x) { return std::min(kCells - 1, static_cast<int>(x * 2)); };
    return std::array{along(d.x), along(d.y), along(d.z)};
  };
  // The cells are visited once each, and every cell touches the one before it
  std::set<std::array<int, 3>> visited{cell_of(order[0])};
  int jumps = 0, unordered = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const std::array cell = cell_of(order[i]), before = cell_of(order[i - 1]);
    if (cell == before) {
      unordered += position[&order[i]] > position[&order[i - 1]] ? 0 : 1;
      continue;
    }
    CHECK(visited.insert(cell).second);
    int steps = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) steps += std::abs(cell[axis] - before[axis]);
    jumps += steps == 1 ? 0 : 1;
  }
  CHECK(visited.size() == kCells * kCells * kCells);
  CHECK(jumps == 0);
  CHECK(unordered == 0);
}

TEST_CASE("photon map: keys are sorted stably by the bits requested") {
  std::mt19937_64 random(3);
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, std::size_t{200'001}}) {
    auto keys = std::make_unique<std::uint64_t[]>(count);
    for (std::size_t i = 0; i < count; ++i) keys[i] = random();
    std::vector<std::uint64_t> expected(keys.get(), keys.get() + count);
    const auto part = [](std::uint64_t key) { return key >> 5 & ((std::uint64_t{1} << 30) - 1); };
    std::stable_sort(expected.begin(), expected.end(),
                     [&](std::uint64_t a, std::uint64_t b) { return part(a) < part(b); });
    radix_sort(keys, count, 5, 35);
    CHECK(std::equal(expected.begin(), expected.end(), keys.get()));
  }
}

TEST_CASE("photon map: powers are divided by the number of emitted photons and columns do not depend on threads") {
  const auto tasks = random_photons(20, 5000, 3);
  const PhotonMap map(tasks, 400'000, 0.1f, PhotonKernel::kDisc);
  double expected = 0, found = 0;
  for (const auto& task : tasks)
    for (const Photon& photon : task) expected += static_cast<double>(photon.power.c1) / 400'000;
  for (std::uint32_t i = 0; i < map.view().size; ++i) found += static_cast<double>(map.view().photon(i).power.c1);
  CHECK(found == near(expected, 1e-5));
  for (const std::size_t threads : {std::size_t{1}, std::size_t{3}}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const PhotonMap again(tasks, 400'000, 0.1f, PhotonKernel::kDisc);
    CHECK(same_photons(map.view(), again.view()));
  }
  CHECK(PhotonMap({}, 1, 1, PhotonKernel::kDisc).view().empty());
}

namespace {

/// The radius of the maps of the test below, m.
constexpr double kLookupRadius = 0.4;

/// Red radiance that the photons around a diffuse vertex reflect, over its reflectance.
double gathered_by_hand(const VertexItem<Scalar>& item, const std::vector<Photon>& photons, PhotonKernel kernel,
                        int lookup_size) {
  std::vector<std::pair<double, const Photon*>> near;
  for (const Photon& photon : photons) {
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
    sum += k * shading * static_cast<double>(photon->power.c0);
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
    const std::vector<Photon> photons = photons_of(map.view());
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
      CHECK(a.c0 == near(b.c0, 1e-4));
      CHECK(a.c2 == near(b.c2, 1e-4));
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
      const double expected = static_cast<double>(reflectance) * gathered_by_hand(item, photons, kernel, lookup_size);
      INFO("item " << i);
      CHECK(static_cast<double>(scalar.wave.radiance.row(slot).radiance.c0) == near(expected, 2e-3));
    }
  }
}

}  // namespace sheaf::test_photon_map
