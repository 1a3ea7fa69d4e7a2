// Every spelling of the course dialects that docs/scene-format/nori.md lists. Equivalent spellings give the same image,
// which differs from that of the defaults.
#include "core/image/exr.h"
#include "core/image/image.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/image_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/media_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace sheaf::test_nori_spellings {

using namespace test;

namespace {

/// The parts of a scene. Each part has a default that makes the effect of the others visible.
struct Scene {
  std::string bsdf = "<bsdf type='diffuse'/>";
  std::string mesh = "<mesh type='sphere'>";  ///< not closed
  std::string inside;                         ///< children of the mesh besides its BSDF
  std::string emitters =
      "<emitter type='point'><point name='position' value='2,3,4'/>"
      "<color name='intensity' value='30,25,20'/></emitter>"
      "<emitter type='constant'><color name='radiance' value='0.2,0.3,0.4'/></emitter>";
  std::string camera_type = "perspective";
  std::string camera;
  std::string integrator = "<integrator type='path_mis'/>";
  std::string sampler = "<sampler type='sobol'><integer name='sampleCount' value='4'/></sampler>";
  std::string more;  ///< children of the scene
};

/// Renders scenes in one folder that holds the files they refer to.
class Studio {
 public:
  Studio() {
    write_pnm(folder_ / "image.ppm", 2, 2, 3, 255, {255, 20, 40, 30, 200, 60, 90, 50, 250, 240, 230, 10});
    write_vol(folder_ / "fog.vol", 4, 1, [](Vec3f p, int) { return 4 * p.x; });
    Image sky(4, 2, {"R", "G", "B"});
    for (std::size_t i = 0; i < sky.data.size(); ++i) sky.data[i] = 0.1f * static_cast<float>(i);
    write_exr(folder_ / "sky.exr", sky);
  }

  std::vector<float> render(const Scene& s) const {
    const std::string text =
        "<scene>" + s.integrator + s.sampler + "<camera type='" + s.camera_type +
        "'><integer name='width' value='12'/><integer name='height' value='8'/><rfilter type='box'/>"
        "<transform name='toWorld'><scale value='-1,1,1'/><lookat origin='0,0,4' target='0,0,0' up='0,1,0'/>"
        "</transform>" +
        s.camera + "</camera>" + s.mesh + s.bsdf + s.inside +
        "</mesh>"
        "<mesh type='parallelogram'><point name='origin' value='-3,-1.2,3'/><vector name='u' value='6,0,0'/>"
        "<vector name='v' value='0,0,-6'/></mesh>" +
        s.emitters + s.more + "</scene>";
    INFO(text);
    const Description d = read_scene(write_below(folder_, "scene.xml", text));
    return sheaf::render(*compile_scene(d), {}).film.to_image().data;
  }

