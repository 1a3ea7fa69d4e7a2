// The pbrt dialect: shapes. Full spheres, cylinders and disks stay analytic. Partial ones, and textured disks, are
// tessellated because their texture coordinates differ.
#include "scene/dialects/common/covered_emission.h"
#include "scene/dialects/pbrt/reader.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/ply_header.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf::pbrt {

namespace {

constexpr int kSteps = 128;  ///< segments of a full circle

/// Point on a circle at parameter u; s[0] is phimax in radians.
Vec3f around(const float* s, float u, float radius, float z) {
  const float phi = u * s[0];
  return {radius * std::cos(phi), radius * std::sin(phi), z};
}

// Spheres: phimax, radius, polar angles at v = 0 and v = 1.
float polar_angle(const float* s, float v) { return s[2] + v * (s[3] - s[2]); }
Vec3f sphere_normal(const float* s, float u, float v) {
  return around(s, u, std::sin(polar_angle(s, v)), std::cos(polar_angle(s, v)));
}
Vec3f sphere_point(const float* s, float u, float v) { return sphere_normal(s, u, v) * s[1]; }

// Cylinders: phimax, radius, zmin, zmax.
Vec3f cylinder_point(const float* s, float u, float v) { return around(s, u, s[1], s[2] + v * (s[3] - s[2])); }
Vec3f cylinder_normal(const float* s, float u, float) { return around(s, u, 1, 0); }

// Disks: phimax, radius, height, inner radius.
Vec3f disk_point(const float* s, float u, float v) { return around(s, u, s[1] + v * (s[3] - s[1]), s[2]); }
Vec3f disk_normal(const float*, float, float) { return {0, 0, 1}; }

float read_phimax(Parameters& p) { return p.number("phimax", 360, {0, 360, false}); }
float radians(float degrees) { return degrees * kPi / 180; }
int steps_of(float phimax) { return std::max(4, static_cast<int>(std::ceil(kSteps * phimax / 360))); }

Mesh mesh_of(const Patch& patch) {
  Mesh mesh;
  append(mesh, patch);
  return mesh;
}

/// Properties of a shape beyond its description.
struct Geometry {
  float area = 0;
  bool has_normals = false;  ///< normals determine the front side, even if the transform mirrors
  bool is_mesh = false;
  std::size_t lights = 1;  ///< number of lights that pbrt creates: one per triangle or patch
};

Geometry read_sphere(Parameters& p, ShapeDescription& shape, bool textured) {
  const float radius = p.number("radius", 1, kPositive), phimax = read_phimax(p);
  const float a = std::clamp(p.number("zmin", -radius), -radius, radius);
  const float b = std::clamp(p.number("zmax", radius), -radius, radius);
  const float low = std::min(a, b), high = std::max(a, b);
  const float area = radians(phimax) * radius * (high - low);
  if (phimax == 360.0f && low == -radius && high == radius) {
    shape.geometry = SphereShape{{0, 0, 0}, radius};
    // v runs upwards here and downwards in pbrt
    if (textured) shape.to_world = shape.to_world * Transform::scale({1, 1, -1});
    return {area};
  }
  const int steps = steps_of(phimax);
  shape.geometry = mesh_of({sphere_point,
                            sphere_normal,
                            {radians(phimax), radius, std::acos(low / radius), std::acos(high / radius)},
                            steps,
                            kSteps / 2});
  return {area, true, true};
}

Geometry read_cylinder(Parameters& p, ShapeDescription& shape, bool) {
  const float radius = p.number("radius", 1, kPositive), phimax = read_phimax(p);
  const float a = p.number("zmin", -1), b = p.number("zmax", 1);
  const float low = std::min(a, b), high = std::max(a, b);
  if (low == high) p.fail("has no height: 'zmin' and 'zmax' are equal");
  const float area = radians(phimax) * radius * (high - low);
  if (phimax == 360.0f) {
    shape.geometry = CylinderShape{{0, 0, low}, {0, 0, high}, radius};
    return {area};
  }
  shape.geometry =
      mesh_of({cylinder_point, cylinder_normal, {radians(phimax), radius, low, high}, steps_of(phimax), 1});
  return {area, true, true};
}

Geometry read_disk(Parameters& p, ShapeDescription& shape, bool textured) {
  const float radius = p.number("radius", 1, kPositive), phimax = read_phimax(p), height = p.number("height", 0);
  const float inner = p.number("innerradius", 0, {0, double{radius}, false});
  const float area = radians(phimax) * 0.5f * (radius * radius - inner * inner);
  if (phimax == 360.0f && inner == 0.0f && !textured) {
    shape.geometry = DiskShape{};
    if (height != 0.0f) shape.to_world = shape.to_world * Transform::translate({0, 0, height});
    if (radius != 1.0f) shape.to_world = shape.to_world * Transform::scale({radius, radius, 1});
    return {area};
  }
  shape.geometry = mesh_of({disk_point, disk_normal, {radians(phimax), radius, height, inner}, steps_of(phimax), 1});
  return {area, true, true};
}

/// Reads face count and presence of normals from a PLY header.
Geometry ply_geometry(const std::filesystem::path& file) {
  const std::string bytes = read_mesh_text(file, "PLY file");
  Geometry geometry{0, false, true};
  for (const PlyElement& element : parse_ply_header(bytes, file.string()).elements) {
    if (element.name == "face") geometry.lights = element.count;
    for (const PlyProperty& property : element.properties)
      if (element.name == "vertex" && property.name == "nx") geometry.has_normals = true;
  }
  return geometry;
}

Geometry read_ply_shape(Parameters& p, ShapeDescription& shape, bool) {
  MeshFileShape mesh;
  mesh.file = p.file("filename");
  mesh.format = "ply";
  mesh.flip_tex_coords = false;
  mesh.smooth_normals = false;
  if (p.has("displacement")) {
    p.unsupported("displacement of its vertices", "ignored");
    p.ignore({"displacement"});
  }
  p.ignore({"edgelength"});
  Geometry geometry{0, false, true};
  if (shape.to_world.swaps_handedness() || p.reader().attributes.area_light) geometry = ply_geometry(mesh.file);
  shape.geometry = std::move(mesh);
  return geometry;
}

Geometry read_subdivision_shape(Parameters& p, ShapeDescription& shape, bool textured) {
  Mesh mesh = read_subdivision(p, textured);
  const Geometry geometry{0, true, true, mesh.triangles.size()};
  shape.geometry = std::move(mesh);
  return geometry;
}

/// Sets a mesh of faces with this number of corners.
Geometry set_mesh(Parameters& p, ShapeDescription& shape, Mesh mesh, std::size_t corners) {
  const Parameter* indices = p.find("indices");
  const Geometry geometry{0, !mesh.normals.empty(), true, indices == nullptr ? 1 : indices->numbers.size() / corners};
  shape.geometry = std::move(mesh);
  return geometry;
}

Geometry read_triangles(Parameters& p, ShapeDescription& shape, bool textured) {
  return set_mesh(p, shape, read_triangle_mesh(p, textured), 3);
}

Geometry read_patches(Parameters& p, ShapeDescription& shape, bool) {
  return set_mesh(p, shape, read_bilinear_mesh(p), 4);
}

Geometry read_curve_shape(Parameters& p, ShapeDescription& shape, bool) {
  shape.geometry = read_curve(p, shape.to_world);
  shape.to_world = Transform();
  return Geometry{0, true, false};
}

/// `textured`: the texture coordinates matter.
constexpr NameTable<Geometry (*)(Parameters&, ShapeDescription&, bool textured)> kShapes{
    {{"bilinearmesh", read_patches},
     {"curve", read_curve_shape},
     {"cylinder", read_cylinder},
     {"disk", read_disk},
     {"loopsubdiv", read_subdivision_shape},
     {"plymesh", read_ply_shape},
     {"sphere", read_sphere},
     {"trianglemesh", read_triangles}}};

/// Applies the `alpha` mask to the material. A constant of 0 makes the shape invisible: rays never hit it, but its area
/// light emits in full.
MaterialId masked(Parameters& p, MaterialId nested, ShapeDescription& shape) {
  const std::optional<ScalarInput> alpha = find_scalar_input(p, "alpha");
  if (!alpha) return nested;
  if (const float* number = std::get_if<float>(&*alpha)) {
    shape.is_visible = *number > 0.0f;
    if (!shape.is_visible || *number >= 1.0f) return nested;
  }
  return add(p.reader(), MaskDescription{*alpha, nested}, p.where());
}

void add_emission(Parameters& p, ShapeDescription& shape, const Geometry& geometry) {
  Reader& reader = p.reader();
  const std::optional<AreaLight>& light = reader.attributes.area_light;
  if (!light) return;
  if (reader.object != nullptr)
    return reader.note(p.where(), p.title() + " is part of an object, its AreaLightSource is ignored as in pbrt");
  if (reader.attributes.material.is_interface)
    return reader.note(p.where(), p.title() + " has the material 'interface', its AreaLightSource is ignored");
  if (std::holds_alternative<Curves>(shape.geometry)) return p.unsupported("light of curves", "ignored");
  shape.emits_on_both_sides = light->two_sided;
  std::optional<SpectrumInput> radiance = light->radiance;
  if (light->power) {
    // For shapes other than meshes, pbrt uses the area before the transform.
    if (geometry.area > 0.0f)
      radiance =
          scaled_input(reader, light->radiance, *light->power / (kPi * geometry.area * (light->two_sided ? 2 : 1)));
    else
      shape.power = *light->power * static_cast<float>(geometry.lights);
  }
  if (!radiance) return;
  CoveredEmission emission = covered_emission(reader.description, std::move(*radiance), *shape.material);
  shape.radiance = std::move(emission.radiance);
  shape.radiance_scale = emission.scale;
}

/// Sets the media on both sides if they differ; otherwise the surface is no medium boundary.
void add_media(Parameters& p, ShapeDescription& shape) {
  const Attributes& a = p.reader().attributes;
  if (a.inside == a.outside && !a.material.interior) return;
  if (std::holds_alternative<Curves>(shape.geometry)) return p.unsupported("media inside of curves", "ignored");
  shape.interior = a.material.interior ? a.material.interior : medium_of(p.reader(), a.inside, p.where());
  shape.exterior = medium_of(p.reader(), a.outside, p.where());
}

}  // namespace

