// The pbrt dialect: materials. As in pbrt, reflecting materials are two-sided.
#include "core/color/color.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf::pbrt {

namespace {

using Model = decltype(MaterialDescription::model);

constexpr float kMinAlpha = 1e-4f;
constexpr float kSmoothAlpha = 1e-3f;  // pbrt treats lower values as smooth

/// Reads the roughness `parameter`, or the parameter `default_value` if it is missing, as a GGX alpha. `remap`: applies
/// pbrt's remapping, the square root.
ScalarInput read_alpha(Parameters& p, const char* parameter, const char* default_value, bool remap) {
  std::optional<ScalarInput> roughness = find_scalar_input(p, parameter);
  if (!roughness) roughness = find_scalar_input(p, default_value);
  if (!roughness) return 0.0f;
  if (remap) {
    if (std::optional<ScalarInput> root = root_of(p.reader(), *roughness)) return *root;
    p.unsupported("remapping of the roughness of this texture", "rendered as the slope");
  }
  return *roughness;
}

/// Reads a GGX roughness. `prefix` is "interface." or "conductor." in layered materials.
std::optional<RoughnessDescription> read_roughness(Parameters& p, const std::string& prefix, bool remap) {
  const std::string u = prefix + "uroughness", v = prefix + "vroughness", both = prefix + "roughness";
  RoughnessDescription roughness;
  roughness.distribution = RoughnessDescription::Distribution::kGgx;
  roughness.alpha_u = read_alpha(p, u.c_str(), both.c_str(), remap);
  roughness.alpha_v =
      p.has(u.c_str()) || p.has(v.c_str()) ? read_alpha(p, v.c_str(), both.c_str(), remap) : roughness.alpha_u;
  float* numbers[] = {std::get_if<float>(&roughness.alpha_u), std::get_if<float>(&roughness.alpha_v)};
  if (numbers[0] != nullptr && numbers[1] != nullptr && std::max(*numbers[0], *numbers[1]) < kSmoothAlpha)
    return std::nullopt;
  for (float* alpha : numbers)
    if (alpha != nullptr) *alpha = std::max(*alpha, kMinAlpha);
  return roughness;
}

Model diffuse(Parameters& p) {
  return DiffuseDescription{
      find_spectrum_input(p, "reflectance", Use::kReflectance).value_or(SpectrumDescription::constant(0.5f))};
}

/// Returns the complex index of refraction for reflectance r at normal incidence, by pbrt's rule:
/// eta = 1, k = 2 sqrt(r / (1 - r)).
ConductorDescription::Ior metal_of(const SpectrumDescription& reflectance) {
  const auto k_of = [](float r) {
    const float bounded = std::clamp(r, 0.0f, 0.9999f);
    return 2 * std::sqrt(bounded / (1 - bounded));
  };
  using S = SpectrumDescription;
  S k = reflectance;
  if (auto* gray = std::get_if<S::Constant>(&k.value)) gray->value = k_of(gray->value);
  if (auto* rgb = std::get_if<S::Rgb>(&k.value))
    rgb->value = {k_of(rgb->value.x), k_of(rgb->value.y), k_of(rgb->value.z)};
  if (auto* table = std::get_if<S::Table>(&k.value))
    std::transform(table->values.begin(), table->values.end(), table->values.begin(), k_of);
  return {S::constant(1), k};
}

/// Reads eta and k, or reflectance. eta and k become relative to a dielectric of index `around`.
ConductorDescription conductor(Parameters& p, const std::string& prefix, float around) {
  const std::string eta_name = prefix + "eta",
                    k_name = prefix == "conductor." && !p.has("conductor.k") ? "k" : prefix + "k";
  ConductorDescription metal;
  const auto reflectance = find_spectrum_input(p, "reflectance", Use::kReflectance);
  const auto eta = find_spectrum_input(p, eta_name.c_str(), Use::kUnbounded);
  const auto k = find_spectrum_input(p, k_name.c_str(), Use::kUnbounded);
  // Convert a reflectance to an index of refraction
  if (reflectance && (eta || k))
    p.fail(fmt::format("has both 'reflectance' and '{}', expected one", eta ? eta_name : k_name));
  if (reflectance) {
    if (const auto* constant = std::get_if<SpectrumDescription>(&*reflectance)) {
      metal.ior = metal_of(*constant);
    } else {
      p.unsupported("a texture of 'reflectance'", "rendered as the reflectance at all angles");
      metal.specular_reflectance = *reflectance;
    }
    return metal;
  }
  // Make eta and k relative to the surrounding dielectric
  const auto relative = [&](const std::optional<SpectrumInput>& given, const char* copper) -> SpectrumInput {
    const SpectrumInput input = given ? *given : SpectrumInput(named_spectrum(p, "", copper, Use::kUnbounded));
    const std::optional<SpectrumInput> divided = scaled_input(p.reader(), input, 1 / around);
    if (!divided) p.fail("has a texture of the metal's index of refraction that cannot be scaled");
    return *divided;
  };
  metal.ior = ConductorDescription::Ior{relative(eta, "metal-Cu-eta"), relative(k, "metal-Cu-k")};
  return metal;
}

/// The layer between coat and base.
struct Layer {
  float thickness;
  int max_depth;
};

/// Reads the layer parameters; scattering in the layer is unsupported.
Layer read_clear_layer(Parameters& p) {
  const auto albedo = find_spectrum_input(p, "albedo", Use::kReflectance);
  const SpectrumDescription* constant = albedo ? std::get_if<SpectrumDescription>(&*albedo) : nullptr;
  const auto* rgb = constant != nullptr ? std::get_if<SpectrumDescription::Rgb>(&constant->value) : nullptr;
  if (albedo && !(rgb != nullptr && rgb->value == Vec3f{0, 0, 0}))
    p.unsupported("scattering between the layers ('albedo')", "ignored");
  p.ignore({"g", "nsamples"});
  constexpr float kDefaultThickness = 0.01f;
  const ScalarInput thickness = find_scalar_input(p, "thickness").value_or(kDefaultThickness);
  const float* number = std::get_if<float>(&thickness);
  if (number == nullptr)
    p.reader().note(p.where(), p.title() + ": 'thickness' is a texture, expected a number; rendered with 0.01");
  return {number != nullptr ? std::max(*number, 0.0f) : kDefaultThickness, p.integer("maxdepth", 10, 0, 1 << 20)};
}

Model coated_diffuse(Parameters& p, bool remap) {
  PlasticDescription plastic;
  // Read the coat and the base
  plastic.int_ior = read_index(p, "eta", 1.5f).value;
  plastic.ext_ior = 1;
  plastic.diffuse_reflectance = std::get<DiffuseDescription>(diffuse(p)).reflectance;
  plastic.nonlinear = true;
  plastic.roughness = read_roughness(p, "", remap);
  if (plastic.roughness) {
    float* u = std::get_if<float>(&plastic.roughness->alpha_u);
    float* v = std::get_if<float>(&plastic.roughness->alpha_v);
    if (u == nullptr || v == nullptr) {
      p.unsupported("a texture of the coat's roughness", "rendered with a slope of 0.3");
      plastic.roughness->alpha_u = plastic.roughness->alpha_v = 0.3f;
    } else if (*u != *v) {
      p.unsupported("a coat whose roughness differs along and across", "rendered with the mean");
      *u = *v = 0.5f * (*u + *v);
    }
  }
  // Match the energy of pbrt's random walk
  const Layer layer = read_clear_layer(p);
  const double alpha = plastic.roughness ? double{std::get<float>(plastic.roughness->alpha_u)} : 0.0;
  const LayeredBase base(alpha, double{plastic.int_ior}, double{layer.thickness}, layer.max_depth);
  const std::optional<SpectrumInput> reflectance = base_input(p.reader(), plastic.diffuse_reflectance, base);
  if (!reflectance) p.fail("has a texture of 'reflectance' that cannot be changed");
  plastic.diffuse_reflectance = *reflectance;
  return plastic;
}

/// Reads a coated conductor as a blend. A mirror with the coat's roughness has the weight of the coat's reflectance at
/// normal incidence. The metal inside the coat has the remaining weight.
Model coated_conductor(Parameters& p, bool remap, const SourceLocation& where) {
  const float eta = read_index(p, "interface.eta", 1.5f).value;
  ConductorDescription metal = conductor(p, "conductor.", eta), coat;
  metal.roughness = read_roughness(p, "conductor.", remap);
  coat.roughness = read_roughness(p, "interface.", remap);
  const Layer layer = read_clear_layer(p);
  p.reader().note(where,
                  p.title() + " rendered as a blend of the metal and the reflection of the coat at normal incidence");
  const float at_right_angles = (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1));
  // Light passes the coat twice and the absorbing layer twice, here for incidence at 45 degrees. A metal of reflectance
  // 0.8 reflects again the light that the coat returns to it.
  constexpr float kTypicalReflectance = 0.8f;
  const float cosine = std::sqrt(1 - 0.5f / std::max(eta * eta, 0.5f));
  const float through = std::exp(-2 * layer.thickness / std::max(cosine, 0.1f));
  const float transmitted = (1 - at_right_angles) * through / (1 - at_right_angles * through * kTypicalReflectance);
  const std::optional<SpectrumInput> seen = scaled_input(p.reader(), metal.specular_reflectance, transmitted);
  if (seen) metal.specular_reflectance = *seen;
  return BlendDescription{at_right_angles, {add(p.reader(), metal, where), add(p.reader(), coat, where)}};
}

