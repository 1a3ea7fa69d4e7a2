// Slabs with single scattering: reading, and the row.
#include "scene/materials/hanrahan_krueger.h"

#include "scene/data/measured_media.h"
#include "scene/description/media.h"
#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

namespace {

/// Sets the coefficients of the measured medium that `material` names, by default skin1.
void read_slab_material(Properties& p, HanrahanKruegerDescription& slab) {
  const std::string name = p.string("material", "skin1");
  const MeasuredMedium* found = find_measured_medium(name);
  if (found == nullptr) {
    p.report_at("material",
                fmt::format("is {}, expected the name of a measured medium{}", in_quotes(name),
                            did_you_mean(name, measured_medium_names())),
                SceneErrorCode::kUnknownName);
    found = find_measured_medium("skin1");
  }
  slab.first = SpectrumDescription{SpectrumDescription::Rgb{found->sigma_s}};
  slab.second = SpectrumDescription{SpectrumDescription::Rgb{found->sigma_a}};
  slab.by_albedo = false;
}

/// Returns the mean cosine of the nested phase function, or 0 without one.
float read_mean_cosine(Properties& p, const BsdfDialect& dialect) {
  const std::optional<PhaseId> id = dialect.phase(p);
  if (!id) return 0;
  const PhaseDescription& phase = p.context().phase_list[static_cast<std::size_t>(*id)];
  if (const auto* hg = std::get_if<HenyeyGreensteinDescription>(&phase.model)) return hg->g;
  if (std::holds_alternative<IsotropicPhaseDescription>(phase.model)) return 0;
  throw SceneError(phase.where, "phase function of 'hk' not supported, expected isotropic or hg");
}

}  // namespace

HanrahanKruegerDescription HanrahanKruegerDescription::read(Properties& p, const BsdfDialect& dialect) {
  HanrahanKruegerDescription result;
  const auto sigma_t = p.find_spectrum_input("sigma_t", SpectrumRole::kIor);
  const auto sigma_s = p.find_spectrum_input("sigma_s", SpectrumRole::kIor);
  const auto sigma_a = p.find_spectrum_input("sigma_a", SpectrumRole::kIor);
  const auto albedo = p.find_spectrum_input("albedo", SpectrumRole::kReflectance);
  const bool pair = sigma_t || albedo, other = sigma_s || sigma_a;
  if (pair && other) p.fail("mixes 'sigmaT' and 'albedo' with 'sigmaS' and 'sigmaA', expected one of the pairs");
  if (pair != (sigma_t && albedo) || other != (sigma_s && sigma_a))
    p.fail("has only one coefficient, expected 'sigmaS' and 'sigmaA', or 'sigmaT' and 'albedo'");
  if ((pair || other) && p.has("material")) p.report_conflict("material", "coefficients");
  if (pair) result.first = *sigma_t, result.second = *albedo;
  if (other) result.first = *sigma_s, result.second = *sigma_a, result.by_albedo = false;
  if (!pair && !other) read_slab_material(p, result);
  result.thickness = p.number("thickness", 1, kNotNegative);
  result.g = read_mean_cosine(p, dialect);
  return result;
}

MaterialRow HanrahanKruegerDescription::make_row(RowContext& context) const {
  MaterialRowBuilder<HanrahanKruegerParameters> m{context};
  m.set(m.p.first, first, TextureRole::kUnbounded);
  m.set(m.p.second, second, by_albedo ? TextureRole::kReflectance : TextureRole::kUnbounded);
  m.p.by_albedo = by_albedo ? 1 : 0;
  m.p.thickness = thickness;
  m.p.g = g;
  return m.row<HanrahanKruegerClosure>();
}

}  // namespace sheaf
