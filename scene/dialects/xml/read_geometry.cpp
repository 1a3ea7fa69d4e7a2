// Shapes shared by the Nori and Mitsuba dialects: mesh files, quadrics, curves, height fields, signed distance grids.
#include "scene/dialects/xml/read_geometry.h"

#include "scene/formats/curve_file.h"
#include "scene/formats/hair_file.h"
#include "scene/formats/height_field.h"
#include "scene/formats/vol_file.h"

#include <limits>

namespace sheaf {

namespace {

void read_mesh_file(Properties& p, bool flips_obj, ShapeDescription& shape) {
  MeshFileShape mesh;
  mesh.format = p.type();
  mesh.file = p.file("filename");
  shape.face_normals = p.boolean("face_normals", false);
  mesh.smooth_normals = flips_obj;
  if (mesh.format == "serialized") {
    mesh.flip_tex_coords = false;
    mesh.shape_index = p.integer("shape_index", 0, 0, std::numeric_limits<int>::max());
  } else {
    mesh.flip_tex_coords = p.boolean("flip_tex_coords", flips_obj && mesh.format == "obj");
  }
  if (p.find_number("max_smooth_angle"))
    p.context().note(p.where(), "'max_smooth_angle' ignored: normals follow 'face_normals' and the file");
  p.ignore({"collapse"});
  if (mesh.format == "ply") p.ignore({"srgb"});
  shape.geometry = std::move(mesh);
}

void read_sphere(Properties& p, bool, ShapeDescription& shape) {
  const Vec3d center = p.point("center", {0, 0, 0});
  shape.geometry = SphereShape{center, p.number("radius", 1, kPositive)};
}

void read_cylinder(Properties& p, bool, ShapeDescription& shape) {
  CylinderShape cylinder;
  cylinder.p0 = p.point("p0", cylinder.p0);
  cylinder.p1 = p.point("p1", cylinder.p1);
  cylinder.radius = p.number("radius", 1, kPositive);
  if (cylinder.p0 == cylinder.p1) p.fail("has no length: 'p0' and 'p1' coincide", SceneErrorCode::kOutOfRange);
  shape.geometry = cylinder;
}

void read_curves(Properties& p, bool, ShapeDescription& shape) {
  const auto basis = p.type() == "linearcurve" ? Curves::Basis::kLinear : Curves::Basis::kBspline;
  shape.geometry = read_curve_file(p.file("filename"), basis);
}

/// `keep_straight`: keep points where hairs are straight.
void read_hair(Properties& p, ShapeDescription& shape, bool keep_straight) {
  HairReading reading;
  reading.keep_straight = keep_straight;
  reading.radius = p.number("radius", reading.radius, kPositive);
  // The transform scales radii by its length along z.
  reading.radius *= length(p.placement("to_world").to_world.vector({0, 0, 1}));
  reading.angle_threshold = p.number("angle_threshold", reading.angle_threshold, {0, 90, false});
  reading.reduction = p.number("reduction", reading.reduction, kUnitInterval);
  if (reading.reduction == 1) {
    p.report_at("reduction", "is 1, expected less than 1", SceneErrorCode::kOutOfRange);
    reading.reduction = HairReading().reduction;
  }
  shape.geometry = read_hair_file(p.file("filename"), reading);
}

void read_reduced_hair(Properties& p, bool, ShapeDescription& shape) { read_hair(p, shape, false); }
void read_whole_hair(Properties& p, bool, ShapeDescription& shape) { read_hair(p, shape, true); }

/// Reads a height field: a mesh if the heights are an image, else a grid of points at which the texture is evaluated.
void read_height_field_shape(Properties& p, bool, ShapeDescription& shape) {
  const bool smooth = p.boolean("shading_normals", true);
  const float scale = p.number("scale", 1);
  constexpr int kDefaultSize = 256;
  const int width = p.integer("width", kDefaultSize, 2, kMaxGridSide),
            height = p.integer("height", kDefaultSize, 2, kMaxGridSide);
  shape.face_normals = !smooth;
  // Read heights from an image file
  const XmlElement* nested = p.any_texture();
  if (nested == nullptr) {
    shape.geometry = read_height_field(p.file("filename"), scale, smooth, false);
    return;
  }
  if (p.has("filename")) p.report_conflict("filename", "a texture");
  // Read heights from a texture; a bitmap counts as an image
  const SpectrumInput input = p.context().readers.texture(*nested, p.context());
  const auto* id = std::get_if<TextureId>(&input);
  const BitmapDescription* bitmap =
      id == nullptr
          ? nullptr
          : std::get_if<BitmapDescription>(&p.context().description.textures.at(static_cast<std::size_t>(*id)).model);
  if (bitmap == nullptr || bitmap->made) {
    shape.geometry = HeightFieldShape{input, width, height, scale, smooth};
    return;
  }
  if (bitmap->change.invert || bitmap->change.exponent != 1.0f || bitmap->channel != BitmapDescription::Channel::kColor)
    throw SceneError(nested->where,
                     "is inverted, raised to a power or a single channel, expected a plain texture for a height field",
                     SceneErrorCode::kUnsupported);
  shape.geometry = read_height_field(bitmap->file, scale * bitmap->change.scale, smooth, bitmap->raw);
}

void read_sdf_grid(Properties& p, bool, ShapeDescription& shape) {
  const std::filesystem::path file = p.file("filename");
  DenseVolume volume = read_vol(file, false);
  if (volume.channels != 1)
    throw SceneError(SourceLocation{file.string()}, "is a grid of colors, expected one channel of distances");
  SdfGrid grid{volume.size, std::move(volume.values)};
  for (const int side : grid.size)
    if (side < 2)
      throw SceneError(SourceLocation{file.string()},
                       "has a side of 1 point, expected at least 2 points along each axis");
  static constexpr NameTable<bool> kNormals{{{"smooth", true}, {"analytic", false}}};
  grid.smooth_normals = p.choice("normals", kNormals, true);
  shape.geometry = std::move(grid);
}

template <class Shape> void read_unit_shape(Properties&, bool, ShapeDescription& shape) { shape.geometry = Shape{}; }

}  // namespace

constexpr NameTable<GeometryReader> kSharedShapes{{{"bsplinecurve", read_curves},
                                                   {"cube", read_unit_shape<CubeShape>},
                                                   {"cylinder", read_cylinder},
                                                   {"disk", read_unit_shape<DiskShape>},
                                                   {"hair", read_reduced_hair},
                                                   {"heightfield", read_height_field_shape},
                                                   {"linearcurve", read_curves},
                                                   {"obj", read_mesh_file},
                                                   {"ply", read_mesh_file},
                                                   {"rectangle", read_unit_shape<RectangleShape>},
                                                   {"sdfgrid", read_sdf_grid},
                                                   {"serialized", read_mesh_file},
                                                   {"sphere", read_sphere}}};

constexpr NameTable<GeometryReader> kShapesWithAllPoints{{{"hair", read_whole_hair}}};

}  // namespace sheaf
