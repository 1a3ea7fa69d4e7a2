// The Nori dialect: integrators of the course's first exercises, rendered as white scenes with their own light or none.
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/nori/reader.h"

#include <numbers>

namespace sheaf::nori {

namespace {

/// Reads `simple`: an isotropic point light of power `energy` (W) at `position`.
void make_simple(Properties& p, Description& description) {
  PointLightDescription light;
  light.position = p.point("position", {0, 0, 0});
  light.intensity = scaled(p.spectrum("energy", SpectrumDescription::constant(1), SpectrumRole::kEmission),
                           1.0f / (4.0f * std::numbers::pi_v<float>));
  make_white(description, false);
  description.integrator.given_name = "simple";
  description.lights.push_back({std::move(light), p.where()});
}

}  // namespace

constexpr NameTable<ExerciseReader> kExercises{{{"simple", make_simple}}};

bool read_exercise(Properties& p) {
  Description& description = p.context().description;
  if (const auto* read = kExercises.find(p.type())) {
    (*read)(p, description);
  } else if (const auto found = find_integrator(p.type()); found && found->entry->whitens_scene) {
    const auto length = p.find_number("length", kPositive);
    if (traits_of(found->entry->kind).measures_visibility && !length)
      p.fail("needs the float 'length'", SceneErrorCode::kMissing);
    white_scene(*found, length.value_or(kInfinity), false, description);
  } else {
    return false;
  }
  return true;
}

}  // namespace sheaf::nori
