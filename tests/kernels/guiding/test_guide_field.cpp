// Path guiding: samples of the mixtures against their pdfs, fitting of the mixtures, and the lookup of guide cells.
#include "core/sampling/octahedral.h"
#include "kernels/guiding/guide_field.h"
#include "kernels/guiding/guide_sample.h"
#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <random>

namespace sheaf::test_guide_field {

namespace {

constexpr int kTests = 8;  // tests that share the significance level

/// Uniform in [0, 1).
float uniform(std::mt19937& random) { return unit_float(static_cast<std::uint32_t>(random())); }

Vec3f uniform_direction(std::mt19937& random) {
  const float u = uniform(random), v = uniform(random);
  return square_to_sphere<Scalar>(u, v);
}

/// Training records with uniformly sampled directions; `of` is the integrand per steradian. The BSDF is uniform too.
template <class F> std::vector<GuideRecord> records_of(int count, F&& of, Vec3f p = {0, 0, 0}) {
  std::mt19937 random(3);
  std::vector<GuideRecord> records;
  for (int i = 0; i < count; ++i) {
    const Vec3f d = uniform_direction(random);
    const float weight = of(d) / kUniformSpherePdf;
    records.push_back({p, encode_octahedral<Scalar>(d), weight, kUniformSpherePdf, 4u, weight});
  }
  return records;
}

/// An unnormalized von Mises-Fisher lobe of concentration `kappa` around `middle`, with peak value 1.
float lobe(Vec3f d, Vec3f middle, float kappa) { return std::exp(kappa * (dot(d, middle) - 1)); }

const Vec3f kFirst = normalize(Vec3f{1, 2, 2}), kSecond = normalize(Vec3f{-2, 1, 1});

GuideMixture two_lobes() {
  GuideMixture mixture = first_mixture({0, 0, 0});
  GuideSums sums;
  const auto records = records_of(40000, [](Vec3f d) { return lobe(d, kFirst, 60) + 0.5f * lobe(d, kSecond, 15); });
  for (int pass = 0; pass < 4; ++pass) fit_mixture(records, mixture, sums);
  return mixture;
}

GuideView view_of(const GuideMixture& mixture) {
  GuideView view;
  view.mixtures = &mixture;
  return view;
}

/// A direction sampled from the guide alone; empty if the BSDF is to be sampled.
std::optional<Vec3f> guided(const GuideView& view, const Random4<Scalar>& u) {
  const auto s = sample_guide<Scalar>(view, 0u, 1, u);
  return s.taken ? std::optional(s.direction) : std::nullopt;
}

void check_sampling(const GuideMixture& mixture) {
  const GuideView view = view_of(mixture);
  const auto pdf = [&view](Vec3f d) -> double {
    const GuideValue<Scalar> value = evaluate_guide<Scalar>(view, 0u, 1u, d);
    return double{value.pdf_solid_angle} * (1 - double{value.bsdf_probability});
  };
  const ChiSquare result = chi_square_sphere([&view](const Random4<Scalar>& u) { return guided(view, u); }, pdf);
  CHECK(result.integral == near(1 - mixture.bsdf_probability, 1e-3));
  CHECK(result.p_value > significance_of_each(kTests));
}

}  // namespace

TEST_CASE("guiding: directions follow their pdf and the pdf integrates to one") {
  check_sampling(first_mixture({0, 0, 0}));
  check_sampling(first_mixture({0, -1, 0}));
  check_sampling(two_lobes());
}

TEST_CASE("guiding: lobes of every concentration integrate to one") {
  for (const float kappa : {kMinKappa, 1.0f, 100.0f, kMaxKappa}) {
    CAPTURE(kappa);
    // The pdf depends only on the angle to the mean direction; its integral is in closed form.
    const double peak = double{lobe_peak(kappa)}, k = double{kappa};
    CHECK(2 * 3.141592653589793 * peak * -std::expm1(-2 * k) / k == near(1, 1e-5));
    const Vec3f d = sample_lobe<Scalar>(kFirst, kappa, 0.5f, 0.3f);
    CHECK(length(d) == near(1, 1e-5));
    // Half of all directions lie within the median angle.
    const double median = -std::log(0.5 + 0.5 * std::exp(-2 * k)) / k;
    CHECK(1 - double{dot(d, kFirst)} == near(median, 0.01));
  }
}

TEST_CASE("guiding: SIMD results equal scalar ones and lanes are independent") {
  std::mt19937 random(5);
  const std::vector<GuideMixture> mixtures = {GuideMixture(), two_lobes(), first_mixture({1, 0, 0})};
  GuideView view;
  view.mixtures = mixtures.data();
  for (int round = 0; round < 50; ++round) {
    const WideUint rows = wide_uints([&](int) { return static_cast<std::uint32_t>(random() % mixtures.size()); });
    const auto numbers = [&] { return wide_floats([&](int) { return uniform(random); }); };
    const Random4<Wide> u{numbers(), numbers(), numbers(), numbers()};
    const auto sampled = sample_guide<Wide>(view, rows, kWidth, u);
    const Vec3<Wide> d = square_to_sphere<Wide>(u.y, u.z);
    const auto value = evaluate_guide<Wide>(view, rows, ~0u, d);
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto s = sample_guide<Scalar>(view, rows[lane], 1, {u.x[lane], u.y[lane], u.z[lane], u.w[lane]});
      CHECK(s.taken == lane_of(sampled.taken, lane));
      CHECK(s.bsdf_u == sampled.bsdf_u[lane]);
      if (s.taken) {
        const Vec3f at{sampled.direction.x[lane], sampled.direction.y[lane], sampled.direction.z[lane]};
        CHECK(length(s.direction - at) < 1e-5f);
      }
      const auto v = evaluate_guide<Scalar>(view, rows[lane], 1, {d.x[lane], d.y[lane], d.z[lane]});
      CHECK(v.bsdf_probability == value.bsdf_probability[lane]);
      CHECK(v.pdf_solid_angle == value.pdf_solid_angle[lane]);
    }
  }
}

