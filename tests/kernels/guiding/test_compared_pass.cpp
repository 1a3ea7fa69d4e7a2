// The jackknife, and the choice of light candidates from made-up trials.
#include "core/sampling/rng.h"
#include "kernels/training/candidate_choice.h"
#include "kernels/training/compared_pass.h"
#include "tests/support/near.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_compared_pass {

namespace {

/// A trial whose squared radiances with 1, 2 and 4 candidates exceed those with 8 by 1, 0.4 and 0.1. `common`: size of
/// a random term that the estimates with all numbers of candidates share.
ComparedPass iterate(float common) {
  ComparedPass pass;
  pass.rays = 100'000;
  pass.light_vertices = 40'000;
  pass.shadow_rays = {30'000, 30'000, 30'000, 30'000};
  for (std::uint32_t task_index = 0; task_index < 4; ++task_index) {
    ComparedTask& task = pass.tasks.emplace_back();
    for (std::uint32_t k = 0; k < 4000; ++k) {
      const auto u = random4<Scalar>(3, k, task_index, 0);
      const float x = 4 + 3.4641f * (u.x - 0.5f), square = x * x + common * (u.y - 0.3f);
      task.radiance[k % 2].push_back(x);
      task.squared_radiance[k % 2].push_back({square + 1, square + 0.4f, square + 0.1f, square});
    }
  }
  return pass;
}

}  // namespace

TEST_CASE("trial pass: the jackknife error of a mean is its standard error") {
  std::array<double, kJackknifeGroups> without{};
  MeanVariance values;
  double sum = 0;
  for (std::size_t i = 0; i < kJackknifeGroups; ++i) {
    const double value = std::sin(1.7 * static_cast<double>(i * i));
    without[i] = value;
    values.add(value);
    sum += value;
  }
  for (double& value : without) value = (sum - value) / (kJackknifeGroups - 1);
  CHECK(jackknife_error(without) == near(std::sqrt(values.variance() / kJackknifeGroups), 1e-12));
  without.fill(3);
  CHECK(jackknife_error(without) == 0);
}

TEST_CASE("candidate choice: noise that all numbers of candidates share does not matter") {
  const CandidateChoice expected = choose_candidates(iterate(0), 0.1);
  CHECK(expected.count == 4);
  for (const float common : {0.5f, 20.0f}) {
    CAPTURE(common);
    const CandidateChoice found = choose_candidates(iterate(common), 0.1);
    CHECK(found.count == expected.count);
    // Squares are rounded to floats
    for (std::size_t k = 0; k < std::size(kCandidateCounts); ++k)
      CHECK(found.gains[k] == near(expected.gains[k], 1e-4));
  }
}

TEST_CASE("candidate choice: both sets of a pixel count") {
  const CandidateChoice expected = choose_candidates(iterate(0), 0.1);
  for (const std::size_t set : {0u, 1u}) {
    CAPTURE(set);
    // Twice the differences in one set, and none in the other, have the same mean.
    ComparedPass pass = iterate(0);
    for (ComparedTask& task : pass.tasks)
      for (std::size_t i = 0; i < task.squared_radiance[set].size(); ++i) {
        Spectrum4& twice = task.squared_radiance[set][i];
        Spectrum4& none = task.squared_radiance[1 - set][i];
        twice = twice * 2 + Spectrum4(-twice.c3);
        none = Spectrum4(none.c3);
      }
    const CandidateChoice found = choose_candidates(pass, 0.1);
    CHECK(found.count == expected.count);
    for (std::size_t k = 0; k < std::size(kCandidateCounts); ++k)
      CHECK(found.gains[k] == near(expected.gains[k], 1e-4));
  }
}

TEST_CASE("candidate choice: a gain that a small part of the pixels decides is not believed") {
  for (const bool is_even : {true, false}) {
    CAPTURE(is_even);
    // With one candidate, all pixels have 1.5 times the variance, or those of one group 9 times
    ComparedPass pass = iterate(0);
    std::size_t pixel = 0;
    for (ComparedTask& task : pass.tasks)
      for (std::size_t i = 0; i < task.radiance[0].size(); ++i, ++pixel) {
        const bool is_noisy = is_even || pixel / kComparedSamples % kJackknifeGroups == 3;
        const float excess = is_noisy ? (is_even ? 0.5f : 0.5f * kJackknifeGroups) : 0.0f;
        for (auto& squared : task.squared_radiance)
          squared[i] = {squared[i].c3 + excess, squared[i].c3, squared[i].c3, squared[i].c3};
      }
    const CandidateChoice found = choose_candidates(pass, 0);
    CHECK(found.gains[1] == near(1.5, 0.05));
    CHECK((found.count > 1) == is_even);
  }
}

}  // namespace sheaf::test_compared_pass
