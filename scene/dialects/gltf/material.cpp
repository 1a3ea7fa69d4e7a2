// Materials of glTF as materials, textures and media of a scene.
#include "scene/dialects/common/covered_emission.h"
#include "scene/dialects/gltf/reader.h"

#include <algorithm>
#include <cmath>

namespace sheaf::gltf {

namespace {

using Channel = BitmapDescription::Channel;

/// Roughness up to which transmitting surfaces are smooth. The closure of rough ones has a minimum of about this.
constexpr float kSmooth = 0.03f;

SpectrumDescription rgb(Vec3f color) { return SpectrumDescription::rgb(color.x, color.y, color.z); }

bool is_zero(Vec3f color) { return color.x == 0 && color.y == 0 && color.z == 0; }
bool is_one(Vec3f color) { return color.x == 1 && color.y == 1 && color.z == 1; }

/// Cauchy's formula for an index of refraction at the helium d line and an Abbe number (KHR_materials_dispersion).
Dispersion dispersion_of(float ior, float abbe_number) {
  // Wavelengths of the lines d, F and C in micrometers.
  constexpr double kD = 0.5875618, kF = 0.4861327, kC = 0.6562725;
  const double b = (double(ior) - 1) / (double(abbe_number) * (1 / (kF * kF) - 1 / (kC * kC)));
  Dispersion out;
  out.form = Dispersion::Form::kPowers;
  out.constant = static_cast<float>(double(ior) - b / (kD * kD));
  out.terms[0] = {static_cast<float>(b), -2};
  return out;
}

/// Rows of the matrix from the mesh's uv, with v upwards, to those of an image.
std::array<float, 6> uv_matrix(const GltfTextureUse& use) {
  const float c = std::cos(use.rotation), s = std::sin(use.rotation);
  const float sx = use.scale[0], sy = use.scale[1];
  // With v downwards: u' = c sx u + s sy v + offset[0], v' = -s sx u + c sy v + offset[1].
  return {c * sx, -s * sy, use.offset[0] + s * sy, s * sx, c * sy, 1 - use.offset[1] - c * sy};
}

}  // namespace

/// Builds the surface of one material.
class MaterialBuilder {
 public:
  MaterialBuilder(Materials& owner, const GltfMaterial& m, const VertexData& data)
      : owner_(owner), out_(owner.out_), m_(m), data_(data), primary_(primary_uv_set(m)) {}

  Surface build() {
    Surface surface;
    if (m_.unlit) {
      surface.radiance = base_color();
      surface.emits_on_both_sides = true;
      surface.material = add(DiffuseDescription{SpectrumDescription::constant(0)});
    } else {
      surface.material = add_reflector(surface);
      add_emission(surface);
    }
    surface.material = add_alpha(surface.material);
    if (surface.radiance) {
      CoveredEmission emission = covered_emission(out_, std::move(*surface.radiance), surface.material);
      surface.radiance = std::move(emission.radiance);
      surface.radiance_scale = emission.scale;
    }
    return surface;
  }

 private:
  // Products of constants and textures

  TextureId add_texture(TextureModel model, const std::array<float, 6>& to_uv = {1, 0, 0, 0, 1, 0}) {
    TextureDescription texture;
    texture.model = std::move(model);
    texture.to_uv = to_uv;
    texture.id = m_.name;
    texture.where = {owner_.file_.file.string(), 0};
    out_.textures.push_back(std::move(texture));
    return static_cast<TextureId>(out_.textures.size() - 1);
  }

  SpectrumInput times(SpectrumInput a, Vec3f factor) {
    if (is_one(factor)) return a;
    return add_texture(ProductTextureDescription{rgb(factor), std::move(a)});
  }
  ScalarInput times(ScalarInput a, float factor) {
    if (const float* constant = std::get_if<float>(&a)) return *constant * factor;
    if (factor == 1) return a;
    return add_texture(ProductTextureDescription{SpectrumDescription::constant(factor), std::get<TextureId>(a)});
  }
  ScalarInput times(ScalarInput a, ScalarInput b) {
    if (const float* constant = std::get_if<float>(&b)) return times(a, *constant);
    if (const float* constant = std::get_if<float>(&a)) return times(b, *constant);
    return add_texture(ProductTextureDescription{std::get<TextureId>(a), std::get<TextureId>(b)});
  }
  ScalarInput one_minus(ScalarInput a) {
    if (const float* constant = std::get_if<float>(&a)) return 1 - *constant;
    return add_texture(MixTextureDescription{SpectrumDescription::constant(1), SpectrumDescription::constant(0), a});
  }

