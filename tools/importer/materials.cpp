// Materials: Lambert, Phong and Blinn as metallic-roughness materials of glTF, and their textures.
#include "tools/importer/conversion.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace sheaf::importer {

namespace {

using nlohmann::json;

constexpr float kGray = 0.6f;  ///< surfaces without a color

double fraction(double value) { return std::clamp(finite(value), 0.0, 1.0); }

/// Wrap modes of samplers.
int wrap(aiTextureMapMode mode) {
  constexpr int kRepeat = 10497, kClamp = 33071, kMirror = 33648;
  if (mode == aiTextureMapMode_Mirror) return kMirror;
  return mode == aiTextureMapMode_Wrap ? kRepeat : kClamp;
}

/// Adds the images and textures, each once.
class Textures {
 public:
  explicit Textures(Conversion& to) : to_(to) {}

  /// The image that a material names; nothing if it cannot be used.
  std::optional<int> image(const aiString& path) {
    const std::string name = text(path);
    const auto [found, is_new] = images_.try_emplace(name);
    if (is_new) found->second = add_image(path);
    return found->second;
  }

  int texture(int image, aiTextureMapMode u, aiTextureMapMode v) {
    const auto [found, is_new] = textures_.try_emplace({image, wrap(u), wrap(v)});
    if (is_new) {
      const int sampler = to_.glb.add("samplers", {{"wrapS", wrap(u)}, {"wrapT", wrap(v)}});
      found->second = to_.glb.add("textures", {{"source", image}, {"sampler", sampler}});
    }
    return found->second;
  }

 private:
  std::optional<int> add_image(const aiString& path) {
    const aiTexture* const embedded = to_.scene.GetEmbeddedTexture(path.C_Str());
    if (embedded == nullptr && path.length > 0) return to_.glb.add("images", {{"uri", text(path)}});
    // The bytes of an image file have a width and no height.
    if (embedded == nullptr || embedded->mHeight != 0 || embedded->mWidth == 0) {
      to_.notes.push_back(fmt::format("image '{}' is embedded without a file format (ignored)", text(path)));
      return std::nullopt;
    }
    return to_.glb.add("images", {{"bufferView", to_.glb.add_view(embedded->pcData, embedded->mWidth)},
                                  {"mimeType", "image/" + std::string(embedded->achFormatHint)}});
  }

  Conversion& to_;
  std::map<std::string, std::optional<int>> images_;
  std::map<std::array<int, 3>, int> textures_;
};

/// Converts one material.
class MaterialConverter {
 public:
  MaterialConverter(Conversion& to, Textures& textures, const aiMaterial& from)
      : to_(to), textures_(textures), from_(from), name_(text(const_cast<aiMaterial&>(from).GetName())) {}

  json convert() {
    out_["name"] = name_;
    convert_base();
    convert_reflection();
    convert_opacity();
    convert_emission();
    if (const json normals = texture({aiTextureType_NORMALS, aiTextureType_NORMAL_CAMERA}); !normals.is_null())
      out_["normalTexture"] = normals;
    note_others();
    return std::move(out_);
  }

 private:
  std::optional<float> number(const char* key, unsigned type, unsigned index) const {
    float value = 0;
    if (from_.Get(key, type, index, value) != aiReturn_SUCCESS) return std::nullopt;
    return value;
  }
  std::optional<aiColor3D> color(const char* key, unsigned type, unsigned index) const {
    aiColor3D value;
    if (from_.Get(key, type, index, value) != aiReturn_SUCCESS) return std::nullopt;
    return value;
  }

  void note(const std::string& message) { to_.notes.push_back(fmt::format("material '{}': {}", name_, message)); }

  /// Returns the first texture of these types as a glTF texture, or null.
  json texture(std::initializer_list<aiTextureType> types) {
    for (const aiTextureType type : types) {
      aiString path;
      unsigned uv_set = 0;
      aiTextureMapMode modes[2] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
      if (from_.GetTexture(type, 0, &path, nullptr, &uv_set, nullptr, nullptr, modes) != aiReturn_SUCCESS) continue;
      const std::optional<int> image = textures_.image(path);
      if (!image) continue;
      return {{"index", textures_.texture(*image, modes[0], modes[1])}, {"texCoord", uv_set}};
    }
    return nullptr;
  }

  /// Returns the file name of the image of a texture type, or an empty string.
  std::string path(aiTextureType type) const {
    aiString path;
    return from_.GetTexture(type, 0, &path) == aiReturn_SUCCESS ? text(path) : std::string();
  }

  void convert_base() {
    const aiColor3D gray(kGray, kGray, kGray);
    aiColor3D base = color(AI_MATKEY_BASE_COLOR).value_or(color(AI_MATKEY_COLOR_DIFFUSE).value_or(gray));
    json& core = out_["pbrMetallicRoughness"];
    // Surfaces without shading show their emission alone.
    if (shading() == aiShadingMode_NoShading) base = {0, 0, 0};
    // A texture replaces the color.
    if (const json image = texture({aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}); !image.is_null()) {
      core["baseColorTexture"] = image;
      base = {1, 1, 1};
    }
    core["baseColorFactor"] = {fraction(base.r), fraction(base.g), fraction(base.b), 1.0};
  }

  int shading() const {
    int mode = aiShadingMode_Gouraud;
    from_.Get(AI_MATKEY_SHADING_MODEL, mode);
    return mode;
  }

  /// Roughness, metalness, and the reflectance of the dielectric layer. Lambert's surfaces do not have that layer.
  void convert_reflection() {
    const std::optional<float> metallic = number(AI_MATKEY_METALLIC_FACTOR);
    double roughness = 1, specular = 0;
    if (metallic || color(AI_MATKEY_BASE_COLOR)) {
      roughness = number(AI_MATKEY_ROUGHNESS_FACTOR).value_or(0.5f);
      specular = 1;
    } else if (const int mode = shading(); mode == aiShadingMode_Phong || mode == aiShadingMode_Blinn) {
      const aiColor3D reflected = color(AI_MATKEY_COLOR_SPECULAR).value_or(aiColor3D(0, 0, 0));
      specular = std::max({reflected.r, reflected.g, reflected.b}) * number(AI_MATKEY_SHININESS_STRENGTH).value_or(1);
      // The exponent n of Phong's model is as wide as a microfacet distribution of alpha^2 = 2 / (n + 2).
      const double exponent = std::max(finite(number(AI_MATKEY_SHININESS).value_or(0)), 0.0);
      roughness = std::pow(2 / (exponent + 2), 0.25);
    }
    json& core = out_["pbrMetallicRoughness"];
    core["metallicFactor"] = fraction(metallic.value_or(0));
    core["roughnessFactor"] = fraction(roughness);
    out_["extensions"]["KHR_materials_specular"] = {{"specularFactor", fraction(specular)}};
  }

  void convert_opacity() {
    double opacity = fraction(number(AI_MATKEY_OPACITY).value_or(1));
    if (opacity == 0) {
      note("its opacity is 0 (rendered as opaque)");
      opacity = 1;
    }
    json& core = out_["pbrMetallicRoughness"];
    core["baseColorFactor"][3] = opacity;
    const std::string mask = path(aiTextureType_OPACITY), base = path(aiTextureType_DIFFUSE);
    const bool in_base = !mask.empty() && (mask == base || mask == path(aiTextureType_BASE_COLOR));
    if (!mask.empty() && !in_base) note("its opacity texture is not the alpha of its color texture (ignored)");
    if (opacity < 1 || in_base) out_["alphaMode"] = "BLEND";
  }

  void convert_emission() {
    aiColor3D emission = color(AI_MATKEY_COLOR_EMISSIVE).value_or(aiColor3D(0, 0, 0));
    if (const json image = texture({aiTextureType_EMISSION_COLOR, aiTextureType_EMISSIVE}); !image.is_null()) {
      out_["emissiveTexture"] = image;
      emission = {1, 1, 1};
    }
    const auto positive = [](double value) { return std::max(finite(value), 0.0); };
    out_["emissiveFactor"] = {positive(emission.r), positive(emission.g), positive(emission.b)};
    int two_sided = 0;
    from_.Get(AI_MATKEY_TWOSIDED, two_sided);
    out_["doubleSided"] = two_sided != 0;
  }

  void note_others() {
    struct Other {
      aiTextureType type;
      const char* name;
    };
    for (const Other other :
         {Other{aiTextureType_SPECULAR, "specular"}, Other{aiTextureType_HEIGHT, "bump"},
          Other{aiTextureType_SHININESS, "shininess"}, Other{aiTextureType_METALNESS, "metalness"},
          Other{aiTextureType_DIFFUSE_ROUGHNESS, "roughness"}, Other{aiTextureType_DISPLACEMENT, "displacement"}})
      if (from_.GetTextureCount(other.type) > 0) note(fmt::format("its {} texture is ignored", other.name));
  }

  Conversion& to_;
  Textures& textures_;
  const aiMaterial& from_;
  std::string name_;
  json out_ = json::object();
};

}  // namespace

void add_materials(Conversion& to) {
  Textures textures(to);
  for (unsigned i = 0; i < to.scene.mNumMaterials; ++i)
    to.glb.add("materials", MaterialConverter(to, textures, *to.scene.mMaterials[i]).convert());
}

}  // namespace sheaf::importer
