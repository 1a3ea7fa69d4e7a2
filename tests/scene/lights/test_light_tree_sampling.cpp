// Selection by the light tree: correct probabilities, never zero for a light that is visible from the point, and SIMD
// against scalar results.
#include "kernels/lights/light_tree.h"

#include "core/math/frame.h"
#include "tests/scene/lights/light_tree_cases.h"
#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sheaf::test_light_tree_sampling {

using namespace light_tree_cases;

namespace {

/// Position i on the emitter of a LightBounds with its normal there; returns whether light from there reaches p.
bool can_shine(const LightBounds& light, std::uint32_t i, Vec3f p) {
  const auto u = numbers(7, i), v = numbers(8, i);
  const Vec3f extent = light.upper - light.lower;
  const Vec3f y = light.lower + Vec3f{extent.x * u.x, extent.y * u.y, extent.z * u.z};
  const double theta_o = std::acos(double(light.cos_theta_o));
  const auto frame = Frame<Scalar>::from_normal(light.axis);
  const double theta = theta_o * (i % 3 == 0 ? 1.0 : double(v.x)), azimuth = 6.2831853 * v.y;
  const Vec3f local{static_cast<float>(std::sin(theta) * std::cos(azimuth)),
                    static_cast<float>(std::sin(theta) * std::sin(azimuth)), static_cast<float>(std::cos(theta))};
  const Vec3f normal = frame.to_world(local);
  const Vec3f to_p = p - y;
  const double distance = std::sqrt(double(length_squared(to_p)));
  if (!(distance > 1e-6)) return false;
  double cosine = dot(to_p, normal) / distance;
  if (light.two_sided) cosine = std::fabs(cosine);
  // A spot light emits inside its cone only, not around each of its directions.
  if (light.cos_theta_e >= 1) return double(dot(to_p, light.axis)) / distance > double(light.cos_theta_o) + 1e-6;
  return cosine > double(light.cos_theta_e) + 1e-6;
}

/// The draws of two traversals that end together.
template <class L>
std::array<LightTreeSample<L>, 2> ends(const LightTree& tree, LightTreeTraversal<L> a, LightTreeTraversal<L> b) {
  LightTreeTraversal<L> walks[2] = {a, b};
  LightTreeSample<L> samples[2];
  finish_light_traversals<L>(tree.view(), walks, samples);
  return {samples[0], samples[1]};
}

}  // namespace

TEST_CASE("light tree: probabilities add up to one or to zero where no light is visible") {
  for (const std::uint32_t count : {1u, 2u, 5u, 64u, 1000u}) {
    const LightTree tree = build_light_tree(mixed_lights(count));
    for (std::uint32_t i = 0; i < 20; ++i) {
      const Vec3f p = position(11, i, i % 2 == 0 ? 12.0f : 200.0f), n = i % 3 == 0 ? Vec3f{} : direction(12, i);
      int valid = 0;
      for (std::uint32_t k = 0; k < 50; ++k) valid += draw_light(tree, p, n, numbers(13, k).x).valid;
      const double sum = sum_of_probabilities(tree, p, n);
      // Draws fail where a node may be visible but none of its children, which are bounded more tightly.
      if (count <= kLightChildren)
        CHECK((std::fabs(sum - 1) < 1e-5 || sum == 0));
      else
        CHECK(sum < 1 + 1e-5);
      if (sum > 1 - 1e-5) CHECK(valid == 50);
      if (sum == 0) CHECK(valid == 0);
    }
  }
  LightSet points;
  for (std::uint32_t i = 0; i < 500; ++i) points.push_back(point_at(position(14, i, 5), numbers(15, i).x + 0.01f));
  const LightTree tree = build_light_tree(points);
  for (std::uint32_t i = 0; i < 50; ++i)
    CHECK(std::fabs(sum_of_probabilities(tree, position(16, i, 8), direction(17, i)) - 1) < 1e-5);
}

