// glTF files without optional properties, and what is done about valid content that is not supported.
#include "scene/compile/compile.h"
#include "tests/support/files/gltf_samples.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_gltf_optional {

using namespace test;
using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

Description read_bytes(const std::string& bytes, const char* name, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  Description d = read_scene(write_below(folder, name, bytes), options);
  compile_scene(d);  // textures and attributes must exist
  return d;
}
Description read_document(const json& document, const ReadOptions& options = {}) {
  return read_bytes(document.dump(), "model.gltf", options);
}

bool has_note(const Description& d, const std::string& part) {
  return std::any_of(d.notes.begin(), d.notes.end(), [&](const std::string& note) { return contains(note, part); });
}

const json kTexture = {{"index", 0}, {"texCoord", 1}};

json extended_materials() {
  json layers = {{"KHR_materials_clearcoat",
                  {{"clearcoatFactor", 0.5},
                   {"clearcoatTexture", kTexture},
                   {"clearcoatRoughnessFactor", 0.5},
                   {"clearcoatRoughnessTexture", kTexture},
                   {"clearcoatNormalTexture", kTexture}}},
                 {"KHR_materials_sheen",
                  {{"sheenColorFactor", {1, 1, 1}},
                   {"sheenColorTexture", kTexture},
                   {"sheenRoughnessFactor", 0.5},
                   {"sheenRoughnessTexture", kTexture}}},
                 {"KHR_materials_specular",
                  {{"specularFactor", 0.5},
                   {"specularTexture", kTexture},
                   {"specularColorFactor", {1, 1, 1}},
                   {"specularColorTexture", kTexture}}},
                 {"KHR_materials_anisotropy",
                  {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 1}, {"anisotropyTexture", kTexture}}},
                 {"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}}};
  json glass = {{"KHR_materials_transmission", {{"transmissionFactor", 1}, {"transmissionTexture", kTexture}}},
                {"KHR_materials_volume",
                 {{"thicknessFactor", 1},
                  {"thicknessTexture", kTexture},
                  {"attenuationDistance", 1},
                  {"attenuationColor", {0.5, 1, 1}}}},
                {"KHR_materials_ior", {{"ior", 1.4}}},
                {"KHR_materials_dispersion", {{"dispersion", 0.5}}}};
  json glossy = {{"KHR_materials_pbrSpecularGlossiness",
                  {{"diffuseFactor", {1, 1, 1, 1}},
                   {"diffuseTexture", kTexture},
                   {"specularFactor", {1, 1, 1}},
                   {"glossinessFactor", 0.5},
                   {"specularGlossinessTexture", kTexture}}}};
  return {{{"extensions", layers}, {"emissiveFactor", {1, 1, 1}}}, {{"extensions", glass}}, {{"extensions", glossy}}};
}

json core_material() {
  json texture = kTexture;
  texture["extensions"]["KHR_texture_transform"] = {
      {"offset", {0, 1}}, {"rotation", 1}, {"scale", {2, 2}}, {"texCoord", 0}};
  json normals = kTexture, occlusion = kTexture;
  normals["scale"] = 2;
  occlusion["strength"] = 0.5;
  return {{"name", "all"},
          {"extras", 7},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {1, 1, 1, 1}},
            {"baseColorTexture", texture},
            {"metallicFactor", 0.5},
            {"roughnessFactor", 0.5},
            {"metallicRoughnessTexture", kTexture}}},
          {"normalTexture", normals},
          {"occlusionTexture", occlusion},
          {"emissiveTexture", kTexture},
          {"emissiveFactor", {0.5, 0.5, 0.5}},
          {"alphaMode", "MASK"},
          {"alphaCutoff", 0.25},
          {"doubleSided", true},
          {"extensions", json::object()}};
}

