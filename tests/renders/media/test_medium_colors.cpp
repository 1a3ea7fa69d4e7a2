// Media on grids with gray absorption and colored scattering: each color has its own extinction.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_medium_colors {

namespace {

const double kLevel = significance_of_each(50);

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("media on grids: every mix of gray and colored coefficients attenuates each color by both") {
  const TemporaryFolder folder;
  const auto ones = write_vol(folder / "ones.vol", 2, 1, [](Vec3f, int) { return 1.0f; });
  const SpectrumDescription gray = SpectrumDescription::constant(0.4f),
                            colored = SpectrumDescription::rgb(0.1f, 0.6f, 2);
  const double both[] = {0.5, 1.0, 2.4};
  for (const bool absorbs_gray : {true, false})
    for (const MediumEstimator estimator :
         {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio}) {
      CAPTURE(absorbs_gray);
      CAPTURE(static_cast<int>(estimator));
      // A wall of radiance 2 behind the cube [0, 1]^3.
      Description d = empty_scene(32, 32);
      d.sampler.sample_count = 32;
      d.sampler.seed = 5;
      look_at(d, {-5, 0.5f, 0.5f}, {0, 0.5f, 0.5f}, {0, 1, 0}, 0.01f);
      d.integrator.max_depth = 1;
      d.integrator.medium_estimator = estimator;
      add_area_light_rectangle(d, Transform::translate({3, 0.5f, 0.5f}) * Transform::rotate({0, 1, 0}, -90), 2);
      add_shape(d, CubeShape{}, Transform::translate({0.5f, 0.5f, 0.5f}) * Transform::scale({0.5f, 0.5f, 0.5f}));
      MediumDescription m;
      m.coefficients = absorbs_gray ? AbsorptionScatteringDescription{gray, colored}
                                    : AbsorptionScatteringDescription{colored, gray};
      m.density = vol(ones);
      fill(d, d.shapes.back(), add_medium(d, m));
      const Image image = render(*compile_scene(d), {}).film.to_image();
      for (int c = 0; c < 3; ++c) {
        CAPTURE(c);
        MeanVariance mean;
        for (int y = 0; y < image.height; ++y)
          for (int x = 0; x < image.width; ++x) mean.add(image.at(x, y, c));
        INFO("mean " << mean.mean() << ", expected " << 2 * std::exp(-both[c]));
        CHECK(mean.p_value(2 * std::exp(-both[c])) >= kLevel);
      }
    }
}

TEST_SUITE_END();

}  // namespace sheaf::test_medium_colors