TEST_CASE("guiding: a fitted mixture approximates the distribution of its training samples") {
  const GuideMixture mixture = two_lobes();
  const GuideView view = view_of(mixture);
  // Weights of the lobes in the integrand, by their integrals: 2 pi (1 - exp(-2 kappa)) / kappa.
  const double first = 1.0 / 60, second = 0.5 / 15, a = double{mixture.bsdf_probability};
  const auto density = [&](Vec3f d) {
    const auto v = evaluate_guide<Scalar>(view, 0u, 1u, d);
    return a * double{kUniformSpherePdf} + (1 - a) * double{v.pdf_solid_angle};
  };
  const double full_angle = 2 * 3.141592653589793;
  const auto guided = [&](Vec3f d) { return evaluate_guide<Scalar>(view, 0u, 1u, d).pdf_solid_angle; };
  CHECK(guided(kFirst) == near(1 / (full_angle * (first + second)), 0.15));
  CHECK(guided(kSecond) == near(0.5 / (full_angle * (first + second)), 0.25));
  CHECK(density(-kFirst) < 0.05);
  CHECK(a < 0.35);  // the BSDF is uniform and explains nothing

  // There is nothing to learn: BSDF sampling is already optimal.
  GuideMixture even = first_mixture({0, 0, 0});
  GuideSums sums;
  const auto records = records_of(20000, [](Vec3f) { return 1.0f; });
  const float before = even.bsdf_probability;
  for (int pass = 0; pass < 4; ++pass) fit_mixture(records, even, sums);
  CHECK(even.bsdf_probability >= 0.9f * before);
  for (const Vec3f d : {kFirst, kSecond, -kFirst})
    CHECK(evaluate_guide<Scalar>(view_of(even), 0u, 1, d).mixed(kUniformSpherePdf) ==
          near(double{kUniformSpherePdf}, 0.3));
}

TEST_CASE("guiding: training samples without radiance leave the mixture valid") {
  GuideMixture mixture = first_mixture({0, 0, 1});
  GuideSums sums;
  const auto records = records_of(100, [](Vec3f) { return 0.0f; });
  fit_mixture(records, mixture, sums);
  const auto v = evaluate_guide<Scalar>(view_of(mixture), 0u, 1, kFirst);
  CHECK(is_finite(v.pdf_solid_angle));
  CHECK(v.bsdf_probability > 0);
}