void read_shape(Reader& reader, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("Shape '{}'", entity.type), entity.where, std::move(entity.parameters));
  ShapeDescription shape;
  shape.where = entity.where;
  const TransformPair& transform = reader.attributes.transform;
  shape.to_world = transform.start;
  if (!reader.attributes.material.id) {
    if (!reader.standard_material) reader.standard_material = make_material(reader, "", {"diffuse", {}, entity.where});
    reader.attributes.material = *reader.standard_material;
  }
  reader.used_texture = reader.attributes.material.textured;
  shape.material = masked(p, *reader.attributes.material.id, shape);
  const bool has_emission_image =
      reader.attributes.area_light && std::holds_alternative<TextureId>(reader.attributes.area_light->radiance);
  const bool textured = reader.used_texture || has_emission_image;
  const Geometry geometry = plugin(kShapes, "shape", entity.type, entity.where)(p, shape, textured);
  const bool mirrored = geometry.is_mesh && !geometry.has_normals && transform.start.swaps_handedness();
  const bool is_curve = std::holds_alternative<Curves>(shape.geometry);
  shape.flip_normals = !is_curve && reader.attributes.reverse_orientation != mirrored;
  add_emission(p, shape, geometry);
  if (shape.is_visible) add_media(p, shape);
  p.reject_unused();
  if (!shape.is_visible && !shape.radiance) return;
  if (transform.moves()) {
    shape.motion = reader.motion_of(transform, transform.start.inverse() * shape.to_world, entity.where);
    if (shape.motion) shape.to_world = reader.description.motions[static_cast<std::size_t>(*shape.motion)].reference();
  }
  auto& shapes = reader.object != nullptr ? reader.object->group.shapes : reader.description.shapes;
  // Merge the hairs of a hairstyle into one shape. Textured curves stay separate, because merging changes v.
  if (is_curve && !textured && append_curve(shapes, shape)) return;
  shapes.push_back(std::move(shape));
}

}  // namespace sheaf::pbrt