/// A triangle with all attributes, which is skinned, morphed and animated, and one with each further material.
void add_meshes(GltfBuilder& gltf) {
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["NORMAL"] = gltf.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  primitive["attributes"]["TANGENT"] = gltf.add<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4");
  primitive["attributes"]["TEXCOORD_0"] = gltf.add<float>({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["attributes"]["TEXCOORD_1"] = gltf.add<float>({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["attributes"]["COLOR_0"] = gltf.add<std::uint8_t>({9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9}, "VEC4", true);
  primitive["attributes"]["JOINTS_0"] = gltf.add<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = gltf.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
  const json attributes = primitive["attributes"];
  // Indices whose first values come from the buffer view, and the last one from elsewhere
  const int indices = gltf.add<std::uint16_t>({0, 1, 0}, "SCALAR");
  const std::uint16_t sparse_indices[] = {0, 1, 2}, values[] = {0, 1, 2};
  gltf.json["accessors"][indices]["byteOffset"] = 0;
  gltf.json["accessors"][indices]["name"] = "indices";
  gltf.json["accessors"][indices]["min"] = {0};
  gltf.json["accessors"][indices]["max"] = {2};
  gltf.json["accessors"][indices]["sparse"] = {
      {"count", 3},
      {"indices",
       {{"bufferView", gltf.add_view(sparse_indices, sizeof(sparse_indices))},
        {"byteOffset", 0},
        {"componentType", 5123}}},
      {"values", {{"bufferView", gltf.add_view(values, sizeof(values))}, {"byteOffset", 0}}}};
  primitive["indices"] = indices;
  primitive["mode"] = 4;
  primitive["material"] = 0;
  primitive["extras"] = json::object();
  primitive["targets"] = {{{"POSITION", gltf.add<float>({0, 0, 1, 0, 0, 0, 0, 0, 0}, "VEC3")},
                           {"NORMAL", gltf.add<float>({0, 0, 1, 0, 0, 0, 0, 0, 0}, "VEC3")},
                           {"TANGENT", gltf.add<float>({0, 0, 1, 0, 0, 0, 0, 0, 0}, "VEC3")}}};
  gltf.json["meshes"][0]["name"] = "mesh";
  gltf.json["meshes"][0]["weights"] = {0.5};
  for (int material = 1; material <= 3; ++material) {
    json displayed = attributes;
    displayed.erase("JOINTS_0");
    displayed.erase("WEIGHTS_0");
    gltf.add_mesh(displayed)["material"] = material;
  }
}

void add_nodes(GltfBuilder& gltf) {
  json& nodes = gltf.json["nodes"];
  nodes[0] = {{"name", "skinned"}, {"mesh", 0}, {"skin", 0}, {"weights", {0.25}}, {"extras", {1, 2}}};
  nodes.push_back({{"name", "joint"},
                   {"translation", {1, 0, 0}},
                   {"rotation", {0, 0, 0, 1}},
                   {"scale", {1, 1, 1}},
                   {"children", {2}}});
  nodes.push_back({{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1}}});
  nodes.push_back({{"mesh", 1}});
  nodes.push_back({{"mesh", 2}, {"extensions", json::object()}});
  nodes.push_back({{"mesh", 3}});
  const int vectors = gltf.add<float>({1, 0, 0, 2, 0, 0}, "VEC3");
  nodes[5]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", vectors},
      {"ROTATION", gltf.add<float>({0, 0, 0, 1, 0, 0, 0, 1}, "VEC4")},
      {"SCALE", gltf.add<float>({1, 1, 1, 2, 2, 2}, "VEC3")}};
  nodes.push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
  for (int light = 0; light < 3; ++light)
    nodes.push_back({{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}, {"translation", {0, 0, 5}}});
  gltf.json["scenes"][0] = {{"name", "scene"}, {"nodes", {0, 1, 3, 4, 5, 6, 7, 8, 9}}, {"extras", nullptr}};
  std::vector<float> identities(32, 0.0f);
  for (std::size_t i = 0; i < 32; i += i % 16 == 15 ? 1 : 5) identities[i] = 1;
  gltf.json["skins"] = {{{"name", "skin"},
                         {"joints", {1, 2}},
                         {"skeleton", 1},
                         {"inverseBindMatrices", gltf.add<float>(identities, "MAT4")}}};
  gltf.json["cameras"] = {{{"name", "camera"},
                           {"type", "perspective"},
                           {"perspective", {{"yfov", 0.7}, {"znear", 0.1}, {"aspectRatio", 1.5}, {"zfar", 100}}},
                           {"extras", {{"aperture_radius", 0.01}}}}};
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"},
       {"name", "spot"},
       {"color", {1, 1, 1}},
       {"intensity", 5},
       {"range", 9},
       {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.5}}}},
      {{"type", "point"}, {"color", {1, 1, 1}}, {"intensity", 5}, {"range", 9}},
      {{"type", "directional"}, {"color", {1, 1, 1}}, {"intensity", 5}}};
}

