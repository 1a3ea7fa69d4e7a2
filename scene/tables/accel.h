// Embree's acceleration structures: of the scene, and of points and lines near rays. accel.cpp is the only file that
// includes Embree.
#pragma once

#include "scene/tables/shape_rows.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sheaf {

/// Rays per call.
inline constexpr int kPacketWidth = 16;

/// Sixteen rays with room for their hits, laid out as Embree wants them. Rays must be finite; directions need not be
/// normalised, distances are in units of their length.
struct alignas(64) RayPacket {
  float origin_x[kPacketWidth], origin_y[kPacketWidth], origin_z[kPacketWidth];
  float t_near[kPacketWidth];
  float direction_x[kPacketWidth], direction_y[kPacketWidth], direction_z[kPacketWidth];
  float time[kPacketWidth];
  float t_far[kPacketWidth];  ///< in: farthest distance; out: distance of the hit, or -infinity from occluded()
  std::uint32_t mask[kPacketWidth];
  std::uint32_t id[kPacketWidth];  ///< the caller's, left alone
  std::uint32_t flags[kPacketWidth];
  float normal_x[kPacketWidth], normal_y[kPacketWidth], normal_z[kPacketWidth];  ///< geometric, any length
  float u[kPacketWidth], v[kPacketWidth];  ///< barycentric coordinates of the second and third vertex; of curves
                                           ///< u alone, along the segment
  std::uint32_t primitive[kPacketWidth];   ///< triangle, segment or cell of the shape
  std::uint32_t shape[kPacketWidth];       ///< kNone: no hit. intersect() wants it to be kNone on entry
  std::uint32_t instance[kPacketWidth];    ///< row of the instance that was hit; kNone: the shape is in no group
  std::uint32_t instance_primitive[kPacketWidth];

  /// Fills what does not change from packet to packet.
  RayPacket();
};

/// The shapes of a group: `shape_count` rows of AccelInput::shapes.
struct ShapeRange {
  std::uint32_t first_shape, shape_count;
};

/// The geometry tables that Embree is to index; they must outlive the Accel.
struct AccelInput {
  const ShapeRow* shapes;
  std::uint32_t shape_count;  ///< those that are in no group; the groups' shapes follow them
  const VertexRow* vertices;
  const std::uint32_t* triangles;
  const QuadricRow* quadrics;
  const CurvePointRow* curve_points;
  const std::uint32_t* curve_segments;
  const SdfGridRow* sdf_grids;
  const float* sdf_values;
  const std::uint32_t* sdf_cells;
  const std::uint32_t* vertex_counts;  ///< per shape; of curves their points
  bool watertight;                     ///< see CompileOptions::watertight
  const ShapeRange* groups;            ///< none of them empty
  std::uint32_t group_count;
  const InstanceRow* instances;
  std::uint32_t instance_count;
};

/// A built acceleration structure. Const and safe to query from many threads. Results are the same bits whoever shares
/// the packet and however many threads built it.
class Accel {
 public:
  explicit Accel(const AccelInput& input);
  ~Accel();
  Accel(const Accel&) = delete;
  Accel& operator=(const Accel&) = delete;

  /// Nearest hits of the first `count` rays.
  void intersect(RayPacket& packet, int count) const noexcept;
  /// Whether anything lies before t_far, for the first `count` rays: t_far becomes -infinity.
  void occluded(RayPacket& packet, int count) const noexcept;
  /// Memory that Embree holds, in bytes.
  std::size_t bytes() const;

  /// The Embree library's version, e.g. "3.13.5".
  static const char* library_version();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A point and how far from it rays are still near.
struct alignas(16) AccelPoint {
  float x, y, z, radius;  ///< metres
};

/// A point near a ray.
struct NearPoint {
  float t;              ///< along the ray, metres
  float squared;        ///< distance across it over the point's radius, squared; below 1
  std::uint32_t index;  ///< of the point
};

/// Points, to be found near rays. Const and safe to query from many threads.
class PointAccel {
 public:
  /// Empty.
  PointAccel();
  /// Throws Error (runtime) where memory does not suffice.
  explicit PointAccel(std::vector<AccelPoint> points);
  ~PointAccel();
  PointAccel(PointAccel&&) noexcept;
  PointAccel& operator=(PointAccel&&) noexcept;

  /// Appends the points that lie nearer to the ray than their radius, measured across it, and along it between 0 and
  /// `length`; in no order. `direction`: unit length.
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

/// A stretch of a line.
struct AccelLine {
  Vec3f start, direction;  ///< unit length
  float length;            ///< metres
};

/// A line near a ray: where they are nearest to each other.
struct NearLine {
  float t;              ///< along the ray, metres
  float along;          ///< along the line from its start, metres
  float squared;        ///< distance between them over the radius, squared; below 1
  float cosine, sine;   ///< of the angle between their directions, the sine positive
  std::uint32_t index;  ///< of the line
};

/// Lines, to be found near rays. Const and safe to query from many threads.
class LineAccel {
 public:
  /// Empty.
  LineAccel();
  /// `radius`: how far from lines rays are still near, metres. Lines longer than `piece`, metres, are cut for Embree,
  /// whose boxes around long ones hold much else. Throws Error (runtime) where memory does not suffice.
  LineAccel(const std::vector<AccelLine>& lines, float radius, float piece);
  ~LineAccel();
  LineAccel(LineAccel&&) noexcept;
  LineAccel& operator=(LineAccel&&) noexcept;

  /// Appends the lines that come nearer to the ray than the radius where both are nearest to each other: on the ray
  /// between 0 and `length`, on the line between its ends. In no order, each once; not those that are as good as
  /// parallel to the ray. `direction`: unit length.
  void near_ray(Vec3f origin, Vec3f direction, float length, std::vector<NearLine>& found) const noexcept;
  std::size_t size() const { return size_; }
  /// All memory, in bytes.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::size_t size_ = 0;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheaf
