#include "scene/compile/move_camera.h"

#include "scene/compile/compile_camera.h"
#include "scene/compile/media/medium_probe.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Finds the medium in which the rays of the camera start, over the shutter.
void probe_camera(const CameraDescription& camera, SceneTables& scene) {
  constexpr int kParts = 256;
  MediumTables& media = scene.media;
  if (media.boundaries.empty()) return;
  media.camera_media.clear();
  if (camera.medium) {
    media.camera_medium = static_cast<std::uint32_t>(*camera.medium) + 1;
    return;
  }
  const SceneView view = scene.view();
  const Vec3f start =
      scene.sensor.camera
          .ray<Scalar>(0.5f * static_cast<float>(scene.film.width), 0.5f * static_cast<float>(scene.film.height), 0, 0)
          .origin;
  const bool moves = !scene.motion.instances.empty() || !scene.motion.deformations.empty();
  const std::vector<TimedMedium> found = media_over_time(
      moves ? kParts : 0, [&](float time) { return medium_at(view, start, time, {}, media.outer_medium); });
  media.camera_medium = found[0].medium;
  if (found.size() == 1) return;
  for (const TimedMedium& from : found) media.camera_media.push_back({0, from.time, from.medium});
}

}  // namespace

void move_camera(const CameraDescription& camera, const FilmSettings& film, std::unique_ptr<Scene>& scene) {
  CameraDescription moved = camera;
  moved.to_world = Transform::translate(-scene->origin()) * camera.to_world;
  const Camera made = make_camera(moved, film.width, film.height);
  SceneTables tables = Scene::release(std::move(scene));
  tables.sensor.camera = made;
  tables.film = film;
  if (!tables.motion.cameras.empty()) tables.motion.cameras[0] = {};
  // Shadow rays to the environment end outside of everything, including the camera
  tables.radius = std::max(tables.radius, length(made.origin - tables.center));
  if (tables.media.outer_radius < kInfinity)
    tables.media.outer_radius = std::max(tables.media.outer_radius, 1.01f * tables.radius);
  probe_camera(camera, tables);
  scene = std::make_unique<Scene>(std::move(tables));
}

}  // namespace sheaf