TEST_CASE("light tree: lights are drawn with their probability") {
  constexpr int kCases = 12, kDraws = 200000;
  double worst = 1;
  for (std::uint32_t c = 0; c < kCases; ++c) {
    const std::uint32_t count = c % 3 == 0 ? 3 : c % 3 == 1 ? 40 : 400;
    const LightTree tree = build_light_tree(mixed_lights(count, c));
    const Vec3f p = position(21, c, 12), n = c % 4 == 3 ? Vec3f{} : direction(22, c);
    std::vector<double> observed(count + 1), expected(count + 1);
    double sum = 0;
    for (std::uint32_t i = 0; i < count; ++i) sum += expected[i] = probability(tree, p, n, i);
    expected[count] = std::max(1 - sum, 1e-6);
    int wrong = 0;
    for (std::uint32_t k = 0; k < kDraws; ++k) {
      const auto choice = draw_light(tree, p, n, numbers(23 + c, k).x);
      observed[choice.valid ? choice.light : count] += 1;
      wrong += choice.valid && std::fabs(choice.probability - expected[choice.light]) > 1e-5 * choice.probability;
      wrong += !choice.valid && choice.probability != 0;
      wrong += !(choice.remapped >= 0 && choice.remapped < 1);
    }
    CHECK(wrong == 0);
    for (double& e : expected) e *= kDraws;
    worst = std::min(worst, chi_square(observed, expected).p_value);
  }
  CHECK(worst > significance_of_each(kCases));
}

TEST_CASE("light tree: the remapped random number is uniform") {
  const LightTree tree = build_light_tree(mixed_lights(20));
  std::vector<double> cells(32);
  for (std::uint32_t k = 0; k < 100000; ++k) {
    const auto choice = draw_light(tree, {1, 2, 3}, {0, 0, 1}, numbers(31, k).x);
    if (choice.valid) cells[static_cast<std::size_t>(choice.remapped * 32)] += 1;
  }
  CHECK(chi_square_uniform(cells).p_value > kSignificance);
}

TEST_CASE("light tree: SIMD results equal scalar ones") {
  const LightSet lights = mixed_lights(777);
  const LightTree tree = build_light_tree(lights);
  int wrong = 0, other = 0, total = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto id = [&](int lane) { return i * kWidth + static_cast<std::uint32_t>(lane); };
    const auto p_of = [&](int lane) { return position(41, id(lane), 15); };
    const auto n_of = [&](int lane) { return id(lane) % 5 == 0 ? Vec3f{} : direction(42, id(lane)); };
    const auto has = [&](int lane) { return id(lane) % 7 != 0; };
    const Vec3<Wide> p{wide_floats([&](int k) { return p_of(k).x; }), wide_floats([&](int k) { return p_of(k).y; }),
                       wide_floats([&](int k) { return p_of(k).z; })};
    const Vec3<Wide> n{wide_floats([&](int k) { return n_of(k).x; }), wide_floats([&](int k) { return n_of(k).y; }),
                       wide_floats([&](int k) { return n_of(k).z; })};
    const WideMask has_normal = wide_mask(has);
    const WideFloat u = wide_floats([&](int k) { return numbers(43, id(k)).x; });
    const auto choice = sample_light_tree<Wide>(tree.view(), p, n, has_normal, u);
    const WideMask asked = wide_mask([&](int k) { return id(k) % 11 != 0; });
    const WideUint light = wide_uints([&](int k) { return id(k) % 11 != 0 ? id(k) * 31 % 777 : 0xffffffffu; });
    const WideFloat probabilities = light_tree_probability<Wide>(tree.view(), p, n, has_normal, light, asked);
    for (int k = 0; k < kWidth; ++k, ++total) {
      const auto single = sample_light_tree<Scalar>(tree.view(), p_of(k), n_of(k), has(k), u[k]);
      const bool valid = lane_of(choice.valid, k);
      wrong += valid != (choice.probability[k] > 0);
      if (single.light != choice.light[k] || (single.probability > 0) != (choice.probability[k] > 0)) {
        ++other;  // u is on the border between two lights, within rounding
      } else {
        wrong += std::fabs(single.probability - choice.probability[k]) > 1e-4 * single.probability;
        wrong += std::fabs(single.remapped - choice.remapped[k]) > 0.05f;
      }
      const bool is_asked = lane_of(asked, k);
      const float q = light_tree_probability<Scalar>(tree.view(), p_of(k), n_of(k), has(k), light[k], is_asked);
      wrong += std::fabs(q - probabilities[k]) > 1e-4 * q;
    }
  }
  CHECK(wrong == 0);
  CHECK(other < total / 1000);
}