Model dielectric(Parameters& p, bool thin, bool remap) {
  DielectricDescription glass;
  const Index index = read_index(p, "eta", 1.5f);
  glass.int_ior = index.value;
  glass.int_dispersion = index.dispersion;
  glass.ext_ior = 1;
  glass.thin = thin;
  if (!thin) glass.roughness = read_roughness(p, "", remap);
  return glass;
}

/// Reads a number in [0, 1] or a texture.
ScalarInput hair_roughness(Parameters& p, const char* name, ScalarInput default_value) {
  const ScalarInput roughness = find_scalar_input(p, name).value_or(default_value);
  if (const float* number = std::get_if<float>(&roughness); number != nullptr && !(*number >= 0 && *number <= 1))
    p.fail_at(name, fmt::format("is {}, expected a number from 0 to 1", *number));
  return roughness;
}

Model hair(Parameters& p) {
  HairDescription fiber;
  const auto sigma_a = find_spectrum_input(p, "sigma_a", Use::kUnbounded);
  const char* name = p.has("color") ? "color" : "reflectance";
  const auto reflectance = find_spectrum_input(p, name, Use::kReflectance);
  const auto eumelanin = find_scalar_input(p, "eumelanin"), pheomelanin = find_scalar_input(p, "pheomelanin");
  const bool by_melanin = eumelanin || pheomelanin;
  if (int{sigma_a.has_value()} + int{reflectance.has_value()} + int{by_melanin} > 1)
    p.fail("has more than one of 'sigma_a', 'reflectance' and the melanins, expected one");
  fiber.color =
      HairDescription::Melanin{by_melanin ? eumelanin.value_or(0.0f) : ScalarInput(1.3f), pheomelanin.value_or(0.0f)};
  if (sigma_a) fiber.color = HairDescription::Absorption{*sigma_a, 1};
  if (reflectance) fiber.color = HairDescription::Reflectance{*reflectance};
  fiber.longitudinal_roughness = hair_roughness(p, "beta_m", 0.3f);
  fiber.azimuthal_roughness = hair_roughness(p, "beta_n", 0.3f);
  fiber.scale_tilt = p.number("alpha", 2);
  fiber.int_ior = p.number("eta", 1.55f, kPositive);
  fiber.ext_ior = 1;
  return fiber;
}

