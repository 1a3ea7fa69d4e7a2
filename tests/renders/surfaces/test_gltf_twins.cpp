// glTF scenes render like the same scenes in the format of Mitsuba, by Welch's t-test on blocks of pixels.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/gltf_samples.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>

namespace sheaf::test_gltf_twins {

using namespace test;
using nlohmann::json;

namespace {

constexpr int kWidth = 64, kHeight = 48, kBlock = 8, kRenders = 12, kSamples = 32;

/// A sphere with normals and texture coordinates, v downwards.
struct Sphere {
  std::vector<float> positions, normals, uvs;
  std::vector<std::uint16_t> corners;

  Sphere() {
    constexpr int kColumns = 24, kRows = 12;
    for (int j = 0; j <= kRows; ++j)
      for (int i = 0; i <= kColumns; ++i) {
        const float phi = 2 * kPi * float(i) / kColumns, theta = kPi * float(j) / kRows;
        const float n[3] = {std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)};
        positions.insert(positions.end(), n, n + 3);
        normals.insert(normals.end(), n, n + 3);
        uvs.insert(uvs.end(), {float(i) / kColumns, float(j) / kRows});
      }
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kColumns; ++i) {
        const int a = j * (kColumns + 1) + i, b = a + kColumns + 1;
        for (const int corner : {a, b, a + 1, a + 1, b, b + 1}) corners.push_back(static_cast<std::uint16_t>(corner));
      }
  }

  /// The sphere as a PLY file, with v upwards.
  std::string ply() const {
    const std::size_t vertices = positions.size() / 3, faces = corners.size() / 3;
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertices) +
                       "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
                       "property float nz\nproperty float u\nproperty float v\nelement face " +
                       std::to_string(faces) + "\nproperty list uchar int vertex_indices\nend_header\n";
    char line[256];
    for (std::size_t i = 0; i < vertices; ++i) {
      const float *p = &positions[3 * i], *n = &normals[3 * i];
      std::snprintf(line, sizeof(line), "%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", double(p[0]), double(p[1]),
                    double(p[2]), double(n[0]), double(n[1]), double(n[2]), double(uvs[2 * i]),
                    1 - double(uvs[2 * i + 1]));
      text += line;
    }
    for (std::size_t f = 0; f < faces; ++f)
      text += "3 " + std::to_string(corners[3 * f]) + " " + std::to_string(corners[3 * f + 1]) + " " +
              std::to_string(corners[3 * f + 2]) + "\n";
    return text;
  }
};

/// Both versions of a scene of spheres before a camera at (0, 0, 8).
class Twins {
 public:
  Twins() {
    gltf_.json["nodes"] = {{{"camera", 0}, {"translation", {0, 0, 8}}}};
    gltf_.json["cameras"] = {
        {{"type", "perspective"},
         {"perspective", {{"yfov", 0.6}, {"aspectRatio", double(kWidth) / kHeight}, {"znear", 0.01}}}}};
    attributes_ = {{"POSITION", gltf_.add(sphere_.positions, "VEC3")},
                   {"NORMAL", gltf_.add(sphere_.normals, "VEC3")},
                   {"TEXCOORD_0", gltf_.add(sphere_.uvs, "VEC2")}};
    indices_ = gltf_.add(sphere_.corners, "SCALAR");
  }

  GltfBuilder& gltf() { return gltf_; }

