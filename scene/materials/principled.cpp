// Mitsuba's principled: reading, and the row.
#include "scene/materials/principled.h"

#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

#include <cmath>

namespace sheaf {

namespace {

const ScalarInput kAbsent = 0.0f;

constexpr const char* kBlackMetal =
    "the metallic part of this principled material is black: with 'specular' 0, an index of refraction of 1, nothing "
    "reflects specularly, as in Mitsuba (expected 'specular' above 0 or another 'eta')";

}  // namespace

PrincipledDescription PrincipledDescription::read(Properties& p, const BsdfDialect&) {
  PrincipledDescription result;
  read_declared(p, result);
  result.eta = p.number("eta", result.eta, kPositive);
  const std::optional<float> specular = p.find_number("specular", kUnitInterval);
  if (specular && p.has("eta")) p.fail("has both 'eta' and 'specular', expected one");
  // Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering": specular is the
  // reflectance at normal incidence over 0.08.
  if (specular) result.eta = 2.0f / (1.0f - std::sqrt(0.08f * *specular)) - 1.0f;
  p.ignore({"main_specular_sampling_rate", "clearcoat_sampling_rate", "diffuse_reflectance_sampling_rate"});
  return result;
}

MaterialRow PrincipledDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<PrincipledParameters> m{context};
  m.set_declared(*this);
  // An index-matched boundary would transmit without refraction, a delta lobe without a pdf.
  constexpr float kMinTransmittingEta = 1.001f;
  const bool matched = eta == 1.0f && spec_trans != kAbsent;
  m.p.eta = matched ? kMinTransmittingEta : eta;
  m.set_base_luminance(base_color, {spec_tint, sheen_tint}, TextureRole::kScalar);
  // kernels/bsdf/principled.h: without a difference of the indices, metal has no specular reflection.
  if (eta == 1.0f && metallic != kAbsent && spec_trans == kAbsent) context.warning = kBlackMetal;
  return with_tangent(m.row<PrincipledClosure>(), anisotropic);
}

}  // namespace sheaf
