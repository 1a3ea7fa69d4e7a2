// Shapes, shape groups and instances of a scene.
#pragma once

#include "core/io/error.h"
#include "core/math/transform.h"
#include "scene/description/inputs.h"
#include "scene/description/motion.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sheaf {

/// The tangent of a vertex, in which normal maps and anisotropic materials are given.
struct MeshTangent {
  Vec3f direction;
  float handedness = 1;  ///< 1 or -1: the bitangent is handedness * cross(normal, direction)
  bool operator==(const MeshTangent&) const = default;
};

/// A triangle mesh. Per-vertex arrays are either empty or as long as `positions`.
struct Mesh {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<Vec2f> uvs;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into the vertex arrays, all valid
  /// Named values for every vertex or every triangle.
  struct Attribute {
    std::string name;           ///< begins with "vertex_" or "face_"
    int channels = 1;           ///< 1 or 3
    std::vector<float> values;  ///< `channels` per vertex or per triangle
  };
  std::vector<Attribute> attributes = {};
  /// Replace the directions of increasing u and v, which are the tangents and bitangents of other meshes. Ignored
  /// without normals. Bump maps need the directions of uv: not for meshes with such materials.
  std::vector<MeshTangent> tangents = {};
};

/// A triangle mesh in a file.
struct MeshFileShape {
  std::filesystem::path file;   ///< resolved path
  std::string format = "obj";   ///< ModelFormat::key (scene/formats/model_formats.h)
  bool flip_tex_coords = true;  ///< replace v by 1 - v (Mitsuba's default for OBJ)
  bool smooth_normals = true;   ///< compute smooth normals for vertices without normals
  int shape_index = 0;          ///< index of the mesh in a serialized file
  /// Faces with invalid vertex indices are errors, or are dropped with a warning.
  enum class BadFaces { kError, kDrop } bad_faces = BadFaces::kError;
};
/// A mesh that deforms: the same triangles at several times. Between them its vertices and normals change linearly;
/// before the first and after the last one it is static.
struct DeformingMesh {
  struct Key {
    double time = 0;  ///< in the unit of ShutterDescription
    std::variant<MeshFileShape, Mesh> mesh;
    Transform to_shape = {};  ///< to the space of the shape
  };
  std::vector<Key> keys;  ///< at least one; times increase
};
/// `center` is in the shape's local space. Normals point outwards.
struct SphereShape {
  Vec3d center{0, 0, 0};
  float radius = 1;
};
/// [-1, 1]^2 in the xy plane, normal +z, uv (0, 0) at (-1, -1).
struct RectangleShape {};
/// [-1, 1]^3, normals outwards; each face covers the unit square of uv.
struct CubeShape {};
/// Unit disk in the xy plane, normal +z; u is the radius, v the angle / 2 pi.
struct DiskShape {};
/// Open cylinder around the segment p0 p1; normals outwards; u is the angle / 2 pi, v runs from p0 to p1.
struct CylinderShape {
  Vec3d p0{0, 0, 0}, p1{0, 0, 1};
  float radius = 1;
};

/// Round tubes, normals outwards. u is the angle / 2 pi; v runs along all segments in order.
struct Curves {
  enum class Basis {
    kLinear,   ///< cones between neighboring points, with spheres around the points
    kBspline,  ///< uniform cubic B-splines, one segment per four consecutive points; no caps at the ends
  } basis = Basis::kBspline;
  struct Point {
    Vec3f position;
    float radius = 0;  ///< not negative; the shape's transform does not scale it
  };
  std::vector<Point> points;          ///< points of all curves, curve after curve
  std::vector<std::uint32_t> starts;  ///< index of the first point of each curve; increasing, starts with 0

  /// Points per segment.
  std::uint32_t order() const { return basis == Basis::kLinear ? 2 : 4; }
};

/// Curves that deform: the same curves at several times. Between them positions and radii change linearly; before the
/// first and after the last one they are static.
struct DeformingCurves {
  struct Key {
    double time = 0;  ///< in the unit of ShutterDescription
    Curves curves;
    Transform to_shape = {};  ///< of the points, to the space of the shape
  };
  std::vector<Key> keys;  ///< at least one; times increase; all have the same `basis`, `starts` and number of points
};

/// Zero level set of a function on [0, 1]^3, usually a signed distance. Its values are given at grid points, x fastest,
/// with trilinear interpolation. Normals point towards positive values. No uv.
struct SdfGrid {
  std::array<int, 3> size{};   ///< points along each axis, at least 2
  std::vector<float> values;   ///< finite
  bool smooth_normals = true;  ///< see SdfGridRecord::smooth
};

/// Height field over [-1, 1]^2 of the xy plane, from a texture. It becomes a mesh of `width` x `height` vertices, at
/// the centers of the cells of a regular grid on the unit square of uv.
struct HeightFieldShape {
  SpectrumInput texture;  ///< luminance if colored
  int width = 0, height = 0;
  float scale = 1;
  bool smooth = true;  ///< the mesh gets normals
};

struct ShapeDescription {
  std::variant<MeshFileShape, Mesh, SphereShape, RectangleShape, CubeShape, DiskShape, CylinderShape, Curves, SdfGrid,
               HeightFieldShape, DeformingMesh, DeformingCurves>
      geometry;
  Transform to_world;
  bool flip_normals = false;
  bool face_normals = false;           ///< meshes: ignore vertex normals
  std::optional<MaterialId> material;  ///< default: diffuse, reflectance 0.5
  /// Makes the shape an area light that emits on the side of the normal; W / (m^2 sr).
  std::optional<SpectrumInput> radiance;
  /// Texture that `radiance` is multiplied by, if that is a spectrum.
  std::optional<TextureId> radiance_scale = {};
  /// Strength of a clearcoat over the emission: its reflectance attenuates `radiance` (kernels/lights/light_coat.h).
  ScalarInput emission_coat = 0.0f;
  /// The area light emits only along its normal: `radiance` is then radiant exitance, W / m^2. Only photons can sample
  /// it.
  bool emits_along_normal = false;
  bool emits_on_both_sides = false;  ///< the area light also emits on the side opposite to the normal
  /// Total power of the area light, W. `radiance` is scaled by this power over the flux that radiance 1 would emit.
  std::optional<float> power;
  /// Media behind and in front of the surface. Both empty: the surface does not change the medium. One empty: vacuum
  /// there.
  std::optional<MediumId> interior, exterior;
  /// The exterior is the medium that contains the shape; `exterior` is then empty.
  bool exterior_is_surrounding = false;
  SourceLocation where;
  std::string id = {}, emitter_id = {};  ///< names of the shape and of its area light in files; may be empty
  /// Of shapes outside of groups.
  std::optional<MotionId> motion = {};
  /// False: rays never hit the shape. If it emits, only light sampling finds it.
  bool is_visible = true;
};

/// Shapes that are visible only through instances. Their transforms lead to the group's space. Each instance of an
/// emitting shape is a separate light.
struct ShapeGroup {
  std::vector<ShapeDescription> shapes;
  std::string id;  ///< name for messages; may be empty
  SourceLocation where;
};

/// An instance of a shape group. Kept small: scenes may have millions.
struct InstanceDescription {
  std::array<double, 12> to_world{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  ///< rows of the 3x4 matrix; invertible
  std::uint32_t group = 0;                                              ///< index into Description::groups
  std::optional<MotionId> motion = {};
};

}  // namespace sheaf