TEST_CASE("guiding: the mean of a cell is that of the light at its vertices, with earlier passes counting half") {
  std::mt19937 random(11);
  const auto train = [&random](GuideField& field, float found, std::size_t split_records) {
    std::vector<std::vector<GuideRecord>> tasks(3);
    for (auto& task : tasks)
      for (int i = 0; i < 4000; ++i) {
        const Vec3f p{uniform(random), uniform(random), uniform(random)};
        const std::uint32_t row = guide_row<Scalar>(field.view(), 4u, guide_code<Scalar>(field.view(), p));
        task.push_back(
            {p, encode_octahedral<Scalar>(uniform_direction(random)), 1, kUniformSpherePdf, row << 3 | 4u, found});
      }
    field.train(tasks, split_records);
  };
  const auto check_means = [](const GuideField& field, double expected, std::size_t min_cells) {
    std::size_t known = 0;
    for (const float mean : field.means()) {
      if (mean < 0) continue;
      CHECK(mean == near(expected, 1e-5));
      ++known;
    }
    CHECK(known >= min_cells);
  };
  GuideField split, whole;
  for (int pass = 0; pass < 3; ++pass) {
    train(split, 3, 400);
    check_means(split, 3, 10);
  }
  train(whole, 1, 1'000'000);
  check_means(whole, 1, 1);
  train(whole, 4, 1'000'000);
  check_means(whole, (0.5 * 1 + 4) / 1.5, 1);
}

TEST_CASE("guiding: the halves of a cell share its statistics") {
  // Light from one direction in the first pass, from another in the second, in which the cell is split
  constexpr int kRecords = 8000;
  const Vec3f positions[2] = {{0.1f, 0.1f, 0.1f}, {0.9f, 0.9f, 0.9f}};
  GuideField field;
  const auto mixture_at = [&](Vec3f position) {
    const GuideView view = field.view();
    return view.mixtures[guide_row<Scalar>(view, kGuideMedia, guide_code<Scalar>(view, position))];
  };
  std::mt19937 random(21);
  const auto train = [&](Vec3f middle, std::size_t split_records) {
    std::vector<GuideRecord> records;
    for (int i = 0; i < 2 * kRecords; ++i) {
      const Vec3f p = positions[i % 2] + Vec3f{uniform(random), uniform(random), uniform(random)} * 0.05f;
      const std::uint32_t row = guide_row<Scalar>(field.view(), kGuideMedia, guide_code<Scalar>(field.view(), p));
      const Vec3f d = uniform_direction(random);
      const float weight = lobe(d, middle, 30) / kUniformSpherePdf;
      records.push_back({p, encode_octahedral<Scalar>(d), weight, kUniformSpherePdf, row << 3 | kGuideMedia, weight});
    }
    field.train({records}, split_records);
    return records;
  };
  const auto pdf = [](const GuideMixture& mixture, Vec3f d) {
    return double{evaluate_guide<Scalar>(view_of(mixture), 0u, 1u, d).pdf_solid_angle};
  };
  const auto check_same = [&](const GuideMixture& a, const GuideMixture& b) {
    for (const Vec3f d : {kFirst, kSecond}) CHECK(pdf(a, d) == near(pdf(b, d), 1e-3));
  };
  GuideMixture expected = first_mixture({0, 0, 0});
  GuideSums sums;
  fit_mixture(train(kFirst, 1'000'000), expected, sums);
  check_same(mixture_at(positions[0]), expected);
  const std::vector<GuideRecord> records = train(kSecond, kRecords + kRecords / 2);
  // Each half has half of the statistics, and its own records
  halve(sums);
  for (std::size_t half = 0; half < 2; ++half) {
    GuideMixture mixture = expected;
    GuideSums of_half = sums;
    std::vector<GuideRecord> own;
    for (std::size_t i = half; i < records.size(); i += 2) own.push_back(records[i]);
    fit_mixture(own, mixture, of_half);
    check_same(mixture_at(positions[half]), mixture);
  }
}

