// Materials that both dialects spell alike: plugins of Mitsuba with all their parameters.
#pragma once

#include "scene/xml/properties.h"

#include <functional>

namespace sheaf {

/// Reads a nested <bsdf> and appends it to the description.
using BsdfReader = std::function<MaterialId(const XmlElement&)>;

/// How the dialect at hand reads materials.
struct BsdfDialect {
  BsdfReader nested;
  bool before_version_2 = false;  ///< of Mitsuba: conductors are copper by default and may lie in a dielectric
  bool names_disperse = false;    ///< dielectrics by Mitsuba's names depend on the wavelength if nothing is said
};

/// Reads a plugin into `material`, with its properties from `p`, which the caller finishes. False if the plugin is none
/// of shared_bsdf_names(). Throws SceneError.
bool read_shared_bsdf(Properties& p, const BsdfDialect& dialect, MaterialDescription& material);

/// The plugins that read_shared_bsdf() knows, in order of the alphabet.
const std::vector<std::string>& shared_bsdf_names();

/// Appends a finished material with the place and id of its element.
MaterialId add_material_of(Properties& p, MaterialDescription material);

/// An index of refraction, as a number or as the name of a dielectric.
float read_ior(Properties& p, const char* property, float default_value);
/// A roughness; numbers below 0.0001 are raised to it.
ScalarInput read_alpha(Properties& p, const char* name, ScalarInput default_value);
/// `distribution`, and `alpha` or both of `alpha_u` and `alpha_v`.
RoughnessDescription read_roughness(Properties& p);
/// The same, where it may be neither a texture nor different along and across.
RoughnessDescription read_uniform_roughness(Properties& p);

/// The numbers of a string property.
std::vector<float> read_numbers(Properties& p, const char* name);

/// roughdiffuse, ward, hk, coating and roughcoating, of Mitsuba before 2.
RoughDiffuseDescription read_rough_diffuse(Properties& p);
WardDescription read_ward(Properties& p);
HanrahanKruegerDescription read_hanrahan_krueger(Properties& p);
CoatDescription read_coat(Properties& p, const BsdfDialect& dialect);
/// Scales both down, with a note, where they add up to more than 1, unless `ensureEnergyConservation` says otherwise.
void limit_energy(Properties& p, SpectrumInput& diffuse, SpectrumInput& specular);

PrincipledDescription read_principled(Properties& p);
/// polarizer, circular, retarder: what light that is not polarised keeps of itself goes straight on.
MaskDescription read_polarizer(Properties& p);
/// Says that a plugin acts as on light that is not polarised.
void note_polarisation(Properties& p);
PrincipledThinDescription read_principled_thin(Properties& p);

/// twosided, mask, blendbsdf, mixturebsdf, bumpmap, normalmap. Throws SceneError for the wrong number of nested
/// materials, and for a side of a two-sided one that transmits light.
TwoSidedDescription read_two_sided(Properties& p, const BsdfDialect& dialect);
MaskDescription read_mask(Properties& p, const BsdfDialect& dialect);
BlendDescription read_blend(Properties& p, const BsdfDialect& dialect);
/// As blends of blends, with a black material for what the weights leave.
BlendDescription read_mixture(Properties& p, const BsdfDialect& dialect);
BumpMapDescription read_bump_map(Properties& p, const BsdfDialect& dialect);
NormalMapDescription read_normal_map(Properties& p, const BsdfDialect& dialect);

}  // namespace sheaf
