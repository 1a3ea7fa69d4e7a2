// Participating media shared by the Nori and Mitsuba dialects: coefficients, emission and phase function.
#include "scene/dialects/xml/read_medium.h"

#include "scene/dialects/xml/read_phase.h"

namespace sheaf {

namespace {

bool is_grid(const VolumeInput& input) { return std::holds_alternative<GridVolumeDescription>(input); }

/// Reads a blackbody temperature (K): a grid, or a constant, which becomes a constant emission.
void read_temperature(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  const auto temperature = find_volume_input(p, "temperature", SpectrumRole::kIor, dialect);
  if (!temperature) return;
  if (medium.emission)
    return p.report("has both 'emission' and 'temperature', expected one", SceneErrorCode::kDuplicate,
                    "'temperature' ignored");
  if (const auto* grid = std::get_if<GridVolumeDescription>(&*temperature)) {
    medium.temperature = *grid;
    return;
  }
  const float kelvin =
      number_of(p, "temperature", std::get<SpectrumDescription>(*temperature)) * medium.temperature_scale;
  if (kelvin > 0) medium.emission = SpectrumDescription{SpectrumDescription::Blackbody{kelvin, 1}};
}

}  // namespace

bool read_coefficients(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  ExtinctionAlbedoDescription pair;
  const bool by_extinction = has_volume_input(p, "sigma_t") || has_volume_input(p, "albedo");
  pair.sigma_t = volume_input(p, "sigma_t", std::get<SpectrumDescription>(pair.sigma_t), SpectrumRole::kIor, dialect);
  pair.albedo =
      volume_input(p, "albedo", std::get<SpectrumDescription>(pair.albedo), SpectrumRole::kReflectance, dialect);
  const auto sigma_a = find_constant_volume(p, "sigma_a", SpectrumRole::kIor, dialect);
  const auto sigma_s = find_constant_volume(p, "sigma_s", SpectrumRole::kIor, dialect);
  if (by_extinction && (sigma_a || sigma_s))
    p.fail("mixes 'sigma_t' and 'albedo' with 'sigma_a' and 'sigma_s', expected one of the pairs");
  if (sigma_a || sigma_s) {
    const SpectrumDescription nothing;
    medium.coefficients = AbsorptionScatteringDescription{sigma_a.value_or(nothing), sigma_s.value_or(nothing)};
    return true;
  }
  medium.coefficients = std::move(pair);
  return by_extinction;
}

void read_medium_rest(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  medium.scale *= p.number("scale", 1, kNotNegative);
  medium.emission = find_volume_input(p, "emission", SpectrumRole::kEmission, dialect);
  medium.temperature_scale = p.number("temperature_scale", 1, kNotNegative);
  medium.emission_scale = p.number("emission_scale", 1, kNotNegative);
  read_temperature(p, dialect, medium);
  medium.phase = find_phase(p);
}

void expect_homogeneous(const Properties& p, const MediumDescription& medium) {
  const auto* pair = std::get_if<ExtinctionAlbedoDescription>(&medium.coefficients);
  const bool varies = medium.density || medium.temperature || (medium.emission && is_grid(*medium.emission)) ||
                      (pair != nullptr && (is_grid(pair->sigma_t) || is_grid(pair->albedo)));
  if (varies) p.fail("has a grid, expected constants; use type 'heterogeneous' for grids");
}

std::optional<MediumId> find_read_medium(const XmlElement& element, const ReadContext& context) {
  const auto known = context.media.find(&element);
  return known != context.media.end() ? std::optional<MediumId>(known->second) : std::nullopt;
}

MediumId add_medium(Properties& p, MediumDescription medium) {
  p.reject_unused();
  medium.where = p.where();
  if (const std::string* id = p.element().find_attribute("id")) medium.id = *id;
  std::vector<MediumDescription>& media = p.context().description.media;
  media.push_back(std::move(medium));
  const auto index = static_cast<MediumId>(media.size() - 1);
  p.context().media.emplace(&p.element(), index);
  return index;
}

}  // namespace sheaf
