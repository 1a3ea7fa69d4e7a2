// Materials shared by the Nori and Mitsuba dialects: Mitsuba's principled and principledthin.
#include "scene/dialects/common/read_bsdf.h"

#include <cmath>

namespace sheaf {

namespace {

/// Reads a parameter in [0, 1] into `value`, if present.
void read_share(Properties& p, const char* name, ScalarInput& value) {
  value = p.scalar_input(name, value, kUnitInterval);
}

}  // namespace

PrincipledDescription read_principled(Properties& p) {
  PrincipledDescription result;
  result.base_color = p.spectrum_input("base_color", result.base_color, SpectrumRole::kReflectance);
  read_share(p, "roughness", result.roughness);
  read_share(p, "anisotropic", result.anisotropic);
  read_share(p, "metallic", result.metallic);
  read_share(p, "spec_trans", result.spec_trans);
  read_share(p, "spec_tint", result.spec_tint);
  read_share(p, "sheen", result.sheen);
  read_share(p, "sheen_tint", result.sheen_tint);
  read_share(p, "flatness", result.flatness);
  read_share(p, "clearcoat", result.clearcoat);
  read_share(p, "clearcoat_gloss", result.clearcoat_gloss);
  const std::optional<float> eta = p.find_number("eta", kPositive);
  const std::optional<float> specular = p.find_number("specular", kUnitInterval);
  if (eta && specular) p.fail("has both 'eta' and 'specular', expected one");
  if (eta) result.eta = *eta;
  // Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering": specular is the
  // reflectance at normal incidence over 0.08.
  if (specular) result.eta = 2.0f / (1.0f - std::sqrt(0.08f * *specular)) - 1.0f;
  p.ignore({"main_specular_sampling_rate", "clearcoat_sampling_rate", "diffuse_reflectance_sampling_rate"});
  return result;
}

PrincipledThinDescription read_principled_thin(Properties& p) {
  PrincipledThinDescription result;
  result.base_color = p.spectrum_input("base_color", result.base_color, SpectrumRole::kReflectance);
  read_share(p, "roughness", result.roughness);
  read_share(p, "anisotropic", result.anisotropic);
  read_share(p, "spec_trans", result.spec_trans);
  read_share(p, "spec_tint", result.spec_tint);
  read_share(p, "sheen", result.sheen);
  read_share(p, "sheen_tint", result.sheen_tint);
  read_share(p, "flatness", result.flatness);
  result.eta = p.scalar_input("eta", result.eta, kPositive);
  result.diff_trans = p.scalar_input("diff_trans", result.diff_trans, {0, 2, false});
  p.ignore({"specular_reflectance_sampling_rate", "specular_transmittance_sampling_rate",
            "diffuse_reflectance_sampling_rate", "diffuse_transmittance_sampling_rate"});
  return result;
}

}  // namespace sheaf