 private:
  TemporaryFolder folder_;
};

/// Largest difference of two images, relative to the largest value of the first.
double difference(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.size() != b.size()) return 1;
  double most = 0, largest = 1e-9;
  for (std::size_t i = 0; i < a.size(); ++i) {
    most = std::max(most, std::fabs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
    largest = std::max(largest, std::fabs(static_cast<double>(a[i])));
  }
  return most / largest;
}

/// Equivalent spellings, none of which is the default.
using Spellings = std::vector<std::string>;

/// Checks groups of equivalent spellings. `insert` inserts one into a scene; an empty string leaves the default.
template <class Insert> void check_groups(const std::vector<Spellings>& groups, Insert&& insert) {
  const Studio studio;
  const auto rendered = [&](const std::string& text) {
    Scene scene;
    insert(scene, text);
    return studio.render(scene);
  };
  const std::vector<float> plain = rendered("");
  for (const Spellings& group : groups) {
    const std::vector<float> first = rendered(group.front());
    CAPTURE(group.front());
    CHECK(difference(plain, first) > 1e-3);
    for (std::size_t i = 1; i < group.size(); ++i) {
      CAPTURE(group[i]);
      CHECK(difference(first, rendered(group[i])) < 1e-5);
    }
  }
}

std::string number(const std::string& name, const std::string& value) {
  return "<float name='" + name + "' value='" + value + "'/>";
}
std::string whole(const std::string& name, const std::string& value) {
  return "<integer name='" + name + "' value='" + value + "'/>";
}
std::string text(const std::string& name, const std::string& value) {
  return "<string name='" + name + "' value='" + value + "'/>";
}
std::string color(const std::string& name, const std::string& value) {
  return "<color name='" + name + "' value='" + value + "'/>";
}
std::string point(const std::string& name, const std::string& value) {
  return "<point name='" + name + "' value='" + value + "'/>";
}
std::string of_type(const std::string& kind, const std::string& type, const std::string& inside = "") {
  return "<" + kind + " type='" + type + "'>" + inside + "</" + kind + ">";
}

/// Checks each parameter in a material of one plugin. The image of the defaults is the reference.
void check_parameters(const std::string& plugin, const std::vector<Spellings>& groups, const std::string& rest = "") {
  CAPTURE(plugin);
  check_groups(groups, [&](Scene& scene, const std::string& s) { scene.bsdf = of_type("bsdf", plugin, rest + s); });
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("Nori spellings: material plugins render equally in all spellings") {
  check_groups(
      {{of_type("bsdf", "mirror"), of_type("bsdf", "conductor", text("material", "none"))},
       {of_type("bsdf", "transparent"), of_type("bsdf", "null")},
       {of_type("bsdf", "microfacet")},
       {of_type("bsdf", "disney")},
       {of_type("bsdf", "dielectric")},
       {of_type("bsdf", "roughdielectric")},
       {of_type("bsdf", "diffuse", color("albedo", "0.9,0.2,0.1")),
        of_type("bsdf", "diffuse", color("reflectance", "0.9,0.2,0.1")),
        of_type("bsdf", "diffuse", color("albedo", "0.9,0.2,0.1") + "<boolean name='use_cosine' value='false'/>")}},
      [](Scene& scene, const std::string& s) {
        if (!s.empty()) scene.bsdf = s;
      });
}

TEST_CASE("Nori spellings: material parameters render equally in all spellings") {
  check_parameters("microfacet", {{number("intIOR", "1.9"), number("int_ior", "1.9")},
                                  {number("extIOR", "1.3"), number("ext_ior", "1.3")},
                                  {number("alpha", "0.4"), number("m_alpha", "0.4")},
                                  {color("kd", "0.1,0.3,0.2"), color("albedo", "0.1,0.3,0.2")}});
  // Parameters whose effect the defaults hide need others to be visible.
  const std::string seen = number("clearcoat", "0.5") + number("sheen", "0.5") + number("metallic", "0.2") +
                           color("baseColor", "0.8,0.3,0.2");
  check_parameters("disney",
                   {{number("subsurface", "0.8")},
                    {number("specular", "0.9")},
                    {number("specularTint", "0.8"), number("specular_tint", "0.8")},
                    {number("roughness", "0.2")},
                    {number("anisotropic", "0.8")},
                    {number("sheenTint", "0"), number("sheen_tint", "0")},
                    {number("clearcoatGloss", "0.2"), number("clearcoat_gloss", "0.2")}},
                   seen);
  check_parameters("disney", {{color("baseColor", "0.8,0.3,0.2"), color("albedo", "0.8,0.3,0.2")},
                              {number("metallic", "0.7")},
                              {number("sheen", "0.7")},
                              {number("clearcoat", "0.7")}});
  check_parameters("dielectric", {{number("intIOR", "1.9")},
                                  {number("extIOR", "1.3")},
                                  {color("sigmaA", "0.2,0.5,1"), color("sigma_a", "0.2,0.5,1")}});
  check_parameters("null", {{color("sigmaA", "0.2,0.5,1")}});
  const std::string normals = "<texture name='normal' type='image'>" + text("filename", "image.ppm") + "</texture>";
  check_parameters("diffuse", {{normals}});
  check_parameters("microfacet", {{normals}});
}

TEST_CASE("Nori spellings: textures render equally in all spellings") {
  const auto texture = [](const std::string& type, const std::string& inside) {
    return "<texture name='albedo' type='" + type + "'>" + inside + "</texture>";
  };
  const std::string file = text("filename", "image.ppm"), two = "' value='0.3, 0.4'/>";
  const auto scales = [&](const std::string& name) {
    return Spellings{"<vector2 name='" + name + two, "<point2 name='" + name + two, "<vector name='" + name + two,
                     "<point name='" + name + two};
  };
  const auto check_in = [&](const std::string& type, const std::string& rest, const std::vector<Spellings>& groups) {
    CAPTURE(type);
    check_groups(groups, [&](Scene& scene, const std::string& s) {
      scene.bsdf = of_type("bsdf", "diffuse", texture(type, rest + s));
    });
  };
  const std::string small = "<vector2 name='scale' value='0.2, 0.2'/>";
  check_in("checkerboard_color", small,
           {{color("value1", "0.2,0.5,0.1"), "<rgb name='value1' value='0.2,0.5,0.1'/>"},
            {color("value2", "0.2,0.5,0.1")},
            scales("delta"),
            {number("delta", "0.1"), "<vector2 name='delta' value='0.1, 0.1'/>"}});
  check_in("checkerboard_color", "",
           {scales("scale"), {number("scale", "0.25"), "<vector2 name='scale' value='0.25, 0.25'/>"}});
  for (const char* type : {"image", "imagetexture", "png_texture", "normaltexture"})
    check_in(type, file,
             {{text("filter", "nearest"), text("interpolation", "nearest")},
              {"<boolean name='raw' value='true'/>"},
              scales("scale"),
              {"<vector2 name='delta' value='0.25, 0.1'/>"}});
  const std::string moved = "<vector2 name='delta' value='0.3, 0.3'/>";
  check_in("image", file + moved, {{text("wrap", "mirror")}, {text("wrap", "clamp")}});
  // All names of image and color textures.
  const auto plain = [&](const std::string& type, const std::string& inside) {
    return of_type("bsdf", "diffuse", texture(type, inside));
  };
  check_groups(
      {{plain("image", file), plain("imagetexture", file), plain("png_texture", file), plain("normaltexture", file),
        plain("bitmap", file), plain("image", file + "<boolean name='sphericalTexture' value='true'/>")},
       {plain("constant_color", color("value", "0.7,0.2,0.1")),
        of_type("bsdf", "diffuse", color("albedo", "0.7,0.2,0.1"))},
       {plain("constant_float", number("value", "0.7")), plain("constant_color", number("value", "0.7"))},
       {plain("constant_color", ""), of_type("bsdf", "diffuse", number("albedo", "0"))},
       {plain("checkerboard_color", ""), plain("checkerboard_float", "")}},
      [](Scene& scene, const std::string& s) {
        if (!s.empty()) scene.bsdf = s;
      });
}

TEST_CASE("Nori spellings: emitters render equally in all spellings") {
  const auto replaced = [](Scene& scene, const std::string& s) {
    scene.emitters = s.empty() ? of_type("emitter", "constant") : s;
  };
  const std::string at = point("position", "0,3,3");
  const auto spot = [](const std::string& inside) { return of_type("emitter", "spot", inside); };
  check_groups(
      {{of_type("emitter", "point", at + color("intensity", "1,2,3")),
        of_type("emitter", "point", at + color("power", "12.5663706,25.1327412,37.6991118"))},
       {of_type("emitter", "point", at), of_type("emitter", "point", at + number("intensity", "1"))},
       {of_type("emitter", "constant", color("radiance", "0.1,0.2,0.3"))},
       {of_type("emitter", "envmap", text("filename", "sky.exr")),
        of_type("emitter", "envmap",
                "<texture name='radiance' type='image'>" + text("filename", "sky.exr") + "</texture>"),
        of_type("emitter", "envmap", "<texture type='bitmap'>" + text("filename", "sky.exr") + "</texture>")},
       {of_type("emitter", "envmap", text("filename", "sky.exr") + number("scale", "3"))},
       {spot(at + "<vector name='direction' value='0,-3,-3'/>"), spot(at + point("lookAt", "0,0,0")),
        spot("<transform name='toWorld'><lookat origin='0,3,3' target='0,0,0' up='0,1,0'/></transform>"),
        spot(at + point("lookAt", "0,0,0") + number("totalWidth", "30") + number("falloffStart", "25")),
        // 2 pi (1 - (cos 25 + cos 30) / 2)
        spot(at + point("lookAt", "0,0,0") + number("power", "0.71516838"))},
       {spot(at + point("lookAt", "0,0,0") + number("totalWidth", "20")),
        spot(at + point("lookAt", "0,0,0") + number("totalWidth", "20") + number("falloffStart", "15"))},
       {spot(at + point("lookAt", "0,0,0") + number("falloffStart", "5"))},
       {of_type("emitter", "directional", "<vector name='direction' value='0,-1,-1'/>" + color("irradiance", "1,2,3")),
        of_type("emitter", "directional", "<vector name='direction' value='0,-1,-1'/>" + color("intensity", "1,2,3")),
        of_type("emitter", "directional",
                "<transform name='toWorld'><lookat origin='0,1,1' target='0,0,0' up='0,1,0'/></transform>" +
                    color("irradiance", "1,2,3"))},
       {of_type("emitter", "directional", "<vector name='direction' value='0,0,-1'/>"),
        of_type("emitter", "directional", "<vector name='direction' value='0,0,-1'/>" + number("irradiance", "1"))}},
      replaced);
  const auto area = [](const std::string& type, const std::string& inside) { return of_type("emitter", type, inside); };
  check_groups(
      {{area("area", ""), area("area", number("radiance", "1")), area("sphere_emitter", "")},
       {area("area", color("radiance", "3,2,1")), area("mesh_emitter", color("radiance", "3,2,1"))},
       {area("area", "<texture name='radiance' type='image'>" + text("filename", "image.ppm") + "</texture>")}},
      [](Scene& scene, const std::string& s) { scene.inside = s; });
}

TEST_CASE("Nori spellings: shapes render equally in all spellings") {
  const auto mesh = [](const std::string& type, const std::string& inside) {
    return "<mesh type='" + type + "'>" + inside;
  };
  const auto moved = [](const std::string& steps) { return "<transform name='toWorld'>" + steps + "</transform>"; };
  check_groups({{mesh("sphere", point("center", "0.5,0.2,0")), mesh("sphere", moved("<translate value='0.5,0.2,0'/>")),
                 mesh("sphere", point("center", "0.5,0.2,0") + number("radius", "1") + text("name", "ball"))},
                {mesh("sphere", number("radius", "0.6")), mesh("sphere", moved("<scale value='0.6,0.6,0.6'/>")),
                 mesh("sphere", moved("<scale value='0.6'/>"))},
                {mesh("parallelogram", ""),
                 mesh("parallelogram", point("origin", "0,0,0") + "<vector name='u' value='1,0,0'/><vector name='v' "
                                                                  "value='0,1,0'/>"),
                 mesh("rectangle", moved("<scale value='0.5,0.5,1'/><translate value='0.5,0.5,0'/>"))},
                {mesh("parallelogram", point("origin", "-1,-1,0") + "<vector name='u' value='2,0,0'/><vector name='v' "
                                                                    "value='0,2,0'/>"),
                 mesh("rectangle", "")}},
               [](Scene& scene, const std::string& s) {
                 if (!s.empty()) scene.mesh = s;
               });
  // Groups and instances in both notations.
  const std::string ball = "<mesh type='sphere'>" + number("radius", "0.4") + "</mesh>";
  const std::string insert = moved("<translate value='1,0,1'/>");
  check_groups(
      {{"<mesh type='shapegroup' id='g'>" + ball + "</mesh><mesh type='instance'><ref id='g'/>" + insert + "</mesh>",
        "<mesh type='ref' name='g'>" + ball + "</mesh><mesh type='instance'>" + text("ref", "g") + insert + "</mesh>",
        "<mesh type='sphere'>" + number("radius", "0.4") + insert + "</mesh>",
        "<shape type='sphere'>" + number("radius", "0.4") + insert + "</shape>"}},
      [](Scene& scene, const std::string& s) { scene.more = s; });
}

TEST_CASE("Nori spellings: cameras and filters and samplers render equally in all spellings") {
  check_groups({{number("fov", "60"), whole("fov", "60")},
                {text("fovAxis", "y"), text("fov_axis", "y")},
                {number("nearClip", "3.2"), number("near_clip", "3.2")},
                {number("farClip", "3.6"), number("far_clip", "3.6")},
                {number("apertureRadius", "0.3") + number("focusDistance", "2"),
                 number("lensRadius", "0.3") + number("focalDistance", "2")}},
               [](Scene& scene, const std::string& s) { scene.camera = s; });
  const auto type_of = [](Scene& scene, const std::string& s) {
    if (!s.empty()) scene.camera_type = s;
  };
  check_groups({{"orthographic"}}, type_of);
  check_groups({{number("lensRadius", "0.3") + number("focusDistance", "2")}}, [](Scene& scene, const std::string& s) {
    scene.camera_type = "thinlens";
    scene.camera = s.empty() ? number("apertureRadius", "0") : s;
  });
  const auto sampler = [](const std::string& type, const std::string& count) {
    return of_type("sampler", type, "<integer name='sampleCount' value='" + count + "'/>");
  };
  check_groups({{sampler("sobol", "8"), of_type("sampler", "sobol", number("sampleCount", "8")),
                 of_type("sampler", "sobol", number("sample_count", "8.0")), sampler("ldsampler", "8"),
                 sampler("halton", "8"), sampler("hammersley", "8"), sampler("orthogonal", "8")},
                {sampler("sobol", "1"), of_type("sampler", "sobol")},
                {sampler("stratified", "4")},
                {sampler("multijitter", "4")},
                {sampler("zsobol", "4")}},
               [](Scene& scene, const std::string& s) {
                 if (!s.empty()) scene.sampler = s;
               });
}

TEST_CASE("Nori spellings: integrators render equally in all spellings") {
  const auto insert = [](Scene& scene, const std::string& s) {
    scene.bsdf = of_type("bsdf", "microfacet", number("alpha", "0.2"));
    scene.emitters = "<emitter type='constant'><color name='radiance' value='0.2,0.3,0.4'/></emitter>";
    scene.more = "<mesh type='sphere'>" + point("center", "1.5,1.5,1.5") + number("radius", "0.5") +
                 of_type("emitter", "area", number("radiance", "8")) + "</mesh>";
    scene.integrator = s.empty() ? of_type("integrator", "path_mis") : s;
  };
  const auto plain = [](const std::string& type) { return of_type("integrator", type); };
  const auto named = [&](std::initializer_list<const char*> types) {
    Spellings group;
    for (const char* type : types) group.push_back(plain(type));
    return group;
  };
  check_groups({named({"path_mats", "vol_path_mats", "volpath_mats", "path_vol_mats", "medium_path_mats"}),
                named({"path_ems"}),
                named({"path_ris"}),
                named({"direct", "direct_mis"}),
                named({"direct_mats"}),
                named({"direct_ems"}),
                named({"direct_ris"}),
                named({"whitted"}),
                named({"normals"}),
                named({"depth"}),
                named({"ao"}),
                named({"ptracer"}),
                {of_type("integrator", "av", number("length", "1"))},
                {of_type("integrator", "simple", point("position", "2,3,4") + color("energy", "300,200,100"))}},
               insert);
  const Studio studio;
  const auto rendered = [&](const std::string& integrator) {
    Scene scene;
    insert(scene, integrator);
    return studio.render(scene);
  };
  const std::vector<float> path = rendered("");
  for (const char* same : {"path", "vol_path", "vol_path_mis", "volpath_mis", "path_vol", "path_vol_mis",
                           "path_mis_vol", "medium_path", "medium_path_mis", "volpath", "volpathmis"}) {
    CAPTURE(same);
    CHECK(difference(path, rendered(plain(same))) == 0);
  }
  const std::string hidden = "<boolean name='hideEmitters' value='true'/>";
  check_groups(
      {{of_type("integrator", "path", whole("maxDepth", "2")), of_type("integrator", "path", number("maxDepth", "2")),
        of_type("integrator", "path", whole("max_depth", "2.0")), plain("direct")},
       {of_type("integrator", "path", whole("maxDepth", "1"))},
       {of_type("integrator", "path", hidden), of_type("integrator", "path_mis", hidden)},
       {of_type("integrator", "path", whole("candidates", "8")), plain("path_ris")}},
      insert);
}

TEST_CASE("Nori spellings: photon maps render equally in all spellings") {
  const auto insert = [](const std::string& type, const std::string& rest) {
    return [type, rest](Scene& scene, const std::string& s) {
      scene.integrator = of_type("integrator", type, rest + s);
      scene.emitters =
          "<emitter type='point'><point name='position' value='2,3,4'/>"
          "<color name='intensity' value='30,25,20'/></emitter>";
    };
  };
  const std::string few = whole("photonCount", "2000"), wide = number("photonRadius", "0.3");
  check_groups({{whole("photonCount", "500"), number("photonCount", "500"), whole("photon_count", "5e2"),
                 number("globalPhotons", "500")}},
               [&](Scene& scene, const std::string& s) { insert("photonmapper", wide)(scene, s.empty() ? few : s); });
  check_groups({{number("photonRadius", "0.3"), number("photon_radius", "0.3")},
                {text("kernel", "cone")},
                {text("kernel", "epanechnikov")},
                {"<boolean name='sampleDirect' value='true'/>"},
                {"<boolean name='finalGather' value='true'/>"}},
               insert("photonmapper", few));
  check_groups({{whole("lookupSize", "3"), number("lookup_size", "3")}}, insert("photonmapper", few + wide));
  check_groups({{number("initialRadius", "0.5"), number("initial_radius", "0.5")}, {number("alpha", "0.1")}},
               insert("sppm", few));
  const Studio studio;
  const auto rendered = [&](const std::string& type) {
    Scene scene;
    insert(type, few + wide)(scene, "");
    return studio.render(scene);
  };
  CHECK(difference(rendered("photonmapper"), rendered("photonmap")) == 0);
}

TEST_CASE("Nori spellings: media render equally in all spellings") {
  const auto medium = [](const std::string& type, const std::string& inside) {
    return of_type("medium", type, inside);
  };
  const std::string grid = text("filename", "fog.vol");
  const auto volume = [&](const std::string& name, const std::string& inside) {
    return "<volume name='" + name + "' type='gridvolume'>" + grid + inside + "</volume>";
  };
  const auto insert = [](Scene& scene, const std::string& s) {
    scene.bsdf.clear();
    scene.inside = s.empty() ? "<medium type='homogeneous'/>" : s;
  };
  const std::string pair = color("sigmaT", "1,2,3") + color("albedo", "0.9,0.8,0.7");
  check_groups(
      {{medium("homogeneous", pair), medium("homog", pair),
        medium("homogeneous", color("sigma_t", "1,2,3") + color("albedo", "0.9,0.8,0.7")),
        medium("homogeneous", color("sigmaA", "0.1,0.4,0.9") + color("sigmaS", "0.9,1.6,2.1")),
        medium("homogeneous", color("sigma_a", "0.1,0.4,0.9") + color("sigma_s", "0.9,1.6,2.1")),
        medium("homogeneous", color("sigmaT", "2,4,6") + color("albedo", "0.9,0.8,0.7") + number("scale", "0.5")),
        medium("homogeneous", color("sigmaT", "2,4,6") + color("albedo", "0.9,0.8,0.7") + number("density", "0.5")),
        medium("homogeneous", color("sigmaT", "4,8,12") + color("albedo", "0.9,0.8,0.7") + number("density", "0.5") +
                                  number("scale", "0.5"))},
       {medium("homogeneous", "<phase type='hg'/>"),
        medium("homogeneous", "<phase type='hg'><float name='g' value='0.8'/></phase>"),
        medium("homogeneous", "<phasefunction type='hg'/>")},
       {medium("homogeneous", color("emission", "1,2,3"))},
       {medium("heterogeneous", grid), medium("heterogeneous", grid + "<boolean name='fitToShape' value='true'/>"),
        medium("heterogeneous", volume("density", "")),
        medium("heterogeneous", grid + "<transform name='toWorld'><scale value='2,2,2'/>"
                                       "<translate value='-1,-1,-1'/></transform>")},
       {medium("heterogeneous", grid + "<boolean name='fitToShape' value='false'/>"),
        medium("heterogeneous", grid + "<transform name='toWorld'><scale value='1'/></transform>")},
       {medium("heterogeneous", grid + text("filterType", "nearest")),
        medium("heterogeneous", volume("density", text("filter_type", "nearest")))}},
      insert);
  // Estimators differ in their random numbers or steps.
  check_groups(
      {{text("method", "march"), text("method", "raymarch")}, {text("method", "delta"), text("method", "woodcock")}},
      [&](Scene& scene, const std::string& s) { insert(scene, medium("heterogeneous", grid + pair + s)); });
  check_groups({{text("mediumEstimator", "marching"), text("medium_estimator", "marching")},
                {text("mediumEstimator", "marching") + number("stepSize", "0.9"),
                 text("mediumEstimator", "marching") + number("step_size", "0.9")},
                {text("mediumEstimator", "delta")}},
               [&](Scene& scene, const std::string& s) {
                 insert(scene, medium("heterogeneous", grid + pair));
                 scene.integrator = of_type("integrator", "path_mis", s);
               });
  // Media around the camera.
  check_groups({{medium("homogeneous", number("sigmaT", "0.1"))}},
               [](Scene& scene, const std::string& s) { scene.more = s; });
}

TEST_SUITE_END();

}  // namespace sheaf::test_nori_spellings
