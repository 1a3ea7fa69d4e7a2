// Lights behind null interfaces, masks and thin dielectrics, in any order. Paths pass them with a probability, shadow
// rays with certainty, and the pdf of finding a light counts from the last vertex: every strategy matches the closed
// form.
#include "tests/support/media_testing.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <functional>
#include <string>
#include <vector>

namespace sheaf::test_passing_estimators {

namespace {

constexpr double kPiD = 3.14159265358979323846;
constexpr float kAlbedo = 0.6f, kOpacity = 0.6f, kIndex = 4;
/// Transmittance color of thin dielectrics.
constexpr float kTint[3] = {0.9f, 0.6f, 0.3f};

/// A plane above the floor, parallel to it.
struct Screen {
  enum Kind { kNull, kMask, kPane } kind;
  float height;
};

/// Fresnel reflectance of an interface at this cosine.
double fresnel(double cosine, double index) {
  const double far = std::sqrt(1 - (1 - cosine * cosine) / (index * index));
  const double s = (cosine - index * far) / (cosine + index * far), p = (index * cosine - far) / (index * cosine + far);
  return (s * s + p * p) / 2;
}

/// Fraction of light that passes a screen at this cosine to its normal.
double passing(const Screen& screen, double cosine, int channel) {
  if (screen.kind == Screen::kNull) return 1;
  if (screen.kind == Screen::kMask) return 1 - double(kOpacity);
  const double once = fresnel(cosine, kIndex);
  return (1 - once) / (1 + once) * kTint[channel];
}

void add_screen(Description& d, const Screen& screen) {
  MaterialId material{};
  if (screen.kind == Screen::kNull) {
    material = add_material(d, NullDescription{});
  } else if (screen.kind == Screen::kMask) {
    const MaterialId black = add_diffuse(d, 0);
    material = add_material(d, MaskDescription{kOpacity, black});
  } else {
    DielectricDescription pane;
    pane.int_ior = kIndex;
    pane.ext_ior = 1;
    pane.thin = true;
    pane.specular_transmittance = SpectrumDescription::rgb(kTint[0], kTint[1], kTint[2]);
    material = add_material(d, pane);
  }
  add_rectangle(d, Transform::translate({0, 0, screen.height}) * Transform::scale({100, 100, 1}), material);
}

/// A diffuse floor at z = 0 that the camera sees at the origin, from below all screens.
Description floor_below(const std::vector<Screen>& screens) {
  Description d = one_point_scene(48);
  look_at_point(d, {0.5f, 0, 0.1f}, {0, 0, 0});
  d.integrator.max_depth = 2;
  d.integrator.thin_dielectrics_are_free = true;
  add_rectangle(d, Transform::scale({100, 100, 1}), add_diffuse(d, kAlbedo));
  for (const Screen& screen : screens) add_screen(d, screen);
  return d;
}

/// A light of constant radiance that fills a cone around the normal of the floor.
struct ConeLight {
  const char* name;
  double radiance, least_cosine;
  std::function<void(Description&)> add;
};

const std::vector<ConeLight>& cone_lights() {
  static const std::vector<ConeLight> all = {
      {"disk", 3, std::sqrt(0.5),
       [](Description& d) {
         const MaterialId black = add_diffuse(d, 0);
         emit(add_shape(d, DiskShape{}, Transform::translate({0, 0, 1}) * Transform::rotate({1, 0, 0}, 180), black), 3);
       }},
      {"sphere", 2, std::sqrt(5.0) / 3,
       [](Description& d) {
         add_area_light_sphere(d, {0, 0, 3}, 2, 2);
       }},
      {"environment", 1, 0, [](Description& d) { add_constant_light(d, 1); }},
  };
  return all;
}

/// Radiance that the floor reflects of a light behind screens.
double reflected(const ConeLight& light, const std::vector<Screen>& screens, int channel) {
  constexpr int kSteps = 20000;
  const double least = light.least_cosine;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = least + (1 - least) * (i + 0.5) / kSteps;
    double fraction = cosine;
    for (const Screen& screen : screens) fraction *= passing(screen, cosine, channel);
    sum += fraction;
  }
  return kAlbedo / kPiD * light.radiance * 2 * kPiD * sum * (1 - least) / kSteps;
}

void check_screens(const std::vector<std::vector<Screen>>& sets) {
  const double level = significance_of_each(static_cast<int>(sets.size() * cone_lights().size()) * 3 * 3);
  for (std::size_t i = 0; i < sets.size(); ++i)
    for (const ConeLight& light : cone_lights())
      for (const NamedStrategy& strategy : kLightStrategies) {
        CAPTURE(i);
        CAPTURE(light.name);
        CAPTURE(strategy.name);
        Description d = floor_below(sets[i]);
        light.add(d);
        d.integrator.strategy = strategy.strategy;
        const PixelMeans found = pixel_means(d);
        for (int c = 0; c < 3; ++c) {
          CAPTURE(c);
          const double expected = reflected(light, sets[i], c);
          check_mean(found[static_cast<std::size_t>(c)], expected, level, 1e-4 * expected);
        }
      }
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("pass-through: all strategies agree on lights behind one and two thin dielectrics") {
  check_screens({{{Screen::kPane, 0.6f}}, {{Screen::kPane, 0.3f}, {Screen::kPane, 0.7f}}});
}

TEST_CASE("pass-through: all strategies agree on near and far lights behind masks and null interfaces") {
  check_screens({{{Screen::kMask, 0.9f}},
                 {{Screen::kNull, 0.2f}, {Screen::kMask, 0.8f}},
                 {{Screen::kMask, 0.4f}, {Screen::kMask, 0.7f}}});
}

TEST_CASE("pass-through: all strategies agree on lights behind a mask and a thin dielectric and a null interface") {
  check_screens({{{Screen::kPane, 0.25f}, {Screen::kNull, 0.5f}, {Screen::kMask, 0.9f}},
                 {{Screen::kMask, 0.15f}, {Screen::kPane, 0.8f}}});
}

TEST_CASE("pass-through: all strategies agree on several unequal lights behind screens") {
  for (const std::vector<Screen>& screens : {std::vector<Screen>{{Screen::kPane, 0.3f}, {Screen::kPane, 0.7f}},
                                             std::vector<Screen>{{Screen::kNull, 0.2f}, {Screen::kMask, 0.8f}}}) {
    CAPTURE(static_cast<int>(screens[0].kind));
    Description d = floor_below(screens);
    cone_lights()[0].add(d);
    add_area_light_sphere(d, {-2.5f, 0, 2.2f}, 1.3f, 6);
    add_area_light_rectangle(d, Transform::translate({0.5f, 2.5f, 1.8f}) * Transform::rotate({1, 0, 0}, 120), 4);
    add_constant_light(d, 0.3f);
    check_strategies_agree(d, significance_of_each(2 * 9));
  }
}

TEST_CASE("pass-through: all strategies agree on a mask whose opacity is a volume texture") {
  const TemporaryFolder folder;
  TextureDescription opacity;
  opacity.model = VolumeTextureDescription{
      vol(write_vol(folder / "opacity.vol", 4, 1, [](Vec3f p, int) { return p.x < 0.5f ? 0.05f : 0.95f; }),
          Transform::translate({-1, -1, 0}) * Transform::scale({2, 2, 1})),
      1};
  Description d = floor_below({});
  d.textures.push_back(opacity);
  const MaterialId black = add_diffuse(d, 0);
  add_rectangle(d, Transform::translate({0, 0, 0.4f}) * Transform::scale({100, 100, 1}),
                add_material(d, MaskDescription{TextureId{0}, black}));
  add_area_light_rectangle(d, Transform::translate({-0.8f, 0, 1}) * Transform::rotate({1, 0, 0}, 180), 4);
  add_constant_light(d, 0.5f);
  check_strategies_agree(d, significance_of_each(9));
}

TEST_SUITE_END();

}  // namespace sheaf::test_passing_estimators