  /// Adds a sphere at (x, y, 0). `inside`: elements of the XML shape.
  json& add_sphere(double x, double y, const json& material, const std::string& inside, double mirror = 1) {
    gltf_.json["materials"].push_back(material);
    json& primitive = gltf_.add_mesh(attributes_);
    primitive["indices"] = indices_;
    primitive["material"] = gltf_.json["materials"].size() - 1;
    gltf_.json["nodes"].push_back(
        {{"mesh", gltf_.json["meshes"].size() - 1}, {"translation", {x, y, 0}}, {"scale", {mirror, 1, 1}}});
    xml_ += "<shape type='ply'><string name='filename' value='sphere.ply'/><transform name='to_world'><scale x='" +
            std::to_string(mirror) + "'/><translate x='" + std::to_string(x) + "' y='" + std::to_string(y) +
            "'/></transform>" + inside + "</shape>\n";
    return gltf_.json["nodes"].back();
  }
  /// Animates a node from time 0 to time 1, linearly. `path`: translation, rotation or scale.
  void animate(std::size_t node, const char* path, const std::vector<float>& values) {
    const int times = gltf_.add<float>({0, 1}, "SCALAR");
    const int output = gltf_.add<float>(values, values.size() == 8 ? "VEC4" : "VEC3");
    json& animation = gltf_.json["animations"][0];
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    animation["samplers"].push_back({{"input", times}, {"output", output}});
  }

  /// Adds a sphere with keys at time 0 and time 1: `keys` are the transforms of the XML shape, and the tracks of the
  /// node follow by animate(). Returns the node.
  std::size_t add_moving_sphere(const json& material, const std::string& inside, const std::string& keys) {
    add_sphere(0, 0, material, inside);
    const std::string still = "<transform name='to_world'><scale x='1.000000'/>";
    const std::size_t begin = xml_.rfind(still), end = xml_.find("</transform>", begin) + 12;
    xml_.replace(begin, end - begin, "<animation name='to_world'>" + keys + "</animation>");
    return gltf_.json["nodes"].size() - 1;
  }

  /// Exposes from 0.25 to 1. `camera`: keys of the XML camera.
  void expose(const std::string& camera) {
    shutter_ = ShutterDescription{0.25, 1, 0};
    camera_ =
        "<float name='shutter_open' value='0.25'/><float name='shutter_close' value='1'/><animation name="
        "'to_world'>" +
        camera + "</animation>";
  }

  void add_light(const json& light, const json& position, const std::string& element) {
    json& lights = gltf_.json["extensions"]["KHR_lights_punctual"]["lights"];
    json node = position;
    node["extensions"]["KHR_lights_punctual"]["light"] = lights.size();
    lights.push_back(light);
    gltf_.json["nodes"].push_back(node);
    xml_ += element + "\n";
  }

  /// Compares the renders.
  void check(ColorMode color = ColorMode::kRgb) {
    gltf_.json["scenes"][0]["nodes"] = json::array();
    for (std::size_t i = 0; i < gltf_.json["nodes"].size(); ++i) gltf_.json["scenes"][0]["nodes"].push_back(i);
    const TemporaryFolder folder;
    write_below(folder, "sphere.ply", sphere_.ply());
    const std::string sensor =
        "<sensor type='perspective'><string name='fov_axis' value='y'/><float name='fov' value='34.3774677'/>"
        "<float name='near_clip' value='0.01'/>" +
        camera_ + "</sensor>";
    ReadOptions options;
    options.surroundings.environment = ModelEnvironment::kNoEnvironment;
    options.shutter = shutter_;
    if (shutter_) options.moment.time = 0;
    const Description a = read_scene(write_below(folder, "scene.gltf", gltf_.text()), options);
    Description b =
        read_scene(write_below(folder, "scene.xml", mitsuba_scene(xml_, sensor, "<integrator type='volpath'/>")));
    compare(statistics_of(a, 1, color), statistics_of(b, 1001, color));
  }

 private:
  using Blocks = std::vector<MeanVariance>;

  /// Means of each block and channel over independent renders.
  static Blocks statistics_of(Description d, std::uint32_t seed, ColorMode color) {
    d.film.width = kWidth, d.film.height = kHeight;
    d.film.filter = {PixelFilter::Kind::kBox, 0.5f, 0.5f};
    d.sampler.kind = SamplerKind::kIndependent;
    d.sampler.sample_count = kSamples;
    d.integrator.rr_depth = 50;
    CompileOptions options;
    options.color = color;
    Blocks blocks(static_cast<std::size_t>(kWidth / kBlock * (kHeight / kBlock) * 3));
    for (int i = 0; i < kRenders; ++i) {
      d.sampler.seed = seed + static_cast<std::uint32_t>(i);
      const Image image = render(*compile_scene(d, options), {}).film.to_image();
      std::vector<double> sums(blocks.size(), 0);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
          for (int c = 0; c < 3; ++c)
            sums[static_cast<std::size_t>((y / kBlock * (kWidth / kBlock) + x / kBlock) * 3 + c)] +=
                double(image.at(x, y, c));
      for (std::size_t k = 0; k < blocks.size(); ++k) blocks[k].add(sums[k] / (kBlock * kBlock));
    }
    return blocks;
  }