void add_animation(GltfBuilder& gltf) {
  const int times = gltf.add<float>({0, 1}, "SCALAR");
  const int values = gltf.add<float>({0, 0, 0, 4, 0, 0}, "VEC3");
  const json pointer = {{"KHR_animation_pointer", {{"pointer", "/materials/0/alphaCutoff"}}}};
  const int cutoffs = gltf.add<float>({0, 1}, "SCALAR");
  gltf.json["animations"] = {{{"name", "walk"},
                              {"channels",
                               {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}},
                                {{"sampler", 1}, {"target", {{"node", 3}, {"path", "translation"}}}},
                                {{"sampler", 2}, {"target", {{"path", "pointer"}, {"extensions", pointer}}}}}},
                              {"samplers",
                               {{{"input", times}, {"output", values}, {"interpolation", "STEP"}},
                                {{"input", times}, {"output", values}, {"interpolation", "LINEAR"}},
                                {{"input", times}, {"output", cutoffs}, {"interpolation", "LINEAR"}}}}}};
}

/// A document with all properties of the core specification, and all of the extensions that are read.
json full_document() {
  GltfBuilder gltf;
  add_meshes(gltf);
  add_nodes(gltf);
  add_animation(gltf);
  gltf.json["asset"] = {{"version", "2.0"}, {"minVersion", "2.0"},          {"generator", "test"},
                        {"copyright", ""},  {"extensions", json::object()}, {"extras", "text"}};
  gltf.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_animation_pointer"};
  gltf.json["extensionsRequired"] = {"KHR_lights_punctual"};
  gltf.json["extras"] = json::object();
  gltf.json["materials"] = json::array({core_material()});
  for (const json& material : extended_materials()) gltf.json["materials"].push_back(material);
  gltf.json["images"] = {{{"uri", kPixelUri}, {"mimeType", "image/png"}, {"name", "pixel"}}};
  gltf.json["samplers"] = {
      {{"name", "s"}, {"wrapS", 33648}, {"wrapT", 33071}, {"magFilter", 9728}, {"minFilter", 9984}}};
  gltf.json["textures"] = {{{"name", "t"}, {"source", 0}, {"sampler", 0}}};
  for (json& view : gltf.json["bufferViews"]) view["name"] = "view";
  gltf.json["bufferViews"][0]["byteStride"] = 12;
  gltf.json["bufferViews"][0]["target"] = 34962;
  json document = json::parse(gltf.text());
  document["buffers"][0]["name"] = "buffer";
  return document;
}

/// The optional properties of each kind of object. glTF 2.0, section 5, and the extensions' schemas.
const std::vector<std::pair<const char*, std::vector<const char*>>> kOptional = {
    {"", {"extensionsUsed", "extensionsRequired", "animations", "extras", "scene", "scenes"}},
    {"/asset", {"minVersion", "generator", "copyright", "extensions", "extras"}},
    {"/scenes/0", {"name", "extras"}},
    {"/accessors/8", {"bufferView", "byteOffset", "name", "min", "max", "sparse"}},
    {"/accessors/8/sparse/indices", {"byteOffset"}},
    {"/accessors/8/sparse/values", {"byteOffset"}},
    {"/accessors/5", {"normalized", "bufferView"}},
    {"/animations/0", {"name"}},
    {"/animations/0/channels/0/target", {"node"}},
    {"/animations/0/channels/1/target", {"node"}},
    {"/animations/0/channels/2/target", {"extensions"}},
    {"/animations/0/samplers/0", {"interpolation"}},
    {"/buffers/0", {"name"}},
    {"/bufferViews/0", {"byteOffset", "byteStride", "target", "name"}},
    {"/cameras/0", {"name", "extras"}},
    {"/cameras/0/perspective", {"aspectRatio", "zfar"}},
    {"/images/0", {"mimeType", "name"}},
    {"/materials/0",
     {"name", "extras", "extensions", "pbrMetallicRoughness", "normalTexture", "occlusionTexture", "emissiveTexture",
      "emissiveFactor", "alphaMode", "alphaCutoff", "doubleSided"}},
    {"/materials/0/normalTexture", {"texCoord", "scale"}},
    {"/materials/0/occlusionTexture", {"texCoord", "strength"}},
    {"/materials/0/pbrMetallicRoughness",
     {"baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor", "metallicRoughnessTexture"}},
    {"/materials/0/pbrMetallicRoughness/baseColorTexture", {"texCoord", "extensions"}},
    {"/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform",
     {"offset", "rotation", "scale", "texCoord"}},
    {"/materials/1/extensions/KHR_materials_clearcoat",
     {"clearcoatFactor", "clearcoatTexture", "clearcoatRoughnessFactor", "clearcoatRoughnessTexture",
      "clearcoatNormalTexture"}},
    {"/materials/1/extensions/KHR_materials_sheen",
     {"sheenColorFactor", "sheenColorTexture", "sheenRoughnessFactor", "sheenRoughnessTexture"}},
    {"/materials/1/extensions/KHR_materials_specular",
     {"specularFactor", "specularTexture", "specularColorFactor", "specularColorTexture"}},
    {"/materials/1/extensions/KHR_materials_anisotropy",
     {"anisotropyStrength", "anisotropyRotation", "anisotropyTexture"}},
    {"/materials/1/extensions/KHR_materials_emissive_strength", {"emissiveStrength"}},
    {"/materials/2/extensions/KHR_materials_transmission", {"transmissionFactor", "transmissionTexture"}},
    {"/materials/2/extensions/KHR_materials_volume",
     {"thicknessFactor", "thicknessTexture", "attenuationDistance", "attenuationColor"}},
    {"/materials/2/extensions/KHR_materials_ior", {"ior"}},
    {"/materials/2/extensions/KHR_materials_dispersion", {"dispersion"}},
    {"/materials/3/extensions/KHR_materials_pbrSpecularGlossiness",
     {"diffuseFactor", "diffuseTexture", "specularFactor", "glossinessFactor", "specularGlossinessTexture"}},
    {"/meshes/0", {"name", "weights"}},
    {"/meshes/0/primitives/0", {"indices", "material", "mode", "targets", "extras"}},
    {"/meshes/0/primitives/0/attributes",
     {"NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0", "JOINTS_0", "WEIGHTS_0"}},
    {"/meshes/0/primitives/0/targets/0", {"POSITION", "NORMAL", "TANGENT"}},
    {"/nodes/0", {"name", "mesh", "skin", "weights", "extras"}},
    {"/nodes/1", {"name", "translation", "rotation", "scale", "children"}},
    {"/nodes/2", {"matrix"}},
    {"/nodes/5/extensions/EXT_mesh_gpu_instancing/attributes", {"TRANSLATION", "ROTATION", "SCALE"}},
    {"/nodes/6", {"camera"}},
    {"/samplers/0", {"name", "wrapS", "wrapT", "magFilter", "minFilter"}},
    {"/skins/0", {"name", "skeleton", "inverseBindMatrices"}},
    {"/textures/0", {"name", "source", "sampler"}},
    {"/extensions/KHR_lights_punctual/lights/0", {"name", "color", "intensity", "range"}},
    {"/extensions/KHR_lights_punctual/lights/0/spot", {"innerConeAngle", "outerConeAngle"}},
    {"/extensions/KHR_lights_punctual/lights/1", {"color", "intensity", "range"}},
    {"/extensions/KHR_lights_punctual/lights/2", {"color", "intensity"}},
};

