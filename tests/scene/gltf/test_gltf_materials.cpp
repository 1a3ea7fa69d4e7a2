// glTF materials: factors, textures, layers, transmission, emission and coverage.
#include "scene/compile/compile.h"
#include "tests/support/files/gltf_samples.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_gltf_materials {

using namespace test;
using nlohmann::json;

namespace {

/// A triangle with a material, texture coordinates and one texture.
GltfBuilder textured(const json& material) {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["TEXCOORD_0"] = gltf.add<float>({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["attributes"]["TEXCOORD_1"] = gltf.add<float>({0, 0, 0.5f, 0, 0, 0.25f}, "VEC2");
  primitive["material"] = 0;
  gltf.json["materials"] = json::array({material});
  gltf.json["images"] = {{{"uri", kPixelUri}}};
  gltf.json["textures"] = {{{"source", 0}}};
  return gltf;
}

struct Read {
  Description d;
  /// The material of the first shape, or one nested in it.
  const MaterialDescription& top() const { return at(*d.shapes.front().material); }
  const MaterialDescription& at(MaterialId id) const { return d.materials[static_cast<std::size_t>(id)]; }
  template <class Model> const Model& model(MaterialId id) const {
    REQUIRE(std::holds_alternative<Model>(at(id).model));
    return std::get<Model>(at(id).model);
  }
  /// The closure of an opaque material.
  const MetallicRoughnessDescription& opaque() const {
    return model<MetallicRoughnessDescription>(model<TwoSidedDescription>(*d.shapes.front().material).front);
  }
  const TextureDescription& texture(const auto& input) const {
    return d.textures[static_cast<std::size_t>(std::get<TextureId>(input))];
  }
};

Read read_material(const json& material) {
  const TemporaryFolder folder;
  Read read{read_scene(write_below(folder, "model.gltf", textured(material).text()), {})};
  compile_scene(read.d);  // textures must load
  return read;
}

Vec3f rgb_of(const SpectrumInput& input) {
  return std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(input).value).value;
}

}  // namespace

TEST_CASE("gltf: factors become the closure's parameters and defaults are those of the specification") {
  const Read read = read_material(
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {0.25, 0.5, 0.75, 1}}, {"metallicFactor", 0.125}, {"roughnessFactor", 0.375}}}});
  CHECK(rgb_of(read.opaque().base_color).z == 0.75f);
  CHECK(std::get<float>(read.opaque().metallic) == 0.125f);
  CHECK(std::get<float>(read.opaque().roughness) == 0.375f);
  const Read standard = read_material(json::object());
  CHECK(std::get<float>(standard.opaque().metallic) == 1);
  CHECK(std::get<float>(standard.opaque().roughness) == 1);
  CHECK(standard.opaque().eta == 1.5f);
}

