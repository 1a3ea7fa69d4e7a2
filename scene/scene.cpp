#include "scene/scene.h"

namespace sheaf {

namespace {
template <class T> std::size_t bytes_of(const std::vector<T>& v) { return v.capacity() * sizeof(T); }
}  // namespace

SceneView Scene::view() const {
  SceneView v;
  v.shapes = shapes_.data();
  v.positions = positions_.data();
  v.normals = normals_.data();
  v.uvs = uvs_.data();
  v.triangles = triangles_.data();
  v.quadrics = quadrics_.data();
  v.materials = materials_.data();
  v.lights = lights_.data();
  v.light_alias = light_alias_.data();
  v.triangle_alias = triangle_alias_.data();
  v.light_triangles = light_triangles_.data();
  v.shape_count = static_cast<std::uint32_t>(shapes_.size());
  v.material_count = static_cast<std::uint32_t>(materials_.size());
  v.light_count = static_cast<std::uint32_t>(lights_.size());
  v.bucket_count = bucket_count_;
  std::copy(std::begin(bucket_begin_), std::end(bucket_begin_), v.bucket_begin);
  v.environment = environment_;
  v.center = center_;
  v.radius = radius_;
  v.seed = sampler_.seed;
  v.camera = camera_;
  v.filter = &filter_;
  v.integrator = integrator_;
  v.accel = accel_.get();
  return v;
}

SceneInfo Scene::info() const {
  SceneInfo info = counts_;
  info.table_bytes = bytes_of(shapes_) + bytes_of(positions_) + bytes_of(normals_) + bytes_of(uvs_) +
                     bytes_of(triangles_) + bytes_of(quadrics_) + bytes_of(materials_) + bytes_of(lights_) +
                     bytes_of(light_alias_) + bytes_of(triangle_alias_) + bytes_of(light_triangles_);
  info.accel_bytes = accel_->bytes();
  return info;
}

}  // namespace sheaf
