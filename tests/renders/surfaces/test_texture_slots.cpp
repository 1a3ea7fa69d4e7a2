// A texture of one value acts like the number or the color of that value, for every parameter that may be textured.
// The parameters are taken from the list of material models, from the queries of the XML readers, and from the sources
// of the pbrt and glTF readers, so that new ones are tested as well.
#include "core/image/exr.h"
#include "scene/xml/query_recorder.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"
#include "tests/support/plugin_samples.h"
#include "tests/support/render_testing.h"

#include <fstream>
#include <regex>
#include <sstream>

namespace sheaf::test_texture_slots {

using namespace test;
using nlohmann::json;

namespace {

constexpr double kTolerance = 0.03;  ///< of means: noise where a texture changes the order of random decisions

/// Means of red, green and blue over an image of 12 x 12 pixels.
using Means = std::array<double, 3>;

Means means_of(Description d, ColorMode color = ColorMode::kRgb) {
  d.film.width = d.film.height = 12;
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = 24;
  d.sampler.seed = 3;
  d.integrator.max_depth = 5;
  CompileOptions options;
  options.color = color;
  const Image image = render(*compile_scene(d, options), {}).film.to_image();
  Means means{};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c)
        means[static_cast<std::size_t>(c)] += static_cast<double>(image.at(x, y, c)) / (image.width * image.height);
  return means;
}

void check_same(const Means& constant, const Means& textured, double tolerance = kTolerance) {
  for (std::size_t c = 0; c < 3; ++c) CHECK(textured[c] == near(constant[c], tolerance));
}

/// The view of a ball at the origin, between a lamp and a wall.
void add_surroundings(Description& d) {
  look_at(d, {0, -3, 1}, {0, 0, 0}, {0, 0, 1}, 50);
  d.lights.clear();
  add_constant_light(d, 0.4f);
  add_area_light_sphere(d, {-2, -2, 3}, 0.6f, 20);
  const Transform wall = Transform::translate({0, 2, 0}) * Transform::rotate({1, 0, 0}, 90);
  add_rectangle(d, wall * Transform::scale({3, 3, 1}), add_two_sided(d, add_diffuse_rgb(d, 0.8f, 0.5f, 0.3f)));
}

// Material models

constexpr float kNumber = 0.35f;
const SpectrumDescription kColor = SpectrumDescription::rgb(0.3f, 0.5f, 0.7f);

template <class T>
concept HasFields = requires(T& object) {
  T::fields(object);
};

template <class T> inline constexpr bool kIsVariant = false;
template <class... T> inline constexpr bool kIsVariant<std::variant<T...>> = true;

/// Calls f(slot) for all ScalarInputs and SpectrumInputs of an object, those of its parts included.
template <class T, class F> void for_each_slot(T& object, F&& f) {
  if constexpr (std::is_same_v<T, ScalarInput> || std::is_same_v<T, SpectrumInput>) {
    f(object);
  } else if constexpr (requires { object.has_value(); }) {
    if (object.has_value()) for_each_slot(*object, f);
  } else if constexpr (HasFields<T>) {
    std::apply([&](auto&... fields) { (for_each_slot(fields, f), ...); }, T::fields(object));
  } else if constexpr (kIsVariant<T>) {
    std::visit([&](auto& part) { for_each_slot(part, f); }, object);
  }
}

/// Sets the references of a model, and its options: those with an index in the bits of `options`.
template <class T> void set_options(T& object, unsigned options, unsigned& next, MaterialId nested, TextureId flat) {
  if constexpr (std::is_same_v<T, MaterialId>) {
    object = nested;
  } else if constexpr (std::is_same_v<T, TextureId>) {
    object = flat;
  } else if constexpr (std::is_same_v<T, bool>) {
    if ((options >> next++ & 1u) != 0) object = !object;
  } else if constexpr (std::is_same_v<T, std::optional<RoughnessDescription>>) {
    if ((options >> next++ & 1u) != 0) object.emplace();
  } else if constexpr (std::is_same_v<T, std::optional<ConductorDescription::Ior>>) {
    if ((options >> next++ & 1u) != 0) object.emplace();
  } else if constexpr (HasFields<T>) {
    std::apply([&](auto&... fields) { (set_options(fields, options, next, nested, flat), ...); }, T::fields(object));
  }
}

void set_constant(ScalarInput& slot) { slot = kNumber; }
void set_constant(SpectrumInput& slot) { slot = kColor; }

/// An image of one texel.
TextureId add_texel(Description& d, const std::vector<std::string>& channels, const std::vector<float>& values) {
  auto image = std::make_shared<Image>(1, 1, channels);
  image->data = values;
  BitmapDescription bitmap;
  bitmap.made = std::move(image);
  bitmap.raw = true;
  TextureDescription texture;
  texture.model = std::move(bitmap);
  d.textures.push_back(std::move(texture));
  return static_cast<TextureId>(d.textures.size() - 1);
}
void set_texture(Description& d, ScalarInput& slot) { slot = add_texel(d, {"Y"}, {kNumber}); }
void set_texture(Description& d, SpectrumInput& slot) { slot = add_texel(d, {"B", "G", "R"}, {0.7f, 0.5f, 0.3f}); }

/// The means of a ball of a model. `textured`: index of the slot with a texture; -1: none. Sets the number of slots.
/// Nothing if the scene is not valid.
template <class Model> std::optional<Means> model_means(unsigned options, int textured, ColorMode color, int& slots) {
  Description d = empty_scene(12, 12);
  add_surroundings(d);
  Model model;
  unsigned next = 0;
  const TextureId flat = add_texel(d, {"B", "G", "R"}, {1, 0.5f, 0.5f});
  set_options(model, options, next, add_diffuse_rgb(d, 0.5f, 0.6f, 0.2f), flat);
  if ((options >> next) != 0) return {};
  slots = 0;
  for_each_slot(model, [&](auto& slot) {
    set_constant(slot);
    if (slots++ == textured) set_texture(d, slot);
  });
  add_sphere(d, {0, 0, 0}, 1, add_material(d, model));
  try {
    return means_of(d, color);
  } catch (const SceneError&) { return {}; }  // the slot takes numbers only
}

/// Returns the number of slots.
template <class Model> int check_model(ColorMode color) {
  int tested = 0;
  if constexpr (!std::is_same_v<Model, MeasuredDescription>) {
    for (unsigned options = 0; options < 8; options = options == 0 ? 1 : 2 * options) {
      int slots = 0;
      const std::optional<Means> constant = model_means<Model>(options, -1, color, slots);
      for (int slot = 0; constant && slot < slots; ++slot) {
        CAPTURE(slot);
        CAPTURE(options);
        CAPTURE(static_cast<int>(color));
        int same = 0;
        const std::optional<Means> textured = model_means<Model>(options, slot, color, same);
        if (textured) check_same(*constant, *textured);
        tested += textured ? 1 : 0;
      }
    }
  }
  return tested;
}

template <class... Models> int check_models(const std::variant<Models...>*, ColorMode color) {
  int index = 0, tested = 0;
  (
      [&] {
        CAPTURE(index);
        tested += check_model<Models>(color);
        ++index;
      }(),
      ...);
  return tested;
}

}  // namespace