Model subsurface(Parameters& p, bool remap, std::optional<MediumId>& interior) {
  DielectricDescription boundary;
  boundary.int_ior = p.number("eta", 1.33f, kPositive);
  boundary.ext_ior = 1;
  boundary.roughness = read_roughness(p, "", remap);
  interior = read_subsurface(p, boundary.int_ior);
  return boundary;
}

Model mix(Parameters& p) {
  const Parameter* names = p.find("materials");
  if (names == nullptr || names->type != "string" || names->strings.size() != 2)
    p.fail_at("materials", "is invalid, expected the names of two materials");
  BlendDescription blend;
  blend.weight = find_scalar_input(p, "amount").value_or(0.5f);
  if (float* weight = std::get_if<float>(&blend.weight)) *weight = std::clamp(*weight, 0.0f, 1.0f);
  Reader& reader = p.reader();
  for (std::size_t i = 0; i < 2; ++i) {
    const auto found = reader.materials.find(names->strings[i]);
    if (found == reader.materials.end())
      p.fail_at("materials", fmt::format("has '{}', which is not defined yet", names->strings[i]));
    reader.used_texture = reader.used_texture || found->second.textured;
    if (found->second.interior) p.unsupported("subsurface scattering in a mix", "rendered as its boundary");
    blend.nested[i] = *found->second.id;
  }
  return blend;
}

