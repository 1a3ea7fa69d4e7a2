// Homogeneous media of a tile against the scalar code for single rays.
#include "kernels/media/uniform_medium.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <array>

namespace sheaf::test_uniform_medium {

namespace {

using L = Wide;
using F = Float<L>;

const Spectrum4 kExtinction{0.3f, 1.1f, 2.5f, 0.7f}, kScattering{0.2f, 1.0f, 0.5f, 0.7f};

/// A row of a medium with these coefficients.
MediumRow medium_row(bool scatters) {
  MediumRow row;
  row.flags = kMediumHomogeneous | kMediumAbsorptionScattering | (scatters ? kMediumScatters : 0u);
  const Float4 scattering(scatters ? kScattering : Spectrum4{});
  (Float4(kExtinction) - scattering).store(row.first);
  scattering.store(row.second);
  return row;
}

/// The same coefficients for a tile.
UniformMedium<L> uniform_medium(std::uint32_t hero, bool weighted, bool scatters) {
  const Spectrum4 s = scatters ? kScattering : Spectrum4{}, t = kExtinction;
  return {
      {F(s.c0), F(s.c1), F(s.c2), F(s.c3)}, {F(t.c0), F(t.c1), F(t.c2), F(t.c3)}, Uint<L>(hero), weighted, scatters};
}

/// Calls check(scalar ray, the medium of the tile) for each hero, with and without pdfs of the other lanes.
template <class Check> void for_each_case(Check&& check) {
  SceneView scene{};
  for (const bool scatters : {true, false})
    for (const bool weighted : {true, false})
      for (int hero = 0; hero < 4; ++hero) {
        CAPTURE(scatters);
        CAPTURE(weighted);
        CAPTURE(hero);
        const MediumRow row = medium_row(scatters);
        const MediumSpectra spectra{Float4::load(row.first), Float4::load(row.second), {}};
        const MediumRay ray{scene, row, spectra, {}, {}, {0, 0, 1}, 0.8f, hero, weighted};
        check(ray, uniform_medium(static_cast<std::uint32_t>(hero), weighted, scatters));
      }
}

void check_same(const Spectrum<L>& tile, int lane, Float4 single) {
  const auto found = LaneRows<L, Spectrum>(tile)[lane];
  CHECK(Float4(found)[0] == near(single[0], 1e-5));
  CHECK(Float4(found)[1] == near(single[1], 1e-5));
  CHECK(Float4(found)[2] == near(single[2], 1e-5));
  CHECK(Float4(found)[3] == near(single[3], 1e-5));
}

}  // namespace

TEST_CASE("uniform medium: distances and weights of a tile are those of single rays") {
  for_each_case([](const MediumRay& ray, const UniformMedium<L>& medium) {
    // Lane k has the number (k + 0.5) / width, so that some paths scatter and others pass.
    const F u = make_lanes<F>([](int lane) { return (static_cast<float>(lane) + 0.5f) / L::width; });
    const Spectrum<L> beta{F(0.9f), F(0.8f), F(0.7f), F(0.6f)}, r_u{F(1.0f), F(2.0f), F(0.5f), F(0.25f)};
    TileWeights<L> weights{beta, r_u, r_u};
    const LaneArray<F> t(track_uniform<L>(medium, F(ray.length), u, weights)), numbers(u);
    int scattered = 0;
    for (int lane = 0; lane < L::width; ++lane) {
      CAPTURE(lane);
      const Float4 start(Spectrum4{1.0f, 2.0f, 0.5f, 0.25f});
      PathWeights single{Float4(Spectrum4{0.9f, 0.8f, 0.7f, 0.6f}), start, start};
      CHECK(t[lane] == near(track_homogeneous(ray, numbers[lane], single), 1e-5));
      check_same(weights.beta, lane, single.beta);
      check_same(weights.r_u, lane, single.r_u);
      check_same(weights.r_l, lane, single.r_l);
      if (t[lane] < ray.length) ++scattered;
    }
    CHECK((scattered > 0) == medium.scatters);
    CHECK(scattered < L::width);
  });
}

TEST_CASE("uniform medium: the transmittance of a tile is that of single rays") {
  for_each_case([](const MediumRay& ray, const UniformMedium<L>& medium) {
    const Spectrum<L> passed = medium.transmittance(F(ray.length));
    PathWeights single{Float4(1.0f), Float4(1.0f), Float4(1.0f)};
    pass_homogeneous(ray, true, single);
    check_same(passed, L::width - 1, single.beta);
    check_same(medium.pdf_ratio(passed), L::width - 1, single.r_u);
  });
}

TEST_CASE("uniform medium: weights are rescaled by the largest pdf") {
  TileWeights<L> weights{Spectrum<L>(F(3.0f)), {F(1.0f), F(8e6f), F(0.0f), F(2.0f)}, Spectrum<L>(F(4e6f))};
  weights.rescale();
  check_same(weights.r_u, 0, Float4(Spectrum4{1.0f / 8e6f, 1.0f, 0.0f, 2.0f / 8e6f}));
  check_same(weights.r_l, 0, Float4(0.5f));
  check_same(weights.beta, 0, Float4(3.0f / 8e6f));
}

}  // namespace sheaf::test_uniform_medium
