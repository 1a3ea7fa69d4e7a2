// The pbrt dialect: material "subsurface". A random walk in the scattering medium replaces pbrt's tabulated BSSRDF.
#include "scene/data/measured_media.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

constexpr float kShortestPath = 1e-9f;

/// Applies f to the values of a spectrum.
template <class F> SpectrumDescription mapped_values(SpectrumDescription spectrum, F&& f) {
  using S = SpectrumDescription;
  if (auto* gray = std::get_if<S::Constant>(&spectrum.value)) gray->value = f(gray->value);
  if (auto* rgb = std::get_if<S::Rgb>(&spectrum.value))
    rgb->value = {f(rgb->value.x), f(rgb->value.y), f(rgb->value.z)};
  if (auto* table = std::get_if<S::Table>(&spectrum.value))
    std::transform(table->values.begin(), table->values.end(), table->values.begin(), f);
  return spectrum;
}

/// Reads a constant spectrum; textures are unsupported.
std::optional<SpectrumDescription> find_constant(Parameters& p, const char* name, Use use) {
  const std::optional<SpectrumInput> input = find_spectrum_input(p, name, use);
  if (!input) return std::nullopt;
  if (const auto* spectrum = std::get_if<SpectrumDescription>(&*input)) return *spectrum;
  p.unsupported(fmt::format("a texture of '{}'", name), "rendered as 0.5");
  return SpectrumDescription::constant(0.5f);
}

/// Internal diffuse reflectance of a boundary with relative index `eta` (a fit by Egan and Hilgeman 1973).
float internal_reflectance(float eta) {
  return eta > 1 ? std::clamp(-1.4399f / (eta * eta) + 0.7099f / eta + 0.6681f + 0.0636f * eta, 0.0f, 1.0f) : 0.0f;
}

/// Returns the single-scattering albedo of a thick medium with diffuse reflectance `reflectance` (Kulla and Conty,
/// "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course, after van de Hulst). `internal`: the
/// fraction of light from within that the boundary reflects.
float albedo_of(float reflectance, float internal, float g) {
  const float r = std::clamp(reflectance, 0.0f, 0.9999f), a = r / (1 - internal + r * internal);
  const float s = 4.09712f + 4.20863f * a - std::sqrt(9.59217f + 41.6808f * a + 17.7126f * a * a);
  return std::clamp((1 - s * s) / (1 - g * s * s), 0.0f, 1.0f);
}

void set_by_name(Parameters& p, MediumDescription& medium, const std::string& name) {
  const MeasuredMedium* found = find_measured_medium(name);
  if (found == nullptr) {
    p.unsupported(fmt::format("the medium '{}'{}", name, did_you_mean(name, measured_medium_names())),
                  "rendered as 'skin1'");
    found = find_measured_medium("skin1");
  }
  const auto rgb = [](Vec3f v) { return SpectrumDescription::rgb(v.x, v.y, v.z); };
  medium.coefficients = AbsorptionScatteringDescription{rgb(found->sigma_a), rgb(found->sigma_s)};
  p.ignore({"sigma_a", "sigma_s", "reflectance", "mfp"});
}

void set_by_reflectance(Parameters& p, MediumDescription& medium, const SpectrumDescription& reflectance, float eta,
                        float g) {
  const float internal = internal_reflectance(eta);
  const auto mfp = find_constant(p, "mfp", Use::kUnbounded).value_or(SpectrumDescription::constant(1));
  medium.coefficients =
      ExtinctionAlbedoDescription{mapped_values(mfp, [](float length) { return 1 / std::max(length, kShortestPath); }),
                                  mapped_values(reflectance, [&](float r) { return albedo_of(r, internal, g); })};
  medium.scale = 1 / medium.scale;  // `scale` multiplies the mean free path
}

}  // namespace

MediumId read_subsurface(Parameters& p, float eta) {
  MediumDescription medium;
  medium.where = p.where();
  medium.scale = p.number("scale", 1, kPositive);
  const float g = p.number("g", 0, {-1, 1, true});
  // Read the coefficients
  const std::optional<std::string> name = p.find_string("name");
  const auto sigma_a = find_constant(p, "sigma_a", Use::kUnbounded),
             sigma_s = find_constant(p, "sigma_s", Use::kUnbounded);
  const auto reflectance = find_constant(p, "reflectance", Use::kReflectance);
  if (name) {
    set_by_name(p, medium, *name);
  } else if (sigma_a || sigma_s) {
    if (!sigma_a || !sigma_s)
      p.fail(fmt::format("has only '{}', expected 'sigma_a' and 'sigma_s'", sigma_a ? "sigma_a" : "sigma_s"));
    if (reflectance) p.fail_at("reflectance", "is set together with 'sigma_a' and 'sigma_s', expected one of them");
    medium.coefficients = AbsorptionScatteringDescription{*sigma_a, *sigma_s};
  } else if (reflectance) {
    set_by_reflectance(p, medium, *reflectance, eta, g);
  } else {
    medium.coefficients = AbsorptionScatteringDescription{SpectrumDescription::rgb(0.0011f, 0.0024f, 0.014f),
                                                          SpectrumDescription::rgb(2.55f, 3.21f, 3.77f)};
  }
  Description& description = p.reader().description;
  // Append the phase function and the medium
  if (g != 0.0f && !name) {
    description.phases.push_back({HenyeyGreensteinDescription{g}, p.where()});
    medium.phase = static_cast<PhaseId>(description.phases.size() - 1);
  }
  p.reader().note_once(p.where(), p.title() +
                                      " rendered as a dielectric around a scattering medium: its shapes must be "
                                      "closed, and 'maxdepth' counts every scattering event");
  description.media.push_back(std::move(medium));
  return static_cast<MediumId>(description.media.size() - 1);
}

}  // namespace sheaf::pbrt