  // Textures

  /// The texture of an image or of one of its channels.
  TextureId image(const GltfTextureUse& use, Channel channel, bool raw) {
    const std::array<float, 6> to_uv = uv_matrix(use);
    const int set = use.uv_set == primary_ ? kNoIndex : use.uv_set;
    const Materials::TextureKey key{use.image,
                                    static_cast<int>(channel),
                                    raw,
                                    static_cast<int>(use.wrap_u),
                                    static_cast<int>(use.wrap_v),
                                    use.nearest,
                                    to_uv,
                                    set};
    const auto [found, is_new] = owner_.textures_.try_emplace(key);
    if (is_new) {
      found->second = add_texture(bitmap(use, channel, raw), to_uv);
      if (set != kNoIndex) found->second = add_texture(UvSetTextureDescription{uv_attribute(set), found->second});
    }
    return found->second;
  }

  BitmapDescription bitmap(const GltfTextureUse& use, Channel channel, bool raw) const {
    const GltfImage& from = owner_.file_.images[static_cast<std::size_t>(use.image)];
    const auto wrap = [](GltfTextureUse::Wrap mode) {
      if (mode == GltfTextureUse::Wrap::kClamp) return TextureWrap::kClamp;
      return mode == GltfTextureUse::Wrap::kMirror ? TextureWrap::kMirror : TextureWrap::kRepeat;
    };
    BitmapDescription to;
    to.file = from.file;
    to.encoded = from.encoded;
    to.channel = channel;
    to.raw = raw;
    to.wrap_u = wrap(use.wrap_u);
    to.wrap_v = wrap(use.wrap_v);
    if (use.nearest) to.filter = TextureFilter::kNearest;
    return to;
  }

  SpectrumInput color(Vec3f factor, const GltfTexture& texture) {
    if (!texture || is_zero(factor)) return rgb(factor);
    return times(SpectrumInput(image(*texture, Channel::kColor, false)), factor);
  }
  ScalarInput number(float factor, const GltfTexture& texture, Channel channel) {
    if (!texture || factor == 0) return factor;
    return times(ScalarInput(image(*texture, channel, true)), factor);
  }

  TextureId attribute(const char* name) { return add_texture(MeshAttributeDescription{name}); }

  ScalarInput anisotropy_rotation() {
    const GltfTexture& texture = m_.anisotropy_texture;
    if (!texture || m_.anisotropy == 0) return m_.anisotropy_rotation;
    const ScalarInput x = image(*texture, Channel::kRed, true), y = image(*texture, Channel::kGreen, true);
    return add_texture(DirectionTextureDescription{x, y, m_.anisotropy_rotation});
  }

  SpectrumInput base_color() {
    const bool glossy = m_.specular_glossiness.has_value();
    SpectrumInput out = glossy ? color(m_.specular_glossiness->diffuse, m_.specular_glossiness->diffuse_texture)
                               : color(m_.base_color, m_.base_color_texture);
    if (!data_.has_color) return out;
    return add_texture(ProductTextureDescription{std::move(out), attribute("vertex_color")});
  }

  // Layers of the surface

  MaterialId add(MaterialModel model) {
    MaterialDescription material;
    material.model = std::move(model);
    material.id = m_.name;
    material.where = {owner_.file_.file.string(), 0};
    out_.materials.push_back(std::move(material));
    return static_cast<MaterialId>(out_.materials.size() - 1);
  }

