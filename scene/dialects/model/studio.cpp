#include "scene/dialects/model/studio.h"

#include "scene/dialects/model/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

namespace sheaf {

namespace {

/// Dimensions of the backdrop in radii of the model: the floor ends at kFlatDepth behind its center.
constexpr double kFlatDepth = 1.2, kCurveRadius = 2.5, kWall = kFlatDepth + kCurveRadius, kMinExtent = 8,
                 kMinHeight = 6;
constexpr int kCurveSteps = 48;
/// What the backdrop covers, over the field of view: pixel filters reach over the border of the image.
constexpr double kCover = 1.1;

/// The space of the studio: +x to the right of the image, +y away from the camera, +z upwards. The origin is below the
/// center of the model, on the floor. Lengths are in radii of the model.
struct StudioSpace {
  explicit StudioSpace(const ModelFrame& frame)
      : x(frame.right), y(cross(frame.floor_normal, frame.right)), z(frame.floor_normal), scale(frame.radius) {
    // The model hovers by more than its rounding errors
    const Vec3d c = frame.center;
    const double rounding = 1e-6 * std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)});
    height = -frame.bottom / scale + std::max(1e-3, rounding / scale);
    origin = c - z * (height * scale);
  }

  Vec3d vector(Vec3d v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  Vec3d point(Vec3d p) const { return vector(p - origin) * (1 / scale); }
  Vec3d to_world(Vec3d v) const { return x * v.x + y * v.y + z * v.z; }
  /// The transform to the world of a space with these axes and origin.
  Transform placed(Vec3d a, Vec3d b, Vec3d c, Vec3d at) const {
    const Vec3d columns[4] = {to_world(a) * scale, to_world(b) * scale, to_world(c) * scale,
                              origin + to_world(at) * scale};
    Matrix4 m;
    for (std::size_t j = 0; j < 4; ++j) {
      m.m[0][j] = columns[j].x;
      m.m[1][j] = columns[j].y;
      m.m[2][j] = columns[j].z;
    }
    return Transform(m);
  }

  Vec3d x, y, z, origin;
  double scale, height;  ///< the latter: of the center over the floor
};

/// The camera in the space of the studio.
struct StudioCamera {
  StudioCamera(const StudioSpace& space, const ModelFrame& frame)
      : eye(space.point(frame.eye)),
        right(space.vector(frame.right)),
        up(space.vector(frame.up)),
        forward(space.vector(-frame.front)),
        tangents(frame.tangents) {}

  /// The direction to a corner of the image.
  Vec3d corner(double a, double b) const {
    return forward + right * (a * kCover * tangents[0]) + up * (b * kCover * tangents[1]);
  }

  Vec3d eye, right, up, forward;
  std::array<double, 2> tangents;
};

/// Extents of the backdrop.
struct BackdropExtents {
  double width = kMinExtent, front = kMinExtent, height = kMinHeight;  ///< the first: half of it
};

/// The part of the backdrop that the camera sees, if that is larger than the minimum.
BackdropExtents seen_extents(const StudioCamera& camera) {
  BackdropExtents extents;
  const auto add = [&](Vec3d p) {
    extents.width = std::max(extents.width, kCover * std::abs(p.x));
    extents.front = std::max(extents.front, -kCover * p.y);
    extents.height = std::max(extents.height, kCover * p.z);
  };
  const Vec3d eye = camera.eye;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-1.0, 1.0}) {
      const Vec3d d = camera.corner(a, b);
      const double wall = (kWall - eye.y) / d.y, floor = -eye.z / d.z;
      if (d.y > 0 && eye.z + wall * d.z >= 0) {
        add(eye + d * wall);
      } else {
        add(eye + d * floor);
      }
    }
  // The edge in which floor and wall would meet
  const double depth = dot(Vec3d{0, kWall, 0} - eye, camera.forward);
  add({std::abs(eye.x) + kCover * camera.tangents[0] * depth, 0, 0});
  return extents;
}

