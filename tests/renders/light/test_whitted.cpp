// Integrators of Whitted 1980, whose paths continue at mirrors only, and Nori's exercises ambient occlusion and average
// visibility.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace sheaf::test_whitted {

using namespace test;

namespace {

double mean_of(const std::string& text) {
  const Image image = render(*compile_scene(read_text(text)), {}).film.to_image();
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += image.at(x, y, 0);
  return sum / (image.width * image.height);
}

}  // namespace

TEST_CASE("whitted: mirrors show directly lit floors but floors show no indirect light") {
  const auto scene = [](const char* integrator) {
    return mitsuba_scene(R"(
      <shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="180"/></transform>
        <bsdf type="conductor"/></shape>
      <shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
      <shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate x="1" angle="90"/>
        <translate y="4"/></transform><bsdf type="diffuse"/></shape>
      <emitter type="point"><point name="position" value="1, 2, -2"/><rgb name="intensity" value="10"/></emitter>)",
                         R"(<sensor type="perspective"><float name="fov" value="0.2"/><transform name="to_world">
        <lookat origin="0, 1, -2" target="0, 0.5, 0" up="0, 1, 0"/></transform><film type="hdrfilm">
        <integer name="width" value="16"/><integer name="height" value="16"/></film>
        <sampler type="sobol"><integer name="sample_count" value="16"/></sampler></sensor>)",
                         std::string("<integrator type='") + integrator + "'/>");
  };
  const double expected = 0.5 / std::numbers::pi * 10 * (2 / std::sqrt(5.0)) / 5;
  CHECK(mean_of(scene("whitted")) == near(expected, 0.003));
  CHECK(mean_of(scene("path")) > 1.05 * expected);
}

TEST_CASE("ambient occlusion: a point beside an infinite wall sees half of the sky for every material") {
  const std::string text = R"(<scene><integrator type="ao"/><sampler type="independent">
      <integer name="sampleCount" value="64"/></sampler>
    <camera type="perspective"><float name="fov" value="0.01"/><transform name="toWorld">
      <lookat origin="1, 2, 0" target="0.01, 0, 0" up="0, 0, 1"/></transform>
      <integer name="width" value="16"/><integer name="height" value="16"/></camera>
    <mesh type="rectangle"><transform name="toWorld"><scale value="1000"/><rotate axis="1,0,0" angle="-90"/></transform>
      <bsdf type="mirror"/></mesh>
    <mesh type="rectangle"><transform name="toWorld"><scale value="1000"/><rotate axis="0,1,0" angle="90"/></transform>
      <emitter type="area"><color name="radiance" value="7"/></emitter></mesh></scene>)";
  // 16384 directions, each occluded or not, have a standard error of 0.004.
  CHECK(std::abs(mean_of(text) - 0.5) < 0.016);
}

TEST_CASE("average visibility: a floor below a ceiling sees hits beyond the length and misses") {
  const auto scene = [](const char* target, const char* length) {
    return R"(<scene><integrator type="av"><float name="length" value=")" + std::string(length) + R"("/></integrator>
    <sampler type="independent"><integer name="sampleCount" value="64"/></sampler>
    <camera type="perspective"><float name="fov" value="0.01"/><transform name="toWorld">
      <lookat origin="1, 0.5, 0" target=")" +
           target + R"(" up="0, 0, 1"/></transform>
      <integer name="width" value="16"/><integer name="height" value="16"/></camera>
    <mesh type="rectangle"><transform name="toWorld"><scale value="1000"/><rotate axis="1,0,0" angle="-90"/></transform>
      <bsdf type="mirror"/></mesh>
    <mesh type="rectangle"><transform name="toWorld"><scale value="1000"/><rotate axis="1,0,0" angle="90"/>
      <translate value="0, 1, 0"/></transform><bsdf type="dielectric"/></mesh></scene>)";
  };
  // Over a uniform hemisphere the cosine is uniform, and the ceiling is within the length where it exceeds 1 / 2.5.
  // 16384 directions, each occluded or not, have a standard error of 0.004.
  CHECK(std::abs(mean_of(scene("0, 0, 0", "2.5")) - 0.4) < 0.016);
  CHECK(std::abs(mean_of(scene("0, 1, 0", "4")) - 0.25) < 0.014);
  CHECK(mean_of(scene("0, 0, 0", "0.999")) == 1.0);
  // With a large length, only directions beyond the edge of the ceiling miss it, at a tangent of 1000.
  CHECK(mean_of(scene("0, 0, 0", "1e30")) < 0.005);
  // Parallel to both planes, there are no hits.
  CHECK(mean_of(scene("2, 0.5, 0", "2.5")) == 1.0);
}

}  // namespace sheaf::test_whitted
