// Helpers for reading materials, shared by the models and dialects.
#pragma once

#include "scene/materials/material.h"
#include "scene/materials/roughness.h"
#include "scene/xml/read_declared.h"

#include <functional>
#include <string>
#include <vector>

namespace sheaf {

/// Reads a nested <bsdf> and appends it to the description.
using BsdfReader = std::function<MaterialId(const XmlElement&)>;

/// Dialect-specific options for reading materials.
struct BsdfDialect {
  BsdfReader nested;
  /// Reads the phase function of the object; nullopt if it has none.
  std::optional<PhaseId> (*phase)(Properties& p) = nullptr;
  /// Mitsuba before 2: conductors default to copper and may be embedded in a dielectric.
  bool before_version_2 = false;
  /// Dielectrics named as in Mitsuba are dispersive by default.
  bool names_disperse = false;
};

/// Appends a material, returns its index.
MaterialId add_material(ReadContext& context, MaterialDescription material);
/// Appends a finished material with the location and id of its element.
MaterialId add_material_of(Properties& p, MaterialDescription material);
/// Appends a material that reflects nothing.
MaterialId add_black_material(Properties& p);

/// Reads an index of refraction, as a number or as the name of a dielectric.
float read_ior(Properties& p, const char* property, float default_value);
/// Reads a reflectance or transmittance.
SpectrumInput read_reflectance(Properties& p, const char* name, SpectrumInput default_value);
/// Reads a parameter in [0, 1] into `value`, if present.
void read_unit(Properties& p, const char* name, ScalarInput& value);
/// Reads a roughness; raises numbers below 0.0001 to this minimum.
ScalarInput read_alpha(Properties& p, const char* name, ScalarInput default_value);
/// Reads `distribution`, and `alpha` or both of `alpha_u` and `alpha_v`.
RoughnessDescription read_roughness(Properties& p);
/// Reads an isotropic roughness without textures.
RoughnessDescription read_uniform_roughness(Properties& p);
/// Scales both reflectances down, with a note, if their sum exceeds 1, unless `ensureEnergyConservation` is false.
void limit_energy(Properties& p, SpectrumInput& diffuse, SpectrumInput& specular);

/// Reads the list of numbers in a string property.
std::vector<float> read_numbers(Properties& p, const char* name);
/// Returns the first of the alternative names that is present, or the first name.
const char* first_of(Properties& p, std::initializer_list<const char*> names);
/// Formats names as "a, b, c".
std::string list_of(const std::vector<std::string>& names);

/// The nested materials. Throws SceneError unless there are from `low` to `high`.
std::vector<const XmlElement*> nested_bsdfs(Properties& p, std::size_t low, std::size_t high, const char* expected);
/// Reads the only nested material.
MaterialId read_nested_bsdf(Properties& p, const BsdfDialect& dialect);
/// Throws SceneError if a nested material transmits light.
void expect_opaque(Properties& p, MaterialId nested);
/// The only nested texture or color.
const XmlElement& only_texture(Properties& p);
/// Reads a texture; for a constant, appends a constant texture.
TextureId read_map(const XmlElement& texture, ReadContext& context);

/// Adds a note that the plugin acts on all light as on unpolarized light.
void note_polarization(Properties& p);

/// read_declared() of a material.
template <DeclaresParameters Model> void read_declared(Properties& p, Model& model) {
  read_declared(p, model, SpectrumRole::kReflectance);
}

}  // namespace sheaf
