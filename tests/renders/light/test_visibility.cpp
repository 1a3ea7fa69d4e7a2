// Ambient occlusion and average visibility under the same names in all dialects and on the command line.
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/read_scene.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <string>

namespace sheaf::test_visibility {

namespace {

/// An infinite floor and wall, seen where they meet, with lights, media and glass that these integrators ignore.
constexpr const char* kMitsuba = R"(<scene version="3.0.0">INTEGRATOR
  <sensor type="perspective"><float name="fov" value="0.01"/>
    <transform name="to_world"><lookat origin="1,2,0" target="0.01,0,0" up="0,0,1"/></transform>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film>
    <sampler type="independent"><integer name="sample_count" value="64"/></sampler></sensor>
  <shape type="rectangle"><transform name="to_world"><scale value="1000"/><rotate x="1" angle="90"/></transform>
    <bsdf type="dielectric"/></shape>
  <shape type="rectangle"><transform name="to_world"><scale value="1000"/><rotate y="1" angle="-90"/></transform>
    <emitter type="area"><rgb name="radiance" value="7"/></emitter></shape>
  <shape type="sphere"><float name="radius" value="3"/><bsdf type="null"/>
    <medium name="interior" type="homogeneous"><rgb name="sigma_t" value="9"/></medium></shape>
  <emitter type="constant"/></scene>)";

constexpr const char* kPbrt = R"(INTEGRATOR
LookAt 1 2 0  0.01 0 0  0 0 1
Camera "perspective" "float fov" 0.01
Film "rgb" "integer xresolution" 16 "integer yresolution" 16
Sampler "independent" "integer pixelsamples" 64
WorldBegin
LightSource "infinite"
Material "dielectric"
Shape "bilinearmesh" "point3 P" [-1000 0 -1000  1000 0 -1000  -1000 0 1000  1000 0 1000]
AttributeBegin
AreaLightSource "diffuse"
Shape "bilinearmesh" "point3 P" [0 -1000 -1000  0 1000 -1000  0 -1000 1000  0 1000 1000]
AttributeEnd
)";

std::string with(std::string text, const std::string& integrator) {
  return text.replace(text.find("INTEGRATOR"), 10, integrator);
}

Description read(const std::string& text, const char* name) {
  const TemporaryFolder folder;
  write_bytes(folder / name, text);
  return read_scene(folder / name);
}

/// 16384 directions, each occluded or not, have a standard error of 0.004.
void check_half(const Description& d) { check_mean(pixel_means(d)[1], 0.5, 1e-4, 1e-3); }

}  // namespace

TEST_CASE("ambient occlusion: a point beside a wall is half occluded in every dialect and on the command line") {
  check_half(read(with(kMitsuba, "<integrator type='ao'/>"), "scene.xml"));
  check_half(read(with(kPbrt, "Integrator \"ambientocclusion\""), "scene.pbrt"));
  check_half(read(with(kPbrt, "Integrator \"ao\""), "scene.pbrt"));
  for (const char* const name : {"ao", "ambientocclusion"}) {
    Description mitsuba = read(with(kMitsuba, "<integrator type='photonmapper'/>"), "scene.xml");
    apply_integrator_name(name, false, mitsuba);
    check_half(mitsuba);
    Description pbrt = read(with(kPbrt, "Integrator \"volpath\""), "scene.pbrt");
    apply_integrator_name(name, false, pbrt);
    check_half(pbrt);
  }
}

TEST_CASE("average visibility: images match with and without a length in every dialect") {
  // Half of the directions around the normal of the floor hit the wall, at any distance.
  check_half(read(with(kMitsuba, "<integrator type='av'/>"), "scene.xml"));
  Description d = read(with(kMitsuba, "<integrator type='path'/>"), "scene.xml");
  apply_integrator_name("av", false, d);
  check_half(d);
  check_half(read(with(kPbrt, "Integrator \"av\""), "scene.pbrt"));
  // With this length, the wall is too far away to be hit.
  for (const Description& scene : {read(with(kMitsuba,
                                             "<integrator type='av'><float name='length' value='1e-4'/>"
                                             "</integrator>"),
                                        "scene.xml"),
                                   read(with(kPbrt, "Integrator \"av\" \"float length\" 1e-4"), "scene.pbrt")})
    CHECK(pixel_means(scene)[1].mean() == near(1));
}

}  // namespace sheaf::test_visibility
