// Materials of glTF with their extensions, and the textures that they use.
#include "scene/formats/gltf_library.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Converts one material.
class MaterialConverter {
 public:
  MaterialConverter(const GltfChecker& from, std::size_t index)
      : from_(from), m_(from.model.materials[index]), part_(fmt::format("materials[{}]", index)) {}

  GltfMaterial convert() {
    to_.name = m_.name;
    convert_core();
    convert_transmission();
    convert_layers();
    convert_specular();
    return std::move(to_);
  }

 private:
  using Value = tinygltf::Value;

  void convert_core() {
    const tinygltf::PbrMetallicRoughness& core = m_.pbrMetallicRoughness;
    if (core.baseColorFactor.size() == 4) {
      to_.base_color = {fraction(core.baseColorFactor[0], "baseColorFactor"),
                        fraction(core.baseColorFactor[1], "baseColorFactor"),
                        fraction(core.baseColorFactor[2], "baseColorFactor")};
      to_.alpha = fraction(core.baseColorFactor[3], "baseColorFactor");
    }
    to_.metallic = fraction(core.metallicFactor, "metallicFactor");
    to_.roughness = fraction(core.roughnessFactor, "roughnessFactor");
    to_.base_color_texture = texture(core.baseColorTexture);
    to_.metallic_roughness_texture = texture(core.metallicRoughnessTexture);
    to_.normal_texture = texture(m_.normalTexture);
    to_.normal_scale = from_.number(m_.normalTexture.scale, part_, "scale");
    if (m_.emissiveFactor.size() == 3)
      to_.emissive = {positive(m_.emissiveFactor[0], "emissiveFactor"),
                      positive(m_.emissiveFactor[1], "emissiveFactor"),
                      positive(m_.emissiveFactor[2], "emissiveFactor")};
    to_.emissive_texture = texture(m_.emissiveTexture);
    if (const Value* e = extension("KHR_materials_emissive_strength"))
      to_.emissive_strength = positive(from_.number(*e, "emissiveStrength", 1, part_), "emissiveStrength");
    if (m_.alphaMode == "MASK") to_.alpha_mode = GltfMaterial::AlphaMode::kMask;
    if (m_.alphaMode == "BLEND") to_.alpha_mode = GltfMaterial::AlphaMode::kBlend;
    to_.alpha_cutoff = from_.number(m_.alphaCutoff, part_, "alphaCutoff");
    to_.double_sided = m_.doubleSided;
    to_.unlit = extension("KHR_materials_unlit") != nullptr;
  }

  void convert_transmission() {
    if (const Value* e = extension("KHR_materials_ior")) {
      to_.ior = from_.number(*e, "ior", 1.5f, part_);
      if (to_.ior != 0 && to_.ior < 1) throw from_.out.error(part_, "'ior' is less than 1");
    }
    if (const Value* e = extension("KHR_materials_dispersion"))
      to_.dispersion = positive(from_.number(*e, "dispersion", 0, part_), "dispersion");
    if (const Value* e = extension("KHR_materials_transmission")) {
      to_.transmission = factor(*e, "transmissionFactor");
      to_.transmission_texture = texture(*e, "transmissionTexture");
    }
    if (const Value* e = extension("KHR_materials_volume")) {
      to_.thickness = positive(from_.number(*e, "thicknessFactor", 0, part_), "thicknessFactor");
      const float distance = from_.number(*e, "attenuationDistance", kInfinity, part_);
      if (distance > 0) to_.attenuation_distance = distance;
      to_.attenuation_color = color(*e, "attenuationColor", 1);
    }
  }

