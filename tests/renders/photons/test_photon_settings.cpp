// Photon mapping in course scenes: the effect of every property and every integrator name on the image.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/xml_elements.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace sheaf::test_photon_settings {

using namespace test;

namespace {

/// A glass sphere on a floor below a lamp, optionally in fog.
std::string scene_of(const std::string& integrator, bool fog) {
  const std::string medium =
      "<medium type='homogeneous'><color name='sigma_a' value='0.05,0.05,0.05'/>"
      "<color name='sigma_s' value='0.3,0.3,0.3'/></medium>";
  const std::string filled =
      "<mesh type='sphere'><point name='center' value='0,1,0'/><float name='radius' value='8'/>"
      "<bsdf type='null'/>" +
      medium + "</mesh>";
  return "<scene>" + integrator + (fog ? filled : "") +
         "<camera type='perspective'><float name='fov' value='40'/><transform name='toWorld'>"
         "<lookat origin='0,1,4' target='0,0.6,0' up='0,1,0'/></transform>"
         "<integer name='width' value='32'/><integer name='height' value='24'/><rfilter type='box'/>" +
         "</camera><sampler type='independent'><integer name='sampleCount' value='4'/></sampler>"
         "<mesh type='sphere'><point name='center' value='0,0.6,0'/><float name='radius' value='0.5'/>"
         "<bsdf type='dielectric'/></mesh>"
         "<mesh type='parallelogram'><point name='origin' value='-2,0,2'/><vector name='u' value='4,0,0'/>"
         "<vector name='v' value='0,0,-4'/><bsdf type='diffuse'><color name='albedo' value='0.6,0.6,0.6'/></bsdf>"
         "</mesh><mesh type='sphere'><point name='center' value='0.6,3,0.3'/><float name='radius' value='0.15'/>"
         "<emitter type='area'><color name='radiance' value='60,60,60'/></emitter></mesh></scene>";
}

struct Rendering {
  std::vector<float> data;
  double mean = 0;
  double roughness = 0;  ///< mean difference of neighbors over the mean
  double peak = 0;       ///< brightest pixel of the floor
  double stored = 0;     ///< photons
  std::uint32_t spp = 0;
};

const std::string kFew = integer("photonCount", "4000") + number("photonRadius", "0.15");

/// `samples`: per pixel; 0: as the scene says.
Rendering rendering(const std::string& properties, const std::string& type = "photonmapper", bool fog = false,
                    std::uint32_t seed = 3, std::uint32_t samples = 0) {
  const Description d = read_text(
      scene_of("<integrator type='" + type + "'>" + properties + integer("maxDepth", "6") + "</integrator>", fog));
  RenderOptions options;
  options.seed = seed;
  if (samples > 0) options.samples_per_pixel = samples;
  const RenderResult result = render(*compile_scene(d), options);
  const Image image = result.film.to_image();
  Rendering out;
  out.data = image.data;
  out.stored = static_cast<double>(result.report.photons.stored);
  out.spp = result.report.spp;
  for (int y = 12; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double v = static_cast<double>(image.at(x, y, 1));
      out.mean += v / (12 * image.width);
      out.peak = std::max(out.peak, v);
      if (x > 0) out.roughness += std::fabs(v - static_cast<double>(image.at(x - 1, y, 1))) / (12 * image.width);
    }
  out.roughness /= out.mean;
  return out;
}

/// Checks that photon mapping with these properties has the mean of path tracing, over several seeds. Blur across the
/// edges of surfaces may change it by 3 %.
void check_same_mean_as_paths(const std::string& properties, bool fog = false, std::uint32_t repeats = 16) {
  // Standard errors 0.5 % and 1 %
  static const std::array<double, 2> expected{rendering("", "path_mis", false, 1, 1024).mean,
                                              rendering("", "path_mis", true, 1, 256).mean};
  MeanVariance found;
  for (std::uint32_t seed = 0; seed < repeats; ++seed)
    found.add(rendering(properties, "photonmapper", fog, 100 + seed).mean);
  const double right = expected[fog ? 1 : 0];
  CHECK(found.variance() < repeats * std::pow(0.12 * right, 2));
  check_mean(found, right, significance_of_each(7), 0.03 * right);
}

}  // namespace

TEST_CASE("photon settings: counts and radii are read") {
  const Rendering plain = rendering(kFew);
  const Rendering more = rendering(integer("photonCount", "16000") + number("photonRadius", "0.15"));
  CHECK(more.stored == near(4 * plain.stored, 0.1));
  CHECK(more.roughness < 0.9 * plain.roughness);
  const Rendering wide = rendering(integer("photonCount", "4000") + number("photonRadius", "0.6"));
  CHECK(wide.stored == plain.stored);
  CHECK(wide.roughness < 0.6 * plain.roughness);
  const Rendering nearest = rendering(kFew + integer("lookupSize", "4"));
  CHECK(nearest.roughness > 1.3 * plain.roughness);
  for (const char* kernel : {"cone", "epanechnikov"}) {
    const Rendering other = rendering(kFew + word("kernel", kernel));
    CHECK(other.data != plain.data);
    check_same_mean_as_paths(kFew + word("kernel", kernel));
  }
  CHECK(rendering(kFew + word("kernel", "disc")).data == plain.data);
}

