#include "scene/compile/compile_camera.h"

#include "core/math/frame.h"
#include "scene/description/field_of_view.h"
#include "scene/surfaces/shape.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

void check(const CameraDescription& d) {
  if (!(d.near_clip >= 0.0f && d.near_clip < d.far_clip))
    throw SceneError(d.where,
                     fmt::format("clip distances must be in order and not negative, found {} (near) and {} (far)",
                                 d.near_clip, d.far_clip));
  if (!(d.aperture_radius >= 0.0f && d.aperture_radius < kInfinity))
    throw SceneError(d.where, fmt::format("radius of the aperture must not be negative, found {}", d.aperture_radius));
  if (!(d.focus_distance > 0.0f))
    throw SceneError(d.where, fmt::format("focus distance must be positive, found {}", d.focus_distance));
}

/// Direction in world space of a vector in camera space, normalized. Throws SceneError if its length is zero or not
/// finite.
Vec3f unit_vector(const CameraDescription& d, Vec3f v) {
  const Vec3f world = d.to_world.vector(v);
  const float length = sheaf::length(world);
  if (!(length > 0.0f) || !std::isfinite(length)) throw SceneError(d.where, "the sensor's transform is singular");
  return world * (1.0f / length);
}

/// Sets the unit axes of camera space. Throws SceneError if they are not orthogonal.
void set_axes(Camera& camera, const CameraDescription& d) {
  camera.lens_x = unit_vector(d, {1, 0, 0});
  camera.lens_y = unit_vector(d, {0, 1, 0});
  camera.forward = unit_vector(d, {0, 0, 1});
  const float mixed =
      std::max({std::fabs(dot(camera.lens_x, camera.lens_y)), std::fabs(dot(camera.lens_y, camera.forward)),
                std::fabs(dot(camera.forward, camera.lens_x))});
  if (mixed > 1e-4f) throw SceneError(d.where, "a spherical camera is skewed by its transform (expected a rotation)");
}

/// Throws SceneError if the distortion is not monotonic on the film. `radius` is the largest tangent shown.
void check_distortion(const CameraDescription& d, double radius) {
  const double k1 = d.distortion[0], k2 = d.distortion[1];
  constexpr int kSteps = 4096;
  for (double r = 0; r * (1 + r * r * (k1 + r * r * k2)) < radius; r += radius / kSteps) {
    const double slope = 1 + r * r * (3 * k1 + r * r * 5 * k2);
    if (!(slope > 1e-3))
      throw SceneError(d.where, fmt::format("the distortion 'kc' folds the image on the film, at the tangent {}", r));
  }
}

/// Sensors that measure along one or more rays and form no image.
Camera make_meter(const CameraDescription& d, int width, int height) {
  using Projection = CameraDescription::Projection;
  Camera camera;
  camera.near_clip = d.near_clip;
  camera.clip_range = d.far_clip - d.near_clip;
  camera.sees_points = false;
  camera.origin = d.to_world.point({0, 0, 0});
  camera.corner = unit_vector(d, {0, 0, 1});
  if (d.projection != Projection::kIrradianceMeter) return camera;
  const Vec3f x = d.to_world.vector({1, 0, 0}), y = d.to_world.vector({0, 1, 0});
  const auto frame = Frame<Scalar>::from_normal(normalize(d.to_world.normal({0, 0, 1})));
  const float extent = max_component(abs(camera.origin)) + max_component(abs(x)) + max_component(abs(y));
  camera.origin = camera.origin - x - y + frame.n * (4 * kOffsetUlps * extent);
  camera.origin_dx = x * (2.0f / static_cast<float>(width));
  camera.origin_dy = y * (2.0f / static_cast<float>(height));
  camera.lens_x = frame.s;
  camera.lens_y = frame.t;
  camera.corner = frame.n;
  camera.rays = CameraRays::kHemisphere;
  camera.weight = kPi;
  return camera;
}

Camera make_spherical(const CameraDescription& d, int width, int height) {
  Camera camera;
  camera.near_clip = d.near_clip;
  camera.clip_range = d.far_clip - d.near_clip;
  camera.rays = d.equal_area ? CameraRays::kEqualArea : CameraRays::kSpherical;
  camera.origin = d.to_world.point({0, 0, 0});
  set_axes(camera, d);
  camera.film_step = {1.0f / static_cast<float>(width), 1.0f / static_cast<float>(height)};
  return camera;
}