  void convert_layers() {
    if (const Value* e = extension("KHR_materials_clearcoat")) {
      to_.clearcoat = factor(*e, "clearcoatFactor");
      to_.clearcoat_roughness = factor(*e, "clearcoatRoughnessFactor");
      to_.clearcoat_texture = texture(*e, "clearcoatTexture");
      to_.clearcoat_roughness_texture = texture(*e, "clearcoatRoughnessTexture");
      if (to_.clearcoat > 0 && e->Has("clearcoatNormalTexture"))
        note("'clearcoatNormalTexture' is not supported (the coat has the normals of its base)");
    }
    if (const Value* e = extension("KHR_materials_sheen")) {
      to_.sheen_color = color(*e, "sheenColorFactor", 0);
      to_.sheen_roughness = factor(*e, "sheenRoughnessFactor");
      to_.sheen_color_texture = texture(*e, "sheenColorTexture");
      to_.sheen_roughness_texture = texture(*e, "sheenRoughnessTexture");
    }
    if (const Value* e = extension("KHR_materials_anisotropy")) {
      to_.anisotropy = factor(*e, "anisotropyStrength");
      to_.anisotropy_rotation = from_.number(*e, "anisotropyRotation", 0, part_);
      to_.anisotropy_texture = texture(*e, "anisotropyTexture");
    }
  }

  void convert_specular() {
    if (const Value* e = extension("KHR_materials_specular")) {
      to_.specular = fraction(from_.number(*e, "specularFactor", 1, part_), "specularFactor");
      to_.specular_color = color(*e, "specularColorFactor", 1);
      to_.specular_texture = texture(*e, "specularTexture");
      to_.specular_color_texture = texture(*e, "specularColorTexture");
    }
    if (const Value* e = extension("KHR_materials_pbrSpecularGlossiness")) {
      GltfSpecularGlossiness& s = to_.specular_glossiness.emplace();
      if (const Value* diffuse = GltfChecker::find(*e, "diffuseFactor")) {
        s.diffuse = {component(*diffuse, 0), component(*diffuse, 1), component(*diffuse, 2)};
        to_.alpha = component(*diffuse, 3);
      } else {
        to_.alpha = 1;
      }
      s.specular = color(*e, "specularFactor", 1);
      s.glossiness = fraction(from_.number(*e, "glossinessFactor", 1, part_), "glossinessFactor");
      s.diffuse_texture = texture(*e, "diffuseTexture");
      s.specular_glossiness_texture = texture(*e, "specularGlossinessTexture");
    }
  }

  void note(const std::string& message) const { from_.out.notes.push_back(from_.out.error(part_, message).what()); }

  const Value* extension(const char* name) const {
    const auto found = m_.extensions.find(name);
    return found == m_.extensions.end() ? nullptr : &found->second;
  }

  float positive(double value, const char* name) const {
    const float number = from_.number(value, part_, name);
    if (number < 0) note(fmt::format("'{}' is negative (rendered as 0)", name));
    return std::max(number, 0.0f);
  }
  float fraction(double value, const char* name) const {
    const float number = positive(value, name);
    if (number > 1) note(fmt::format("'{}' is greater than 1 (rendered as 1)", name));
    return std::min(number, 1.0f);
  }
  float factor(const Value& object, const char* name) const {
    return fraction(from_.number(object, name, 0, part_), name);
  }
  float component(const Value& array, std::size_t k) const {
    if (!array.IsArray() || array.ArrayLen() <= k || !array.Get(k).IsNumber())
      throw from_.out.error(part_, fmt::format("a color has less than {} numbers", k + 1));
    return positive(array.Get(k).GetNumberAsDouble(), "a color");
  }
  Vec3f color(const Value& object, const char* name, float otherwise) const {
    const Value* value = GltfChecker::find(object, name);
    if (value == nullptr) return {otherwise, otherwise, otherwise};
    return {component(*value, 0), component(*value, 1), component(*value, 2)};
  }

