#include "scene/scene.h"

namespace sheaf {

SceneView Scene::make_view() const {
  SceneView v;
  v.geometry = geometry_.view();
  v.materials = materials_.view();
  v.textures = textures_.view(v.geometry.triangles, v.geometry.shape_count);
  v.lights = lights_.view();
  v.media = media_.view();
  v.motion = motion_.view();
  v.sensor = sensor_.view(film_.width);
  if (color_ == ColorMode::kSpectral) v.spectral = spectra_.view();
  v.accel = accel_.get();
  v.origin = origin_;
  v.center = center_;
  v.radius = radius_;
  v.needs_transmittance = needs_transmittance_;
  v.shadow_rays_pass_thin_dielectrics = shadow_rays_pass_thin_dielectrics_;
  v.light_selector = integrator_.light_selector;
  v.color = color_;
  return v;
}

SceneInfo Scene::info() const {
  SceneInfo info = counts_;
  info.table_bytes = geometry_.bytes() + materials_.bytes() + textures_.bytes() + lights_.bytes() + media_.bytes() +
                     motion_.bytes() + spectra_.bytes();
  info.accel_bytes = accel_->bytes();
  return info;
}

std::vector<MemoryUse> Scene::memory() const {
  const auto vertices = static_cast<double>(geometry_.vertices.capacity());
  const auto indices = static_cast<double>(bytes_of(geometry_.triangles));
  const auto tangents = static_cast<double>(bytes_of(geometry_.tangents));
  const double rest = static_cast<double>(geometry_.bytes()) - vertices * sizeof(VertexRow) - indices - tangents;
  std::vector<MemoryUse> uses;
  const auto add = [&](const char* what, double bytes) { uses.push_back({what, bytes, {}}); };
  add("positions", vertices * sizeof(Vec3f));
  add("normals", vertices * sizeof(Vec3f));
  add("texture coordinates", vertices * sizeof(Vec2f));
  if (tangents > 0) add("tangents", tangents);
  add("vertex indices", indices);
  add("shapes and instances", rest);
  add("BVH", accel_ != nullptr ? static_cast<double>(accel_->bytes()) : 0.0);
  add("textures", static_cast<double>(textures_.bytes()));
  add("lights", static_cast<double>(lights_.bytes()));
  add("media", static_cast<double>(media_.bytes()));
  if (motion_.bytes() > 0) add("motion", static_cast<double>(motion_.bytes()));
  add("materials and spectra", static_cast<double>(materials_.bytes() + spectra_.bytes()));
  return uses;
}

}  // namespace sheaf
