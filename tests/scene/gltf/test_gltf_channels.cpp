// The channel of a texture that each property of glTF materials reads.
#include "tests/support/files/gltf_samples.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

namespace sheaf::test_gltf_channels {

using namespace test;
using nlohmann::json;
using Channel = BitmapDescription::Channel;

namespace {

Description read_material(const json& material) {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["TEXCOORD_0"] = gltf.add<float>({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["material"] = 0;
  gltf.json["materials"] = json::array({material});
  gltf.json["images"] = {{{"uri", kPixelUri}}};
  gltf.json["textures"] = {{{"source", 0}}};
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.gltf", gltf.text()), {});
}

/// Channels of the images that a scene uses.
std::vector<Channel> channels_of(const Description& d) {
  std::vector<Channel> channels;
  for (const TextureDescription& texture : d.textures)
    if (const auto* image = std::get_if<BitmapDescription>(&texture.model)) channels.push_back(image->channel);
  return channels;
}

/// A material with one texture, at a pointer, and the factors that it needs to matter.
json with_texture(const char* texture, json factors) {
  json material = std::move(factors);
  material[json::json_pointer(texture)] = {{"index", 0}};
  return material;
}

json extension(const char* name, const json& factors) { return {{"extensions", {{name, factors}}}}; }

}  // namespace

TEST_CASE("gltf channels: every texture is read from the channel of its specification") {
  struct Slot {
    const char* texture;
    json factors;
    std::vector<Channel> channels;
  };
  const char *coat = "KHR_materials_clearcoat", *sheen = "KHR_materials_sheen", *specular = "KHR_materials_specular";
  const json glass = extension("KHR_materials_transmission", {{"transmissionFactor", 1}});
  const std::vector<Slot> slots = {
      {"/pbrMetallicRoughness/baseColorTexture", json::object(), {Channel::kColor}},
      {"/pbrMetallicRoughness/metallicRoughnessTexture", json::object(), {Channel::kBlue, Channel::kGreen}},
      {"/normalTexture", json::object(), {Channel::kColor}},
      {"/emissiveTexture", {{"emissiveFactor", {1, 1, 1}}}, {Channel::kColor}},
      {"/extensions/KHR_materials_clearcoat/clearcoatTexture",
       extension(coat, {{"clearcoatFactor", 1}}),
       {Channel::kRed}},
      {"/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
       extension(coat, {{"clearcoatFactor", 1}, {"clearcoatRoughnessFactor", 1}}),
       {Channel::kGreen}},
      {"/extensions/KHR_materials_sheen/sheenColorTexture",
       extension(sheen, {{"sheenColorFactor", {1, 1, 1}}}),
       {Channel::kColor}},
      {"/extensions/KHR_materials_sheen/sheenRoughnessTexture",
       extension(sheen, {{"sheenColorFactor", {1, 1, 1}}, {"sheenRoughnessFactor", 1}}),
       {Channel::kAlpha}},
      {"/extensions/KHR_materials_specular/specularTexture", extension(specular, json::object()), {Channel::kAlpha}},
      {"/extensions/KHR_materials_specular/specularColorTexture",
       extension(specular, json::object()),
       {Channel::kColor}},
      {"/extensions/KHR_materials_transmission/transmissionTexture",
       {{"pbrMetallicRoughness", {{"metallicFactor", 0}}}, {"extensions", glass["extensions"]}},
       {Channel::kRed}},
      {"/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture",
       extension("KHR_materials_pbrSpecularGlossiness", json::object()),
       {Channel::kAlpha, Channel::kColor}},
  };
  for (const Slot& slot : slots) {
    CAPTURE(slot.texture);
    CHECK(channels_of(read_material(with_texture(slot.texture, slot.factors))) == slot.channels);
  }
}

}  // namespace sheaf::test_gltf_channels
