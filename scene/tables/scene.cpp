#include "scene/tables/scene.h"

namespace sheaf {

namespace {
template <class Table> std::size_t bytes_of(const Table& table) {
  return table.capacity() * sizeof(typename Table::value_type);
}
}  // namespace

SceneView Scene::view() const {
  SceneView v;
  v.shapes = shapes_.data();
  v.vertices = vertices_.data();
  v.triangles = triangles_.data();
  v.quadrics = quadrics_.data();
  v.curve_points = curve_points_.data();
  v.curve_segments = curve_segments_.data();
  v.sdf_grids = sdf_grids_.data();
  v.sdf_values = sdf_values_.data();
  v.sdf_cells = sdf_cells_.data();
  v.instances = instances_.empty() ? nullptr : instances_.data();
  v.materials = materials_.data();
  v.bindings = bindings_.data();
  v.normal_maps = normal_maps_.data();
  v.closure_tables = closure_tables_.empty() ? nullptr : closure_tables_.data();
  v.textures = {textures_.rows.data(),     textures_.tiles.get(),
                attributes_.data(),        attribute_values_.data(),
                triangles_.data(),         attributes_.empty() ? 0u : static_cast<std::uint32_t>(shapes_.size()),
                textures_.grid_rows.data()};
  v.media = media_.data();
  v.boundaries = boundaries_.data();
  v.grids = {grid_rows_.data()};
  v.majorant_grids = majorant_rows_.data();
  v.blackbodies = blackbodies_ ? &*blackbodies_ : nullptr;
  v.needs_transmittance = has_transparency_;
  v.shadow_rays_pass_thin_dielectrics = shadow_rays_pass_thin_dielectrics_;
  v.camera_medium = camera_medium_;
  v.outer_medium = outer_medium_;
  v.lights = lights_.data();
  v.light_alias = light_alias_.data();
  v.light_tree = light_tree_.view();
  v.bounded_light_count = bounded_light_count_;
  v.triangle_alias = triangle_alias_.data();
  v.light_triangles = light_triangles_.data();
  v.light_frames = light_frames_.data();
  v.light_uvs = light_uvs_.data();
  v.light_powers = light_powers_.data();
  v.envmap = envmap_.view();
  v.has_textured_lights = has_textured_lights_;
  v.shape_count = static_cast<std::uint32_t>(shapes_.size());
  v.material_count = static_cast<std::uint32_t>(materials_.size());
  v.light_count = static_cast<std::uint32_t>(lights_.size());
  v.bucket_count = bucket_count_;
  std::copy(std::begin(bucket_begin_), std::end(bucket_begin_), v.bucket_begin);
  std::copy(std::begin(kind_flags_), std::end(kind_flags_), v.kind_flags);
  v.has_composites = has_composites_;
  v.environment = environment_;
  v.center = center_;
  v.radius = radius_;
  v.medium_radius = medium_radius_;
  v.camera = camera_;
  v.more_cameras = more_cameras_.data();
  v.more_camera_count = static_cast<std::uint32_t>(more_cameras_.size());
  v.column_width = static_cast<float>(film_.width) / static_cast<float>(more_cameras_.size() + 1);
  v.filter = &filter_;
  if (filter_weights_) v.filter_weights = &*filter_weights_;
  v.light_selector = integrator_.light_selector;
  v.accel = accel_.get();
  v.color = color_;
  if (color_ == ColorMode::kSpectral)
    v.spectral = {{spectrum_tables_.data()}, material_spectra_.data(), light_spectra_.data(),
                  medium_spectra_.data(),    &UpliftTable::get(),      &SensorCurves::get()};
  return v;
}

SceneInfo Scene::info() const {
  SceneInfo info = counts_;
  info.table_bytes =
      bytes_of(shapes_) + bytes_of(vertices_) + bytes_of(triangles_) + bytes_of(quadrics_) + bytes_of(curve_points_) +
      bytes_of(curve_segments_) + bytes_of(sdf_grids_) + bytes_of(sdf_values_) + bytes_of(sdf_cells_) +
      bytes_of(instances_) + bytes_of(materials_) + bytes_of(bindings_) + bytes_of(normal_maps_) +
      bytes_of(closure_tables_) + bytes_of(textures_.rows) + textures_.tile_count * sizeof(TexelTile) +
      bytes_of(attributes_) + bytes_of(attribute_values_) + bytes_of(lights_) + bytes_of(light_alias_) +
      bytes_of(triangle_alias_) + bytes_of(light_triangles_) + bytes_of(light_frames_) + bytes_of(light_uvs_) +
      bytes_of(light_powers_) + bytes_of(light_tree_.nodes) + bytes_of(light_tree_.trails) + envmap_.bytes() +
      bytes_of(spectrum_tables_) + bytes_of(material_spectra_) + bytes_of(light_spectra_) + bytes_of(medium_spectra_) +
      bytes_of(media_) + bytes_of(boundaries_);
  for (const BrickGrid& grid : grids_) info.table_bytes += grid.bytes();
  for (const BrickGrid& grid : textures_.grids) info.table_bytes += grid.bytes();
  for (const MajorantGrid& grid : majorant_grids_) info.table_bytes += grid.bytes();
  info.accel_bytes = accel_->bytes();
  return info;
}

}  // namespace sheaf