  /// Adds what reflects and transmits. Sets the medium inside of `surface`.
  MaterialId add_reflector(Surface& surface) {
    MetallicRoughnessDescription opaque = layers();
    const ScalarInput transmission = number(m_.transmission, m_.transmission_texture, Channel::kRed);
    const bool transmits = m_.transmission > 0 && opaque.metallic != ScalarInput(1.0f);
    const bool is_volume = transmits && m_.thickness > 0;
    const bool is_smooth_wall = transmits && !is_volume && is_smooth(opaque);
    if (!is_volume && !is_smooth_wall) {
      if (transmits) opaque.transmission = transmission;
      return finish(add(std::move(opaque)), !transmits);
    }
    if (is_volume) surface.interior = add_medium();
    // Only the part that is not metal transmits.
    const ScalarInput transmitted = times(transmission, one_minus(opaque.metallic));
    DielectricDescription glass = dielectric(opaque, is_smooth_wall);
    if (transmitted == ScalarInput(1.0f)) return finish(add(std::move(glass)), false);
    const ScalarInput metallic = opaque.metallic;
    const bool has_metal = metallic != ScalarInput(0.0f);
    if (const float* constant = std::get_if<float>(&transmitted); constant != nullptr && has_metal)
      opaque.metallic = times(metallic, 1 / (1 - *constant));
    if (std::holds_alternative<float>(transmitted) || !has_metal)
      return finish(add(BlendDescription{transmitted, {add_two_sided(std::move(opaque)), add(std::move(glass))}}),
                    false);
    // With textures, the metal is blended with the rest instead of being a part of the opaque one, which would be
    // metallic / (1 - share). The model is linear in `metallic`.
    opaque.metallic = 0.0f;
    MetallicRoughnessDescription metal = opaque;
    metal.metallic = 1.0f;
    const MaterialId rest =
        add(BlendDescription{transmission, {add_two_sided(std::move(opaque)), add(std::move(glass))}});
    return finish(add(BlendDescription{metallic, {rest, add_two_sided(std::move(metal))}}), false);
  }

  /// Whether the roughness is at most kSmooth everywhere. Textures are at most 1.
  bool is_smooth(const MetallicRoughnessDescription& surface) const {
    const float* roughness = std::get_if<float>(&surface.roughness);
    if (roughness != nullptr) return *roughness <= kSmooth;
    return !m_.specular_glossiness && m_.roughness <= kSmooth;
  }

  MaterialId add_two_sided(MaterialModel model) {
    const MaterialId id = add(std::move(model));
    return add(TwoSidedDescription{id, id});
  }

  MetallicRoughnessDescription layers() {
    MetallicRoughnessDescription out;
    out.base_color = base_color();
    out.eta = m_.ior;
    if (m_.specular_glossiness) {
      const GltfSpecularGlossiness& s = *m_.specular_glossiness;
      out.metallic = 0.0f;
      out.roughness = one_minus(number(s.glossiness, s.specular_glossiness_texture, Channel::kAlpha));
      out.specular_color = color(s.specular, s.specular_glossiness_texture);
      out.eta = kInfinity;
    } else {
      out.metallic = number(m_.metallic, m_.metallic_roughness_texture, Channel::kBlue);
      out.roughness = number(m_.roughness, m_.metallic_roughness_texture, Channel::kGreen);
      out.specular = number(m_.specular, m_.specular_texture, Channel::kAlpha);
      out.specular_color = color(m_.specular_color, m_.specular_color_texture);
    }
    out.anisotropy = number(m_.anisotropy, m_.anisotropy_texture, Channel::kBlue);
    out.anisotropy_rotation = anisotropy_rotation();
    out.sheen_color = color(m_.sheen_color, m_.sheen_color_texture);
    if (!is_zero(m_.sheen_color))
      out.sheen_roughness = number(m_.sheen_roughness, m_.sheen_roughness_texture, Channel::kAlpha);
    out.clearcoat = number(m_.clearcoat, m_.clearcoat_texture, Channel::kRed);
    if (m_.clearcoat > 0)
      out.clearcoat_roughness = number(m_.clearcoat_roughness, m_.clearcoat_roughness_texture, Channel::kGreen);
    return out;
  }