  static void compare(const Blocks& a, const Blocks& b) {
    const double level = significance_of_each(static_cast<int>(a.size()));
    double light = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      const double difference = a[k].mean() - b[k].mean();
      light += b[k].mean();
      // Vertices are rounded differently.
      if (std::fabs(difference) <= 1e-3 * std::fabs(b[k].mean())) continue;
      const double u = a[k].variance() / kRenders, v = b[k].variance() / kRenders;
      INFO("block " << k << ": " << a[k].mean() << " and " << b[k].mean() << ", deviations " << std::sqrt(u) << ", "
                    << std::sqrt(v));
      REQUIRE(u + v > 0);
      const double degrees = (u + v) * (u + v) / ((u * u + v * v) / (kRenders - 1));  // Welch 1947
      CHECK(student_t_p_value(difference / std::sqrt(u + v), degrees) >= level);
    }
    CHECK(light > 0.5);
  }

  Sphere sphere_;
  GltfBuilder gltf_;
  json attributes_;
  int indices_ = 0;
  std::optional<ShutterDescription> shutter_;
  std::string xml_,
      camera_ = "<transform name='to_world'><lookat origin='0,0,8' target='0,0,0' up='0,1,0'/></transform>";
};

/// A dielectric without specular reflection is diffuse.
json diffuse(const json& color) {
  return {{"pbrMetallicRoughness", {{"baseColorFactor", color}, {"metallicFactor", 0}}},
          {"extensions", {{"KHR_materials_specular", {{"specularFactor", 0}}}}}};
}
std::string diffuse_xml(const std::string& rgb) {
  return "<bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' value='" + rgb + "'/></bsdf></bsdf>";
}

}  // namespace