TEST_CASE("light tree: candidates that share the upper levels of a traversal draw the same lights") {
  for (const std::uint32_t count : {1u, 2u, 3u, 9u, 30u, 1000u}) {
    const LightTree tree = build_light_tree(mixed_lights(count, count));
    int wrong = 0, other = 0, valid = 0;
    for (std::uint32_t i = 0; i < 300; ++i) {
      const auto id = [&](int lane) { return i * kWidth + static_cast<std::uint32_t>(lane); };
      const auto p_of = [&](int lane) { return position(44, id(lane), 15); };
      const Vec3<Wide> p{wide_floats([&](int k) { return p_of(k).x; }), wide_floats([&](int k) { return p_of(k).y; }),
                         wide_floats([&](int k) { return p_of(k).z; })};
      const auto n_of = [&](int lane) { return id(lane) % 5 == 0 ? Vec3f{} : direction(45, id(lane)); };
      const Vec3<Wide> n{wide_floats([&](int k) { return n_of(k).x; }), wide_floats([&](int k) { return n_of(k).y; }),
                         wide_floats([&](int k) { return n_of(k).z; })};
      const WideFloat u = wide_floats([&](int k) { return numbers(46, id(k)).x; });
      const auto cut = light_tree_cut<Wide>(tree.view(), p, n, WideMask(true));
      // The other traversal reaches a part of the tree of another depth.
      const auto [shared, other_choice] =
          ends<Wide>(tree, begin_light_traversal<Wide>(tree.view(), cut, p, n, WideMask(true), u),
                     begin_light_traversal<Wide>(p, n, WideMask(true), WideFloat(kOneMinusEpsilon) - u));
      const auto own = sample_light_tree<Wide>(tree.view(), p, n, WideMask(true), u);
      for (int k = 0; k < kWidth; ++k) {
        valid += lane_of(own.valid, k);
        const auto single_cut = light_tree_cut<Scalar>(tree.view(), p_of(k), n_of(k), true);
        const auto [single, again] =
            ends<Scalar>(tree, begin_light_traversal<Scalar>(tree.view(), single_cut, p_of(k), n_of(k), true, u[k]),
                         begin_light_traversal<Scalar>(p_of(k), n_of(k), true, kOneMinusEpsilon - u[k]));
        wrong += again.valid != lane_of(other_choice.valid, k);
        if (again.light == other_choice.light[k])
          wrong += std::fabs(again.probability - other_choice.probability[k]) > 1e-5f * again.probability;
        else
          ++other;
        if (shared.light[k] != own.light[k] || single.light != own.light[k]) {
          ++other;  // u is on the border between two lights, within rounding
          continue;
        }
        // Probabilities of the upper levels are stored as running sums, with the rounding of numbers near 1.
        const float probability = own.probability[k], rounding = 1e-5f * probability + 0x1p-25f;
        wrong += std::fabs(shared.probability[k] - probability) > rounding;
        wrong += std::fabs(single.probability - probability) > rounding;
        wrong +=
            std::fabs(shared.remapped[k] - own.remapped[k]) > 0.05f || lane_of(shared.valid, k) != (probability > 0);
      }
    }
    CHECK(wrong == 0);
    CHECK(other <= 2 * 300 * kWidth / 1000);
    CHECK(valid > 1000);
  }
}

TEST_CASE("light tree: a light that illuminates a point has a positive probability") {
  for (const std::uint32_t count : {1u, 2u, 30u, 300u}) {
    const LightSet lights = mixed_lights(count, 50 + count);
    const LightTree tree = build_light_tree(lights);
    int missed = 0, shining = 0;
    for (std::uint32_t i = 0; i < 60000; ++i) {
      const std::uint32_t light = i % count;
      const Vec3f middle = (lights[light].lower + lights[light].upper) * 0.5f;
      const float distances[] = {0.01f, 0.3f, 3, 30, 3e4f};
      const Vec3f p = middle + direction(51, i) * distances[i % 5];
      if (!can_shine(lights[light], i, p)) continue;
      ++shining;
      missed += !(probability(tree, p, direction(52, i), light) > 0);
    }
    CHECK(shining > 10000);
    CHECK(missed == 0);
  }
}

