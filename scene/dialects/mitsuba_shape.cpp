// The Mitsuba dialect: shapes.
#include "scene/dialects/mitsuba.h"
#include "scene/dialects/read_emitter.h"

#include <limits>

namespace sheaf::mitsuba {

namespace {

MeshFileShape read_mesh_file(Properties& p, ShapeDescription& shape) {
  MeshFileShape mesh;
  using Format = MeshFileShape::Format;
  mesh.format = p.type() == "ply" ? Format::kPly : p.type() == "serialized" ? Format::kSerialized : Format::kObj;
  mesh.file = p.file("filename");
  shape.face_normals = p.boolean("face_normals", false);
  if (mesh.format == Format::kSerialized) {
    mesh.flip_tex_coords = false;
    mesh.shape_index = p.integer("shape_index", 0, 0, std::numeric_limits<int>::max());
  } else {
    mesh.flip_tex_coords = p.boolean("flip_tex_coords", mesh.format == Format::kObj);
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

void read_geometry(Properties& p, ShapeDescription& shape) {
  const std::string& type = p.type();
  if (type == "obj" || type == "ply" || type == "serialized") {
    shape.geometry = read_mesh_file(p, shape);
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
    p.fail_plugin({"cube", "cylinder", "disk", "obj", "ply", "rectangle", "serialized", "sphere"});
  }
}

/// What light sources without a bsdf are made of: they reflect nothing.
MaterialId black_material(Reader& reader) {
  if (!reader.black) {
    MaterialDescription material;
    material.model = DiffuseDescription{SpectrumDescription::constant(0)};
    reader.black = add_material(reader.context, std::move(material));
  }
  return *reader.black;
}

/// A boundary that light does not notice.
MaterialId null_material(Reader& reader) {
  if (!reader.null) reader.null = add_material(reader.context, {NullDescription{}, true, true, {}, {}});
  return *reader.null;
}

void read_media(Properties& p, Reader& reader, ShapeDescription& shape) {
  if (const XmlElement* medium = p.named_object("medium", "interior")) shape.interior = medium_of(*medium, reader);
  if (const XmlElement* medium = p.named_object("medium", "exterior")) shape.exterior = medium_of(*medium, reader);
}

}  // namespace

void read_shape(const XmlElement& element, Reader& reader) {
  if (read_instancing(element, reader.context, [&](const XmlElement& e) { read_shape(e, reader); })) return;
  Properties p(element, reader.context);
  ShapeDescription shape;
  shape.where = element.where;
  read_geometry(p, shape);
  shape.to_world = p.transform("to_world");
  shape.flip_normals = p.boolean("flip_normals", false);
  if (const XmlElement* bsdf = p.object("bsdf")) shape.material = material_of(*bsdf, reader);
  if (const XmlElement* emitter = p.object("emitter"))
    shape.radiance = read_area_emitter(*emitter, reader.context, {"sampling_weight"});
  read_media(p, reader, shape);
  if (reader.before_version_2 && !shape.material && (shape.interior || shape.exterior))
    shape.material = null_material(reader);
  if (shape.radiance && !shape.material) shape.material = black_material(reader);
  p.accept({"silhouette_sampling_weight"});
  p.finish();
  reader.context.description.shapes.push_back(std::move(shape));
}

}  // namespace sheaf::mitsuba
