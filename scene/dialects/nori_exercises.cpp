// The Nori dialect: integrators of the course's first exercises, as white scenes in a light of their own, or in none.
#include "scene/dialects/nori.h"

#include <numbers>

namespace sheaf::nori {

namespace {

/// All shapes become white and diffuse, emit nothing and hold nothing; no light is left.
void make_white(Description& description) {
  MaterialDescription white;
  white.model = DiffuseDescription{SpectrumDescription::constant(1)};
  description.materials = {std::move(white)};
  const auto clear = [](std::vector<ShapeDescription>& shapes) {
    for (ShapeDescription& shape : shapes) {
      shape.material = MaterialId{0};
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
  description.integrator.max_depth = 2;
}

/// Each point's share of the sky, by the cosine: a white surface under a sky of radiance 1 that the camera does not
/// see.
void make_ambient_occlusion(Description& description) {
  make_white(description);
  description.lights.push_back({ConstantLightDescription{}, {}});
  description.integrator.strategy = LightStrategy::kBsdfOnly;
  description.integrator.hide_emitters = true;
}

/// The share of the directions around each point's normal, all alike, in which nothing is nearer than `length`; 1 where
/// the camera sees nothing.
void make_average_visibility(Properties& p, Description& description) {
  const auto length = p.find_number("length", kPositive);
  if (!length) p.fail("needs the number 'length'");
  make_white(description);
  description.integrator.kind = IntegratorKind::kVisibility;
  description.integrator.visibility_length = *length;
}

/// `energy` (W) from `position` in all directions.
void make_simple(Properties& p, Description& description) {
  PointLightDescription light;
  light.position = p.vec3("position", {0, 0, 0});
  light.intensity = scaled(p.spectrum("energy", SpectrumDescription::constant(1), SpectrumRole::kEmission),
                           1.0f / (4.0f * std::numbers::pi_v<float>));
  make_white(description);
  description.lights.push_back({std::move(light), p.where()});
}

}  // namespace

bool read_exercise(Properties& p) {
  Description& description = p.context().description;
  if (p.type() == "ao") {
    make_ambient_occlusion(description);
  } else if (p.type() == "av") {
    make_average_visibility(p, description);
  } else if (p.type() == "simple") {
    make_simple(p, description);
  } else {
    return false;
  }
  return true;
}

}  // namespace sheaf::nori