  /// A texture that a core property uses.
  GltfTexture texture(const auto& info) const {
    if (info.index == kNoIndex) return std::nullopt;
    const auto transform = info.extensions.find("KHR_texture_transform");
    return texture_use(info.index, info.texCoord, transform == info.extensions.end() ? nullptr : &transform->second);
  }
  /// A texture that a property of an extension uses.
  GltfTexture texture(const Value& object, const char* name) const {
    const Value* info = GltfChecker::find(object, name);
    if (info == nullptr) return std::nullopt;
    const Value* extensions = GltfChecker::find(*info, "extensions");
    const Value* transform = extensions == nullptr ? nullptr : GltfChecker::find(*extensions, "KHR_texture_transform");
    return texture_use(from_.integer(*info, "index", kNoIndex, part_), from_.integer(*info, "texCoord", 0, part_),
                       transform);
  }

  /// Nothing, with a note, if the texture has no image in a format that is read.
  GltfTexture texture_use(int index, int uv_set, const Value* transform) const {
    const auto& model = from_.model;
    const int checked = from_.required(index, model.textures.size(), part_, "index");
    const tinygltf::Texture& texture = model.textures[static_cast<std::size_t>(checked)];
    const std::string part = fmt::format("textures[{}]", index);
    GltfTextureUse use;
    use.image = image_of(texture, part);
    if (use.image == kNoIndex) {
      from_.out.notes.push_back(from_.out.error(part, "has no image of a supported format (ignored)").what());
      return std::nullopt;
    }
    use.uv_set = uv_set;
    const int sampler = from_.index(texture.sampler, model.samplers.size(), part, "sampler");
    if (sampler != kNoIndex) {
      const tinygltf::Sampler& s = model.samplers[static_cast<std::size_t>(sampler)];
      use.wrap_u = wrap(s.wrapS, part);
      use.wrap_v = wrap(s.wrapT, part);
      use.nearest = s.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    if (transform != nullptr) {
      read_pair(*transform, "offset", use.offset);
      read_pair(*transform, "scale", use.scale);
      use.rotation = from_.number(*transform, "rotation", 0, part_);
      use.uv_set = from_.integer(*transform, "texCoord", use.uv_set, part_);
    }
    if (use.uv_set < 0) throw from_.out.error(part_, "'texCoord' is negative");
    return use;
  }

  /// The image of a texture: WebP if there is one; kNoIndex: none.
  int image_of(const tinygltf::Texture& texture, const std::string& part) const {
    int source = texture.source;
    const auto webp = texture.extensions.find("EXT_texture_webp");
    if (webp != texture.extensions.end()) source = from_.integer(webp->second, "source", source, part);
    return from_.index(source, from_.out.images.size(), part, "source");
  }

  GltfTextureUse::Wrap wrap(int mode, const std::string& part) const {
    if (mode == TINYGLTF_TEXTURE_WRAP_REPEAT) return GltfTextureUse::Wrap::kRepeat;
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return GltfTextureUse::Wrap::kClamp;
    if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return GltfTextureUse::Wrap::kMirror;
    throw from_.out.error(part, fmt::format("its sampler's wrap mode is {}, expected 10497, 33071 or 33648", mode));
  }

  void read_pair(const Value& object, const char* name, float (&to)[2]) const {
    const Value* value = GltfChecker::find(object, name);
    if (value == nullptr) return;
    for (std::size_t k = 0; k < 2; ++k) {
      if (!value->IsArray() || value->ArrayLen() != 2 || !value->Get(k).IsNumber())
        throw from_.out.error(part_, fmt::format("'{}' is not a pair of numbers", name));
      to[k] = from_.number(value->Get(k).GetNumberAsDouble(), part_, name);
    }
  }

  const GltfChecker& from_;
  const tinygltf::Material& m_;
  std::string part_;
  GltfMaterial to_;
};

}  // namespace

void convert_materials(const GltfChecker& from) {
  for (std::size_t i = 0; i < from.model.materials.size(); ++i)
    from.out.materials.push_back(MaterialConverter(from, i).convert());
}

}  // namespace sheaf
