// Finds the media around shapes, around the scene and around the cameras, by probe rays.
#include "scene/compile/media/compile_media.h"
#include "scene/compile/media/medium_probe.h"
#include "scene/tables/motion_sample.h"

#include <algorithm>
#include <span>

namespace sheaf {

namespace {

/// Whether a shape that bounds a medium moves or deforms.
bool boundaries_move(const CompiledGeometry& geometry, const GeometryTables& tables) {
  const auto bounds = [](const ShapeRow& shape) { return shape.boundary != kNone; };
  for (const BoundaryShape& boundary : geometry.boundaries)
    if (tables.shapes[boundary.shape].flags >> kDeformationShift != 0) return true;
  for (const MovingInstance& moving : geometry.moving_instances) {
    const ShapeRange& range = geometry.groups[tables.instances[moving.instance].group];
    const auto first = tables.shapes.begin() + range.first_shape;
    if (std::any_of(first, first + range.shape_count, bounds)) return true;
  }
  return false;
}

/// The shapes whose exterior is the medium that contains them, each where its instances place it, or some of them.
/// `max_probes`: of all shapes and instances together.
std::vector<PlacedShape> surrounded_shapes(const CompiledGeometry& geometry,
                                           const std::vector<InstanceRow>& all_instances, std::size_t max_probes) {
  constexpr std::size_t kMaxInstances = 1024;
  std::vector<std::uint32_t> shapes;
  for (const BoundaryShape& boundary : geometry.boundaries)
    if (geometry.sources[boundary.shape].shape->exterior_is_surrounding) shapes.push_back(boundary.shape);
  std::vector<PlacedShape> placed;
  if (shapes.empty()) return placed;
  std::vector<std::vector<std::uint32_t>> instances(geometry.groups.size());
  for (std::uint32_t i = 0; i < all_instances.size(); ++i) instances[all_instances[i].group].push_back(i);
  const std::size_t fraction = std::clamp<std::size_t>(max_probes / shapes.size(), 1, kMaxInstances);
  for (const std::uint32_t shape : shapes) {
    if (shape < geometry.ungrouped_shapes) {
      placed.push_back({shape, kNone});
      continue;
    }
    const auto starts_behind = [](std::uint32_t index, const ShapeRange& range) { return index < range.first_shape; };
    const auto group = std::upper_bound(geometry.groups.begin(), geometry.groups.end(), shape, starts_behind) - 1;
    const std::vector<std::uint32_t>& all = instances[static_cast<std::size_t>(group - geometry.groups.begin())];
    const std::size_t count = std::min(all.size(), fraction);
    for (std::size_t k = 0; k < count; ++k) placed.push_back({shape, all[k * all.size() / count]});
  }
  return placed;
}

/// Finds the media around the shapes that do not name theirs, for each of their instances and over the shutter.
/// `default_value`: the medium outside of all shapes.
void probe_surroundings(const CompiledGeometry& geometry, std::uint32_t default_value, SceneTables& scene) {
  // Probes of all shapes, instances and times, and limits on the number of times
  constexpr std::size_t kMaxProbes = 1 << 14, kMinParts = 8, kMaxParts = 256;
  const std::vector<PlacedShape> placed = surrounded_shapes(geometry, scene.geometry.instances, kMaxProbes);
  if (placed.empty()) return;
  const std::size_t parts =
      boundaries_move(geometry, scene.geometry) ? std::clamp(kMaxProbes / placed.size(), kMinParts, kMaxParts) : 0;
  // Probe them
  const SceneView view = scene.view();
  std::vector<std::vector<TimedMedium>> media;
  for (const PlacedShape& at : placed)
    media.push_back(media_over_time(static_cast<int>(parts),
                                    [&](float time) { return medium_around(view, at, time, default_value); }));
  // Set the exterior of each shape, or a table if it differs between instances or times
  for (std::size_t first = 0, last = 0; first < placed.size(); first = last) {
    while (last < placed.size() && placed[last].shape == placed[first].shape) ++last;
    BoundaryRow& row = scene.media.boundaries[scene.geometry.shapes[placed[first].shape].boundary];
    row.exterior = media[first][0].medium;
    const auto is_same = [&](const std::vector<TimedMedium>& m) {
      return m.size() == 1 && m[0].medium == row.exterior;
    };
    if (std::all_of(media.begin() + std::ptrdiff_t(first), media.begin() + std::ptrdiff_t(last), is_same)) continue;
    row.first_surrounding = static_cast<std::uint32_t>(scene.media.surroundings.size());
    for (std::size_t i = first; i < last; ++i)
      for (const TimedMedium& from : media[i])
        scene.media.surroundings.push_back({placed[i].instance, from.time, from.medium});
    row.surrounding_count = static_cast<std::uint32_t>(scene.media.surroundings.size()) - row.first_surrounding;
  }
}

/// A part of the film and its camera, for the places where rays start.
struct CameraColumn {
  const Camera& camera;
  float width, height;