TEST_CASE("texture slots: an image of one texel acts like a constant in all material models") {
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral})
    CHECK(check_models(static_cast<const MaterialModel*>(nullptr), color) > 80);
}

// XML dialects

namespace {

/// Content of plugins besides the parameter under test.
std::string content_of(const std::string& plugin) {
  const std::string nested = "<bsdf type='diffuse'/>";
  if (plugin == "blendbsdf") return nested + "<bsdf type='conductor'/>";
  // Only constants are limited
  if (plugin == "phong" || plugin == "ward") return "<boolean name='ensure_energy_conservation' value='false'/>";
  if (plugin == "mask" || plugin == "twosided" || plugin == "coating" || plugin == "roughcoating") return nested;
  return {};
}

Description read_xml(Dialect dialect, const std::string& bsdf) {
  const TemporaryFolder folder;
  Image gray(1, 1, {"Y"}), color(1, 1, {"B", "G", "R"});
  gray.data = {kNumber};
  color.data = {0.7f, 0.5f, 0.3f};
  write_exr(folder / "grey.exr", gray);
  write_exr(folder / "color.exr", color);
  const std::string shape = dialect == Dialect::kNori ? "<mesh type='sphere'>" + bsdf + "</mesh>"
                                                      : "<shape type='sphere'>" + bsdf + "</shape>";
  write_bytes(folder / "scene.xml", scene_around(dialect, shape));
  Description d = read_scene(folder / "scene.xml");
  add_surroundings(d);
  // Textures are read when the scene is compiled
  for (TextureDescription& texture : d.textures)
    if (auto* bitmap = std::get_if<BitmapDescription>(&texture.model)) {
      bitmap->made = std::make_shared<Image>(bitmap->file.stem() == "grey" ? gray : color);
      bitmap->file.clear();
    }
  return d;
}

/// The parameters of a plugin that may be textured, with their types.
std::map<std::string, std::string> slots_of(Dialect dialect, const std::string& plugin, const std::string& content) {
  QueryRecorder recorder;
  try {
    read_xml(dialect, "<bsdf type='" + plugin + "'>" + content + "</bsdf>");
  } catch (const Error&) { return {}; }
  std::map<std::string, std::string> slots;
  for (const ValueQuery& query : recorder.queries)
    if (query.object == "bsdf '" + plugin + "'" && query.type.ends_with(" or texture")) slots[query.name] = query.type;
  return slots;
}

}  // namespace

