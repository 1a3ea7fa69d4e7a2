// Ambient occlusion and average visibility, rendered in scenes of white surfaces.
#include "scene/dialects/common/visibility_integrators.h"

#include <utility>
#include <variant>

namespace sheaf {

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

void apply_visibility_integrator(Visibility visibility, float length, bool two_sided, Description& description) {
  make_white(description, two_sided);
  IntegratorSettings& integrator = description.integrator;
  if (visibility == Visibility::kAverage) {
    integrator.kind = IntegratorKind::kVisibility;
    integrator.visibility_length = length;
    return;
  }
  // A white surface under a sky of radiance 1 that is hidden from the camera.
  description.lights.push_back({ConstantLightDescription{}, {}});
  integrator.strategy = LightStrategy::kBsdfOnly;
  integrator.hide_emitters = true;
}

}  // namespace sheaf
