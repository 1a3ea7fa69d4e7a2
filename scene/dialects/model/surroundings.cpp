// Floors, skies and default settings for models.
#include "scene/dialects/model/surroundings.h"

#include "core/math/frame.h"
#include "scene/dialects/model/auto_camera.h"
#include "scene/dialects/model/framing.h"
#include "scene/dialects/model/studio.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Ratio of floor size to model size; the floor's edge is near the horizon.
constexpr float kFloor = 200;

/// Returns a disk below the box, perpendicular to `up`.
ShapeDescription make_floor(const std::array<Vec3d, 2>& box, Vec3f up) {
  const Vec3d center = box[0] * 0.5 + box[1] * 0.5;
  const Vec3f half = (box[1] * 0.5 - box[0] * 0.5).rounded();
  const float radius = kFloor * std::max(length(half), 1e-6f);
  const Vec3d foot = center - Vec3d(up * dot(up, half));
  const Frame<Scalar> frame = Frame<Scalar>::from_normal(up);
  Matrix4 m;
  const Vec3d columns[4] = {frame.s * radius, frame.t * radius, up, foot};
  for (std::size_t j = 0; j < 4; ++j) {
    m.m[0][j] = columns[j].x;
    m.m[1][j] = columns[j].y;
    m.m[2][j] = columns[j].z;
  }
  ShapeDescription floor;
  floor.geometry = DiskShape{};
  floor.to_world = Transform(m);
  return floor;
}

/// The rotation that turns +y to the up axis.
Transform upright(ModelView::Up up) {
  if (up == ModelView::Up::kX) return Transform::rotate({0, 0, 1}, -90);
  return up == ModelView::Up::kY ? Transform() : Transform::rotate({1, 0, 0}, 90);
}

}  // namespace

MaterialId add_two_sided(Description& description, DiffuseDescription diffuse) {
  MaterialDescription material;
  material.model = std::move(diffuse);
  MaterialDescription both;
  description.materials.push_back(std::move(material));
  const auto id = static_cast<MaterialId>(description.materials.size() - 1);
  both.model = TwoSidedDescription{id, id};
  description.materials.push_back(std::move(both));
  return static_cast<MaterialId>(description.materials.size() - 1);
}

void add_floor(const std::array<Vec3d, 2>& box, const ModelView& view, Description& description) {
  ShapeDescription floor = make_floor(box, up_vector(view));
  floor.material = add_two_sided(description, {SpectrumDescription::rgb(0.45f, 0.43f, 0.41f)});
  description.shapes.push_back(std::move(floor));
}

void add_sky(const std::array<Vec3d, 2>& box, const ModelView& view, const ModelEnvironment& surroundings,
             Description& description) {
  if (surroundings.environment == ModelEnvironment::kNoEnvironment) return;
  if (!surroundings.environment.empty()) {
    EnvmapDescription map;
    map.file = surroundings.environment;
    map.to_world = upright(view.up);
    map.mis_compensation = true;
    description.lights.push_back({std::move(map), {surroundings.environment.string(), 0}});
    description.files.push_back(surroundings.environment);
    return;
  }
  constexpr Vec3f kSky{0.52f, 0.58f, 0.68f}, kSun{1.9f, 1.75f, 1.5f};
  description.lights.push_back({ConstantLightDescription{{SpectrumDescription::Rgb{kSky}}}, {}});
  const Vec3d center = box[0] * 0.5 + box[1] * 0.5;
  const Vec3f up = up_vector(view);
  Vec3f front = (description.camera.to_world.translation() - center).rounded();
  front = front - up * dot(up, front);
  front = length_squared(front) > 0.0f ? normalize(front) : Frame<Scalar>::from_normal(up).s;
  const Vec3f left = cross(front, up);
  DirectionalLightDescription sun;
  sun.direction = -(up * 1.0f + front * 0.5f + left * 0.6f);
  sun.irradiance = {SpectrumDescription::Rgb{kSun}};
  description.lights.push_back({std::move(sun), {}});
}

void add_studio(const std::array<Vec3d, 2>& box, const ModelView& view, const ModelEnvironment& surroundings,
                Description& description) {
  const ModelFrame frame = frame_model(box, view, description);
  const Studio studio = surroundings.chosen_studio();
  if (studio == Studio::kSoft) return add_soft_studio(frame, description);
  const auto named = [](const char* name) { return std::string(kStudioPrefix) + name; };
  // From below, a floor would hide the model
  if (studio == Studio::kSun && surroundings.floor && view.elevation >= 0) {
    add_floor(box, view, description);
    description.shapes.back().id = named("floor");
  }
  const std::size_t first = description.lights.size();
  add_sky(box, view, surroundings, description);
  for (std::size_t i = first; i < description.lights.size(); ++i)
    description.lights[i].id = named(i == first ? "sky" : "sun");
}

void set_model_defaults(Description& description) {
  description.film.width = 800;
  description.film.height = 600;
  description.film.filter = {PixelFilter::Kind::kGaussian, 2.0f, 0.5f};
  description.sampler.sample_count = 64;
}

}  // namespace sheaf
