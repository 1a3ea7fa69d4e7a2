// Tangents of glTF files in images: anisotropy and normal maps against closed forms and against meshes whose texture
// coordinates have the same tangents, through all ways to place and to deform a mesh. Coverage by vertex colors.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/image_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_tangent_renders {

using namespace test;
using nlohmann::json;

namespace {

struct Vector {
  double x = 0, y = 0, z = 0;
  Vector operator+(Vector b) const { return {x + b.x, y + b.y, z + b.z}; }
  Vector operator*(double s) const { return {x * s, y * s, z * s}; }
};
double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector unit(Vector a) { return a * (1 / std::sqrt(dot(a, a))); }

/// Towards the light, which gives pi lx on a surface that faces it, and towards the camera.
const Vector kLight = unit({0.5, 0.3, 0.8}), kView{0, 0, 1};

/// Tangent frame of a plane with normal z.
struct Tangents {
  double angle = 0;       ///< of the tangent from x, radians
  double handedness = 1;  ///< of the bitangent
  Vector tangent() const { return {std::cos(angle), std::sin(angle), 0}; }
  Vector bitangent() const { return Vector{-std::sin(angle), std::cos(angle), 0} * handedness; }
};

/// How a mesh says its tangents.
enum class Source { kAttribute, kUv };

/// A square of edge 8 around the origin with normal z, under a light, before an orthographic camera of 2 x 2 units.
/// Node 0 shows it.
class Square {
 public:
  Square(const Tangents& tangents, Source source, const json& material) {
    std::vector<float> positions, normals, uvs, frames, joints, weights;
    for (const Vector p : {Vector{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}}) {
      positions.insert(positions.end(), {float(p.x), float(p.y), 0});
      normals.insert(normals.end(), {0, 0, 1});
      const Vector t = tangents.tangent(), b = tangents.bitangent();
      // v runs downwards in files
      const double u = source == Source::kUv ? dot(p, t) : -p.y, v = source == Source::kUv ? 1 - dot(p, b) : p.x;
      uvs.insert(uvs.end(), {float(u), float(v)});
      frames.insert(frames.end(), {float(t.x), float(t.y), 0, float(tangents.handedness)});
    }
    json attributes = {{"POSITION", gltf.add(positions, "VEC3")},
                       {"NORMAL", gltf.add(normals, "VEC3")},
                       {"TEXCOORD_0", gltf.add(uvs, "VEC2")}};
    if (source == Source::kAttribute) attributes["TANGENT"] = gltf.add(frames, "VEC4");
    json& primitive = gltf.add_mesh(attributes);
    primitive["indices"] = gltf.add<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
    primitive["material"] = 0;
    gltf.json["materials"] = json::array({material});
    gltf.json["images"] = {{{"uri", "map.bmp"}}};
    gltf.json["textures"] = {{{"source", 0}}};
    gltf.json["cameras"] = {
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.01}, {"zfar", 100}}}}};
    const double w = 1 + kLight.z, norm = std::sqrt(kLight.x * kLight.x + kLight.y * kLight.y + w * w);
    gltf.json["nodes"] = {{{"mesh", 0}},
                          {{"camera", 0}, {"translation", {0, 0, 20}}},
                          {{"rotation", {-kLight.y / norm, kLight.x / norm, 0, w / norm}},
                           {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}};
    gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}, {"intensity", 3.141592653589793}}};
  }

  /// Skins the square to a joint, which becomes node 3.
  void add_joint(const json& joint) {
    json& attributes = gltf.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = gltf.add<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
    attributes["WEIGHTS_0"] = gltf.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    gltf.json["nodes"][0]["skin"] = 0;
    gltf.json["nodes"].push_back(joint);
    gltf.json["scenes"][0]["nodes"].push_back(3);
    gltf.json["skins"] = {{{"joints", {3}}}};
  }

  /// Turns a node about z by 90 degrees within the shutter interval.
  void azimuth(int node) {
    const float half = std::sqrt(0.5f);
    animate(node, "rotation", gltf.add<float>({0, 0, 0, 1, 0, 0, half, half}, "VEC4"));
  }

  /// Animates a node from time 0 to time 1, while the shutter is open.
  void animate(int node, const char* path, int output) {
    const int times = gltf.add<float>({0, 1}, "SCALAR");
    gltf.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}},
                                {"samplers", {{{"input", times}, {"output", output}}}}}};
    options.moment = {0, {}};
    options.shutter = ShutterDescription{0, 1, 0};
  }

  /// The mean radiance of the green channel. `map`: RGB of the texture, below 256.
  double mean(const std::vector<int>& map = {200, 90, 220}) const {
    const TemporaryFolder folder;
    write_bmp(folder / "map.bmp", 1, 1, map);
    Description d = read_scene(write_below(folder, "model.gltf", gltf.text()), options);
    d.film.width = d.film.height = 8;
    d.sampler.sample_count = samples;
    const Image image = render(*compile_scene(d), {}).film.to_image();
    double sum = 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) sum += static_cast<double>(image.at(x, y, 1));
    return sum / 64;
  }

  GltfBuilder gltf;
  ReadOptions options;
  std::uint32_t samples = 4;
};