TEST_CASE("light tree: lights at grazing angles have a positive probability") {
  LightSet lights;
  for (std::uint32_t i = 0; i < 100; ++i) {
    LightBounds flat = point_at({i * 0.1f, 0, 1e4f});
    flat.cos_theta_o = 1;
    flat.axis = {0, 0, -1};
    lights.push_back(flat);
  }
  const LightTree tree = build_light_tree(lights);
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Vec3f behind{i * 0.1f + 100, 0, 1e4f + 50}, grazing{i * 0.1f + 100, 0, 1e4f - 1e-3f};
    CHECK(probability(tree, behind, {0, 0, 1}, i) == 0);
    CHECK(probability(tree, grazing, {0, 0, 1}, i) > 0);
    // The plane of the receiver contains all lights, and a light behind it may still be visible.
    CHECK(probability(tree, {3, 4, 0}, {0, 0, -1}, i) > 0);
    CHECK(probability(tree, {3, 0, 0}, {0, 1, 0}, i) > 0);
  }
}

TEST_CASE("light tree: a single two-sided light is found behind one-sided ones") {
  LightSet lights;
  for (std::uint32_t i = 0; i < 16; ++i) {
    LightBounds flat = point_at({static_cast<float>(i), 0, 0});
    flat.cos_theta_o = 1;
    flat.two_sided = i == 5;
    lights.push_back(flat);
  }
  const LightTree tree = build_light_tree(lights);
  for (std::uint32_t i = 0; i < 16; ++i) CHECK(probability(tree, {3, 2, -40}, {}, i) == (i == 5 ? 1.0 : 0.0));
}

TEST_CASE("light tree: distant lights are chosen by power over squared distance") {
  // Small groups of lights, far from each other and from the point in the middle.
  LightSet lights;
  std::vector<double> ideal;
  double sum = 0;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const std::uint32_t group = i / 20;
    const Vec3f p = direction(61, group) * (500.0f + 100.0f * static_cast<float>(group)) + position(62, i, 0.5f);
    lights.push_back(point_at(p, 1 + 9 * numbers(63, i).x));
    ideal.push_back(lights.back().power / double(length_squared(p)));
    sum += ideal.back();
  }
  const LightTree tree = build_light_tree(lights);
  // At a point from which every node is small, children are chosen by power over squared distance.
  LightSet cloud(lights.begin(), lights.begin() + 20);
  const LightTree small = build_light_tree(cloud);
  double cloud_sum = 0, worst = 0;
  for (std::uint32_t i = 0; i < 20; ++i) cloud_sum += ideal[i];
  for (std::uint32_t i = 0; i < 20; ++i)
    worst = std::max(worst, std::fabs(probability(small, {}, {}, i) / (ideal[i] / cloud_sum) - 1));
  CHECK(worst < 0.02);
  // In a row whose far end gets 1/80 of its near end, a node counts by the distance of its center.
  LightSet row;
  std::vector<double> row_ideal;
  double row_sum = 0;
  for (std::uint32_t i = 0; i < 16; ++i) {
    const float distance = 2000 * std::pow(1.16f, static_cast<float>(i));
    row.push_back(point_at({0.01f * static_cast<float>(i), 1, distance}, 1 + numbers(64, i).x));
    row_ideal.push_back(row.back().power / double(length_squared(row.back().lower)));
    row_sum += row_ideal.back();
  }
  const LightTree line = build_light_tree(row);
  for (std::uint32_t i = 0; i < 16; ++i) {
    const double ratio = probability(line, {}, {}, i) / (row_ideal[i] / row_sum);
    CHECK(ratio > 1 / 3.0);
    CHECK(ratio < 3.0);
  }
  // With nodes around the point, the bound is loose, but within a small factor on average.
  double mean = 0;
  for (std::uint32_t i = 0; i < 400; ++i) mean += ideal[i] / sum * (ideal[i] / sum) / probability(tree, {}, {}, i);
  CHECK(mean < 3.0);
}

