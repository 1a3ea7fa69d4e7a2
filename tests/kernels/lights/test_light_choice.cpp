// Light selection probabilities: those that light sampling uses, against those for paths that hit the light by BSDF
// sampling. The latter know the vertex only by their ray's origin and a rounded normal.
#include "kernels/stages/light_sample_context.h"
#include "scene/compile/compile.h"
#include "scene/surfaces/shape.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace sheaf::test_light_choice {

namespace {

class Vertices {
 public:
  Vec3f direction() { return normalize(Vec3f{normal_(random_), normal_(random_), normal_(random_)}); }
  float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  Vec3f point(float extent) { return {uniform(-extent, extent), uniform(-extent, extent), uniform(-extent, extent)}; }

 private:
  std::mt19937 random_{5};
  std::normal_distribution<float> normal_;
};

/// Lights of all sizes and radiances, rectangles and spheres, in a room of 10 m.
Description lamps(int count) {
  Description d = empty_scene(4, 4);
  Vertices v;
  for (int i = 0; i < count; ++i) {
    const Vec3f at = v.point(5);
    const float size = std::exp(v.uniform(-5, 0)), radiance = std::exp(v.uniform(-4, 4));
    if (i % 2 == 0)
      add_area_light_sphere(d, at, size, radiance);
    else
      add_area_light_rectangle(d,
                               Transform::translate(at) * Transform::rotate(v.direction(), v.uniform(0, 180)) *
                                   Transform::scale({size, size, 1}),
                               radiance);
  }
  return d;
}

/// Whether a light emits towards `p`; rectangles are one-sided.
bool shines(const SceneView& scene, std::uint32_t light, Vec3f p) {
  const LightRow& row = scene.lights.rows[light];
  if (!row.is(kLightKind<RectangleLightKind>)) return true;
  const LightTriangleRow& t = scene.lights.triangles[row.data<MeshLightData>().first_triangle];
  return dot(p - t.p, t.normal) > 0.0f;
}

}  // namespace

TEST_CASE("choice of lights: the MIS weights of light and BSDF sampling add up to one") {
  for (const int count : {3, 40}) {
    const auto scene = compile_scene(lamps(count));
    const SceneView view = scene->view();
    REQUIRE(view.light_selector == LightSelector::kBvh);
    Vertices v;
    double worst = 0, sum = 0;
    int pairs = 0, above = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3f p = v.point(5), ng = v.direction();
      const Vec3f ns = normalize(ng + v.direction() * 0.2f), wi = v.direction();
      const float offset = kOffsetUlps * (dot(abs(ng), abs(p)) + max_component(abs(p)));
      const LightSampleContext<Scalar> sampled = surface_receiver<Scalar>(p, ns);
      const RayState<Scalar> ray{offset_origin<Scalar>(p, ng, offset, wi), kInfinity, wi, 0};
      const auto found = light_sample_context<Scalar>(ray, encode_octahedral<Scalar>(ns), 0.0f);
      for (std::uint32_t light = 0; light < view.lights.count; ++light) {
        if (!shines(view, light, p)) continue;
        const double a = choice_probability<Scalar>(view, sampled, light);
        const double b = choice_probability<Scalar>(view, found, light);
        REQUIRE(a + b > 0);
        // Maximum error of the sum of the two power heuristics, over all pdfs of BSDF sampling.
        const double miss = std::fabs(a - b) / (a + b);
        worst = std::max(worst, miss);
        sum += miss;
        above += miss > 1e-4;
        ++pairs;
      }
    }
    MESSAGE(count << " lights: the MIS weights differ from one by at most " << worst << ", " << sum / pairs
                  << " on average, and by more than 1e-4 in " << 100.0 * above / pairs << " % of the cases");
    // The rest are points that almost touch a light, where the offset of the ray's origin matters.
    CHECK(sum / pairs < 5e-6);
    CHECK(above < pairs / 1000);
    CHECK(worst < 0.02);
  }
}

}  // namespace sheaf::test_light_choice
