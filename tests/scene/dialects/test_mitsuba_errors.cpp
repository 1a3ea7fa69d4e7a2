// Rejected scenes of Mitsuba, and their messages.
#include "tests/support/mitsuba_testing.h"
#include "tests/support/scene_errors.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_mitsuba_errors {

using namespace test;

TEST_CASE("Mitsuba: errors of plugins and elements and nesting have line and fault and nearest name") {
  check_errors({
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
  });
}

TEST_CASE("Mitsuba: errors of properties and colors and spectra have line and fault and nearest name") {
  const auto diffuse = [](const std::string& inside) {
    return mitsuba_scene("<bsdf type='diffuse'>\n" + inside + "</bsdf>");
  };
  check_errors({
      {diffuse("<rgb name='reflectanc' value='0.5'/>"),
       "scene.xml:5: unknown property 'reflectanc' of bsdf 'diffuse', did you mean 'reflectance'?"},
      {diffuse("<rgb name='reflectance' value='1.5'/>"), "expected values within [0, 1]"},
      {diffuse("<rgb name='reflectance' value='-0.5'/>"), "expected values within [0, 1]"},
      {diffuse("<rgb name='reflectance' value='#12345'/>"), "color is '#12345', expected #rrggbb"},
      {diffuse("<rgb name='reflectance' vaule='1'/>"), "<rgb> has no attribute 'vaule', did you mean 'value'?"},
      {diffuse("<rgb name='reflectance'/>"), "<rgb> needs an attribute 'value'"},
      {diffuse("<rgb value='0.1'/>"), "<rgb> in bsdf 'diffuse' needs an attribute 'name'"},
      {diffuse("<rgb name='reflectance' value='0'/><float name='reflectance' value='0'/>"), "is set twice"},
      {diffuse("<string name='reflectance' value='red'/>"),
       "is given as <string>, expected rgb, srgb, spectrum or float"},
      {diffuse("<texture name='reflectance' type='bitmp'/>"),
       "scene.xml:5: unknown texture plugin 'bitmp', did you mean 'bitmap'?"},
      {diffuse("<blackbody name='reflectance' temperature='5000'/>"), "is a blackbody, which only emitters can be"},
      {diffuse("<spectrum name='reflectance' value='500:1'/>"), "at least two wavelength:value pairs"},
      {diffuse("<spectrum name='reflectance' value='600:1, 500:1'/>"), "wavelengths must increase"},
      {diffuse("<spectrum name='reflectance' value='1 2'/>"),
       "expected one number, three numbers of a color, or wavelength:value pairs"},
      {diffuse("<spectrum name='reflectance' type='uniforn'/>"),
       "unknown spectrum plugin 'uniforn', did you mean 'uniform'?"},
      {diffuse("<spectrum name='reflectance' filename='gone.spd'/>"), "scene.xml:5: file 'gone.spd' not found"},
      {mitsuba_scene("<emitter type='point'><point name='position' x='0'/><transform name='to_world'/></emitter>"),
       "has both 'position' and 'to_world'"},
      {mitsuba_scene("<emitter type='constant'><rgb name='radiance' value='-1'/></emitter>"),
       "expected non-negative values"},
  });
}

TEST_CASE("Mitsuba: errors of sensors and samplers have line and fault and nearest name") {
  const auto sensor = [](const std::string& inside) {
    return mitsuba_scene("", "<sensor type='perspective'>" + inside + "</sensor>");
  };
  check_errors({
      {mitsuba_scene("", ""), "scene.xml:1: the scene has no <sensor>"},
      {mitsuba_scene("", "<sensor type='fisheye'/>"), "scene.xml:2: unknown sensor plugin 'fisheye'"},
      {sensor("<float name='fov' value='180'/>"), "is '180', expected a number between 0 and 180"},
      {sensor("<float name='fov' value='30'/><string name='focal_length' value='50mm'/>"), "has both 'fov' and"},
      {sensor("<string name='focal_length' value='50cm'/>"), "property 'focal_length' is '50cm', expected a number"},
      {sensor("<string name='fov_axis' value='z'/>"), "expected x, y, diagonal, smaller or larger"},
      {sensor("<float name='near_clip' value='0'/>"), "property 'near_clip' of sensor 'perspective' is '0'"},
      {sensor("<float name='near_clip' value='5'/><float name='far_clip' value='5'/>"),
       "property 'far_clip' of sensor 'perspective' puts the far plane at 5, expected it beyond the near plane"},
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
  });
}

TEST_CASE("Mitsuba: errors of films and integrators have line and fault and nearest name") {
  const auto film = [](const std::string& inside) {
    return mitsuba_scene("", "<sensor type='perspective'><film type='hdrfilm'>" + inside + "</film></sensor>");
  };
  check_errors({
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
  });
}

