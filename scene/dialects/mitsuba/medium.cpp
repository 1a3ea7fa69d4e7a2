// The Mitsuba dialect: participating media.
#include "scene/data/measured_media.h"
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_medium.h"

namespace sheaf::mitsuba {

const MeasuredMedium& read_measured_medium(Properties& p) {
  constexpr const char* kDefault = "skin1";
  const std::string name = p.string("material", kDefault);
  if (const MeasuredMedium* found = find_measured_medium(name)) return *found;
  p.report_at(
      "material",
      fmt::format("is {}, expected the name of a measured medium{}{}; use 'sigma_s' and 'sigma_a' for others",
                  in_quotes(name), did_you_mean(name, measured_medium_names()), known_names(measured_medium_names())),
      SceneErrorCode::kUnknownName);
  return *find_measured_medium(kDefault);
}

void read_measured_coefficients(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  if (read_coefficients(p, dialect, medium)) {
    if (p.has("material")) p.report_conflict("material", "coefficients");
    return;
  }
  const MeasuredMedium& measured = read_measured_medium(p);
  const auto rgb = [](Vec3f v) { return SpectrumDescription{SpectrumDescription::Rgb{v}}; };
  medium.coefficients = AbsorptionScatteringDescription{rgb(measured.sigma_a), rgb(measured.sigma_s)};
}

namespace {

void read_homogeneous(Properties& p, const VolumeDialect& dialect, bool before_version_2, MediumDescription& medium) {
  if (before_version_2) {
    read_measured_coefficients(p, dialect, medium);
  } else {
    read_coefficients(p, dialect, medium);
  }
  read_medium_rest(p, dialect, medium);
  expect_homogeneous(p, medium);
}

/// Mitsuba before 2: `density` is the extinction coefficient, and `method` selects the distance sampling.
void read_old_heterogeneous(Properties& p, const VolumeDialect& dialect, MediumDescription& medium) {
  ExtinctionAlbedoDescription pair;
  const auto density = find_volume_input(p, "density", SpectrumRole::kIor, dialect);
  if (!density) p.fail("needs the <volume> 'density'", SceneErrorCode::kMissing);
  pair.sigma_t = *density;
  pair.albedo =
      volume_input(p, "albedo", std::get<SpectrumDescription>(pair.albedo), SpectrumRole::kReflectance, dialect);
  medium.coefficients = std::move(pair);
  if (p.named_object("volume", "orientation") != nullptr)
    p.fail(
        "has the unsupported <volume> 'orientation', expected fiber directions in the matrices of the phase function "
        "'sggx'");
  static constexpr NameTable<bool> kMethods{{{"woodcock", false}, {"simpson", true}}};
  if (p.choice("method", kMethods, false)) {
    IntegratorSettings& integrator = p.context().description.integrator;
    integrator.medium_estimator = MediumEstimator::kMarching;
    integrator.step_size = p.number("step_size", integrator.step_size, kPositive);
  }
  p.ignore({"step_size"});
  read_medium_rest(p, dialect, medium);
}

/// Mitsuba 2 and later: the medium ends at the axis-aligned bounding box of its `sigma_t` volume. For a constant or a
/// number, this is the box around the transformed unit cube.
void end_at_bounds(Properties& p, MediumDescription& medium) {
  if (const auto* pair = std::get_if<ExtinctionAlbedoDescription>(&medium.coefficients))
    medium.density = find_volume_bounds(p, "sigma_t", pair->sigma_t);
}

void read_heterogeneous(Properties& p, const VolumeDialect& dialect, bool before_version_2, MediumDescription& medium) {
  // Some forks read files of the old version with the coefficients of the new one.
  const bool extinction = p.named_object("volume", "sigma_t") != nullptr;
  if (before_version_2 && !extinction) return read_old_heterogeneous(p, dialect, medium);
  read_coefficients(p, dialect, medium);
  if (!before_version_2) end_at_bounds(p, medium);
  read_medium_rest(p, dialect, medium);
}

constexpr NameTable<void (*)(Properties&, const VolumeDialect&, bool before_version_2, MediumDescription&)> kMedia{
    {{"heterogeneous", read_heterogeneous}, {"homogeneous", read_homogeneous}}};

}  // namespace

MediumId medium_of(const XmlElement& element, Reader& reader) {
  if (const auto known = find_read_medium(element, reader.context)) return *known;
  Properties p(element, reader.context);
  const VolumeDialect dialect{.bbox_of_file = reader.before_version_2, .may_move = true};
  MediumDescription medium;
  p.plugin(kMedia)(p, dialect, reader.before_version_2, medium);
  p.ignore({"has_spectral_extinction", "sample_emitters", "majorant_grid", "majorant_factor",
            "majorant_resolution_factor", "accel"});
  return add_medium(p, std::move(medium));
}

}  // namespace sheaf::mitsuba
