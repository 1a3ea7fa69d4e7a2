#include "scene/scene.h"

namespace sheaf {

SceneView SceneTables::view() const {
  SceneView v;
  v.geometry = geometry.view();
  v.materials = materials.view();
  v.textures = textures.view(v.geometry.triangles, v.geometry.shape_count);
  v.lights = lights.view();
  v.media = media.view();
  v.motion = motion.view();
  v.sensor = sensor.view(film.width);
  if (color == ColorMode::kSpectral) v.spectral = spectra.view(!textures.rows.empty());
  v.accel = accel.get();
  v.origin = origin;
  v.center = center;
  v.radius = radius;
  v.needs_transmittance = needs_transmittance;
  v.shadow_rays_pass_thin_dielectrics = shadow_rays_pass_thin_dielectrics;
  v.light_selector = integrator.light_selector;
  v.color = color;
  return v;
}

SceneInfo Scene::info() const {
  const SceneTables& t = tables_;
  SceneInfo info = t.info;
  info.table_bytes = t.geometry.bytes() + t.materials.bytes() + t.textures.bytes() + t.lights.bytes() +
                     t.media.bytes() + t.motion.bytes() + t.spectra.bytes();
  info.accel_bytes = t.accel->bytes();
  return info;
}

std::vector<MemoryUse> Scene::memory() const {
  const SceneTables& t = tables_;
  const auto vertices = static_cast<double>(t.geometry.vertices.capacity());
  const auto indices = static_cast<double>(bytes_of(t.geometry.triangles));
  const auto tangents = static_cast<double>(bytes_of(t.geometry.tangents));
  const double rest = static_cast<double>(t.geometry.bytes()) - vertices * sizeof(VertexRow) - indices - tangents;
  std::vector<MemoryUse> uses;
  const auto add = [&](const char* what, double bytes) { uses.push_back({what, bytes, {}}); };
  add("positions", vertices * sizeof(Vec3f));
  add("normals", vertices * sizeof(Vec3f));
  add("texture coordinates", vertices * sizeof(Vec2f));
  if (tangents > 0) add("tangents", tangents);
  add("vertex indices", indices);
  add("shapes and instances", rest);
  add("BVH", t.accel != nullptr ? static_cast<double>(t.accel->bytes()) : 0.0);
  add("textures", static_cast<double>(t.textures.bytes()));
  add("lights", static_cast<double>(t.lights.bytes()));
  add("media", static_cast<double>(t.media.bytes()));
  if (t.motion.bytes() > 0) add("motion", static_cast<double>(t.motion.bytes()));
  add("materials and spectra", static_cast<double>(t.materials.bytes() + t.spectra.bytes()));
  return uses;
}

}  // namespace sheaf
