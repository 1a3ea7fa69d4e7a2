// The Mitsuba dialect: shapes.
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_emitter.h"
#include "scene/dialects/xml/read_geometry.h"
#include "scene/dialects/xml/read_instances.h"
#include "scene/formats/ellipsoids.h"
#include "scene/formats/mesh.h"
#include "scene/materials/reading.h"
#include "scene/xml/read_arrays.h"

#include <cmath>

namespace sheaf::mitsuba {

namespace {

/// Black material of light sources without a BSDF.
MaterialId black_material(Reader& reader) {
  if (!reader.black) {
    MaterialDescription material;
    material.model = DiffuseDescription{SpectrumDescription::constant(0)};
    reader.black = add_material(reader.context, std::move(material));
  }
  return *reader.black;
}

/// Material of a null interface.
MaterialId null_material(Reader& reader) {
  if (!reader.null) reader.null = add_material(reader.context, {NullDescription{}, {}, {}});
  return *reader.null;
}

/// Reads the shapes of a `merge` one by one, because merging does not change the image.
void read_merged(Properties& p, Reader& reader) {
  const std::vector<const XmlElement*> shapes = p.objects("shape");
  p.reject_unused();
  for (const XmlElement* shape : shapes) read_or_omit(*shape, reader.context, [&] { read_shape(*shape, reader); });
}

/// Plugins that become several shapes.
constexpr NameTable<void (*)(Properties&, Reader&)> kAggregates{{{"merge", read_merged}}};

/// Returns the transforms of the unit spheres of an ellipsoids shape.
std::vector<Transform> read_many_ellipsoids(Properties& p) {
  if (p.type() == "ellipsoidsmesh" && p.find_string("shell"))
    p.context().note(p.where(), "'shell' ignored: ellipsoids are exact");
  const float extent = p.number("extent", 3, kPositive);
  return read_ellipsoids(p.file("filename"), extent * p.number("scale_factor", 1, kPositive));
}

/// Plugins with several instances of a unit sphere.
constexpr NameTable<std::vector<Transform> (*)(Properties&)> kEllipsoids{
    {{"ellipsoids", read_many_ellipsoids}, {"ellipsoidsmesh", read_many_ellipsoids}}};

/// The mesh of a nested shape of a deformable shape.
decltype(DeformingMesh::Key::mesh) mesh_at_key(const XmlElement& element, const ShapeDescription& shape) {
  if (const auto* file = std::get_if<MeshFileShape>(&shape.geometry)) return *file;
  if (const auto* mesh = std::get_if<Mesh>(&shape.geometry)) return *mesh;
  if (std::holds_alternative<RectangleShape>(shape.geometry)) return rectangle_mesh();
  if (std::holds_alternative<CubeShape>(shape.geometry)) return cube_mesh();
  throw SceneError(element.where, "is not a mesh, expected only meshes or only curves in a 'deformable' shape",
                   SceneErrorCode::kWrongType);
}

/// Reads a mesh or curves that deform: nested shapes for the times of the string `times`, as in Mitsuba 0.6. They have
/// the material of the first one.
void read_deformable(Properties& p, Reader& reader, ShapeDescription& shape) {
  const std::vector<float> times = read_numbers(p, "times");
  const std::vector<const XmlElement*> children = p.objects("shape");
  if (times.size() != children.size())
    p.fail(
        fmt::format("has {} shapes for {} times, expected one for each of its 'times'", children.size(), times.size()));
  DeformingMesh mesh;
  DeformingCurves curves;
  for (std::size_t i = 0; i < children.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
      p.fail_at("times", "are not finite and increasing");
    // Read the geometry
    Properties child(*children[i], p.context());
    ShapeDescription at_key;
    const GeometryReader* read = kShapesWithAllPoints.find(child.type());
    if (read != nullptr) {
      (*read)(child, true, at_key);
    } else {
      child.plugin(kSharedShapes)(child, true, at_key);
    }
    const Transform to_shape = child.transform("to_world");
    if (auto* at_time = std::get_if<Curves>(&at_key.geometry)) {
      curves.keys.push_back({double{times[i]}, std::move(*at_time), to_shape});
    } else {
      mesh.keys.push_back({double{times[i]}, mesh_at_key(*children[i], at_key), to_shape});
    }
    if (!mesh.keys.empty() && !curves.keys.empty())
      throw SceneError(children[i]->where, "follows shapes of another kind, expected only meshes or only curves",
                       SceneErrorCode::kWrongType);
    // Read what the first shape decides
    if (i == 0) {
      shape.face_normals = at_key.face_normals;
      if (const XmlElement* bsdf = child.object("bsdf")) shape.material = material_of(*bsdf, reader);
      shape.flip_normals = child.boolean("flip_normals", false);
    }
    child.ignore_all();
  }
  if (children.empty()) p.fail("has no shapes, expected meshes or curves for at least one of its 'times'");
  if (curves.keys.empty()) {
    shape.geometry = std::move(mesh);
  } else {
    shape.geometry = std::move(curves);
  }
}

/// Shapes made of other shapes.
constexpr NameTable<void (*)(Properties&, Reader&, ShapeDescription&)> kDeformable{{{"deformable", read_deformable}}};

void read_media(Properties& p, Reader& reader, ShapeDescription& shape) {
  if (const XmlElement* medium = p.named_object("medium", "interior"))
    read_or_omit(*medium, reader.context, [&] { shape.interior = medium_of(*medium, reader); });
  if (const XmlElement* medium = p.named_object("medium", "exterior"))
    read_or_omit(*medium, reader.context, [&] { shape.exterior = medium_of(*medium, reader); });
}

}  // namespace

void read_shape(const XmlElement& element, Reader& reader) {
  if (read_instancing(element, reader.context, [&](const XmlElement& e) { read_shape(e, reader); })) return;
  Properties p(element, reader.context);
  if (const auto* read = kAggregates.find(p.type())) return (*read)(p, reader);
  ShapeDescription shape;
  shape.where = element.where;
  if (const std::string* id = element.find_attribute("id")) shape.id = *id;
  // Read the geometry
  std::vector<Transform> ellipsoids;
  if (const auto* read = kEllipsoids.find(p.type())) {
    ellipsoids = (*read)(p);
    shape.geometry = SphereShape{};
  } else if (p.type() == "mesh" && p.find_array("vertices") != nullptr) {
    shape.face_normals = p.boolean("face_normals", false);
    shape.geometry = read_mesh_arrays(p);
  } else if (const auto* read_keys = kDeformable.find(p.type())) {
    (*read_keys)(p, reader, shape);
  } else {
    p.plugin(kSharedShapes, kEllipsoids, kDeformable, kAggregates)(p, true, shape);
  }
  const Placement placement = p.placement("to_world");
  shape.to_world = placement.to_world;
  shape.flip_normals = p.boolean("flip_normals", false) != shape.flip_normals;
  // Read material, emitter and sensor
  if (const XmlElement* bsdf = p.object("bsdf")) shape.material = material_of(*bsdf, reader);
  if (const XmlElement* emitter = p.object("emitter"))
    find_area_emitter(*emitter, reader.context, shape,
                      {"sampling_weight", "caustic_emitter_single", "caustic_emitter_multi"});
  if (const XmlElement* sensor = p.object("sensor")) {
    const Transform rotated = shape.flip_normals ? Transform::scale({-1, 1, -1}) : Transform();
    reader.shape_sensors.push_back({sensor, p.type(), placement * rotated});
  }
  // Read the media
  read_media(p, reader, shape);
  if (const XmlElement* subsurface = p.object("subsurface")) {
    if (shape.interior)
      p.report("has an interior medium and a <subsurface>, expected one of them", SceneErrorCode::kDuplicate,
               "subsurface ignored");
    else
      read_or_omit(*subsurface, reader.context, [&] { read_subsurface(*subsurface, reader, shape); });
  }
  if (shape.radiance && !shape.material) shape.material = black_material(reader);
  if (reader.before_version_2 && !shape.material && (shape.interior || shape.exterior))
    shape.material = null_material(reader);
  p.ignore({"silhouette_sampling_weight"});
  // Hints for specular manifold sampling (Zeltner et al. 2020), which do not affect the image.
  p.ignore({"caustic_caster_single", "caustic_caster_multi", "caustic_bouncer", "caustic_receiver"});
  p.reject_unused();
  // Add the shape, or one sphere per ellipsoid
  Description& description = reader.context.description;
  if (ellipsoids.empty()) {
    shape.motion = add_motion(description.motions, placement);
    description.shapes.push_back(std::move(shape));
    return;
  }
  for (const Transform& ellipsoid : ellipsoids) {
    const Placement placed = placement * ellipsoid;
    shape.to_world = placed.to_world;
    shape.motion = add_motion(description.motions, placed);
    description.shapes.push_back(shape);
  }
}

}  // namespace sheaf::mitsuba