TEST_CASE("texture slots: an image of one texel acts like a constant in all bsdf plugins") {
  int tested = 0;
  for (const Dialect dialect : {Dialect::kMitsuba, Dialect::kNori}) {
    std::set<std::string> plugins;
    {
      QueryRecorder recorder;
      CHECK_THROWS_AS(read_xml(dialect, "<bsdf type='?'/>"), SceneError);
      plugins = recorder.plugins.at("bsdf");
    }
    for (const std::string& plugin : plugins) {
      const std::string content = content_of(plugin);
      for (const auto& query : slots_of(dialect, plugin, content)) {
        const std::string slot = query.first, type = query.second;
        CAPTURE(std::string(dialect_name(dialect)));
        CAPTURE(plugin);
        CAPTURE(slot);
        const bool is_color = type.starts_with("spectrum");
        const auto with = [&](const std::string& value) {
          return read_xml(dialect, "<bsdf type='" + plugin + "'>" + value + content + "</bsdf>");
        };
        const std::string texture = "<texture type='bitmap' name='" + slot + "'><string name='filename' value='" +
                                    (is_color ? "color" : "grey") +
                                    ".exr'/><boolean name='raw' value='true'/></texture>";
        const std::string constant =
            is_color ? "<rgb name='" + slot + "' value='0.3, 0.5, 0.7'/>" : "<float name='" + slot + "' value='0.35'/>";
        Description a, b;
        try {
          a = with(constant);
          b = with(texture);
        } catch (const SceneError&) { continue; }  // a number only, or another one is required
        check_same(means_of(a), means_of(b));
        ++tested;
      }
    }
  }
  CHECK(tested > 60);
}

// pbrt