  /// The boundary of a volume, or a smooth thin wall.
  DielectricDescription dielectric(const MetallicRoughnessDescription& opaque, bool is_thin) {
    DielectricDescription glass;
    glass.int_ior = std::max(m_.ior, 1.0f);
    glass.ext_ior = 1;
    glass.specular_transmittance = opaque.base_color;
    glass.thin = is_thin;
    if (!m_.specular_glossiness) {
      glass.specular = opaque.specular;
      glass.specular_color = opaque.specular_color;
    }
    if (is_thin) return glass;
    if (m_.dispersion > 0) glass.int_dispersion = dispersion_of(glass.int_ior, 20 / m_.dispersion);
    if (is_smooth(opaque)) return glass;
    const ScalarInput alpha = times(opaque.roughness, opaque.roughness);
    glass.roughness = {RoughnessDescription::Distribution::kGgx, alpha, alpha};
    return glass;
  }

  /// The absorbing medium of a volume.
  std::optional<MediumId> add_medium() {
    if (!std::isfinite(m_.attenuation_distance) || is_one(m_.attenuation_color)) return std::nullopt;
    // Keeps the absorption of black finite: a distance transmits this fraction.
    constexpr float kDarkest = 1e-30f;
    const auto absorption = [&](float c) {
      return std::max(-std::log(std::clamp(c, kDarkest, 1.0f)), 0.0f) / m_.attenuation_distance;
    };
    const Vec3f color = m_.attenuation_color;
    MediumDescription medium;
    medium.coefficients = AbsorptionScatteringDescription{
        rgb({absorption(color.x), absorption(color.y), absorption(color.z)}), SpectrumDescription::constant(0)};
    medium.id = m_.name;
    medium.where = {owner_.file_.file.string(), 0};
    out_.media.push_back(std::move(medium));
    return static_cast<MediumId>(out_.media.size() - 1);
  }

  /// Adds the normal map, and the back of opaque surfaces.
  MaterialId finish(MaterialId id, bool is_opaque) {
    if (m_.normal_texture) {
      NormalMapDescription map;
      map.normals = image(*m_.normal_texture, Channel::kColor, true);
      map.scale = m_.normal_scale;
      map.follows_uv = true;
      map.nested = id;
      id = add(map);
    }
    return is_opaque ? add(TwoSidedDescription{id, id}) : id;
  }

  void add_emission(Surface& surface) {
    if (is_zero(m_.emissive) || m_.emissive_strength == 0) return;
    surface.radiance = color(m_.emissive * m_.emissive_strength, m_.emissive_texture);
    surface.emits_on_both_sides = m_.double_sided;
    surface.emission_coat = number(m_.clearcoat, m_.clearcoat_texture, Channel::kRed);
  }

  MaterialId add_alpha(MaterialId id) {
    if (m_.alpha_mode == GltfMaterial::AlphaMode::kOpaque) return id;
    const GltfTexture& texture =
        m_.specular_glossiness ? m_.specular_glossiness->diffuse_texture : m_.base_color_texture;
    ScalarInput alpha = number(m_.alpha, texture, Channel::kAlpha);
    if (data_.has_alpha) alpha = times(alpha, ScalarInput(attribute("vertex_alpha")));
    if (m_.alpha_mode == GltfMaterial::AlphaMode::kMask) {
      if (const float* constant = std::get_if<float>(&alpha)) {
        alpha = *constant >= m_.alpha_cutoff ? 1.0f : 0.0f;
      } else {
        alpha = add_texture(ThresholdTextureDescription{alpha, m_.alpha_cutoff});
      }
    }
    return alpha == ScalarInput(1.0f) ? id : add(MaskDescription{alpha, id});
  }

  Materials& owner_;
  Description& out_;
  const GltfMaterial& m_;
  const VertexData& data_;
  int primary_;
};

Surface Materials::surface(int material, const VertexData& data) {
  const auto [found, is_new] = surfaces_.try_emplace({material, data});
  if (is_new) {
    static const GltfMaterial standard;
    const GltfMaterial& from = material == kNoIndex ? standard : file_.materials[static_cast<std::size_t>(material)];
    found->second = MaterialBuilder(*this, from, data).build();
  }
  return found->second;
}

}  // namespace sheaf::gltf