  Vec3f middle() const { return camera.ray<Scalar>(0.5f * width, 0.5f * height, 0, 0).origin; }
};

/// Whether the rays of a camera start in several media when the shutter opens.
bool starts_in_several_media(const SceneView& view, const CameraColumn& column, std::uint32_t default_value) {
  const Vec3f middle = column.middle();
  const std::uint32_t medium = medium_at(view, middle, 0, {}, default_value);
  constexpr Vec2<Scalar> kLens[] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  for (int position = 0; position < 9; ++position)
    for (const Vec2<Scalar> lens : std::span(kLens).first(column.camera.has_lens() ? 5 : 1)) {
      const float x = 0.5f * column.width * static_cast<float>(position % 3);
      const float y = 0.5f * column.height * static_cast<float>(position / 3);
      const Vec3f start = column.camera.ray<Scalar>(x, y, lens.x, lens.y).origin;
      if (start != middle && medium_at(view, start, 0, {}, default_value) != medium) return true;
    }
  return false;
}

/// Finds the media in which the rays of each camera start, over the shutter.
void probe_cameras(const Description& in, const CompiledGeometry& geometry, std::span<const CameraDescription> cameras,
                   std::uint32_t default_value, SceneTables& scene) {
  constexpr int kParts = 256;
  const SceneView view = scene.view();
  const auto columns = static_cast<float>(cameras.size());
  const bool all_move = boundaries_move(geometry, scene.geometry);
  std::vector<CameraMediumRow> rows;
  for (std::uint32_t i = 0; i < cameras.size(); ++i) {
    if (const auto named = cameras[i].medium ? cameras[i].medium : in.camera.medium) {
      rows.push_back({i, 0, static_cast<std::uint32_t>(*named) + 1});
      continue;
    }
    const CameraColumn column{scene.sensor.camera_of(i), static_cast<float>(scene.film.width) / columns,
                              static_cast<float>(scene.film.height)};
    const Vec3f middle = column.middle();
    const MotionRow motion = MotionCompiler::of(scene.motion.cameras, i);
    const auto at = [&](float time) {
      const Vec3f p =
          motion.segment_count == 0 ? middle : sample_motion<Scalar>(view.motion, motion, time).placed.point(middle);
      return medium_at(view, p, time, {}, default_value);
    };
    for (const TimedMedium& from : media_over_time(all_move || motion.segment_count > 0 ? kParts : 0, at))
      rows.push_back({i, from.time, from.medium});
    if (starts_in_several_media(view, column, default_value))
      scene.warnings.push_back(SceneError(cameras[i].where,
                                          "the camera's rays start in more than one medium: all are assumed to start "
                                          "in that of the middle one")
                                   .what());
  }
  scene.media.camera_medium = rows[0].medium;
  const auto is_same = [&](const CameraMediumRow& row) { return row.medium == rows[0].medium; };
  if (!std::all_of(rows.begin(), rows.end(), is_same)) scene.media.camera_media = std::move(rows);
}

}  // namespace

void probe_media(const Description& description, const CompiledGeometry& geometry,
                 std::span<const CameraDescription> cameras, SceneTables& scene) {
  MediumTables& media = scene.media;
  // Probe from the inside to the outside: rays from the cameras refer to the media around shapes
  const std::uint32_t default_value = media.camera_medium;
  media.outer_medium = default_value;
  if (!media.boundaries.empty()) {
    probe_surroundings(geometry, default_value, scene);
    media.outer_medium = medium_outside(scene.view(), default_value);
    probe_cameras(description, geometry, cameras, default_value, scene);
  }
  // Warn about missing light
  const bool by_photons = scene.integrator.traits().emits_photons();
  const std::uint32_t outer = media.outer_medium;
  if (by_photons && outer != 0 && (media.rows[outer - 1].flags & kMediumEmits) != 0)
    scene.warnings.push_back(SceneError(description.media[outer - 1].where,
                                        "photons do not carry the emission of an unbounded medium: its scattered "
                                        "light is missing")
                                 .what());
}

}  // namespace sheaf