TEST_CASE("light tree: two lights are chosen by their cosines and distances and powers") {
  // Powers and positions are rounded to 8 bits.
  const auto rounded = [](double x) { return near(x, 3e-3); };
  // Equal distances, 60 and 0 degrees from the normal, then with the normal reversed, and without a normal.
  const Vec3f aslant = Vec3f{std::sqrt(0.75f), 0, 0.5f} * 5.0f, overhead{0, 0, 5};
  const LightTree points = build_light_tree(LightSet{point_at(aslant, 3), point_at(overhead, 3)});
  CHECK(probability(points, {}, {0, 0, 1}, 0) == rounded(1 / 3.0));
  CHECK(probability(points, {}, {0, 0, -1}, 0) == rounded(1 / 3.0));
  CHECK(probability(points, {}, {}, 0) == rounded(0.5));
  CHECK(light_tree_probability<Scalar>(points.view(), {}, {0, 0, 1}, false, 0, true) == rounded(0.5));
  CHECK(sample_light_tree<Scalar>(points.view(), {}, {0, 0, 1}, false, 0.4f).probability == rounded(0.5));
  const LightTree unequal = build_light_tree(LightSet{point_at({0, 0, 5}, 1), point_at({0, 0, -10}, 2)});
  CHECK(probability(unequal, {}, {0, 0, 1}, 0) == rounded(2 / 3.0));
  CHECK(draw_light(unequal, {}, {0, 0, 1}, 0.1f).probability + draw_light(unequal, {}, {0, 0, 1}, 0.9f).probability ==
        near(1));
  // Flat lights, one of which faces 60 degrees past the point. A cone of normals of 20 degrees raises the cosine to at
  // most cos 60 cos 20 + sin 20.
  LightBounds past = point_at(overhead), direct = point_at(overhead);
  past.axis = {std::sqrt(0.75f), 0, -0.5f};
  direct.axis = {0, 0, -1};
  past.cos_theta_o = direct.cos_theta_o = 1;
  const auto fraction_of_past = [&](Vec3f p) {
    return probability(build_light_tree(LightSet{past, direct}), p, {}, 0);
  };
  CHECK(fraction_of_past({}) == rounded(1 / 3.0));
  past.cos_theta_o = std::cos(kPi / 9);
  const double exact = std::cos(kPi / 4.5), most = 0.5 * std::cos(kPi / 9) + std::sin(kPi / 9);
  CHECK(fraction_of_past({}) > exact / (1 + exact));
  CHECK(fraction_of_past({}) < most / (1 + most));
  past.cos_theta_o = 1;
  past.two_sided = direct.two_sided = true;
  CHECK(fraction_of_past({0, 0, 10}) == rounded(1 / 3.0));
  // Spherical lights that subtend asin 0.2 raise the cosine as much. If they subtend more than 30 degrees, it is 1.
  past.two_sided = direct.two_sided = false;
  const auto enlarge = [&](float radius) {
    const float half = radius / std::sqrt(3.0f);
    past.lower = overhead - Vec3f{half, half, half};
    past.upper = overhead + Vec3f{half, half, half};
  };
  enlarge(1);
  CHECK(fraction_of_past({}) == rounded(0.7 / 1.7));
  enlarge(3);
  CHECK(fraction_of_past({}) == rounded(0.5));
  // The same at the receiver, for a sphere 60 degrees from its normal.
  LightBounds ball = point_at(aslant);
  const float half = 1 / std::sqrt(3.0f);
  ball.lower = aslant - Vec3f{half, half, half};
  ball.upper = aslant + Vec3f{half, half, half};
  const LightTree balls = build_light_tree(LightSet{ball, point_at(overhead)});
  CHECK(probability(balls, {}, {0, 0, 1}, 0) == rounded(0.7 / 1.7));
}

}  // namespace sheaf::test_light_tree_sampling
