// The pbrt dialect: media.
#include "scene/data/measured_media.h"
#include "scene/dialects/pbrt/reader.h"
#include "scene/formats/sparse_volume.h"

namespace sheaf::pbrt {

namespace {

SpectrumDescription read_coefficient(Parameters& p, const char* name, SpectrumDescription default_value) {
  return find_spectrum(p, name, Use::kUnbounded).value_or(std::move(default_value));
}

/// Reads `g` as a Henyey-Greenstein phase function; nullopt for isotropic scattering.
std::optional<PhaseId> read_phase(Parameters& p) {
  const float g = p.number("g", 0, {-1, 1, true});
  if (g == 0.0f) return std::nullopt;
  Description& description = p.reader().description;
  description.phases.push_back({HenyeyGreensteinDescription{g}, p.where()});
  return static_cast<PhaseId>(description.phases.size() - 1);
}

void read_homogeneous(Parameters& p, MediumDescription& medium) {
  medium.coefficients = read_coefficients(p);
  medium.scale = p.number("scale", 1, kNotNegative);
  const float emission = p.number("Lescale", 1, kNotNegative);
  if (std::optional<SpectrumDescription> light = find_spectrum(p, "Le", Use::kLight))
    medium.emission = scaled(std::move(*light), emission);
}

void read_nanovdb(Parameters& p, MediumDescription& medium) {
  medium.coefficients = read_coefficients(p);
  medium.scale = p.number("scale", 1, kNotNegative);
  GridVolumeDescription density;
  density.file = p.file("filename");
  density.format = GridVolumeDescription::Format::kSparse;
  density.grid = p.string("gridname", "density");
  density.to_world = p.reader().attributes.transform.start;
  p.reader().note_rest(p.where(), "media");
  GridVolumeDescription temperature = density;
  temperature.grid = p.string("temperaturename", "temperature");
  medium.density = std::move(density);
  const float scale = p.number("LeScale", p.number("Lescale", 1, kNotNegative), kNotNegative);
  if (scale > 0.0f && has_sparse_grid(temperature.file, temperature.grid)) {
    set_temperature(p, medium, std::move(temperature), scale);
  } else {
    if (p.has("temperaturename") && scale > 0.0f)
      p.reader().note(p.where(),
                      fmt::format("{} does not emit: its file has no grid '{}'", p.title(), temperature.grid));
    p.ignore({"temperaturescale", "temperatureoffset", "temperaturecutoff"});
  }
}

}  // namespace

AbsorptionScatteringDescription read_coefficients(Parameters& p) {
  const SpectrumDescription one = SpectrumDescription::constant(1);
  const std::optional<std::string> preset = p.find_string("preset");
  if (!preset) return {read_coefficient(p, "sigma_a", one), read_coefficient(p, "sigma_s", one)};
  const MeasuredMedium* found = find_measured_medium(*preset);
  if (found == nullptr) {
    p.unsupported(fmt::format("the preset '{}'{}{}", *preset, did_you_mean(*preset, measured_medium_names()),
                              known_names(measured_medium_names())),
                  "rendered with sigma_a and sigma_s of 1");
    return {one, one};
  }
  p.ignore({"sigma_a", "sigma_s"});
  const auto rgb = [](Vec3f v) { return SpectrumDescription::rgb(v.x, v.y, v.z); };
  return {rgb(found->sigma_a), rgb(found->sigma_s)};
}

// pbrt normalizes blackbody spectra to a maximum of 1 at every temperature.
void set_temperature(Parameters& p, MediumDescription& medium, GridVolumeDescription temperature, float scale) {
  medium.temperature = std::move(temperature);
  medium.unit_blackbodies = true;
  medium.temperature_scale = p.number("temperaturescale", 1, kNotNegative);
  medium.temperature_offset = p.number(p.has("temperatureoffset") ? "temperatureoffset" : "temperaturecutoff", 0);
  p.ignore({"temperaturecutoff"});
  medium.emission_scale = scale * kLuminanceIntegral;
}

namespace {

constexpr NameTable<void (*)(Parameters&, MediumDescription&)> kMedia{{{"cloud", read_cloud},
                                                                       {"homogeneous", read_homogeneous},
                                                                       {"nanovdb", read_nanovdb},
                                                                       {"rgbgrid", read_rgb_grid},
                                                                       {"uniformgrid", read_uniform_grid}}};

}  // namespace

void read_medium(Reader& reader, const std::string& name, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("MakeNamedMedium '{}'", name), entity.where, std::move(entity.parameters));
  if (reader.media.contains(name)) p.fail("has the name of an earlier medium, expected another name");
  MediumDescription medium;
  medium.where = entity.where;
  medium.id = name;
  plugin(kMedia, "medium", entity.type, entity.where)(p, medium);
  medium.phase = read_phase(p);
  p.reject_unused();
  reader.description.media.push_back(std::move(medium));
  reader.media.emplace(name, static_cast<MediumId>(reader.description.media.size() - 1));
}

std::optional<MediumId> medium_of(const Reader& reader, const std::string& name, const SourceLocation& where) {
  if (name.empty()) return std::nullopt;
  const auto found = reader.media.find(name);
  if (found != reader.media.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& entry : reader.media) known.push_back(entry.first);
  throw SceneError(where, fmt::format("the medium '{}' is not defined yet{}", name, did_you_mean(name, known)));
}

}  // namespace sheaf::pbrt