json metal(double roughness, double anisotropy = 0, double rotation = 0) {
  json material = {{"pbrMetallicRoughness", {{"metallicFactor", 1}, {"roughnessFactor", roughness}}}};
  if (anisotropy > 0)
    material["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", anisotropy},
                                                          {"anisotropyRotation", rotation}};
  return material;
}

/// Radiance of a white anisotropic metal under the light: KHR_materials_anisotropy, D_GGX and V_GGX.
double anisotropic_metal(Vector t, Vector b, double roughness, double strength) {
  const double alpha_b = roughness * roughness, alpha_t = alpha_b + (1 - alpha_b) * strength * strength;
  const Vector h = unit(kLight + kView);
  const double f = std::pow(dot(h, t) / alpha_t, 2) + std::pow(dot(h, b) / alpha_b, 2) + h.z * h.z;
  const auto root = [&](Vector v) {
    return std::sqrt(std::pow(alpha_t * dot(v, t), 2) + std::pow(alpha_b * dot(v, b), 2) + v.z * v.z);
  };
  const double visibility = 0.5 / (kLight.z * root(kView) + kView.z * root(kLight));
  return visibility * kLight.z / (alpha_t * alpha_b * f * f);
}

/// A material that depends on every part of the frame.
json full_material() {
  json material = metal(0.6, 0.8, 0.6);
  material["normalTexture"] = {{"index", 0}, {"scale", 0.5}};
  return material;
}

}  // namespace