TEST_CASE("gltf: metallic is the blue channel and roughness the green one, without decoding, times their factors") {
  const Read read = read_material(
      {{"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}, {"roughnessFactor", 0.5}}}});
  const auto& metallic = std::get<BitmapDescription>(read.texture(read.opaque().metallic).model);
  CHECK(metallic.channel == BitmapDescription::Channel::kBlue);
  CHECK(metallic.raw);
  const auto& product = std::get<ProductTextureDescription>(read.texture(read.opaque().roughness).model);
  CHECK(std::get<BitmapDescription>(read.texture(product.b).model).channel == BitmapDescription::Channel::kGreen);
}

TEST_CASE("gltf: texture transforms rotate and scale about the upper left corner") {
  json transform = {{"offset", {0.5, 0.25}}, {"rotation", 1.5707963267948966}, {"scale", {2, 4}}};
  const Read read =
      read_material({{"pbrMetallicRoughness",
                      {{"baseColorTexture", {{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}}}}}});
  const std::array<float, 6>& m = read.texture(read.opaque().base_color).to_uv;
  // With v downwards, (u, v) = (0.5, 0.25) is scaled to (1, 1), turned to (1, -1) and moved to (1.5, -0.75).
  const float u = 0.5f, v = 1 - 0.25f;
  CHECK(m[0] * u + m[1] * v + m[2] == near(1.5));
  CHECK(1 - (m[3] * u + m[4] * v + m[5]) == near(-0.75));
}

TEST_CASE("gltf: textures use the second set of coordinates, samplers wrap and filter") {
  GltfBuilder gltf = textured({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                               {"emissiveFactor", {1, 1, 1}},
                               {"emissiveTexture", {{"index", 0}, {"texCoord", 1}}}});
  gltf.json["textures"][0]["sampler"] = 0;
  gltf.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  const TemporaryFolder folder;
  const Read read{read_scene(write_below(folder, "model.gltf", gltf.text()), {})};
  const auto& image = std::get<BitmapDescription>(read.texture(read.opaque().base_color).model);
  CHECK(image.wrap_u == TextureWrap::kClamp);
  CHECK(image.wrap_v == TextureWrap::kMirror);
  CHECK(image.filter == TextureFilter::kNearest);
  const auto& set = std::get<UvSetTextureDescription>(read.texture(*read.d.shapes.front().radiance).model);
  CHECK(set.attribute == "vertex_uv1");
  const Mesh& mesh = std::get<Mesh>(read.d.shapes.front().geometry);
  REQUIRE(mesh.attributes.size() == 1);
  CHECK(mesh.attributes[0].values[3] == 0.5f);
  CHECK(mesh.attributes[0].values[7] == 0.75f);
}

TEST_CASE("gltf: alpha is ignored, compared or blended by its mode") {
  const json half = {{"baseColorFactor", {1, 1, 1, 0.5}}};
  const json textured_half = {{"baseColorFactor", {1, 1, 1, 0.5}}, {"baseColorTexture", {{"index", 0}}}};
  CHECK(std::holds_alternative<TwoSidedDescription>(read_material({{"pbrMetallicRoughness", half}}).top().model));
  const Read blend = read_material({{"pbrMetallicRoughness", half}, {"alphaMode", "BLEND"}});
  CHECK(std::get<float>(std::get<MaskDescription>(blend.top().model).opacity) == 0.5f);
  const Read hidden = read_material({{"pbrMetallicRoughness", half}, {"alphaMode", "MASK"}, {"alphaCutoff", 0.6}});
  CHECK(std::get<float>(std::get<MaskDescription>(hidden.top().model).opacity) == 0);
  const Read displayed = read_material({{"pbrMetallicRoughness", half}, {"alphaMode", "MASK"}});
  CHECK(std::holds_alternative<TwoSidedDescription>(displayed.top().model));
  const Read mask = read_material({{"pbrMetallicRoughness", textured_half}, {"alphaMode", "MASK"}});
  const auto& opacity = std::get<MaskDescription>(mask.top().model).opacity;
  CHECK(std::get<ThresholdTextureDescription>(mask.texture(opacity).model).threshold == 0.5f);
}

TEST_CASE("gltf: volumes refract, absorb and disperse") {
  const json volume = {{"thicknessFactor", 0.1}, {"attenuationDistance", 2}, {"attenuationColor", {0.25, 1, 0.5}}};
  const Read read = read_material({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
                                   {"extensions",
                                    {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                                     {"KHR_materials_ior", {{"ior", 1.7}}},
                                     {"KHR_materials_dispersion", {{"dispersion", 0.5}}},
                                     {"KHR_materials_volume", volume}}}});
  const auto& glass = std::get<DielectricDescription>(read.top().model);
  CHECK(glass.int_ior == 1.7f);
  CHECK(glass.ext_ior == 1);
  CHECK_FALSE(glass.roughness);
  // Abbe number 20 / 0.5 = 40 = (n_d - 1) / (n_F - n_C)
  REQUIRE(glass.int_dispersion);
  const float blue = ior<Scalar>(*glass.int_dispersion, 486.13f), red = ior<Scalar>(*glass.int_dispersion, 656.27f);
  CHECK((ior<Scalar>(*glass.int_dispersion, 587.56f) - 1) / (blue - red) == near(40, 1e-3));
  REQUIRE(read.d.shapes.front().interior);
  const auto& medium = std::get<AbsorptionScatteringDescription>(read.d.media.front().coefficients);
  CHECK(rgb_of(std::get<SpectrumDescription>(medium.sigma_a)).x == near(std::log(4.0) / 2));
  CHECK(rgb_of(std::get<SpectrumDescription>(medium.sigma_a)).y == 0);
}

TEST_CASE("gltf: without a volume, transmission is that of a thin wall") {
  const auto thin = [](double roughness) {
    return read_material({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", roughness}}},
                          {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.5}}}}}});
  };
  CHECK(std::get<float>(std::get<MetallicRoughnessDescription>(thin(0.4).top().model).transmission) == 0.5f);
  const Read smooth = thin(0);
  const auto& blend = std::get<BlendDescription>(smooth.top().model);
  CHECK(std::get<float>(blend.weight) == 0.5f);
  CHECK(smooth.model<DielectricDescription>(blend.nested[1]).thin);
}

TEST_CASE("gltf: the partly metallic base of a transmitting volume is the rest of the mixture") {
  const Read read = read_material({{"pbrMetallicRoughness", {{"metallicFactor", 0.5}}},
                                   {"extensions",
                                    {{"KHR_materials_transmission", {{"transmissionFactor", 0.5}}},
                                     {"KHR_materials_volume", {{"thicknessFactor", 1}}}}}});
  const auto& blend = std::get<BlendDescription>(read.top().model);
  CHECK(std::get<float>(blend.weight) == 0.25f);
  const auto& base = read.model<MetallicRoughnessDescription>(read.model<TwoSidedDescription>(blend.nested[0]).front);
  // Metal is half of the whole, and the base three quarters.
  CHECK(std::get<float>(base.metallic) == near(0.5 / 0.75));
}

