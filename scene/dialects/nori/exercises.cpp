// The Nori dialect: integrators of the course's first exercises, rendered as white scenes with their own light or none.
#include "scene/dialects/common/visibility_integrators.h"
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
  description.lights.push_back({std::move(light), p.where()});
}

}  // namespace

constexpr NameTable<ExerciseReader> kExercises{{{"simple", make_simple}}};

bool read_exercise(Properties& p) {
  Description& description = p.context().description;
  if (const auto* read = kExercises.find(p.type())) {
    (*read)(p, description);
  } else if (const Visibility* visibility = kVisibilityIntegrators.find(p.type())) {
    const auto length = p.find_number("length", kPositive);
    if (*visibility == Visibility::kAverage && !length) p.fail("needs the float 'length'");
    apply_visibility_integrator(*visibility, length.value_or(kInfinity), false, description);
  } else {
    return false;
  }
  return true;
}

}  // namespace sheaf::nori