TEST_SUITE("slow") {
  TEST_CASE("gltf: nodes that move render like Mitsuba's animations") {
    Twins twins;
    const float half = std::sqrt(0.5f);
    // A ball that turns by 90 degrees, is squeezed and moves
    const std::size_t ball =
        twins.add_moving_sphere(diffuse({0.8, 0.4, 0.1, 1}), diffuse_xml("0.8, 0.4, 0.1"),
                                "<transform time='0'><scale x='1.5' y='0.5'/><translate x='-2' y='1'/></transform>"
                                "<transform time='1'><scale x='1' y='0.7'/><rotate z='1' angle='90'/><translate x='1' "
                                "y='0.5' z='1'/></transform>");
    twins.animate(ball, "translation", {-2, 1, 0, 1, 0.5f, 1});
    twins.animate(ball, "rotation", {0, 0, 0, 1, 0, 0, half, half});
    twins.animate(ball, "scale", {1.5f, 0.5f, 1, 1, 0.7f, 1});
    // A lamp that moves
    json emitter = diffuse({0, 0, 0, 1});
    emitter["emissiveFactor"] = {1, 0.5, 0.25};
    emitter["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 6;
    const std::size_t lamp = twins.add_moving_sphere(
        emitter, diffuse_xml("0") + "<emitter type='area'><rgb name='radiance' value='6, 3, 1.5'/></emitter>",
        "<transform time='0'><scale value='0.5'/><translate x='2' y='1'/></transform>"
        "<transform time='1'><scale value='0.5'/><translate x='1' y='-2' z='1'/></transform>");
    twins.animate(lamp, "translation", {2, 1, 0, 1, -2, 1});
    twins.animate(lamp, "scale", {0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f});
    // A point light and the camera
    twins.add_light({{"type", "point"}, {"intensity", 20}}, json::object(),
                    "<emitter type='point'><rgb name='intensity' value='20'/><animation name='to_world'><transform "
                    "time='0'><translate x='-3' y='3' z='4'/></transform><transform time='1'><translate x='3' y='3' "
                    "z='4'/></transform></animation></emitter>");
    twins.animate(twins.gltf().json["nodes"].size() - 1, "translation", {-3, 3, 4, 3, 3, 4});
    twins.animate(0, "translation", {0, 0, 8, 0.5f, 0.25f, 8});
    twins.expose(
        "<transform time='0'><lookat origin='0,0,8' target='0,0,0' up='0,1,0'/></transform><transform time='1'>"
        "<lookat origin='0.5,0.25,8' target='0.5,0.25,0' up='0,1,0'/></transform>");
    twins.check();
  }

  TEST_CASE("gltf: surfaces, coverage and emission render like Mitsuba's") {
    Twins twins;
    twins.add_sphere(-2, 1, diffuse({0.8, 0.2, 0.1, 1}), diffuse_xml("0.8, 0.2, 0.1"));
    json emitter = diffuse({0, 0, 0, 1});
    emitter["emissiveFactor"] = {1, 0.5, 0.25};
    emitter["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 6;
    twins.add_sphere(0, -1, emitter,
                     diffuse_xml("0") + "<emitter type='area'><rgb name='radiance' value='6, 3, 1.5'/></emitter>");
    twins.add_sphere(2, 1,
                     {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.6, 0.7, 1}}}},
                      {"extensions", {{"KHR_materials_unlit", json::object()}}}},
                     diffuse_xml("0") + "<emitter type='area'><rgb name='radiance' value='0.5, 0.6, 0.7'/></emitter>");
    json half = diffuse({0.3, 0.9, 0.3, 0.5});
    half["alphaMode"] = "BLEND";
    twins.add_sphere(2, -1.5, half,
                     "<bsdf type='mask'><float name='opacity' value='0.5'/>" + diffuse_xml("0.3, 0.9, 0.3") + "</bsdf>",
                     -1);
    twins.check();
  }

  TEST_CASE("gltf: volumes of glass under punctual lights render like Mitsuba's") {
    for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
      Twins twins;
      const json volume = {{"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.3, 0.9, 0.6}}};
      twins.add_sphere(
          -1.5, 0,
          {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
           {"extensions",
            {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
             {"KHR_materials_ior", {{"ior", 1.4}}},
             {"KHR_materials_volume", volume}}}},
          "<bsdf type='dielectric'><float name='int_ior' value='1.4'/><float name='ext_ior' value='1'/></bsdf>"
          "<medium name='interior' type='homogeneous'><rgb name='sigma_a' value='0.60198640, 0.05268026, 0.25541281'/>"
          "<rgb name='sigma_s' value='0'/></medium>");
      twins.add_sphere(1.5, 0.5, diffuse({0.5, 0.5, 0.5, 1}), diffuse_xml("0.5"));
      twins.add_sphere(0.5, -2, diffuse({0.9, 0.9, 0.9, 1}), diffuse_xml("0.9"));
      twins.add_light({{"type", "point"}, {"color", {1, 0.8, 0.6}}, {"intensity", 30}}, {{"translation", {0, 3, 4}}},
                      "<emitter type='point'><point name='position' x='0' y='3' z='4'/><rgb name='intensity' "
                      "value='30, 24, 18'/></emitter>");
      twins.add_light({{"type", "directional"}, {"intensity", 2}},
                      {{"rotation", {-0.38268343236508984, 0, 0, 0.9238795325112867}}},
                      "<emitter type='directional'><vector name='direction' x='0' y='-0.70710678' "
                      "z='-0.70710678'/><rgb name='irradiance' value='2'/></emitter>");
      twins.check(color);
    }
  }
}

}  // namespace sheaf::test_gltf_twins
