// A glTF document that uses nearly everything that the reader supports.
#pragma once

#include "tests/support/files/gltf_files.h"

namespace sheaf::test {

/// A PNG of one red pixel, as a data URI.
inline constexpr const char* kPixelUri =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJg"
    "gg==";

namespace gltf_samples_detail {

using nlohmann::json;

inline json layered_material() {
  const json texture = {{"index", 0}};
  json extensions = {
      {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatTexture", texture}}},
      {"KHR_materials_sheen", {{"sheenColorFactor", {0.5, 0, 0}}, {"sheenRoughnessTexture", texture}}},
      {"KHR_materials_specular", {{"specularColorFactor", {1, 2, 1}}, {"specularTexture", texture}}},
      {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}},
      {"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}},
  };
  json transform = {{"KHR_texture_transform", {{"offset", {0.5, 0}}, {"scale", {2, 2}}, {"rotation", 1}}}};
  return {{"pbrMetallicRoughness",
           {{"baseColorTexture", {{"index", 0}, {"texCoord", 1}, {"extensions", transform}}},
            {"metallicRoughnessTexture", texture}}},
          {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
          {"emissiveFactor", {1, 1, 0}},
          {"emissiveTexture", texture},
          {"alphaMode", "MASK"},
          {"extensions", extensions}};
}

inline json glass_material() {
  return {{"pbrMetallicRoughness", {{"metallicFactor", 0}}},
          {"doubleSided", true},
          {"extensions",
           {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
            {"KHR_materials_ior", {{"ior", 1.4}}},
            {"KHR_materials_dispersion", {{"dispersion", 0.3}}},
            {"KHR_materials_volume",
             {{"thicknessFactor", 1}, {"attenuationDistance", 1}, {"attenuationColor", {0.5, 1, 1}}}}}}};
}

}  // namespace gltf_samples_detail

/// A skinned and morphed triangle with layers, an instanced one of glass, a camera, a light, and an animation.
inline GltfBuilder gltf_sample() {
  using nlohmann::json;
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["NORMAL"] = gltf.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  primitive["attributes"]["TANGENT"] =
      gltf.add<std::int8_t>({127, 0, 0, 127, 127, 0, 0, 127, 0, 127, 0, -127}, "VEC4", true);
  primitive["attributes"]["TEXCOORD_0"] = gltf.add<float>({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["attributes"]["TEXCOORD_1"] = gltf.add<std::uint16_t>({0, 0, 65535, 0, 0, 65535}, "VEC2", true);
  primitive["attributes"]["COLOR_0"] =
      gltf.add<std::uint8_t>({255, 255, 255, 255, 0, 255, 0, 255, 0, 0, 9, 8}, "VEC4", true);
  primitive["attributes"]["JOINTS_0"] = gltf.add<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = gltf.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
  primitive["indices"] = gltf.add<std::uint8_t>({0, 1, 2}, "SCALAR");
  const int difference = gltf.add<float>({0, 0, 1, 0, 0, 0, 0, 0, 0}, "VEC3");
  primitive["targets"] = {{{"POSITION", difference}, {"TANGENT", difference}, {"COLOR_0", difference}}};
  primitive["material"] = 0;
  gltf.json["nodes"][0]["skin"] = 0;
  gltf.json["skins"] = {{{"joints", {1, 2}},
                         {"inverseBindMatrices", gltf.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                                                  1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                                                                 "MAT4")}}};
  json& glass = gltf.add_mesh({{"POSITION", 0}});
  glass["material"] = 1;
  glass["mode"] = 5;
  const int translations = gltf.add<float>({0, 0, 1, 0, 0, 2}, "VEC3");
  gltf.json["nodes"].push_back({{"translation", {0, 0, 1}}, {"children", {2}}});
  gltf.json["nodes"].push_back({{"rotation", {0, 0, 1, 0}}});
  gltf.json["nodes"].push_back(
      {{"mesh", 1},
       {"scale", {-1, 1, 1}},
       {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translations}}}}}}}});
  gltf.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
  gltf.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"translation", {0, 0, 5}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1, 3, 4, 5};
  gltf.json["materials"] = {gltf_samples_detail::layered_material(), gltf_samples_detail::glass_material()};
  gltf.json["images"] = {{{"uri", kPixelUri}}};
  gltf.json["samplers"] = {{{"wrapS", 33648}, {"magFilter", 9728}}};
  gltf.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}}};
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"intensity", 50}, {"spot", json::object()}}};
  const int times = gltf.add<float>({0, 1}, "SCALAR");
  gltf.json["animations"] = {
      {{"channels",
        {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}},
         {{"sampler", 1}, {"target", {{"node", 2}, {"path", "rotation"}}}},
         {{"sampler", 2}, {"target", {{"node", 0}, {"path", "weights"}}}},
         {{"sampler", 2}, {"target", {{"path", "pointer"}}}}}},
       {"samplers",
        {{{"input", times},
          {"output", gltf.add<float>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}, "VEC3")},
          {"interpolation", "CUBICSPLINE"}},
         {{"input", times}, {"output", gltf.add<std::int8_t>({0, 0, 0, 127, 0, 0, 127, 0}, "VEC4", true)}},
         {{"input", times}, {"output", gltf.add<float>({0, 1}, "SCALAR")}, {"interpolation", "STEP"}}}}}};
  return gltf;
}

}  // namespace sheaf::test