TEST_CASE("Mitsuba materials: errors of parameters have line and fault and nearest name") {
  check_errors(
      {
          {bsdf("roughconducter"), "scene.xml:4: unknown bsdf plugin 'roughconducter', did you mean 'roughconductor'?"},
          {bsdf("irawan"), "unknown bsdf plugin 'irawan'"},
          {bsdf("irawan"),
           "(known: blendbsdf, bumpmap, circular, coating, conductor, dielectric, difftrans, diffuse, hair, hk, mask,"},
          {"<bsdf type='principled'>\n" + number("rougness", "0") + "</bsdf>",
           "scene.xml:5: unknown property 'rougness' of bsdf 'principled', did you mean 'roughness'?"},
          {bsdf("principled", number("roughness", "1.5")), "is '1.5', expected a number from 0 to 1"},
          {bsdf("principled", number("eta", "1.5") + number("specular", "0.5")), "has both 'eta' and 'specular'"},
          {bsdf("principled", word("roughness", "rough")), "is given as <string>, expected float or texture"},
          {bsdf("principled", "<spectrum name='roughness' value='400:1, 700:0'/>"),
           "is a spectrum, expected a number or a texture"},
          {bsdf("principledthin", number("diff_trans", "2.5")), "expected a number from 0 to 2"},
          {bsdf("principledthin", number("metallic", "0.5")), "unknown property 'metallic' of bsdf 'principledthin'"},
          {bsdf("conductor", word("material", "Aux")),
           "property 'material' of bsdf 'conductor' is 'Aux', expected the name of a metal, did you mean 'Au'? (known: "
           "Ag, Al, AlAs,"},
          {bsdf("conductor", number("eta", "1")), "has only 'eta', expected both 'eta' and 'k'"},
          {bsdf("conductor", number("k", "1")), "has only 'k'"},
          {bsdf("conductor", number("eta", "1") + number("k", "1") + word("material", "Au")),
           "is set together with 'eta' and"},
          {bsdf("conductor", number("ext_eta", "1")), "unknown property 'ext_eta' of bsdf 'conductor'"},
          {bsdf("conductor", number("alpha", "0.1")), "unknown property 'alpha' of bsdf 'conductor'"},
          {bsdf("roughconductor", word("distribution", "fong")), "is 'fong', expected beckmann or ggx"},
          {bsdf("roughconductor", word("distribution", "gxx")), "is 'gxx', expected beckmann or ggx"},
          {bsdf("roughconductor", number("alpha_u", "0.1")),
           "has only 'alpha_u', expected both 'alpha_u' and 'alpha_v', or 'alpha'"},
          {bsdf("roughconductor", number("alphaU", "0.1") + number("alphaV", "0.1") + number("alpha", "0.1")),
           "property 'alpha' of bsdf 'roughconductor' is set together with 'alpha_u' and 'alpha_v'"},
          {bsdf("roughconductor", number("alpha", "-1")), "expected a non-negative number"},
          {bsdf("roughplastic", number("alpha_u", "0.1") + number("alpha_v", "0.2")), "differs from 'alpha_u'"},
          {bsdf("roughplastic", "<texture type='checkerboard' name='alpha'/>"), "is a texture, expected a number"},
          {bsdf("dielectric", word("int_ior", "diamant")),
           "is 'diamant', expected a number or the name of a material, did you mean 'diamond'?"},
          {bsdf("dielectric", number("int_ior", "-1")), "expected a positive number"},
          {bsdf("dielectric", word("int_ior", "pyrex") + "<boolean name='dispersion' value='true'/>"),
           "property 'dispersion' of bsdf 'dielectric' is true, but neither side has a dispersion formula"},
          {bsdf("null", number("opacity", "1")), "unknown property 'opacity' of bsdf 'null'"},
      },
      error_of_elements);
  const std::string old = error_of_text(mitsuba_scene(
      bsdf("conductor", "<texture type='checkerboard' name='eta'/>" + number("k", "1") + number("ext_eta", "1.5")),
      "<sensor type='perspective'/>", "", "0.6.0"));
  CHECK_MESSAGE(contains(old, "is set together with a texture of 'eta' or 'k'"), old);
}

TEST_CASE("Mitsuba materials: errors of nested materials and textures name the fault") {
  const std::string two = bsdf("diffuse") + bsdf("diffuse"), board = "<texture type='checkerboard'/>";
  check_errors(
      {
          {bsdf("twosided"), "has 0 nested <bsdf>, expected one or two"},
          {bsdf("twosided", two + bsdf("diffuse")), "has 3 nested <bsdf>, expected one or two"},
          {bsdf("mask"), "has 0 nested <bsdf>, expected one"},
          {bsdf("mask", two), "has 2 nested <bsdf>, expected one"},
          {bsdf("mask", bsdf("diffuse") + number("opacity", "2")), "expected a number from 0 to 1"},
          {bsdf("blendbsdf", bsdf("diffuse")), "has 1 nested <bsdf>, expected two"},
          {bsdf("bumpmap", bsdf("diffuse")), "bsdf 'bumpmap' has no <texture>, expected one"},
          {bsdf("bumpmap", board), "has 0 nested <bsdf>, expected one"},
          {bsdf("bumpmap", bsdf("diffuse") + board + board), "has a second <texture>, expected one"},
          {bsdf("normalmap", bsdf("diffuse") + "<rgb value='1'/><rgb value='1'/>"), "needs an attribute 'name'"},
          {bsdf("normalmap", bsdf("diffuse") + "<rgb name='a' value='1'/><rgb name='b' value='1'/>"),
           "has a second color, expected one"},
          {bsdf("diffuse", board), "<texture> in bsdf 'diffuse' needs an attribute 'name'"},
          {"<bsdf type='mask' id='a'><ref id='a'/></bsdf>", "bsdf 'mask' refers to itself"},
      },
      error_of_elements);
}

}  // namespace sheaf::test_mitsuba_errors