/// The vector whose dot product with a point relative to the origin is the point's z: normal to the film, with dot
/// product 1 with `corner`.
Vec3f z_axis_of(const Camera& camera) {
  const Vec3f across = cross(camera.origin_dx + camera.dx, camera.origin_dy + camera.dy);
  return across * (1.0f / dot(across, camera.corner));
}

/// The camera when the shutter opens. Adds its motion from there.
CameraDescription at_open(CameraDescription camera, std::size_t index, MotionCompiler& motion) {
  const AnimatedTransform* transform = motion.transform(camera.motion);
  if (transform == nullptr) return camera;
  try {
    camera.to_world = transform->at(motion.shutter().open);
    // Directions must be accurate to a fraction of a pixel
    constexpr double kMaxDirectionError = 2e-5;
    MotionProbes probes = MotionProbes::of_directions(kMaxDirectionError);
    probes.add_point(camera.to_world.point({0, 0, 0}));
    const auto steps = tabulate_motion({*transform, camera.to_world.inverse()}, probes, motion.shutter());
    if (steps.size() > 1) MotionCompiler::set(motion.tables().cameras, index, motion.add(steps));
  } catch (const SceneError& error) { throw at_location(camera.where, error); }
  return camera;
}

}  // namespace

CompiledCameras compile_cameras(const Description& in, const SceneSettings& settings, MotionCompiler& motion,
                                ErrorSink& errors) {
  const FilmSettings& film = settings.film;
  CompiledCameras out;
  SensorTables& sensor = out.tables;
  const auto count = static_cast<int>(in.more_cameras.size()) + 1;
  if (film.width % count != 0)
    throw SceneError(
        in.camera.where,
        fmt::format("the film's width of {} pixels is not a multiple of the number of cameras, {}", film.width, count));
  // Place the cameras
  out.at_open.push_back(at_open(in.camera, 0, motion));
  for (const CameraDescription& camera : in.more_cameras)
    out.at_open.push_back(at_open(camera, out.at_open.size(), motion));
  sensor.more_cameras.resize(in.more_cameras.size());
  for (std::size_t i = 0; i < out.at_open.size(); ++i) {
    CameraDescription& camera = out.at_open[i];
    const int width = film.width / count, height = film.height;
    try {
      sensor.camera_of(i) = make_camera(camera, width, height);
    } catch (const SceneError& error) {
      errors.report(error, "rendered with the default lens and clip distances");
      const CameraDescription standard;
      camera.near_clip = standard.near_clip;
      camera.far_clip = standard.far_clip;
      camera.fov = standard.fov;
      sensor.camera_of(i) = make_camera(camera, width, height);
    }
  }
  sensor.pixel_cone = pixel_cone_of(sensor.camera, film.width / count, film.height);
  for (const Camera& camera : sensor.more_cameras) {
    const PixelCone other = pixel_cone_of(camera, film.width / count, film.height);
    sensor.pixel_cone = {std::min(sensor.pixel_cone.width, other.width),
                         std::min(sensor.pixel_cone.spread, other.spread)};
  }
  if (settings.integrator.traits().connects_photons() && (count > 1 || !sensor.camera.sees_points))
    throw SceneError(
        in.camera.where,
        "light tracing needs a single camera that forms an image: photons cannot be connected to this sensor");
  // Tabulate the pixel filter
  const bool weighted = film.filter_mode == FilterMode::kWeighted;
  sensor.filter = weighted ? make_placement_table(film.filter) : make_filter_table(film.filter);
  if (weighted) sensor.filter_weights.emplace(film.filter);
  return out;
}

