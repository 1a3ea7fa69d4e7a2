// Embree's acceleration structures for the scene, and for points and lines near rays. embree.h wraps Embree.
#pragma once

#include "scene/tables/motion.h"
#include "scene/tables/shape_rows.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sheaf {

/// Rays per call.
inline constexpr int kPacketWidth = 16;

/// Sixteen rays and their hits, in Embree's layout. Rays must be finite. Directions need not be normalized; distances
/// are in units of their length.
struct alignas(64) RayPacket {
  float origin_x[kPacketWidth], origin_y[kPacketWidth], origin_z[kPacketWidth];
  float t_near[kPacketWidth];
  float direction_x[kPacketWidth], direction_y[kPacketWidth], direction_z[kPacketWidth];
  float time[kPacketWidth];   ///< in [0, 1] over the shutter; used by shapes that move
  float t_far[kPacketWidth];  ///< in: maximum distance; out: distance of the hit, or -infinity from occluded()
  std::uint32_t mask[kPacketWidth];
  std::uint32_t id[kPacketWidth];  ///< for the caller; unchanged
  std::uint32_t flags[kPacketWidth];
  float normal_x[kPacketWidth], normal_y[kPacketWidth], normal_z[kPacketWidth];  ///< geometric, any length
  /// Barycentric coordinates of the second and third vertex. Curves use only u, along the segment.
  float u[kPacketWidth], v[kPacketWidth];
  std::uint32_t primitive[kPacketWidth];  ///< triangle, segment or cell of the shape
  std::uint32_t shape[kPacketWidth];      ///< kNone: no hit; must be kNone on entry to intersect()
  std::uint32_t instance[kPacketWidth];   ///< row of the instance that was hit; kNone: not an instanced shape
  std::uint32_t instance_primitive[kPacketWidth];

  /// Initializes the fields that are the same for all packets.
  RayPacket();

  /// Sets origin, direction and maximum distance of ray `i`.
  void set_ray(int i, Vec3f origin, Vec3f direction, float distance = kInfinity) {
    origin_x[i] = origin.x, origin_y[i] = origin.y, origin_z[i] = origin.z;
    direction_x[i] = direction.x, direction_y[i] = direction.y, direction_z[i] = direction.z;
    t_far[i] = distance;
  }
};

/// Memory layout of acceleration structures.
enum class BvhLayout {
  kFast,     ///< leaves hold copies of the triangles' vertices
  kCompact,  ///< leaves refer to the vertex table: less memory, slower
};

/// Methods of building an acceleration structure, from the shortest time to the fastest rays.
enum class BvhBuild : std::uint8_t {
  kMorton,   ///< splits halfway along a Morton curve: a third of the time, and rays take up to 1.5 times as long
  kSurface,  ///< splits that minimize surface areas
  kSpatial,  ///< also splits triangles, see BvhSplits
};

/// Spatial splits of acceleration structures (Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume
/// Hierarchies", 2009).
enum class BvhSplits {
  kNotNeeded,  ///< they would not make rays faster
  kBuilt,      ///< by some or all structures of the scene
  kLeftOut,    ///< by some or all structures: the rays would not repay them
};

/// The shapes of a group: `shape_count` rows of AccelInput::shapes.
struct ShapeRange {
  std::uint32_t first_shape, shape_count;
};

/// The geometry tables that Embree indexes. They must outlive the Accel.
struct AccelInput {
  const ShapeRow* shapes;
  std::uint32_t shape_count;  ///< shapes outside of groups; the groups' shapes follow
  const VertexRow* vertices;
  const std::uint32_t* triangles;
  const QuadricRow* quadrics;
  const CurvePointRow* curve_points;
  const std::uint32_t* curve_segments;
  const SdfGridRow* sdf_grids;
  const float* sdf_values;
  const std::uint32_t* sdf_cells;
  const std::uint32_t* vertex_counts;  ///< per shape; curves: number of points
  bool watertight;                     ///< see CompileOptions::watertight
  BvhLayout layout;
  const ShapeRange* groups;  ///< none empty
  std::uint32_t group_count;
  const InstanceRow* instances;
  std::uint32_t instance_count;
  MotionView motion;
  /// Prepares for Accel::update(): every shape gets a structure of its own.
  bool updatable = false;
  /// The method for the structure of the shapes outside of groups, then for that of each group; missing elements are
  /// kSurface. Ignored if `updatable`. At equal distances, structures may find different surfaces.
  std::vector<BvhBuild> builds = {};
};