namespace {

std::string source_of(const std::filesystem::path& file) {
  std::ifstream stream(SHEAF_SOURCE_DIR / file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// The names that match the first group of a pattern in a text.
std::set<std::string> names_in(const std::string& text, const std::string& pattern) {
  std::set<std::string> names;
  const std::regex regex(pattern);
  for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at) names.insert((*at)[1].str());
  return names;
}

Description read_ball(const std::string& material, const std::string& shape_parameters) {
  Description d = read_pbrt_world(
      "Texture \"number\" \"float\" \"imagemap\" \"string filename\" \"grey.exr\"\n"
      "Texture \"color\" \"spectrum\" \"imagemap\" \"string filename\" \"color.exr\"\n"
      "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\n"
      "MakeNamedMaterial \"b\" \"string type\" \"conductor\"\n" +
          material + "\nShape \"sphere\" " + shape_parameters + "\n",
      "Camera \"perspective\"", [](const TemporaryFolder& folder) {
        Image gray(1, 1, {"Y"}), color(1, 1, {"B", "G", "R"});
        gray.data = {kNumber};
        color.data = {0.7f, 0.5f, 0.3f};
        write_exr(folder / "grey.exr", gray);
        write_exr(folder / "color.exr", color);
      });
  for (TextureDescription& texture : d.textures)
    if (auto* bitmap = std::get_if<BitmapDescription>(&texture.model); bitmap != nullptr && bitmap->made == nullptr) {
      const bool is_gray = bitmap->file.stem() == "grey";
      auto texel = std::make_shared<Image>(
          1, 1, is_gray ? std::vector<std::string>{"Y"} : std::vector<std::string>{"B", "G", "R"});
      texel->data = is_gray ? std::vector<float>{kNumber} : std::vector<float>{0.7f, 0.5f, 0.3f};
      bitmap->made = std::move(texel);
      bitmap->file.clear();
    }
  add_surroundings(d);
  return d;
}

}  // namespace

TEST_CASE("texture slots: an image of one texel acts like a constant in all materials of pbrt") {
  const std::string source = source_of("scene/dialects/pbrt/material.cpp");
  const std::set<std::string> types = names_in(source, "type == \"([a-z]+)\"");
  CHECK(types.size() >= 10);
  std::set<std::string> slots = names_in(source, "find_(?:scalar|spectrum)_input\\(p, \"([A-Za-z_]+)\"");
  CHECK(slots.size() >= 8);
  // Names that the source composes or passes on
  for (const char* name : {"roughness", "uroughness", "vroughness", "eta", "k", "beta_m", "beta_n", "color"})
    slots.insert(name);
  int tested = 0;
  for (const std::string& type : types)
    for (const std::string& slot : slots) {
      if (slot == "displacement") continue;  // only its slope matters
      const std::string rest = type == "mix" ? " \"string materials\" [ \"a\" \"b\" ]" : "";
      for (const bool is_color : {false, true}) {
        const std::string start = "Material \"" + type + "\"" + rest;
        const std::string constant =
            start + (is_color ? " \"rgb " + slot + "\" [ 0.3 0.5 0.7 ]" : " \"float " + slot + "\" 0.35");
        const std::string texture = start + " \"texture " + slot + "\" \"" + (is_color ? "color" : "number") + "\"";
        Description a, b;
        try {
          a = read_ball(constant, "");
          b = read_ball(texture, "");
        } catch (const SceneError&) { continue; }  // not a parameter of this material, or a number only
        // The note says so if a texture is replaced
        const bool is_replaced = std::any_of(b.notes.begin(), b.notes.end(), [&](const std::string& note) {
          return note.find("'" + slot + "' is a texture, expected a number") != std::string::npos;
        });
        if (is_replaced) continue;
        CAPTURE(type);
        CAPTURE(slot);
        CAPTURE(is_color);
        check_same(means_of(a), means_of(b));
        ++tested;
      }
    }
  CHECK(tested > 15);
  check_same(means_of(read_ball("", "\"float alpha\" 0.35")), means_of(read_ball("", "\"texture alpha\" \"number\"")));
}

// glTF

namespace {

/// A PNG of one white, opaque pixel.
constexpr const char* kWhiteUri =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII"
    "=";

/// A texture of a glTF material: a JSON pointer to it. Images of ones must change nothing.
struct GltfSlot {
  const char* pointer;
  bool glossy = false;  ///< of KHR_materials_pbrSpecularGlossiness
};

constexpr GltfSlot kSlots[] = {
    {"/pbrMetallicRoughness/baseColorTexture"},
    {"/pbrMetallicRoughness/metallicRoughnessTexture"},
    {"/emissiveTexture"},
    {"/extensions/KHR_materials_transmission/transmissionTexture"},
    {"/extensions/KHR_materials_clearcoat/clearcoatTexture"},
    {"/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture"},
    {"/extensions/KHR_materials_sheen/sheenColorTexture"},
    {"/extensions/KHR_materials_sheen/sheenRoughnessTexture"},
    {"/extensions/KHR_materials_specular/specularTexture"},
    {"/extensions/KHR_materials_specular/specularColorTexture"},
    {"/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture", true},
    {"/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture", true},
};
/// Textures of directions, for which ones are no neutral value, and those that are not supported.
const std::set<std::string> kDirections = {"normalTexture", "anisotropyTexture", "clearcoatNormalTexture"};

enum class Body { kOpaque, kThin, kVolume };

json layered(Body body, float metallic, float roughness) {
  json material = {
      {"pbrMetallicRoughness",
       {{"baseColorFactor", {0.8, 0.6, 0.4, 0.7}}, {"metallicFactor", metallic}, {"roughnessFactor", roughness}}},
      {"emissiveFactor", {0.1, 0.2, 0.1}},
      {"alphaMode", "BLEND"},
      {"extensions",
       {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0.6}, {"clearcoatRoughnessFactor", 0.3}}},
        {"KHR_materials_sheen", {{"sheenColorFactor", {0.3, 0.2, 0.1}}, {"sheenRoughnessFactor", 0.5}}},
        {"KHR_materials_specular", {{"specularFactor", 0.7}, {"specularColorFactor", {1, 0.5, 0.8}}}}}}};
  if (body != Body::kOpaque) material["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 0.8}};
  if (body == Body::kVolume)
    material["extensions"]["KHR_materials_volume"] = {
        {"thicknessFactor", 1}, {"attenuationDistance", 1}, {"attenuationColor", {0.5, 0.9, 0.8}}};
  return material;
}

Description read_square(json material, const char* pointer) {
  GltfBuilder gltf;
  json& primitive = gltf.add_mesh({{"POSITION", gltf.add<float>({-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1}, "VEC3")},
                                   {"TEXCOORD_0", gltf.add<float>({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2")}});
  primitive["indices"] = gltf.add<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  primitive["material"] = 0;
  gltf.json["nodes"] = {{{"mesh", 0}}};
  if (pointer != nullptr) material[json::json_pointer(pointer)] = {{"index", 0}};
  gltf.json["materials"] = json::array({material});
  gltf.json["images"] = {{{"uri", kWhiteUri}}};
  gltf.json["textures"] = {{{"source", 0}}};
  const TemporaryFolder folder;
  Description d = read_scene(write_below(folder, "model.gltf", gltf.text()), {});
  const ShapeDescription square = d.shapes.front();
  d.shapes = {square};
  add_surroundings(d);
  return d;
}

}  // namespace

TEST_CASE("texture slots: images of ones change nothing in all slots of gltf materials") {
  // Every texture that the reader knows is tested
  const std::set<std::string> names =
      names_in(source_of("scene/formats/gltf_materials.cpp"), "\\b([a-z][A-Za-z]*Texture)\\b");
  CHECK(names.size() >= std::size(kSlots));
  for (const std::string& name : names) {
    if (kDirections.contains(name)) continue;
    CAPTURE(name);
    CHECK(std::any_of(std::begin(kSlots), std::end(kSlots),
                      [&](const GltfSlot& slot) { return std::string(slot.pointer).ends_with("/" + name); }));
  }
  struct Surface {
    Body body;
    float metallic, roughness;
  };
  for (const Surface& s :
       {Surface{Body::kOpaque, 0.5f, 0.4f}, Surface{Body::kThin, 0.5f, 0.4f}, Surface{Body::kThin, 0.5f, 0.02f},
        Surface{Body::kVolume, 0.5f, 0.4f}, Surface{Body::kVolume, 0, 0.02f}, Surface{Body::kThin, 1, 0.3f}}) {
    CAPTURE(static_cast<int>(s.body));
    CAPTURE(s.metallic);
    CAPTURE(s.roughness);
    const json material = layered(s.body, s.metallic, s.roughness);
    const Means constant = means_of(read_square(material, nullptr));
    for (const GltfSlot& slot : kSlots) {
      if (slot.glossy) continue;
      if (s.body == Body::kOpaque && std::string(slot.pointer).find("transmission") != std::string::npos) continue;
      CAPTURE(std::string(slot.pointer));
      check_same(constant, means_of(read_square(material, slot.pointer)));
    }
  }
  json glossy = {
      {"extensions",
       {{"KHR_materials_pbrSpecularGlossiness",
         {{"diffuseFactor", {0.5, 0.4, 0.3, 1}}, {"specularFactor", {0.2, 0.3, 0.4}}, {"glossinessFactor", 0.6}}}}}};
  const Means constant = means_of(read_square(glossy, nullptr));
  for (const GltfSlot& slot : kSlots)
    if (slot.glossy) check_same(constant, means_of(read_square(glossy, slot.pointer)));
}

}  // namespace sheaf::test_texture_slots
