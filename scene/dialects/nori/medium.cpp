// The Nori dialect: participating media.
#include "scene/dialects/nori/reader.h"
#include "scene/dialects/xml/read_medium.h"

namespace sheaf::nori {

namespace {

/// Reads `density`: a number that scales the coefficients, or a volume.
void read_density(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  const auto density = find_volume_input(p, "density", SpectrumRole::kIor, dialect);
  if (!density) return;
  if (const auto* grid = std::get_if<GridVolumeDescription>(&*density)) {
    medium.density = *grid;
  } else {
    medium.scale = number_of(p, "density", std::get<SpectrumDescription>(*density));
  }
}

/// Reads `method`, the distance sampling method.
void read_method(Properties& p) {
  static constexpr NameTable<MediumEstimator> kMethods{{{"march", MediumEstimator::kMarching},
                                                        {"raymarch", MediumEstimator::kMarching},
                                                        {"delta", MediumEstimator::kDelta},
                                                        {"woodcock", MediumEstimator::kDelta},
                                                        {"ratio", MediumEstimator::kRatio}}};
  MediumEstimator& estimator = p.context().description.integrator.medium_estimator;
  estimator = p.choice("method", kMethods, estimator);
}

/// Whether a grid defines the density or extinction of the medium.
bool has_grid(const MediumDescription& medium) {
  const auto* pair = std::get_if<ExtinctionAlbedoDescription>(&medium.coefficients);
  return medium.density || (pair != nullptr && std::holds_alternative<GridVolumeDescription>(pair->sigma_t));
}

void read_homogeneous(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  read_coefficients(p, dialect, medium);
  read_density(p, dialect, medium);
  read_medium_rest(p, dialect, medium);
  expect_homogeneous(p, medium);
}

void read_heterogeneous(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  read_coefficients(p, dialect, medium);
  read_density(p, dialect, medium);
  if (p.has("filename")) {
    if (medium.density)
      p.report_conflict("filename", "the <volume> 'density'");
    else
      medium.density = read_grid(p, dialect);
  }
  read_medium_rest(p, dialect, medium);
  if (!has_grid(medium)) p.fail("needs the <volume> 'density' or the string 'filename'", SceneErrorCode::kMissing);
}

constexpr NameTable<void (*)(Properties&, const VolumeDialect&, MediumDescription&)> kMedia{
    {{"heterogeneous", read_heterogeneous}, {"homog", read_homogeneous}, {"homogeneous", read_homogeneous}}};

}  // namespace

MediumId read_medium(const XmlElement& element, ReadContext& context, bool in_shape) {
  if (const auto known = find_read_medium(element, context)) return *known;
  Properties p(element, context);
  const VolumeDialect dialect{.fits_shapes = true, .in_shape = in_shape};
  MediumDescription medium;
  p.plugin(kMedia)(p, dialect, medium);
  read_method(p);
  return add_medium(p, std::move(medium));
}

MediumId add_absorption(const XmlElement& bsdf, SpectrumDescription sigma_a, ReadContext& context) {
  MediumDescription medium;
  medium.coefficients = AbsorptionScatteringDescription{std::move(sigma_a), SpectrumDescription::constant(0)};
  medium.where = bsdf.where;
  context.description.media.push_back(std::move(medium));
  return static_cast<MediumId>(context.description.media.size() - 1);
}

}  // namespace sheaf::nori