TEST_CASE("guiding: cells shrink with the number of training samples and do not depend on threads") {
  std::mt19937 random(8);
  std::vector<std::vector<GuideRecord>> tasks(7);
  for (std::size_t task = 0; task < tasks.size(); ++task)
    for (int i = 0; i < 3000; ++i) {
      const Vec3f p{uniform(random) * (i % 2 == 0 ? 0.01f : 8.0f), uniform(random), uniform(random)};
      const Vec3f to = normalize((p.x < 4 ? Vec3f{4, 0, 9} : Vec3f{4, 9, 0}) - p);
      const Vec3f d = uniform_direction(random);
      const float weight = lobe(d, to, 30);
      tasks[task].push_back({p, encode_octahedral<Scalar>(d), weight, kUniformSpherePdf,
                             static_cast<std::uint32_t>(i % 3 == 0 ? kGuideMedia : 4u), weight});
    }
  std::vector<std::byte> expected;
  for (const std::size_t threads : {1u, 2u, 7u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    GuideField field;
    for (int pass = 0; pass < 3; ++pass) {
      auto told = tasks;
      for (auto& task : told)
        for (GuideRecord& r : task)
          r.row_and_side |= guide_row<Scalar>(field.view(), r.side(), guide_code<Scalar>(field.view(), r.p)) << 3;
      field.train(told, 400);
    }
    const GuideView view = field.view();
    CHECK(field.cells() > 40);
    std::vector<std::byte> bytes((field.cells() + 1) * sizeof(GuideMixture));
    std::memcpy(bytes.data(), view.mixtures, bytes.size());
    if (expected.empty()) expected = bytes;
    CHECK(bytes == expected);

    const auto row = [&view](std::uint32_t side, Vec3f p) {
      return guide_row<Scalar>(view, side, guide_code<Scalar>(view, p));
    };
    // Cells are small where half of the records are.
    CHECK(row(4, {0.001f, 0.2f, 0.2f}) != row(4, {0.001f, 0.8f, 0.2f}));
    CHECK(row(4, {1, 0.5f, 0.5f}) != row(kGuideMedia, {1, 0.5f, 0.5f}));
    CHECK(row(4, {7, 0.5f, 0.5f}) != row(4, {1, 0.5f, 0.5f}));
    // Every position, even an invalid one, has a valid row.
    for (const float x : {-1e9f, 1e9f, -kInfinity, std::nanf("")}) CHECK(row(3, {x, 0, 0}) <= field.cells());
    // SIMD lookups find the same rows.
    for (int round = 0; round < 20; ++round) {
      const auto numbers = [&](float scale) { return wide_floats([&](int) { return scale * uniform(random); }); };
      const Vec3<Wide> p{numbers(8), numbers(1), numbers(1)};
      const WideUint side = wide_uints([&](int) { return static_cast<std::uint32_t>(random() % kGuideSides); });
      const WideUint rows = guide_row<Wide>(view, side, guide_code<Wide>(view, p));
      for (int lane = 0; lane < kWidth; ++lane) CHECK(rows[lane] == row(side[lane], {p.x[lane], p.y[lane], p.z[lane]}));
    }
    // The pdf is high in the directions of the training records.
    const auto density = [&](Vec3f p, Vec3f to) {
      return evaluate_guide<Scalar>(view, row(4, p), 1u, normalize(to - p)).pdf_solid_angle;
    };
    CHECK(density({1, 0.5f, 0.5f}, {4, 0, 9}) > 5 * density({1, 0.5f, 0.5f}, {4, 9, 0}));
    CHECK(density({7, 0.5f, 0.5f}, {4, 9, 0}) > 5 * density({7, 0.5f, 0.5f}, {4, 0, 9}));
  }
}

TEST_CASE("guiding: training samples list paths in order with the radiance found beyond each vertex") {
  const auto vertex = [](std::uint32_t path, float over_beta) {
    return GuideVertex{{static_cast<float>(path), over_beta, 0}, 0, over_beta, 1, 4, path};
  };
  TrainingSamples log;
  log.begin(3);
  log.add(vertex(2, 1), 0);
  log.add(vertex(0, 1), 0.25f);
  log.add(vertex(2, 2), 0.5f);
  log.add(vertex(1, 1), 0);
  log.add(vertex(2, 4), 0.5f);
  log.finish(2, 1.5f);
  log.finish(0, 1);
  log.finish(1, std::nanf(""));
  const GuideMixture mixture;
  const auto records = log.records(view_of(mixture), {});
  REQUIRE(records.size() == 5);
  const float found[] = {0.75f, 0, 1.5f, 2, 4}, paths[] = {0, 1, 2, 2, 2};
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(records[i].found == found[i]);
    CHECK(records[i].weight == found[i]);
    CHECK(records[i].p.x == paths[i]);
  }
  // With a mean of 3 per vertex, a record holds the light found at the next vertex plus the mean times the remaining
  // weight.
  const float means[] = {3.0f};
  const auto smooth = log.records(view_of(mixture), means);
  const float weights[] = {0.75f, 0, 0.5f + 0.5f * 3, 0 + 0.5f * 3, 4};
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(smooth[i].found == found[i]);
    CHECK(smooth[i].weight == weights[i]);
  }
}

}  // namespace sheaf::test_guide_field
