// The structure of the light tree: every light has one leaf, also in degenerate sets of lights.
#include "kernels/lights/light_tree.h"

#include "core/io/error.h"
#include "tests/scene/lights/light_tree_cases.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <vector>

namespace sheaf::test_light_tree {

using namespace light_tree_cases;

namespace {

/// Leaves found by a traversal of all nodes, with all errors of the tree.
struct Survey {
  int wrong = 0;
  std::multiset<std::uint32_t> leaves;
};

/// Unpacked children of a node, with positions in world space.
std::vector<LightChild<Scalar>> unpack(const LightNodeRow& node) {
  float words[LightNodeRow::kWordCount];
  for (int k = 0; k < LightNodeRow::kWordCount; ++k) words[k] = bits_float(node.words[k]);
  return {unpack_light_child<Scalar, 0>(words), unpack_light_child<Scalar, 1>(words),
          unpack_light_child<Scalar, 2>(words), unpack_light_child<Scalar, 3>(words)};
}

double distance(Vec3f a, Vec3f b) {
  return std::hypot(double(a.x) - double(b.x), double(a.y) - double(b.y), double(a.z) - double(b.z));
}

/// Checks the spheres. Boxes are not stored, and spheres of children need not nest, but those of leaves must contain
/// their lights.
void survey(const LightTree& tree, const LightSet& lights, std::uint32_t index, std::uint32_t trail, int level,
            Survey& out) {
  REQUIRE(index < tree.nodes.size());
  REQUIRE(level < kMaxLightTreeDepth);
  const LightNodeRow& node = tree.nodes[index];
  const auto children = unpack(node);
  for (std::uint32_t k = 0; k < kLightChildren; ++k) {
    const std::uint32_t child_trail = trail | k << 2 * level, position = light_tree_child(node, index, k),
                        light = node.lights[k];
    if ((position & kLightLeaf) == 0) {
      out.wrong += position <= index;
      survey(tree, lights, position, child_trail, level + 1, out);
      continue;
    }
    out.wrong += position != (kLightLeaf | (4 * index + k));
    if (light >= lights.size() || tree.trails[light] != child_trail) {
      out.wrong += !std::isnan(children[k].spread);
      continue;
    }
    out.leaves.insert(light);
    for (const Vec3f& corner : {lights[light].lower, lights[light].upper})
      out.wrong +=
          !(distance(corner, children[k].center) <= double(children[k].radius) + 1e-6 * double(length(corner)));
    out.wrong += std::isnan(children[k].spread) == (lights[light].power > 0);
    const bool one_sided = children[k].keep_sign == 0xffffffffu;
    if (lights[light].power > 0) out.wrong += one_sided == lights[light].two_sided;
  }
}

/// Builds a tree and checks that every light is found exactly once, by its trail.
LightTree checked_tree(const LightSet& lights) {
  LightTree tree = build_light_tree(lights);
  REQUIRE(tree.trails.size() == lights.size());
  CHECK(tree.depth <= kMaxLightTreeDepth);
  Survey found;
  if (!lights.empty()) survey(tree, lights, 0, 0, 0, found);
  CHECK(found.wrong == 0);
  CHECK(found.leaves.size() == lights.size());
  CHECK(std::set<std::uint32_t>(found.leaves.begin(), found.leaves.end()).size() == lights.size());
  return tree;
}

}  // namespace

TEST_CASE("light tree: every light has a leaf and equal lights give equal trees") {
  for (const std::uint32_t count : {1u, 2u, 3u, 17u, 1000u}) {
    const LightSet lights = mixed_lights(count);
    const LightTree tree = checked_tree(lights), again = build_light_tree(lights);
    CHECK(tree.nodes.size() < std::max(2u, 2 * count / 3));
    CHECK(tree.trails == again.trails);
    CHECK(std::memcmp(tree.nodes.data(), again.nodes.data(), tree.nodes.size() * sizeof(LightNodeRow)) == 0);
  }
}

TEST_CASE("light tree: degenerate sets of lights give valid trees") {
  SUBCASE("none") {
    const LightTree tree = checked_tree({});
    const auto choice = draw_light(tree, {}, {0, 0, 1}, 0.5f);
    CHECK(!choice.valid);
    CHECK(choice.probability == 0);
    CHECK(light_tree_probability<Scalar>(tree.view(), {}, {}, true, 0, true) == 0);
  }
  SUBCASE("one light") {
    const LightTree tree = checked_tree({point_at({1, 2, 3}, 5)});
    CHECK(draw_light(tree, {}, {0, 0, 1}, 0.999f).probability == 1);
    CHECK(probability(tree, {1, 2, 3}, {0, 0, 1}, 0) == 1);
  }
  SUBCASE("thousands at one position") {
    const LightTree tree = checked_tree(LightSet(5000, point_at({1, 2, 3})));
    CHECK(tree.depth == 7);
    CHECK(std::fabs(probability(tree, {}, {}, 4999) * 5000 - 1) < 0.7);
    CHECK(std::fabs(sum_of_probabilities(tree, {}, {}) - 1) < 1e-4);
    CHECK(std::fabs(sum_of_probabilities(tree, {1, 2, 3}, {}) - 1) < 1e-4);
  }
  SUBCASE("distances that double") {
    LightSet lights;
    for (int i = 0; i < 120; ++i) lights.push_back(point_at({std::ldexp(1.0f, i - 60), 0, 0}));
    const LightTree tree = checked_tree(lights);
    CHECK(tree.depth > kMaxLightTreeDepth - 2);
    CHECK(std::fabs(sum_of_probabilities(tree, {1, 1, 0}, {}) - 1) < 1e-4);
  }
}

TEST_CASE("light tree: awkward values of lights") {
  SUBCASE("no power") {
    LightSet lights = mixed_lights(40);
    for (std::size_t i = 0; i < lights.size(); i += 2) lights[i].power = i % 4 == 0 ? 0.0f : -kInfinity;
    const LightTree some = checked_tree(lights);
    for (std::uint32_t i = 0; i < 40; i += 2) CHECK(probability(some, {}, {}, i) == 0);
    for (LightBounds& light : lights) light.power = std::numeric_limits<float>::quiet_NaN();
    const LightTree none = checked_tree(lights);
    CHECK(sum_of_probabilities(none, {}, {}) == 0);
    CHECK(!draw_light(none, {}, {}, 0.3f).valid);
  }
  SUBCASE("extreme powers and positions") {
    LightSet lights;
    for (int i = 0; i < 60; ++i)
      lights.push_back(point_at(direction(71, static_cast<std::uint32_t>(i)) * (i % 2 == 0 ? 1e37f : 1e-37f),
                                i % 3 == 0 ? 1e38f : 1e-38f));
    const LightTree tree = checked_tree(lights);
    for (const Vec3f& p : {Vec3f{}, Vec3f{1, 1, 1}, Vec3f{3e38f, 0, 0}}) {
      const auto choice = draw_light(tree, p, {0, 0, 1}, 0.5f);
      CHECK(choice.probability >= 0);
      CHECK(choice.probability <= 1);
      CHECK((choice.valid == (choice.probability > 0)));
    }
  }
  SUBCASE("NaN") {
    for (int field = 0; field < 3; ++field) {
      LightSet lights = mixed_lights(3);
      const float nan = std::numeric_limits<float>::quiet_NaN();
      (field == 0 ? lights[1].upper.y : field == 1 ? lights[1].axis.z : lights[1].cos_theta_o) = nan;
      CHECK_THROWS_AS(build_light_tree(lights), SceneError);
    }
    const LightTree tree = build_light_tree(mixed_lights(30));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float u : {0.0f, kOneMinusEpsilon}) {
      const auto choice = draw_light(tree, {nan, 0, kInfinity}, {0, nan, 1}, u);
      CHECK((!choice.valid || choice.light < 30));
    }
  }
}

}  // namespace sheaf::test_light_tree