/// Lambertian reflection and transmission.
Model diffuse_transmission(Parameters& p) {
  const float scale = p.number("scale", 1);
  const auto read = [&](const char* name) {
    const SpectrumInput quarter = SpectrumDescription::constant(0.25f);
    const SpectrumInput input = find_spectrum_input(p, name, Use::kReflectance).value_or(quarter);
    const std::optional<SpectrumInput> scaled = scaled_input(p.reader(), input, scale);
    if (!scaled) p.fail("has a texture that cannot be scaled");
    return *scaled;
  };
  DiffuseTransmitterDescription sheet;
  sheet.reflectance = read("reflectance");
  sheet.transmittance = read("transmittance");
  return sheet;
}

/// Wraps a material in its `displacement` or `normalmap`.
MaterialId mapped(Parameters& p, MaterialId nested, const SourceLocation& where) {
  const std::optional<ScalarInput> displacement = find_scalar_input(p, "displacement");
  if (p.has("normalmap")) {
    if (displacement) p.fail("has both 'displacement' and 'normalmap', expected one");
    BitmapDescription bitmap;
    bitmap.file = p.file("normalmap");
    // Only PNG files are linear; see read_encoding() of textures.
    bitmap.raw = is_png(bitmap.file);
    if (!bitmap.raw && may_hold_integers(bitmap.file))
      p.reader().note(
          where, p.title() + ": as in pbrt, normal maps other than PNG, OpenEXR and PFM files are decoded from sRGB");
    p.reader().used_texture = true;
    return add(p.reader(), NormalMapDescription{add_bitmap(p.reader(), std::move(bitmap), where), false, nested},
               where);
  }
  const TextureId* texture = displacement ? std::get_if<TextureId>(&*displacement) : nullptr;
  return texture != nullptr ? add(p.reader(), BumpMapDescription{*texture, 1, nested}, where) : nested;
}

}  // namespace

MaterialId add(Reader& reader, Model model, const SourceLocation& where) {
  reader.description.materials.push_back({std::move(model), {}, where});
  return static_cast<MaterialId>(reader.description.materials.size() - 1);
}

Material make_material(Reader& reader, const std::string& name, DirectiveArguments entity) {
  const std::string& type = entity.type;
  Parameters p(reader, fmt::format("Material '{}'", name.empty() ? type : name), entity.where,
               std::move(entity.parameters));
  reader.used_texture = false;
  if (type == "interface" || type.empty() || type == "none") {
    p.reject_unused();
    return {add(reader, NullDescription{}, entity.where), false, true};
  }
  // Read the material by its type
  const bool layered = type == "coateddiffuse" || type == "coatedconductor";
  const bool rough = layered || type == "conductor" || type == "dielectric" || type == "subsurface";
  const bool remap = rough ? p.boolean("remaproughness", true) : true;
  std::optional<MediumId> interior;
  bool both_sides = true;
  Model model;
  if (type == "diffuse") {
    model = diffuse(p);
  } else if (type == "conductor") {
    ConductorDescription metal = conductor(p, "", 1);
    metal.roughness = read_roughness(p, "", remap);
    model = std::move(metal);
  } else if (type == "coateddiffuse") {
    model = coated_diffuse(p, remap);
  } else if (type == "coatedconductor") {
    model = coated_conductor(p, remap, entity.where);
  } else if (type == "dielectric" || type == "thindielectric") {
    both_sides = false;
    model = dielectric(p, type == "thindielectric", remap);
  } else if (type == "mix") {
    both_sides = false;  // the nested materials already are
    model = mix(p);
  } else if (type == "diffusetransmission") {
    both_sides = false;
    model = diffuse_transmission(p);
  } else if (type == "measured") {
    model = MeasuredDescription{p.file("filename")};
  } else if (type == "hair") {
    both_sides = false;
    model = hair(p);
  } else if (type == "subsurface") {
    both_sides = false;
    model = subsurface(p, remap, interior);
  } else {
    const std::vector<std::string> known = {
        "coatedconductor", "coateddiffuse", "conductor", "dielectric", "diffuse",       "diffusetransmission", "hair",
        "interface",       "measured",      "mix",       "subsurface", "thindielectric"};
    throw SceneError(entity.where, fmt::format("unknown material '{}'{}", type, did_you_mean(type, known)),
                     SceneErrorCode::kUnknownName);
  }
  // Wrap it in maps and as two-sided
  MaterialId id = mapped(p, add(reader, std::move(model), entity.where), entity.where);
  if (both_sides) id = add(reader, TwoSidedDescription{id, id}, entity.where);
  reader.description.materials.at(static_cast<std::size_t>(id)).id = name;
  p.reject_unused();
  return {id, reader.used_texture, false, interior};
}

}  // namespace sheaf::pbrt
