// Shapes that both dialects spell alike: mesh files and quadrics.
#include "scene/dialects/read_geometry.h"

#include <limits>

namespace sheaf {

namespace {

MeshFileShape read_mesh_file(Properties& p, bool flips_obj, ShapeDescription& shape) {
  MeshFileShape mesh;
  using Format = MeshFileShape::Format;
  mesh.format = p.type() == "ply" ? Format::kPly : p.type() == "serialized" ? Format::kSerialized : Format::kObj;
  mesh.file = p.file("filename");
  shape.face_normals = p.boolean("face_normals", false);
  mesh.smooth_normals = flips_obj;
  if (mesh.format == Format::kSerialized) {
    mesh.flip_tex_coords = false;
    mesh.shape_index = p.integer("shape_index", 0, 0, std::numeric_limits<int>::max());
  } else {
    mesh.flip_tex_coords = p.boolean("flip_tex_coords", flips_obj && mesh.format == Format::kObj);
  }
  if (p.find_number("max_smooth_angle"))
    p.context().note(p.where(), "'max_smooth_angle' is not used: normals are as 'face_normals' and the file say");
  p.accept({"collapse"});
  if (mesh.format == Format::kPly) p.accept({"srgb"});
  return mesh;
}

CylinderShape read_cylinder(Properties& p) {
  CylinderShape cylinder;
  cylinder.p0 = p.vec3("p0", cylinder.p0);
  cylinder.p1 = p.vec3("p1", cylinder.p1);
  cylinder.radius = p.number("radius", 1, kPositive);
  if (cylinder.p0 == cylinder.p1) p.fail("has no length: p0 and p1 coincide");
  return cylinder;
}

}  // namespace

const std::vector<std::string>& shared_shape_names() {
  static const std::vector<std::string> kNames = {"cube", "cylinder",  "disk",       "obj",
                                                  "ply",  "rectangle", "serialized", "sphere"};
  return kNames;
}

bool read_shared_geometry(Properties& p, bool flips_obj, ShapeDescription& shape) {
  const std::string& type = p.type();
  if (type == "obj" || type == "ply" || type == "serialized") {
    shape.geometry = read_mesh_file(p, flips_obj, shape);
  } else if (type == "sphere") {
    const Vec3f center = p.vec3("center", {0, 0, 0});
    shape.geometry = SphereShape{center, p.number("radius", 1, kPositive)};
  } else if (type == "rectangle") {
    shape.geometry = RectangleShape{};
  } else if (type == "cube") {
    shape.geometry = CubeShape{};
  } else if (type == "disk") {
    shape.geometry = DiskShape{};
  } else if (type == "cylinder") {
    shape.geometry = read_cylinder(p);
  } else {
    return false;
  }
  return true;
}

}  // namespace sheaf
