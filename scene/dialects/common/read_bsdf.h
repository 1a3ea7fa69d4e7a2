// Materials shared by the Nori and Mitsuba dialects: Mitsuba's plugins with all their parameters.
#pragma once

#include "scene/xml/properties.h"

#include <functional>

namespace sheaf {

/// Reads a nested <bsdf> and appends it to the description.
using BsdfReader = std::function<MaterialId(const XmlElement&)>;

/// Dialect-specific options for reading materials.
struct BsdfDialect {
  BsdfReader nested;
  /// Mitsuba before 2: conductors default to copper and may be embedded in a dielectric.
  bool before_version_2 = false;
  /// Dielectrics named as in Mitsuba are dispersive by default.
  bool names_disperse = false;
};

/// Reads a plugin into `material`. Its properties come from `p`, which the caller finishes. Returns false unless the
/// plugin is one of shared_bsdf_names(). Throws SceneError.
bool read_shared_bsdf(Properties& p, const BsdfDialect& dialect, MaterialDescription& material);

/// Plugins that read_shared_bsdf() supports, in alphabetical order.
const std::vector<std::string>& shared_bsdf_names();

/// Appends a finished material with the location and id of its element.
MaterialId add_material_of(Properties& p, MaterialDescription material);

/// Reads an index of refraction, as a number or as the name of a dielectric.
float read_ior(Properties& p, const char* property, float default_value);
/// Reads a roughness; raises numbers below 0.0001 to this minimum.
ScalarInput read_alpha(Properties& p, const char* name, ScalarInput default_value);
/// Reads `distribution`, and `alpha` or both of `alpha_u` and `alpha_v`.
RoughnessDescription read_roughness(Properties& p);
/// Reads an isotropic roughness without textures.
RoughnessDescription read_uniform_roughness(Properties& p);

/// Reads the list of numbers in a string property.
std::vector<float> read_numbers(Properties& p, const char* name);

/// roughdiffuse, ward, hk, coating and roughcoating of Mitsuba before 2.
RoughDiffuseDescription read_rough_diffuse(Properties& p);
WardDescription read_ward(Properties& p);
HanrahanKruegerDescription read_hanrahan_krueger(Properties& p);
CoatDescription read_coat(Properties& p, const BsdfDialect& dialect);
/// Scales both reflectances down, with a note, if their sum exceeds 1, unless `ensureEnergyConservation` is false.
void limit_energy(Properties& p, SpectrumInput& diffuse, SpectrumInput& specular);

PrincipledDescription read_principled(Properties& p);
/// Reads polarizer, circular or retarder. The fraction of unpolarised light that passes continues straight on.
MaskDescription read_polarizer(Properties& p);
/// Adds a note that the plugin acts as it does on unpolarised light.
void note_polarisation(Properties& p);
PrincipledThinDescription read_principled_thin(Properties& p);

/// twosided, mask, blendbsdf, mixturebsdf, bumpmap, normalmap. Throws SceneError for the wrong number of nested
/// materials, and for two-sided materials with a side that transmits light.
TwoSidedDescription read_two_sided(Properties& p, const BsdfDialect& dialect);
MaskDescription read_mask(Properties& p, const BsdfDialect& dialect);
BlendDescription read_blend(Properties& p, const BsdfDialect& dialect);
/// Reads nested blends; a black material takes the remaining weight.
BlendDescription read_mixture(Properties& p, const BsdfDialect& dialect);
BumpMapDescription read_bump_map(Properties& p, const BsdfDialect& dialect);
NormalMapDescription read_normal_map(Properties& p, const BsdfDialect& dialect);

}  // namespace sheaf