TEST_CASE("photon settings: numGatherRays enables final gathering") {
  const Rendering plain = rendering(kFew);
  const Rendering gathered = rendering(kFew + integer("numGatherRays", "4"));
  CHECK(gathered.data == rendering(kFew + flag("finalGather") + integer("numGatherRays", "4")).data);
  CHECK(gathered.spp == 4 * plain.spp);
  check_same_mean_as_paths(kFew + integer("numGatherRays", "4"));
  CHECK(rendering(kFew + integer("numGatherRays", "1")).data == rendering(kFew + flag("finalGather")).data);
  CHECK(rendering(kFew + integer("numGatherRays", "0")).data == plain.data);
  // Final gathering is disabled explicitly.
  CHECK(rendering(kFew + integer("numGatherRays", "4") + "<boolean name='finalGather' value='false'/>").data ==
        plain.data);
}

TEST_CASE("photon settings: causticPhotonCount enables a caustic map with causticRadius") {
  const Rendering plain = rendering(kFew);
  const std::string caustics = integer("causticPhotonCount", "4000");
  const Rendering sharp = rendering(kFew + caustics + number("causticRadius", "0.04"));
  const Rendering blurred = rendering(kFew + caustics + number("causticRadius", "0.5"));
  CHECK(sharp.stored > plain.stored + 3000);
  CHECK(sharp.peak > 1.1 * plain.peak);
  CHECK(blurred.peak < 0.8 * plain.peak);
  check_same_mean_as_paths(kFew + caustics + number("causticRadius", "0.04"));
  CHECK(rendering(kFew + integer("causticPhotonCount", "0") + number("causticRadius", "0.04")).data == plain.data);
  // Caustic maps combined with final gathering and with direct light sampling.
  const Rendering both = rendering(kFew + caustics + number("causticRadius", "0.04") + integer("numGatherRays", "4"));
  CHECK(both.data != rendering(kFew + integer("numGatherRays", "4")).data);
  check_same_mean_as_paths(kFew + caustics + number("causticRadius", "0.04") + integer("numGatherRays", "4"));
  const Rendering sampled = rendering(kFew + flag("sampleDirect"));
  CHECK(sampled.stored < 0.7 * plain.stored);
  CHECK(sampled.roughness < plain.roughness);
  CHECK(rendering(kFew + flag("sampleDirect") + caustics).data != sampled.data);
}

TEST_CASE("photon settings: photons in media are read") {
  const auto in_fog = [](const std::string& properties, const std::string& type = "photonmapper") {
    return rendering(properties, type, true);
  };
  const Rendering plain = in_fog(kFew);
  const std::string volume = integer("volumePhotonCount", "3000");
  const Rendering points = in_fog(kFew + volume + number("volumeRadius", "0.1"));
  CHECK(points.stored == near(plain.stored + 3000, 0.1));
  check_same_mean_as_paths(kFew + volume + number("volumeRadius", "0.1"), true, 48);
  CHECK(in_fog(kFew + volume + number("volumeRadius", "0.4")).roughness < points.roughness);
  const Rendering beams = in_fog(kFew + volume + number("volumeRadius", "0.1") + word("mediumPhotons", "beams"));
  CHECK(beams.data != points.data);
  check_same_mean_as_paths(kFew + volume + number("volumeRadius", "0.1") + word("mediumPhotons", "beams"), true);
  CHECK(in_fog(kFew + volume + number("volumeRadius", "0.1") + word("mediumPhotons", "points")).data == points.data);
  // With photonCount alone, media get as many photons with the same radius. Both can be set separately.
  const Rendering both = in_fog(kFew, "volumetricphotonmapper");
  CHECK(both.data == in_fog(kFew + integer("volumePhotonCount", "4000") + number("volumeRadius", "0.15")).data);
  CHECK(in_fog(kFew + volume, "volumetricphotonmapper").data ==
        in_fog(kFew + volume + number("volumeRadius", "0.15")).data);
  CHECK(in_fog(kFew + number("volumeRadius", "0.3"), "volumetricphotonmapper").data ==
        in_fog(kFew + integer("volumePhotonCount", "4000") + number("volumeRadius", "0.3")).data);
}

TEST_CASE("photon settings: all integrator names and progressive maps are read") {
  const Rendering plain = rendering(kFew);
  CHECK(rendering(kFew, "photonmap").data == plain.data);
  const std::string all = "<boolean name='sampleDirect' value='false'/>";
  const std::string few = all + integer("photonCount", "2000") + number("initialRadius", "0.2");
  const Rendering progressive = rendering(few, "sppm");
  CHECK(rendering(few, "ppm").data == progressive.data);
  CHECK(progressive.stored == near(4 * 2000, 0.2));
  CHECK(rendering(few + integer("maxPasses", "7"), "sppm").spp == 7);
  CHECK(rendering(all + integer("photonCount", "2000") + number("initialRadius", "0.05"), "sppm").roughness >
        1.2 * progressive.roughness);
  CHECK(rendering(few + number("alpha", "0.05"), "sppm").roughness >
        rendering(few + number("alpha", "0.95"), "sppm").roughness);
}

}  // namespace sheaf::test_photon_settings
