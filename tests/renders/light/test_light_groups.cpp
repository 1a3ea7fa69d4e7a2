// Layers with the contribution of each light group.
#include "core/image/exr.h"
#include "core/io/error.h"
#include "tests/support/media_testing.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <set>

namespace sheaf::test_light_groups {

namespace {

/// A sphere on a floor under lights of several kinds, in fog.
Description lit_scene() {
  Description d = empty_scene(12, 10);
  look_at(d, {0, 1.2f, -3}, {0, 0.4f, 0}, {0, 1, 0}, 50);
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  d.sampler.sample_count = 8;
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}),
                add_diffuse_rgb(d, 0.8f, 0.5f, 0.3f));
  add_sphere(d, {0, 0.5f, 0}, 0.5f, add_glass(d));
  add_area_light_sphere(d, {1, 1.5f, 0.5f}, 0.3f, 5).emitter_id = "lamp.left";
  add_area_light_sphere(d, {-1, 1.5f, 0.5f}, 0.2f, 3);
  add_point_light(d, {0, 2, -1}, 2);
  d.lights.back().id = "key";
  add_constant_light(d, 0.2f);
  d.camera.medium = add_medium(d, fog(0.1f, 0.8f));
  return d;
}

Image render_image(const Description& d, ColorMode color = ColorMode::kRgb, FilterMode mode = FilterMode::kWeighted) {
  Description filtered = d;
  filtered.film.filter_mode = mode;
  CompileOptions compile;
  compile.color = color;
  RenderOptions options;
  options.light_groups = true;
  return render(*compile_scene(filtered, compile), options).to_image();
}

/// Indices of the red channels of all groups.
std::vector<int> groups_of(const Image& image) {
  std::vector<int> groups;
  for (std::size_t c = 0; c < image.channels.size(); ++c)
    if (image.channels[c].starts_with("light_") && image.channels[c].ends_with(".R"))
      groups.push_back(static_cast<int>(c));
  return groups;
}

/// Largest difference between the sum of the groups and the image, relative to the image.
double difference_of_sum(const Image& image) {
  const std::vector<int> groups = groups_of(image);
  double worst = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        double sum = 0, size = 1e-3;
        for (const int group : groups) {
          sum += image.at(x, y, group + c);
          size += std::fabs(image.at(x, y, group + c));
        }
        worst = std::max(worst, std::fabs(sum - double{image.at(x, y, c)}) / size);
      }
  return worst;
}

double sum_of(const Image& image, const char* channel) {
  const int c = image.find_channel(channel);
  REQUIRE(c >= 0);
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += double{image.at(x, y, c)};
  return sum;
}

}  // namespace

TEST_CASE("light groups: groups add up to the image in both color modes with any filter and with photon maps") {
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral})
    for (const FilterMode mode : {FilterMode::kWeighted, FilterMode::kImportance}) {
      const Image image = render_image(lit_scene(), color, mode);
      CHECK(groups_of(image).size() == 4);
      CHECK(difference_of_sum(image) < 2e-5);
      for (const char* group : {"light_lamp_left.R", "light_area.R", "light_key.R", "light_environment.R"}) {
        CAPTURE(std::string(group));
        CHECK(sum_of(image, group) > 0);
        CHECK(sum_of(image, group) < 0.9 * sum_of(image, "R"));
      }
    }
  Description mapped = lit_scene();
  mapped.integrator.kind = IntegratorKind::kPhotonMapper;
  mapped.integrator.photons.global.count = 500;
  mapped.integrator.photons.caustic.count = 200;
  mapped.integrator.photons.volume.count = 200;
  const Image image = render_image(mapped);
  CHECK(difference_of_sum(image) < 2e-5);
  CHECK(sum_of(image, "light_other.G") > 0);
}

