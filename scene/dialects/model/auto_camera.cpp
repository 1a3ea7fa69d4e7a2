// Automatic camera placement: bounding boxes of shapes, and a camera that frames them.
#include "scene/dialects/model/auto_camera.h"

#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/smooth_normals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sheaf {

namespace {

/// An axis-aligned bounding box.
struct Box {
  static constexpr double kEmpty = std::numeric_limits<double>::infinity();
  Vec3d lower{kEmpty, kEmpty, kEmpty}, upper{-kEmpty, -kEmpty, -kEmpty};

  void grow(Vec3d p) {
    if (!is_finite(p)) return;
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  /// Extends the box by the transformed corners of another box.
  void grow(const Transform& to_world, Vec3d low, Vec3d high) {
    for (int i = 0; i < 8; ++i)
      grow(to_world.precise_point({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z}));
  }
  bool empty() const { return !(lower.x <= upper.x); }
};

/// Loads the mesh file of a shape into memory, with the processing steps that scene/formats/mesh.h lists.
void load(ShapeDescription& shape, const MeshFileShape& from, Description& description) {
  MeshFile file = read_mesh(from);
  for (const std::string& w : file.warnings) description.notes.push_back(fmt::format("{}: {}", from.file.string(), w));
  check_mesh(file.mesh, shape.where);
  shape.face_normals = shape.face_normals || file.face_normals;
  if (shape.face_normals) file.mesh.normals.clear();
  if (!shape.motion) apply_linear_part(file.mesh, shape.to_world);
  drop_degenerate_triangles(file.mesh);
  if (from.smooth_normals && !shape.face_normals && file.mesh.normals.empty()) {
    if (file.is_split) {
      compute_welded_normals(file.mesh);
    } else {
      compute_vertex_normals(file.mesh);
    }
  }
  shape.geometry = std::move(file.mesh);
}

void grow(Box& box, const Curves& curves, const Transform& to_world) {
  for (const Curves::Point& point : curves.points) {
    const Vec3d p = to_world.precise_point(point.position), r{point.radius, point.radius, point.radius};
    box.grow(p - r);
    box.grow(p + r);
  }
}

void grow(Box& box, const ShapeDescription& shape) {
  const Transform& t = shape.to_world;
  if (const auto* mesh = std::get_if<Mesh>(&shape.geometry)) {
    for (const auto& triangle : mesh->triangles)
      for (const std::uint32_t vertex : triangle) box.grow(t.precise_point(mesh->positions[vertex]));
  } else if (const auto* deforming = std::get_if<DeformingMesh>(&shape.geometry)) {
    // Only those of glTF, which are in memory, need a camera
    for (const DeformingMesh::Key& key : deforming->keys)
      if (const auto* at_key = std::get_if<Mesh>(&key.mesh))
        for (const Vec3f p : at_key->positions) box.grow((t * key.to_shape).precise_point(p));
  } else if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry)) {
    const Vec3d r{sphere->radius, sphere->radius, sphere->radius};
    box.grow(t, sphere->center - r, sphere->center + r);
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) {
    const Vec3d r{cylinder->radius, cylinder->radius, cylinder->radius};
    box.grow(t, cylinder->p0 - r, cylinder->p0 + r);
    box.grow(t, cylinder->p1 - r, cylinder->p1 + r);
  } else if (const auto* curves = std::get_if<Curves>(&shape.geometry)) {
    grow(box, *curves, t);
  } else if (const auto* moving = std::get_if<DeformingCurves>(&shape.geometry)) {
    for (const DeformingCurves::Key& key : moving->keys) grow(box, key.curves, t * key.to_shape);
  } else if (std::holds_alternative<CubeShape>(shape.geometry)) {
    box.grow(t, {-1, -1, -1}, {1, 1, 1});
  } else if (std::holds_alternative<SdfGrid>(shape.geometry)) {
    box.grow(t, {0, 0, 0}, {1, 1, 1});
  } else {
    box.grow(t, {-1, -1, 0}, {1, 1, 0});
  }
}

Box read_box(std::vector<ShapeDescription>& shapes, Description& description, ErrorSink& errors) {
  Box box;
  std::vector<ShapeDescription> read;
  read.reserve(shapes.size());
  for (ShapeDescription& shape : shapes) {
    try {
      if (const auto* file = std::get_if<MeshFileShape>(&shape.geometry))
        load(shape, MeshFileShape(*file), description);
    } catch (const SceneError& error) {
      errors.report(error, "shape ignored");
      continue;
    }
    grow(box, shape);
    read.push_back(std::move(shape));
  }
  shapes = std::move(read);
  return box;
}

/// Returns the unit vector from the box to the camera. Azimuths 0 and 90 degrees are +y and +z for the up axis x, +z
/// and +x for y, -y and +x for z.
Vec3f towards_eye(const ModelView& view) {
  const auto radians = [](float degrees) { return degrees * std::numbers::pi_v<float> / 180; };
  const float c = std::cos(radians(view.elevation)), s = std::sin(radians(view.elevation));
  const float along = c * std::cos(radians(view.azimuth)), across = c * std::sin(radians(view.azimuth));
  if (view.up == ModelView::Up::kX) return {s, along, across};
  if (view.up == ModelView::Up::kY) return {across, s, along};
  return {across, -along, s};
}

}  // namespace

Vec3f up_vector(const ModelView& view) {
  if (view.up == ModelView::Up::kX) return {1, 0, 0};
  return view.up == ModelView::Up::kY ? Vec3f{0, 1, 0} : Vec3f{0, 0, 1};
}

std::array<Vec3d, 2> read_bounds(Description& description, ErrorSink& errors) {
  Box box = read_box(description.shapes, description, errors);
  std::vector<Box> groups;
  for (ShapeGroup& group : description.groups) groups.push_back(read_box(group.shapes, description, errors));
  for (const InstanceDescription& instance : description.instances) {
    const Box& group = groups[instance.group];
    if (group.empty()) continue;
    Matrix4 m;
    for (std::size_t i = 0; i < 12; ++i) m.m[i / 4][i % 4] = instance.to_world[i];
    box.grow(Transform(m), group.lower, group.upper);
  }
  if (box.empty()) return {};
  return {box.lower, box.upper};
}

void frame_box(const std::array<Vec3d, 2>& box, const ModelView& view, Description& description) {
  const Vec3d center = box[0] * 0.5 + box[1] * 0.5;
  const float radius = std::max(static_cast<float>(length(box[1] * 0.5 - box[0] * 0.5)), 1e-6f);
  CameraDescription& camera = description.camera;
  camera = CameraDescription();
  camera.fov = view.fov;
  camera.fov_axis = CameraDescription::FovAxis::kSmaller;
  const float distance = radius / std::sin(view.fov * 0.5f * std::numbers::pi_v<float> / 180);
  Vec3f up = up_vector(view);
  const Vec3f towards = towards_eye(view);
  if (std::abs(dot(up, towards)) > 0.999f) up = {up.y, up.z, up.x};
  camera.to_world = Transform::look_at(center + Vec3d(towards) * double{distance}, center, up);
  camera.near_clip = distance * 1e-4f;
  camera.far_clip = distance * 1e4f;
}

void substitute_camera(const XmlElement& root, const char* what, ReadContext& context) {
  if (context.needs_camera)
    context.errors.report(SceneError(root.where, std::string("the scene has no ") + what, SceneErrorCode::kMissing),
                          "rendered with an automatic camera");
  context.frames_scene = true;
}

}  // namespace sheaf
