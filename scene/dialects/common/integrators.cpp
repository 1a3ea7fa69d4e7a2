#include "scene/dialects/common/integrators.h"

#include <string>
#include <utility>
#include <variant>

namespace sheaf {

void apply(const IntegratorMatch& found, IntegratorSettings& integrator) {
  const IntegratorEntry& entry = *found.entry;
  PhotonMappingSettings& photons = integrator.photons;
  if (entry.is_progressive && !photons.progressive) {
    photons.gathering = PhotonGathering::kIndirect;
    if (!integrator.traits().has_photon_maps()) photons.global = {250'000, 0, 0};
  }
  photons.progressive = entry.is_progressive;
  integrator.given_name = found.name;
  integrator.kind = entry.kind;
  integrator.strategy = entry.strategy;
  integrator.thin_dielectrics_are_free = entry.thin_dielectrics_are_free;
  integrator.ends_at_diffuse = entry.ends_at_diffuse;
  if (entry.candidates > 1) integrator.candidates = entry.candidates;
  if (entry.is_direct) integrator.max_depth = 2;
}

namespace {

constexpr const char* kLessNoise = "--caustics mnee or --integrator sppm render caustics with less noise";

std::string substitution_note(std::string_view name, const IntegratorMatch& found) {
  if (found.substitution == Substitution::kNoisier)
    return fmt::format("integrator '{}' is not supported: rendered with '{}', which has the same expectation; {}", name,
                       found.name, kLessNoise);
  return fmt::format("integrator '{}' is rendered with '{}', which has the same expectation", name, found.name);
}

}  // namespace

void report_substitution(const SourceLocation& where, std::string_view name, const IntegratorMatch& found,
                         Remarks& remarks) {
  if (!found.is_substitute()) return;
  const bool is_noisier = found.substitution == Substitution::kNoisier;
  (is_noisier ? remarks.warnings : remarks.notes).push_back(SceneError(where, substitution_note(name, found)).what());
}

IntegratorMatch integrator_or_path(Properties& p, const std::vector<std::string>& others) {
  if (const auto found = find_integrator(p.type())) return *found;
  std::vector<std::string> known = integrator_names();
  for (const std::string& other : others)
    if (!find_integrator(other)) known.push_back(other);
  constexpr const char* kDefault = "path";
  try {
    p.fail_plugin(std::move(known));
  } catch (const SceneError& error) { p.replace_plugin(error, kDefault); }
  return *find_integrator(kDefault);
}

void make_white(Description& description, bool two_sided) {
  const std::vector<MaterialDescription> before = std::move(description.materials);
  description.materials.clear();
  const auto add = [&](decltype(MaterialDescription::model) model) {
    description.materials.emplace_back().model = std::move(model);
    return static_cast<MaterialId>(description.materials.size() - 1);
  };
  MaterialId white = add(DiffuseDescription{SpectrumDescription::constant(1)});
  if (two_sided) white = add(TwoSidedDescription{white, white});
  const auto is_boundary = [&](const ShapeDescription& shape) {
    return shape.material &&
           std::holds_alternative<NullDescription>(before[static_cast<std::size_t>(*shape.material)].model);
  };
  // Null interfaces have no media any more.
  std::erase_if(description.shapes, is_boundary);
  const auto clear = [&](std::vector<ShapeDescription>& shapes) {
    for (ShapeDescription& shape : shapes) {
      shape.material = white;
      shape.radiance.reset();
      shape.interior.reset();
      shape.exterior.reset();
      shape.exterior_is_surrounding = false;
    }
  };
  clear(description.shapes);
  for (ShapeGroup& group : description.groups) clear(group.shapes);
  description.media.clear();
  description.phases.clear();
  description.textures.clear();
  description.lights.clear();
  description.camera.medium.reset();
  for (CameraDescription& camera : description.more_cameras) camera.medium.reset();
  description.integrator = IntegratorSettings();
  description.integrator.max_depth = 2;
}

void white_scene(const IntegratorMatch& found, float length, bool two_sided, Description& description) {
  make_white(description, two_sided);
  IntegratorSettings& integrator = description.integrator;
  apply(found, integrator);
  if (integrator.traits().measures_visibility) {
    integrator.visibility_length = length;
    return;
  }
  // A white surface under a sky of radiance 1 that is hidden from the camera.
  description.lights.push_back({ConstantLightDescription{}, {}});
  integrator.hide_emitters = true;
}

void apply_integrator_name(std::string_view name, bool lenient, Description& description) {
  const std::optional<IntegratorMatch> found = find_integrator(name);
  if (!found)
    throw Error(ExitCode::kUsage, fmt::format("unknown integrator '{}'{}{}", name,
                                              did_you_mean(name, integrator_names()), known_names(integrator_names())));
  const bool is_noisier = found->substitution == Substitution::kNoisier;
  if (is_noisier && !lenient)
    throw Error(ExitCode::kUsage,
                fmt::format("integrator '{}' is not supported; {}; '{}' has the same expectation (--lenient uses it)",
                            name, kLessNoise, found->name));
  if (found->entry->whitens_scene)
    return white_scene(*found, description.integrator.visibility_length, true, description);
  apply(*found, description.integrator);
  if (found->is_substitute())
    (is_noisier ? description.warnings : description.notes).push_back(substitution_note(name, *found));
}

}  // namespace sheaf