TEST_SUITE("Renders") {
  TEST_CASE("gltf tangents: anisotropy follows the tangents of the file, with their handedness") {
    for (const double angle : {0.0, 0.7, 2.0})
      for (const double handedness : {1.0, -1.0})
        for (const double rotation : {0.0, 0.6}) {
          CAPTURE(angle);
          CAPTURE(handedness);
          CAPTURE(rotation);
          const Tangents frame{angle, handedness};
          const Vector t = frame.tangent() * std::cos(rotation) + frame.bitangent() * std::sin(rotation);
          const double expected = anisotropic_metal(t, {-t.y, t.x, 0}, 0.5, 0.9);
          for (const Source source : {Source::kAttribute, Source::kUv})
            CHECK(Square(frame, source, metal(0.5, 0.9, rotation)).mean() == near(expected, 1e-3));
        }
  }

  TEST_CASE("gltf tangents: normal maps follow the tangents of the file, with their handedness") {
    json material = metal(1);
    material["normalTexture"] = {{"index", 0}};
    const double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 220 / 255.0 - 1;
    for (const double angle : {0.0, 0.7, 2.0})
      for (const double handedness : {1.0, -1.0}) {
        CAPTURE(angle);
        CAPTURE(handedness);
        const Tangents frame{angle, handedness};
        const Vector n = unit(frame.tangent() * x + frame.bitangent() * y + Vector{0, 0, z});
        // For alpha = 1 the GGX distribution is constant, and masking depends on the cosines alone
        const double radiance = 0.5 * dot(n, kLight) / (dot(n, kLight) + dot(n, kView));
        // The shadow terminator of Estevez, Lecocq and Stein (2019)
        const double alpha2 = 0.125 * (1 / (n.z * n.z) - 1), tan2 = 1 / (kLight.z * kLight.z) - 1;
        const double expected = radiance * 2 / (1 + std::sqrt(1 + alpha2 * tan2));
        for (const Source source : {Source::kAttribute, Source::kUv})
          CHECK(Square(frame, source, material).mean() == near(expected, 1e-3));
      }
  }

  TEST_CASE("gltf tangents: nodes, instances, joints and motion carry them as they carry texture coordinates") {
    struct Slot {
      std::string name;
      void (*put)(Square&);
    };
    const Slot slots[] = {
        {"node",
         [](Square& s) {
           s.gltf.json["nodes"][0]["rotation"] = {0.1, 0.2, 0.3, 0.9};
         }},
        {"mirrored node",
         [](Square& s) {
           s.gltf.json["nodes"][0]["scale"] = {-1, 2, 1};
         }},
        {"node seen from behind",
         [](Square& s) {
           s.gltf.json["nodes"][0]["rotation"] = {0, 1, 0, 0.1};
         }},
        {"instances",
         [](Square& s) {
           s.gltf.json["nodes"][0]["scale"] = {1, -2, 1};
           s.gltf.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, -5}}});
           s.gltf.json["scenes"][0]["nodes"].push_back(3);
         }},
        {"skin",
         [](Square& s) {
           s.add_joint({{"rotation", {0.1, 0.2, 0.3, 0.9}}, {"scale", {1, 2, 1}}});
         }},
        {"mirrored skin",
         [](Square& s) {
           s.add_joint({{"scale", {-1, 2, 1}}});
         }},
        {"moving node", [](Square& s) { s.azimuth(0); }},
        {"moving joint",
         [](Square& s) {
           s.add_joint({{"scale", {1, -1, 1}}});
           s.azimuth(3);
         }},
    };
    for (const Slot& slot : slots) {
      CAPTURE(slot.name);
      double means[2];
      for (const double handedness : {1.0, -1.0}) {
        Square own({0.7, handedness}, Source::kAttribute, full_material());
        Square of_uv({0.7, handedness}, Source::kUv, full_material());
        slot.put(own);
        slot.put(of_uv);
        means[handedness > 0] = own.mean();
        CHECK(means[handedness > 0] == near(of_uv.mean(), 1e-3));
      }
      CHECK(means[0] != near(means[1], 0.02));
    }
  }

  TEST_CASE("gltf tangents: an instance looks like the same mesh alone") {
    for (const double handedness : {1.0, -1.0}) {
      Square alone({0.3, handedness}, Source::kAttribute, full_material());
      alone.gltf.json["nodes"][0]["scale"] = {1, -2, 1};
      Square shared = alone;
      shared.gltf.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, -5}}});
      shared.gltf.json["scenes"][0]["nodes"].push_back(3);
      CHECK(shared.mean() == near(alone.mean(), 1e-4));
    }
  }

  TEST_CASE("gltf tangents: in mixtures with glass, handedness turns the rotation of anisotropy") {
    json glass = metal(0.4, 0.9, 0.6);
    glass["pbrMetallicRoughness"]["metallicFactor"] = 0.5;
    glass["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 0.5}};
    glass["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
    json rotated = glass;
    rotated["extensions"]["KHR_materials_anisotropy"]["anisotropyRotation"] = -0.6;
    const double left = Square({0, -1}, Source::kAttribute, glass).mean();
    CHECK(left == near(Square({0, 1}, Source::kAttribute, rotated).mean(), 1e-4));
    CHECK(left != near(Square({0, 1}, Source::kAttribute, glass).mean(), 0.02));
  }

  TEST_CASE("gltf: a joint shrinks its vertices to nothing while the shutter is open") {
    Square square({}, Source::kUv, metal(1));
    square.add_joint(json::object());
    square.animate(3, "scale", square.gltf.add<float>({1, 1, 1, 0, 0, 0}, "VEC3"));
    square.samples = 64;
    // The square fills the image until its edge is a quarter of its length: 3/4 + integral of (4 s)^2 from 0 to 1/4
    const double lit = 0.5 * kLight.z / (kLight.z + kView.z), fraction = 0.75 + 1 / 12.0;
    // Five standard errors of independent samples
    CHECK(square.mean() == within(lit * fraction, 5 * lit * std::sqrt(fraction * (1 - fraction) / (64 * 64))));
  }

  TEST_CASE("gltf: alpha masks compare the product of factor and vertex color") {
    json material = metal(1);
    material["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.8};
    material["alphaMode"] = "MASK";
    material["alphaCutoff"] = 0.3;
    Square square({}, Source::kUv, material);
    const double lit = 0.5 * kLight.z / (kLight.z + kView.z);
    CHECK(square.mean() == near(lit, 1e-3));
    const auto set_alpha = [&](float left, float right) {
      square.gltf.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
          square.gltf.add<float>({1, 1, 1, left, 1, 1, 1, right, 1, 1, 1, right, 1, 1, 1, left}, "VEC4");
    };
    set_alpha(0.38f, 0.38f);
    CHECK(square.mean() == near(lit, 1e-3));
    set_alpha(0.37f, 0.37f);
    CHECK(square.mean() == 0);
    // The camera sees the middle quarter of a ramp, of which the upper half is above the cutoff
    set_alpha(0.375f - 0.2f, 0.375f + 0.2f);
    CHECK(square.mean() == near(lit / 2, 0.02));
  }
}

}  // namespace sheaf::test_tangent_renders
