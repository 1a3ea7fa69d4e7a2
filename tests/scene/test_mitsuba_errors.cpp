// The Mitsuba dialect: rejected input and its messages.
#include <doctest/doctest.h>

#include "tests/support/scene_files.h"

namespace sheaf::test_mitsuba_errors {

using namespace test;

TEST_CASE("Mitsuba: errors have line and fault and nearest name") {
  auto sensor = [](const std::string& inside) {
    return mitsuba_scene("", "<sensor type='perspective'>" + inside + "</sensor>");
  };
  auto film = [&](const std::string& inside) { return sensor("<film type='hdrfilm'>" + inside + "</film>"); };
  auto bsdf = [](const std::string& inside) { return mitsuba_scene("<bsdf type='diffuse'>\n" + inside + "</bsdf>"); };
  struct Case {
    std::string text;
    const char* expected;
  };
  const Case cases[] = {
      {mitsuba_scene("<shape type='spher'/>"), "scene.xml:4: unknown shape plugin 'spher', did you mean 'sphere'?"},
      {mitsuba_scene("<bsdf type='irawan'/>"), "unknown bsdf plugin 'irawan'"},
      {mitsuba_scene("<emitter type='moonlight'/>"),
       "unknown emitter plugin 'moonlight' (known: area, collimated, constant, directional, directionalarea, envmap, "
       "point, projector, sky, spot, sun, sunsky, timed_sunsky)"},
      {mitsuba_scene("<medium type='homogenous'/>"), "unknown medium plugin 'homogenous', did you mean 'homogeneous'?"},
      {mitsuba_scene("<texture type='bitmap' id='x'/>"), "scene.xml:4: texture 'bitmap' needs the string 'filename'"},
      {mitsuba_scene("<emitter type='area'/>"), "emitter 'area' must be nested in a <shape>"},
      {mitsuba_scene("<film type='hdrfilm'/>"),
       "<film> at the top level is not referenced, expected it inside a <sensor>"},
      {mitsuba_scene("<integrator type='path'/>"), "scene.xml:4: a second <integrator>"},
      {mitsuba_scene("<shap type='sphere'/>"), "unknown element <shap> in a Mitsuba scene, did you mean 'shape'?"},
      {mitsuba_scene("<shape/>"), "scene.xml:4: <shape> needs an attribute 'type'"},
      {mitsuba_scene("<shape typ='sphere'/>"), "<shape> has no attribute 'typ', did you mean 'type'?"},
      {mitsuba_scene("<shape type='sphere'><integrator type='path'/></shape>"),
       "shape 'sphere' takes no nested <integrator> (known: bsdf, emitter, sensor, medium, subsurface)"},
      {mitsuba_scene("<shape type='sphere'><bsdf type='diffuse'/><bsdf type='diffuse'/></shape>"),
       "shape 'sphere' has 2 nested <bsdf>, expected one"},
      {mitsuba_scene("<shape type='sphere'><emitter type='point'/></shape>"), "unknown emitter plugin 'point'"},
      {mitsuba_scene("<shape type='cylinder'><point name='p1' x='0'/></shape>"), "'p0' and 'p1' coincide"},
      {mitsuba_scene("<shape type='sphere'><float name='radius' value='0'/></shape>"), "expected a positive number"},
      {mitsuba_scene("<shape type='obj'><string name='filename' value='../gone.obj'/></shape>"),
       "scene.xml:4: file '../gone.obj' not found in "},
      {mitsuba_scene("<shape type='obj'><string name='filename' value='/dev/zero'/></shape>"), "is not a regular file"},
      {bsdf("<rgb name='reflectanc' value='0.5'/>"),
       "scene.xml:5: unknown property 'reflectanc' of bsdf 'diffuse', did you mean 'reflectance'?"},
      {bsdf("<rgb name='reflectance' value='1.5'/>"), "expected values within [0, 1]"},
      {bsdf("<rgb name='reflectance' value='-0.5'/>"), "expected values within [0, 1]"},
      {bsdf("<rgb name='reflectance' value='#12345'/>"), "colour is '#12345', expected #rrggbb"},
      {bsdf("<rgb name='reflectance' vaule='1'/>"), "<rgb> has no attribute 'vaule', did you mean 'value'?"},
      {bsdf("<rgb name='reflectance'/>"), "<rgb> needs an attribute 'value'"},
      {bsdf("<rgb value='0.1'/>"), "<rgb> in bsdf 'diffuse' needs an attribute 'name'"},
      {bsdf("<rgb name='reflectance' value='0'/><float name='reflectance' value='0'/>"), "is set twice"},
      {bsdf("<string name='reflectance' value='red'/>"), "is given as <string>, expected rgb, srgb, spectrum or float"},
      {bsdf("<texture name='reflectance' type='bitmp'/>"),
       "scene.xml:5: unknown texture plugin 'bitmp', did you mean 'bitmap'?"},
      {bsdf("<blackbody name='reflectance' temperature='5000'/>"), "is a blackbody, which only emitters can be"},
      {bsdf("<spectrum name='reflectance' value='500:1'/>"), "at least two wavelength:value pairs"},
      {bsdf("<spectrum name='reflectance' value='600:1, 500:1'/>"), "wavelengths must increase"},
      {bsdf("<spectrum name='reflectance' value='1 2'/>"),
       "expected one number, three numbers of a colour, or wavelength:value pairs"},
      {bsdf("<spectrum name='reflectance' type='uniforn'/>"),
       "unknown spectrum plugin 'uniforn', did you mean 'uniform'?"},
      {bsdf("<spectrum name='reflectance' filename='gone.spd'/>"), "scene.xml:5: file 'gone.spd' not found"},
      {mitsuba_scene("<emitter type='point'><point name='position' x='0'/><transform name='to_world'/></emitter>"),
       "has both 'position' and 'to_world'"},
      {mitsuba_scene("<emitter type='constant'><rgb name='radiance' value='-1'/></emitter>"),
       "expected non-negative values"},
      {mitsuba_scene("", ""), "scene.xml:1: the scene has no <sensor>"},
      {mitsuba_scene("", "<sensor type='fisheye'/>"), "scene.xml:2: unknown sensor plugin 'fisheye'"},
      {sensor("<float name='fov' value='180'/>"), "is '180', expected a number between 0 and 180"},
      {sensor("<float name='fov' value='30'/><string name='focal_length' value='50mm'/>"), "has both 'fov' and"},
      {sensor("<string name='focal_length' value='50cm'/>"), "property 'focal_length' is '50cm', expected a number"},
      {sensor("<string name='fov_axis' value='z'/>"), "expected x, y, diagonal, smaller or larger"},
      {sensor("<float name='near_clip' value='0'/>"), "property 'near_clip' of sensor 'perspective' is '0'"},
      {sensor("<float name='near_clip' value='5'/><float name='far_clip' value='5'/>"),
       "property 'far_clip' of sensor 'perspective' puts the far plane at 5.000000, expected it beyond the near plane"},
      {sensor("<float name='near_clip' value='20000'/>"), "property 'near_clip' of sensor 'perspective' puts the far"},
      {mitsuba_scene("", "<sensor type='thinlens'/>"), "sensor 'thinlens' has no 'aperture_radius'"},
      {mitsuba_scene("", "<sensor type='thinlens'><float name='aperture_radius' value='-1'/></sensor>"),
       "property 'aperture_radius' of sensor 'thinlens' is '-1'"},
      {mitsuba_scene("", "<sensor type='orthographic'><float name='fov' value='40'/></sensor>"),
       "unknown property 'fov' of sensor 'orthographic'"},
      {mitsuba_scene("", "<sensor type='ortographic'/>"), "did you mean 'orthographic'?"},
      {sensor("<sampler type='sobl'/>"), "unknown sampler plugin 'sobl', did you mean 'sobol'?"},
      {sensor("<sampler type='sobol'><integer name='sample_count' value='999999999'/></sampler>"),
       "is '999999999', expected an integer from 1 to 16777216"},
      {film("<integer name='width' value='-3'/>"), "is '-3', expected an integer from 1"},
      {film("<integer name='width' value='99999'/><integer name='height' value='99999'/>"), "at most 10^9"},
      {film("<float name='width' value='8.5'/>"), "property 'width' is '8.5', expected an integer"},
      {film("<string name='width' value='8'/>"), "is given as <string>, expected integer"},
      {film("<integer name='crop_offset_x' value='8'/><integer name='crop_width' value='768'/>"),
       "reaches beyond the film of 768 x 576"},
      {film("<integer name='crop_offset_x' value='768'/>"), "reaches beyond the film of 768 x 576"},
      {film("<rfilter type='gaus'/>"), "unknown rfilter plugin 'gaus'"},
      {film("<rfilter type='gaussian'><float name='stddef' value='1'/></rfilter>"), "did you mean 'stddev'?"},
      {mitsuba_scene("", "<sensor type='perspective'/>", "<integrator type='radiosity'/>"),
       "scene.xml:3: unknown integrator plugin 'radiosity'"},
      {mitsuba_scene("", "<sensor type='perspective'/>", "<integrator type='moment'/>"), "has no nested <integrator>"},
      {mitsuba_scene("", "<sensor type='perspective'/>",
                     "<integrator type='path'><integer name='maxDept' value='1'/></integrator>"),
       "unknown property 'maxDept' of integrator 'path', did you mean 'max_depth'?"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const std::string message = error_of_text(c.text);
    CHECK_MESSAGE(contains(message, c.expected), message);
    CHECK(message.starts_with("scene.xml:"));
  }
}

}  // namespace sheaf::test_mitsuba_errors