ReadOptions at_half() {
  ReadOptions options;
  options.moment = {0.5, {}};
  return options;
}

}  // namespace

TEST_CASE("gltf optional: files load without any one of the optional properties") {
  const json full = full_document();
  CHECK(read_document(full, at_half()).shapes.size() >= 3);
  for (const auto& [object, properties] : kOptional)
    for (const char* property : properties) {
      const std::string path = std::string(object) + "/" + property;
      CAPTURE(path);
      json document = full;
      REQUIRE(document.contains(Pointer(path)));
      document[Pointer(object)].erase(property);
      CHECK_NOTHROW(read_document(document, at_half()));
    }
}

TEST_CASE("gltf optional: a file with only the required properties loads") {
  GltfBuilder gltf;
  gltf.add_triangle();
  json document = json::parse(gltf.text());
  for (const char* name : {"scene", "scenes"}) document.erase(name);
  document["bufferViews"][0].erase("byteOffset");
  CHECK(std::get<Mesh>(read_document(document).shapes.at(0).geometry).triangles.size() == 1);
}

TEST_CASE("gltf optional: channels without a node are ignored with a note, others move their nodes") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["nodes"].push_back({{"mesh", 0}});
  gltf.json["nodes"].push_back(json::object());
  gltf.json["nodes"].push_back(json::object());
  add_animation(gltf);
  gltf.json["animations"][0]["channels"][0]["target"] = {{"node", 0}, {"path", "translation"}};
  gltf.json["animations"][0]["samplers"][0]["interpolation"] = "LINEAR";
  gltf.json["animations"][0]["channels"][1]["target"].erase("node");
  const Description d = read_document(json::parse(gltf.text()), at_half());
  CHECK(d.shapes.at(0).to_world.point({0, 0, 0}).x == near(2));
  CHECK(has_note(d, "animations[0]: 2 channels do not animate a node (ignored)"));
}

