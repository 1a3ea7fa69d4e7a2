// Minified textures: less noise, the same means, and bits that do not depend on the division of the work.
#include "core/image/image.h"
#include "core/sampling/rng.h"
#include "tests/support/render_testing.h"
#include "tests/support/same_bits.h"

#include <memory>

namespace sheaf::test_texture_footprints {

namespace {

/// A floor with an image of noise, seen at a grazing angle under a constant sky, and a mirror behind it.
Description noisy_floor(TextureFilter filter, std::uint32_t samples) {
  Description d = empty_scene(32, 16);
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = samples;
  look_at(d, {0, 0.5f, -6}, {0, 0, 0}, {0, 1, 0}, 40);
  auto image = std::make_shared<Image>(2048, 2048, std::vector<std::string>{"R", "G", "B"});
  for (std::size_t i = 0; i < image->data.size(); ++i)
    image->data[i] = random4<Scalar>(1, static_cast<std::uint32_t>(i), 0, 0).x < 0.5f ? 0.0f : 1.0f;
  BitmapDescription bitmap;
  bitmap.made = std::move(image);
  bitmap.filter = filter;
  d.textures.emplace_back().model = bitmap;
  const MaterialId floor = add_two_sided(d, add_material(d, DiffuseDescription{TextureId{0}}));
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({5, 5, 1}), floor);
  add_rectangle(d, Transform::translate({0, 2, 5}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({5, 2, 1}),
                add_mirror(d, 0.9f));
  add_constant_light(d, 1);
  return d;
}

/// Mean, over the pixels that show the floor, and mean squared difference between the two images of two seeds.
struct Noise {
  MeanVariance pixels;
  double variance = 0;
};

Noise noise_of(Description d) {
  Image images[2];
  for (Image& image : images) {
    image = render(*compile_scene(d), {}).to_image();
    ++d.sampler.seed;
  }
  Noise noise;
  for (int y = 0; y < images[0].height; ++y)
    for (int x = 0; x < images[0].width; ++x) {
      const double a = static_cast<double>(images[0].at(x, y, 0)), b = static_cast<double>(images[1].at(x, y, 0));
      noise.pixels.add(a);
      noise.variance += (a - b) * (a - b) / 2 / (images[0].width * images[0].height);
    }
  return noise;
}

}  // namespace

TEST_CASE("texture footprints: minified textures are less noisy and have the same mean") {
  const Noise filtered = noise_of(noisy_floor(TextureFilter::kBilinear, 16)),
              nearest = noise_of(noisy_floor(TextureFilter::kNearest, 16));
  INFO("variances " << filtered.variance << " and " << nearest.variance);
  CHECK(filtered.variance < 0.25 * nearest.variance);
  // Standard error of the difference of means, from the noise
  const double error = std::sqrt((filtered.variance + nearest.variance) / (32 * 16));
  CHECK(std::fabs(filtered.pixels.mean() - nearest.pixels.mean()) < 3 * error + 1e-3);
}

TEST_CASE("texture footprints: bits do not depend on threads, waves and crops") {
  check_same_bits(*compile_scene(noisy_floor(TextureFilter::kBilinear, 4)));
}

}  // namespace sheaf::test_texture_footprints