TEST_CASE("gltf: surfaces emit by factor and strength, on both sides if double-sided") {
  const Read read = read_material({{"emissiveFactor", {0.5, 0.25, 0}},
                                   {"doubleSided", true},
                                   {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}}}}});
  CHECK(rgb_of(*read.d.shapes.front().radiance).x == 4);
  CHECK(read.d.shapes.front().emits_on_both_sides);
  CHECK_FALSE(read_material(json::object()).d.shapes.front().radiance);
  const Read unlit = read_material({{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5, 0, 1}}}},
                                    {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  CHECK(rgb_of(*unlit.d.shapes.front().radiance).y == 0.5f);
}

TEST_CASE("gltf: specular-glossiness becomes a dielectric with colored reflectance") {
  const Read read = read_material({{"extensions",
                                    {{"KHR_materials_pbrSpecularGlossiness",
                                      {{"diffuseFactor", {0.5, 0.25, 0.125, 1}},
                                       {"specularFactor", {0.1, 0.2, 0.3}},
                                       {"glossinessFactor", 0.75}}}}}});
  CHECK(std::get<float>(read.opaque().metallic) == 0);
  CHECK(std::get<float>(read.opaque().roughness) == 0.25f);
  CHECK(rgb_of(read.opaque().base_color).y == 0.25f);
  CHECK(rgb_of(read.opaque().specular_color).z == 0.3f);
  CHECK(std::isinf(read.opaque().eta));
}

TEST_CASE("gltf: layers, normal maps and their textures are read") {
  const Read read =
      read_material({{"normalTexture", {{"index", 0}, {"scale", 0.5}}},
                     {"extensions",
                      {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0.75}, {"clearcoatRoughnessFactor", 0.125}}},
                       {"KHR_materials_sheen", {{"sheenColorFactor", {0.5, 0, 0}}, {"sheenRoughnessFactor", 0.25}}},
                       {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1, 2, 3}}}},
                       {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.625}, {"anisotropyRotation", 1.5}}}}}});
  const auto& map =
      read.model<NormalMapDescription>(read.model<TwoSidedDescription>(*read.d.shapes.front().material).front);
  CHECK(map.scale == 0.5f);
  CHECK(map.follows_uv);
  const auto& m = read.model<MetallicRoughnessDescription>(map.nested);
  CHECK(std::get<float>(m.clearcoat) == 0.75f);
  CHECK(std::get<float>(m.clearcoat_roughness) == 0.125f);
  CHECK(rgb_of(m.sheen_color).x == 0.5f);
  CHECK(std::get<float>(m.sheen_roughness) == 0.25f);
  CHECK(std::get<float>(m.specular) == 0.5f);
  CHECK(rgb_of(m.specular_color).z == 3);
  CHECK(std::get<float>(m.anisotropy) == 0.625f);
  CHECK(std::get<float>(m.anisotropy_rotation) == 1.5f);
}

TEST_CASE("gltf: the texture of anisotropy gives strength and direction") {
  const Read read = read_material(
      {{"extensions",
        {{"KHR_materials_anisotropy",
          {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 1.5}, {"anisotropyTexture", {{"index", 0}}}}}}}});
  CHECK(read.d.notes.empty());
  const MetallicRoughnessDescription& m = read.opaque();
  const auto& direction = std::get<DirectionTextureDescription>(read.texture(m.anisotropy_rotation).model);
  CHECK(direction.offset == 1.5f);
  const auto channel = [&](const ScalarInput& input) {
    const auto& image = std::get<BitmapDescription>(read.texture(input).model);
    CHECK(image.raw);
    return image.channel;
  };
  using Channel = BitmapDescription::Channel;
  CHECK(channel(direction.x) == Channel::kRed);
  CHECK(channel(direction.y) == Channel::kGreen);
  const auto& strength = std::get<ProductTextureDescription>(read.texture(m.anisotropy).model);
  CHECK(channel(ScalarInput(std::get<TextureId>(strength.b))) == Channel::kBlue);
}

TEST_CASE("gltf: values out of range and unsupported parts are noted") {
  const Read read = read_material(
      {{"name", "odd"},
       {"pbrMetallicRoughness", {{"metallicFactor", 1.5}}},
       {"extensions",
        {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}}}}}}}});
  CHECK(contains(read.d.notes.at(0), "materials[0]: 'metallicFactor' is greater than 1"));
  CHECK(contains(read.d.notes.at(1), "'clearcoatNormalTexture' is not supported"));
  CHECK(std::get<float>(read.opaque().metallic) == 1);
}

}  // namespace sheaf::test_gltf_materials