TEST_CASE("gltf optional: inverse bind matrices are the identity by default") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["JOINTS_0"] = gltf.add<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = gltf.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  gltf.json["nodes"][0]["skin"] = 0;
  gltf.json["nodes"].push_back({{"translation", {7, 0, 0}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  gltf.json["skins"] = {{{"joints", {1}}}};
  const Description d = read_document(json::parse(gltf.text()));
  const ShapeDescription& shape = d.shapes.at(0);
  CHECK(shape.to_world.point(std::get<Mesh>(shape.geometry).positions.at(1)).x == near(8));
}

TEST_CASE("gltf optional: indices without a buffer view are zero but for their sparse elements") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  const std::uint16_t sparse_indices[] = {4, 5}, values[] = {1, 2};
  gltf.json["accessors"].push_back(
      {{"componentType", 5125},
       {"count", 6},
       {"type", "SCALAR"},
       {"sparse",
        {{"count", 2},
         {"indices", {{"bufferView", gltf.add_view(sparse_indices, 4)}, {"componentType", 5123}}},
         {"values", {{"bufferView", 0}}}}}});
  const std::uint32_t wide[] = {values[0], values[1]};
  gltf.json["accessors"].back()["sparse"]["values"]["bufferView"] = gltf.add_view(wide, 8);
  primitive["indices"] = 1;
  const Mesh mesh = std::get<Mesh>(read_document(json::parse(gltf.text())).shapes.at(0).geometry);
  REQUIRE(mesh.triangles.size() == 1);
  CHECK(mesh.positions.at(mesh.triangles[0][1]).x == 1);
  CHECK(mesh.positions.at(mesh.triangles[0][2]).y == 1);
}

TEST_CASE("gltf optional: a texture without an image is ignored with a note") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["material"] = 0;
  gltf.json["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}};
  gltf.json["images"] = {{{"uri", kPixelUri}}};
  gltf.json["materials"] = {{{"emissiveFactor", {1, 0.5, 0.25}}, {"emissiveTexture", {{"index", 0}}}}};
  const Description d = read_document(json::parse(gltf.text()));
  const auto& radiance = std::get<SpectrumDescription>(*d.shapes.at(0).radiance);
  CHECK(std::get<SpectrumDescription::Rgb>(radiance.value).value.y == 0.5f);
  CHECK(has_note(d, "textures[0]: has no image of a supported format"));
}

TEST_CASE("gltf optional: a binary file ends where its header says") {
  GltfBuilder gltf;
  gltf.add_triangle();
  const std::string binary = gltf.binary();
  const Description d = read_bytes(binary, "model.glb");
  CHECK(d.notes.empty());
  const auto with_length = [&](std::size_t length) {
    std::string changed = binary;
    for (std::size_t k = 0; k < 4; ++k) changed[8 + k] = static_cast<char>(length >> 8 * k & 0xff);
    return changed;
  };
  for (const std::string& tail : {std::string(25, 'x'), std::string(3, '\0'),
                                  std::string("\xff\xff\xff\x7f"
                                              "BIN\0rest",
                                              12)}) {
    const Description longer = read_bytes(binary + tail, "model.glb");
    CHECK(dump(longer) == dump(d));
    CHECK(has_note(longer, std::to_string(tail.size()) + " bytes behind the end"));
  }
  // Truncated files remain errors, also where a whole chunk is missing
  const auto error_of_bytes = [](const std::string& bytes) {
    const TemporaryFolder folder;
    return error_of(write_below(folder, "model.glb", bytes));
  };
  const std::size_t data = 36 + 8;
  for (const std::size_t cut : {std::size_t{1}, std::size_t{8}, data, data + 1, binary.size() - 20})
    CHECK(contains(error_of_bytes(binary.substr(0, binary.size() - cut)), "is truncated"));
  CHECK(contains(error_of_bytes(with_length(binary.size() + 4)), "is truncated"));
  CHECK(contains(error_of_bytes(with_length(binary.size() - 8).substr(0, binary.size() - 8)), "is truncated"));
  // A header with too small a length does not hide data that is there
  const Description shorter = read_bytes(with_length(binary.size() - 8), "model.glb");
  CHECK(dump(shorter) == dump(d));
  CHECK(has_note(shorter, "its last chunk ends at byte"));
}

TEST_CASE("gltf optional: files that need a later version are errors, later versions are noted") {
  GltfBuilder gltf;
  gltf.add_triangle();
  const auto error_with = [&](const char* version, const char* needed) {
    json document = json::parse(gltf.text());
    document["asset"] = {{"version", version}, {"minVersion", needed}};
    const TemporaryFolder folder;
    return error_of(write_below(folder, "model.gltf", document.dump()));
  };
  CHECK(contains(error_with("2.1", "2.1"), "asset: 'minVersion' is '2.1', but Sheaf reads version 2.0"));
  CHECK(contains(error_with("2.10", "2.10"), "'minVersion' is '2.10'"));
  CHECK(error_with("2.1", "2.0").empty());
  CHECK(error_with("2.0", "2.0").empty());
  gltf.json["asset"]["version"] = "2.1";
  CHECK(has_note(read_document(json::parse(gltf.text())), "asset: has version 2.1 (read as version 2.0)"));
}

TEST_CASE("gltf optional: attributes of morph targets that are ignored are noted") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  const int zeros = gltf.add<float>({0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3");
  const int pairs = gltf.add<float>({0, 0, 0, 0, 0, 0}, "VEC2");
  primitive["targets"] = {{{"POSITION", zeros}, {"COLOR_0", zeros}}, {{"TEXCOORD_1", pairs}, {"COLOR_0", zeros}}};
  const Description d = read_document(json::parse(gltf.text()));
  REQUIRE(d.notes.size() == 1);
  CHECK(has_note(d, "meshes[0].primitives[0]: its morph targets change COLOR_0, TEXCOORD_1 (not supported: ignored)"));
  primitive["targets"] = {{{"POSITION", zeros}}};
  CHECK(read_document(json::parse(gltf.text())).notes.empty());
}

}  // namespace sheaf::test_gltf_optional
