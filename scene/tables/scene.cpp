#include "scene/tables/scene.h"

namespace sheaf {

SceneView Scene::view() const {
  SceneView v;
  v.geometry = geometry_.view();
  v.materials = materials_.view();
  v.textures = textures_.view(v.geometry.triangles, v.geometry.shape_count);
  v.lights = lights_.view();
  v.media = media_.view();
  v.sensor = sensor_.view(film_.width);
  if (color_ == ColorMode::kSpectral) v.spectral = spectra_.view();
  v.accel = accel_.get();
  v.center = center_;
  v.radius = radius_;
  v.needs_transmittance = needs_transmittance_;
  v.has_open_panes = has_open_panes_;
  v.light_selector = integrator_.light_selector;
  v.color = color_;
  return v;
}

SceneInfo Scene::info() const {
  SceneInfo info = counts_;
  info.table_bytes =
      geometry_.bytes() + materials_.bytes() + textures_.bytes() + lights_.bytes() + media_.bytes() + spectra_.bytes();
  info.accel_bytes = accel_->bytes();
  return info;
}

}  // namespace sheaf