Camera make_camera(const CameraDescription& description, int width, int height) {
  check(description);
  using Projection = CameraDescription::Projection;
  if (description.projection == Projection::kSpherical) return make_spherical(description, width, height);
  const bool orthographic = description.projection == Projection::kOrthographic;
  if (!orthographic && description.projection != Projection::kPerspective)
    return make_meter(description, width, height);
  // Compute the size of the film at distance 1
  const double half =
      orthographic ? 1.0 : half_width_of(description.fov, description.fov_axis, width, height, description.where);
  const double step = 2.0 * half / width;
  const auto to_world = [&description](double x, double y, double z) {
    return description.to_world.vector({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  };
  const double left = half * (1.0 - 2.0 * description.principal_point_x);
  const double top = half * height / width * (1.0 - 2.0 * description.principal_point_y);
  Camera camera;
  // Set the clipping planes and the lens
  camera.near_clip = description.near_clip;
  camera.clip_range = description.far_clip - description.near_clip;
  camera.lens_x = to_world(description.aperture_radius, 0, 0);
  camera.lens_y = to_world(0, description.aperture_radius, 0);
  camera.inverse_focus_distance = 1.0f / description.focus_distance;
  // Orthographic cameras: the origin moves over the film
  if (orthographic) {
    camera.origin = description.to_world.point({static_cast<float>(left), static_cast<float>(top), 0});
    camera.origin_dx = to_world(-step, 0, 0);
    camera.origin_dy = to_world(0, -step, 0);
    camera.corner = to_world(0, 0, 1.0);
    camera.z_axis = z_axis_of(camera);
    return camera;
  }
  // Perspective cameras: all rays start at the origin
  camera.origin = description.to_world.point({0, 0, 0});
  camera.corner = to_world(left, top, 1.0);
  camera.dx = to_world(-step, 0, 0);
  camera.dy = to_world(0, -step, 0);
  camera.z_axis = z_axis_of(camera);
  if (description.distortion == std::array<float, 2>{0, 0}) return camera;
  // Check and add the radial distortion
  const double right = left - 2 * half, bottom = top - 2 * half * height / width;
  check_distortion(description, std::hypot(std::max(std::fabs(left), std::fabs(right)),
                                           std::max(std::fabs(top), std::fabs(bottom))));
  camera.rays = CameraRays::kDistorted;
  camera.forward = to_world(0, 0, 1.0);
  camera.film_corner = {static_cast<float>(left), static_cast<float>(top)};
  camera.film_step = {static_cast<float>(-step), static_cast<float>(-step)};
  std::copy(description.distortion.begin(), description.distortion.end(), camera.distortion);
  return camera;
}

PixelCone pixel_cone_of(const Camera& camera, int width, int height) {
  if (!camera.sees_points) return {};
  const auto across = static_cast<float>(width), down = static_cast<float>(height);
  if (camera.rays == CameraRays::kEqualArea) return {0, std::sqrt(4 * kPi / (across * down))};
  if (camera.rays == CameraRays::kSpherical) return {0, kPi * std::min(2 / across, 1 / down)};
  PixelCone cone;
  // Pixels are narrowest in a corner of the film, along the line to its middle
  cone.spread = kInfinity;
  const float pixel = std::min(length(camera.dx), length(camera.dy)), film_distance = 1 / length(camera.z_axis);
  for (const float x : {0.0f, across})
    for (const float y : {0.0f, down}) {
      const float distance = length(camera.corner + camera.dx * x + camera.dy * y);
      cone.spread = std::min(cone.spread, pixel * film_distance / (distance * distance));
    }
  cone.width = std::min(length(camera.origin_dx), length(camera.origin_dy)) + camera.near_clip * cone.spread;
  return cone;
}

void move_outside_scene(Camera& camera, const CameraDescription& description, Vec3f center, float radius) {
  if (description.projection != CameraDescription::Projection::kDistant) return;
  const Vec3f direction = camera.corner;
  if (const auto* point = std::get_if<Vec3d>(&description.target)) {
    camera.origin = point->rounded() - direction * (2 * radius);
  } else if (const auto* area = std::get_if<CameraDescription::TargetArea>(&description.target)) {
    const Vec3f x = area->to_world.vector({1, 0, 0}), y = area->to_world.vector({0, 1, 0});
    camera.origin = area->to_world.point({0, 0, 0}) - direction * (2 * radius);
    if (area->round) {
      camera.lens_x = x, camera.lens_y = y;
    } else {
      camera.origin = camera.origin - x - y;
      camera.origin_dx = x * 2.0f, camera.origin_dy = y * 2.0f;
    }
  } else {
    const auto frame = Frame<Scalar>::from_normal(direction);
    camera.origin = center - direction * radius;
    camera.lens_x = frame.s * radius, camera.lens_y = frame.t * radius;
  }
}

}  // namespace sheaf