TEST_CASE("light groups: layers have unique names whatever the names of lights") {
  const std::vector<std::string> hostile = {"a.b",
                                            "a_b",
                                            "a_b_2",
                                            "point",
                                            "other",
                                            "",
                                            "",
                                            "area",
                                            "R",
                                            ".R",
                                            "a.b.R",
                                            "_",
                                            ".",
                                            "k\xc3\xb6y lamp",
                                            "a\nb",
                                            std::string("a\x01") + "b",
                                            "light",
                                            "other_2",
                                            "point_2",
                                            std::string(300, 'x'),
                                            std::string(299, 'x') + "y"};
  Description d = empty_scene(6, 5);
  d.sampler.sample_count = 16;
  add_rectangle(d, Transform::translate({0, 0, 4}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({9, 9, 1}),
                add_diffuse(d, 0.5f));
  for (std::size_t i = 0; i < hostile.size(); ++i) {
    add_point_light(d, {0.1f * static_cast<float>(i), 0, 1}, 1 + static_cast<float>(i));
    d.lights.back().id = hostile[i];
  }
  add_constant_light(d, 0.3f);
  d.lights.back().id = "point";
  add_area_light_sphere(d, {1, 1, 2}, 0.3f, 5);
  const Image image = render_image(d);
  // The two unnamed lights form one group, as do the two called "point". The area light is unnamed as well.
  CHECK(groups_of(image).size() == hostile.size());
  CHECK(std::set<std::string>(image.channels.begin(), image.channels.end()).size() == image.channels.size());
  for (const std::string& channel : image.channels) CHECK(channel.size() < 256);
  CHECK(difference_of_sum(image) < 2e-5);
  for (const int group : groups_of(image))
    CHECK(sum_of(image, image.channels[static_cast<std::size_t>(group)].c_str()) > 0);
  // Valid names are kept.
  for (const char* const name : {"light_a_b.R", "light_a_b_2.R", "light_point.R", "light_other.R", "light_point_2.R"})
    CHECK(image.find_channel(name) >= 0);
  // Layers survive a round trip through a file.
  const TemporaryFolder folder;
  write_exr(folder / "groups.exr", image);
  const Image back = read_exr(folder / "groups.exr");
  REQUIRE(back.channels.size() == image.channels.size());
  for (const std::string& channel : image.channels)
    CHECK(sum_of(back, channel.c_str()) == sum_of(image, channel.c_str()));
  // The contribution of photon maps has its own layer, beside that of a lamp called "other".
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global.count = 500;
  const Image mapped = render_image(d);
  CHECK(groups_of(mapped).size() == hostile.size() + 1);
  CHECK(std::set<std::string>(mapped.channels.begin(), mapped.channels.end()).size() == mapped.channels.size());
  CHECK(difference_of_sum(mapped) < 2e-5);
}

TEST_CASE("light groups: each group contains the light of its own lamp only") {
  // Two rooms with one lamp each.
  Description d = empty_scene(8, 8);
  d.sampler.sample_count = 16;
  const MaterialId gray = add_two_sided(d, add_diffuse(d, 0.5f));
  add_rectangle(d, Transform::translate({0, 0, 4}) * Transform::scale({10, 10, 1}), gray);
  add_rectangle(
      d, Transform::translate({0, 0, 10.5f}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({10, 10, 1}), gray);
  d.camera.to_world = Transform::translate({0, 0, -1});
  for (const float x : {2.0f, -2.0f}) {
    add_point_light(d, {x, 0, 2}, 10);
    d.lights.back().id = x > 0 ? "left" : "right";
  }
  const Image image = render_image(d);
  const int left = image.find_channel("light_left.R"), right = image.find_channel("light_right.R");
  for (int y = 0; y < 8; ++y) {
    CHECK(image.at(1, y, left) > 0);
    CHECK(image.at(1, y, right) == 0);
    CHECK(image.at(6, y, left) == 0);
    CHECK(image.at(6, y, right) > 0);
  }
}

TEST_CASE("light groups: too many groups are rejected and unnamed lights form one group") {
  Description d = empty_scene(2, 2);
  for (std::size_t i = 0; i <= kMaxLightGroups; ++i) add_point_light(d, {0, 0, 1}, 1);
  CHECK(groups_of(render_image(d)).size() == 1);
  for (std::size_t i = 0; i < d.lights.size(); ++i) d.lights[i].id = std::to_string(i);
  CHECK_THROWS_WITH(render_image(d), doctest::Contains("expected at most 64"));
  d.lights.pop_back();
  CHECK(groups_of(render_image(d)).size() == kMaxLightGroups);
  d.integrator.kind = IntegratorKind::kLightTracer;
  CHECK_THROWS_AS(render_image(d), Error);
}

}  // namespace sheaf::test_light_groups