/// The cyclorama: a profile of floor, quarter circle and wall, extruded along x.
Mesh make_backdrop(const BackdropExtents& extents) {
  Mesh mesh;
  const auto add = [&](double y, double z, double angle) {
    const Vec3f normal = Vec3d{0, -std::sin(angle), std::cos(angle)}.rounded();
    for (const double x : {-extents.width, extents.width}) {
      mesh.positions.push_back(Vec3d{x, y, z}.rounded());
      mesh.normals.push_back(normal);
    }
  };
  add(-extents.front, 0, 0);
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double angle = i * std::numbers::pi / (2 * kCurveSteps);
    add(kFlatDepth + kCurveRadius * std::sin(angle), kCurveRadius * (1 - std::cos(angle)), angle);
  }
  add(kWall, extents.height, std::numbers::pi / 2);
  for (std::uint32_t i = 0; i + 3 < mesh.positions.size(); i += 2) {
    mesh.triangles.push_back({i, i + 1, i + 3});
    mesh.triangles.push_back({i, i + 3, i + 2});
  }
  return mesh;
}

/// A square area light.
struct StudioLight {
  const char* name;
  double azimuth, elevation;   ///< degrees, from the camera to the right and upwards
  double distance, half_size;  ///< radii of the model
  Vec3d irradiance;            ///< at the center of the model, of a surface that faces the light
};

constexpr StudioLight kStudioLights[] = {{"key", -50, 42, 3.6, 1.5, {2.3, 2.2, 2.1}},
                                         {"fill", 65, 20, 3.6, 1.2, {0.45, 0.48, 0.5}},
                                         {"rim", 160, 68, 3.2, 1.0, {1.2, 1.2, 1.2}}};
constexpr float kAmbientRadiance = 0.2f;
constexpr float kBackdropReflectance = 0.25f;

/// The shortest move of points out of the field of view through its left, right or upper side.
Vec3d move_out_of_view(const std::array<Vec3d, 4>& points, const StudioCamera& camera) {
  constexpr double kMargin = 0.1;
  const Vec3d f = camera.forward;
  const Vec3d normals[] = {camera.right + f * camera.tangents[0], f * camera.tangents[0] - camera.right,
                           f * camera.tangents[1] - camera.up};
  double shortest = std::numeric_limits<double>::infinity();
  Vec3d direction;
  for (const Vec3d n : normals) {
    const double norm = length(n);
    double inside = -shortest;
    for (const Vec3d p : points) inside = std::max(inside, dot(p - camera.eye, n) / norm + kMargin);
    if (inside < shortest) std::tie(shortest, direction) = std::pair(inside, n * (-1 / norm));
  }
  return direction * std::max(shortest, 0.0);
}

void add_light(const StudioLight& light, const StudioSpace& space, const StudioCamera& camera,
               Description& description) {
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const double c = std::cos(radians(light.elevation)), s = std::sin(radians(light.elevation));
  const Vec3d center{0, 0, space.height};
  // A square that faces the model
  const Vec3d direction{c * std::sin(radians(light.azimuth)), -c * std::cos(radians(light.azimuth)), s};
  const Vec3d a = cross({0, 0, 1}, direction) * (light.half_size / c), b = cross(direction, a);
  Vec3d at = center + direction * light.distance;
  at = at + move_out_of_view({at + a + b, at + a - b, at - a + b, at - a - b}, camera);
  // The radiance of the wanted irradiance
  const Vec3d to_light = at - center;
  const double distance = length(to_light), cosine = std::max(dot(to_light, direction) / distance, 0.1);
  const double area = 4 * light.half_size * light.half_size;
  ShapeDescription shape;
  shape.geometry = RectangleShape{};
  shape.to_world = space.placed(-a, b, -direction, at);
  const Vec3d radiance = light.irradiance * (distance * distance / (area * cosine));
  shape.radiance = SpectrumDescription{SpectrumDescription::Rgb{radiance.rounded()}};
  shape.id = shape.emitter_id = std::string(kStudioPrefix) + light.name;
  description.shapes.push_back(std::move(shape));
}

}  // namespace

void add_soft_studio(const ModelFrame& frame, Description& description) {
  const StudioSpace space(frame);
  const StudioCamera camera(space, frame);
  constexpr float kGray = kBackdropReflectance;
  ShapeDescription backdrop;
  backdrop.geometry = make_backdrop(seen_extents(camera));
  backdrop.to_world = space.placed({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0});
  backdrop.material = add_two_sided(description, {SpectrumDescription::rgb(kGray, kGray, kGray)});
  backdrop.id = std::string(kStudioPrefix) + "backdrop";
  description.shapes.push_back(std::move(backdrop));
  for (const StudioLight& light : kStudioLights) add_light(light, space, camera, description);
  description.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(kAmbientRadiance)},
                                {},
                                std::string(kStudioPrefix) + "sky"});
}

}  // namespace sheaf