/// A built acceleration structure. Const and safe to query from many threads. Results are bit-identical regardless of
/// the other rays in the packet and of the number of threads that built it.
class Accel {
 public:
  explicit Accel(const AccelInput& input);
  ~Accel();
  Accel(const Accel&) = delete;
  Accel& operator=(const Accel&) = delete;

  /// Nearest hits of the first `count` rays. Other lanes may hold anything; their t_far becomes -infinity.
  void intersect(RayPacket& packet, int count) const noexcept;
  /// Whether anything lies before t_far, for the first `count` rays; sets t_far to -infinity if so, and in other lanes.
  void occluded(RayPacket& packet, int count) const noexcept;
  /// Builds the structures of these shapes again, whose vertices have changed in AccelInput::vertices. `shapes`: meshes
  /// outside of groups. Only for structures that were built with AccelInput::updatable.
  void update(const std::vector<std::uint32_t>& shapes);
  /// Memory that Embree holds, in bytes.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A point with the maximum distance at which rays find it.
struct alignas(16) AccelPoint {
  float x, y, z, radius;  ///< meters
};

/// A point near a ray.
struct NearPoint {
  float t;              ///< along the ray, meters
  float squared;        ///< squared ratio of the distance from the ray to the point's radius; below 1
  std::uint32_t index;  ///< of the point
};

/// Finds points near rays. Const and safe to query from many threads.
class PointAccel {
 public:
  /// Empty.
  PointAccel();
  /// Throws Error (runtime) if out of memory.
  explicit PointAccel(std::vector<AccelPoint> points);
  ~PointAccel();
  PointAccel(PointAccel&&) noexcept;
  PointAccel& operator=(PointAccel&&) noexcept;

  /// Appends the points whose distance from the ray is below their radius, at ray parameters between 0 and `length`, in
  /// unspecified order. `direction` has unit length.
  void near_ray(Vec3f origin, Vec3f direction, float length, std::vector<NearPoint>& found) const noexcept;
  const std::vector<AccelPoint>& points() const { return points_; }
  /// Memory that Embree holds, in bytes.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::vector<AccelPoint> points_;
  float largest_radius_ = 0;
  std::unique_ptr<Impl> impl_;
};

/// A line segment.
struct AccelLine {
  Vec3f start, direction;  ///< unit length
  float length;            ///< meters
};

/// A line near a ray, at their points of closest approach.
struct NearLine {
  float t;              ///< along the ray, meters
  float along;          ///< along the line from its start, meters
  float squared;        ///< squared ratio of their distance to the radius; below 1
  float cosine, sine;   ///< of the angle between their directions; the sine is positive
  std::uint32_t index;  ///< of the line
};

/// Finds line segments near rays. Const and safe to query from many threads.
class LineAccel {
 public:
  /// Empty.
  LineAccel();
  /// `radius`: maximum distance from a ray, meters. Lines longer than `piece`, meters, are split for Embree, because
  /// bounding boxes of long lines are mostly empty. Throws Error (runtime) if out of memory.
  LineAccel(const std::vector<AccelLine>& lines, float radius, float piece);
  ~LineAccel();
  LineAccel(LineAccel&&) noexcept;
  LineAccel& operator=(LineAccel&&) noexcept;

  /// Appends the lines whose distance from the ray is below the radius at the points of closest approach. That point
  /// lies between 0 and `length` on the ray, and between the ends on the line. Each line is appended once, in
  /// unspecified order; nearly parallel lines are skipped. `direction` has unit length.
  void near_ray(Vec3f origin, Vec3f direction, float length, std::vector<NearLine>& found) const noexcept;
  std::size_t size() const { return size_; }
  /// Total memory, in bytes.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::size_t size_ = 0;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheaf
