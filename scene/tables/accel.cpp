#include "scene/tables/accel.h"

#include "core/error.h"
#include "core/memory.h"
#include "scene/tables/build_quality.h"
#include "scene/tables/instance.h"
#include "scene/tables/quadric.h"
#include "scene/tables/scene.h"
#include "scene/tables/sdf_grid.h"

#if SHEAF_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <deque>
#include <new>
#include <vector>

namespace sheaf {

// RayPacket has the layout of Embree's RTCRayHit16, with room at the end for fields that newer versions append.
static_assert(offsetof(RTCRayHit16, ray.tfar) == offsetof(RayPacket, t_far));
static_assert(offsetof(RTCRayHit16, hit.Ng_x) == offsetof(RayPacket, normal_x));
static_assert(offsetof(RTCRayHit16, hit.geomID) == offsetof(RayPacket, shape));
static_assert(offsetof(RTCRayHit16, hit.instID) == offsetof(RayPacket, instance));
static_assert(sizeof(RTCRayHit16) <= sizeof(RayPacket));

RayPacket::RayPacket() {
  std::memset(static_cast<void*>(this), 0, sizeof(*this));
  for (int i = 0; i < kPacketWidth; ++i) {
    mask[i] = 0xffffffffu;
    shape[i] = instance[i] = instance_primitive[i] = kNone;
  }
}

namespace {

/// An Embree device with one scene.
struct EmbreeScene {
  std::atomic<std::ptrdiff_t> bytes{0};
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  EmbreeScene() = default;
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
  // Both throw Error.
  void start(bool watertight);
  void check() const;
};

}  // namespace

struct Accel::Impl : EmbreeScene {
  const InstanceRow* instances = nullptr;  ///< null: no instances
  std::uint32_t first_instance = 0;        ///< geometry id of the first instance
  std::deque<SdfGridView> sdf_grids;       ///< Embree holds pointers to these
};

namespace {

/// Number of threads that Embree assumes for builds. Its builders split work by this number, which affects the order of
/// triangles in leaves and so ties between equal distances. A constant makes all builds identical.
constexpr int kBuildConcurrency = 8;

/// Embree's valid masks for 0 to kPacketWidth rays.
struct ValidMasks {
  alignas(64) int masks[kPacketWidth + 1][kPacketWidth];
  constexpr ValidMasks() : masks{} {
    for (int count = 0; count <= kPacketWidth; ++count)
      for (int i = 0; i < count; ++i) masks[count][i] = -1;
  }
};
constexpr ValidMasks kValid;

bool count_memory(void* user, ssize_t bytes, bool /*after*/) {
  static_cast<std::atomic<std::ptrdiff_t>*>(user)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

void write_bounds(const RTCBoundsFunctionArguments* args, const QuadricBounds& b) {
  *args->bounds_o = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, 0};
}
void bounds_callback(const RTCBoundsFunctionArguments* args) {
  write_bounds(args, quadric_bounds(*static_cast<const QuadricRow*>(args->geometryUserPtr)));
}
void sdf_bounds_callback(const RTCBoundsFunctionArguments* args) {
  write_bounds(args, sdf_cell_bounds(*static_cast<const SdfGridView*>(args->geometryUserPtr), args->primID));
}

/// Intersection functions of user geometries, for one primitive at a time.
struct QuadricSurface {
  static std::optional<QuadricHit> intersect(const void* quadric, std::uint32_t /*primitive*/, Vec3f origin,
                                             Vec3f direction, float t_near, float t_far) {
    return intersect_quadric(*static_cast<const QuadricRow*>(quadric), origin, direction, t_near, t_far);
  }
};
struct SdfSurface {
  static std::optional<QuadricHit> intersect(const void* grid, std::uint32_t cell, Vec3f origin, Vec3f direction,
                                             float t_near, float t_far) {
    return intersect_sdf_cell(*static_cast<const SdfGridView*>(grid), cell, origin, direction, t_near, t_far);
  }
};

/// Intersects ray `i` of `n` with the surface.
template <class Surface>
std::optional<QuadricHit> intersect_one(const void* surface, std::uint32_t primitive, RTCRayN* rays, unsigned n,
                                        unsigned i) {
  const Vec3f origin{RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)};
  const Vec3f direction{RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)};
  return Surface::intersect(surface, primitive, origin, direction, RTCRayN_tnear(rays, n, i), RTCRayN_tfar(rays, n, i));
}

template <class Surface> void intersect_callback(const RTCIntersectFunctionNArguments* args) {
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const auto hit = intersect_one<Surface>(args->geometryUserPtr, args->primID, rays, args->N, i);
    if (!hit) continue;
    RTCRayN_tfar(rays, args->N, i) = hit->t;
    RTCHitN_Ng_x(hits, args->N, i) = hit->normal.x;
    RTCHitN_Ng_y(hits, args->N, i) = hit->normal.y;
    RTCHitN_Ng_z(hits, args->N, i) = hit->normal.z;
    RTCHitN_u(hits, args->N, i) = RTCHitN_v(hits, args->N, i) = 0.0f;
    RTCHitN_primID(hits, args->N, i) = args->primID;
    RTCHitN_geomID(hits, args->N, i) = args->geomID;
    RTCHitN_instID(hits, args->N, i, 0) = args->context->instID[0];
  }
}

template <class Surface> void occluded_callback(const RTCOccludedFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i)
    if (args->valid[i] != 0 && intersect_one<Surface>(args->geometryUserPtr, args->primID, args->ray, args->N, i))
      RTCRayN_tfar(args->ray, args->N, i) = -kInfinity;
}

RTCGeometry make_mesh(RTCDevice device, const AccelInput& in, const ShapeRow& shape, std::uint32_t vertex_count) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, in.vertices + shape.first_vertex,
                             0, sizeof(VertexRow), vertex_count);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             in.triangles + 3 * std::size_t(shape.first_triangle), 0, 12, shape.triangle_count);
  return geometry;
}

RTCGeometry make_quadric_geometry(RTCDevice device, const QuadricRow& row) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryUserData(geometry, const_cast<QuadricRow*>(&row));
  rtcSetGeometryBoundsFunction(geometry, bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback<QuadricSurface>);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback<QuadricSurface>);
  return geometry;
}

/// One primitive per cell that contains the surface. `grid` must not move.
RTCGeometry make_sdf_geometry(RTCDevice device, const SdfGridView& grid, std::uint32_t cell_count) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, cell_count);
  rtcSetGeometryUserData(geometry, const_cast<SdfGridView*>(&grid));
  rtcSetGeometryBoundsFunction(geometry, sdf_bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback<SdfSurface>);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback<SdfSurface>);
  return geometry;
}

/// Culls back faces of curves: rays that leave a curve could otherwise hit it from inside due to rounding.
void cull_inside(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    const Vec3f direction{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                          RTCRayN_dir_z(args->ray, args->N, i)};
    const Vec3f normal{RTCHitN_Ng_x(args->hit, args->N, i), RTCHitN_Ng_y(args->hit, args->N, i),
                       RTCHitN_Ng_z(args->hit, args->N, i)};
    if (!(dot(normal, direction) < 0.0f)) args->valid[i] = 0;
  }
}

RTCGeometry make_curves(RTCDevice device, const AccelInput& in, const ShapeRow& shape, std::uint32_t point_count) {
  const bool linear = static_cast<ShapeKind>(shape.kind) == ShapeKind::kLinearCurves;
  RTCGeometry geometry =
      rtcNewGeometry(device, linear ? RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE : RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                             in.curve_points + shape.first_vertex, 0, sizeof(CurvePointRow), point_count);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT,
                             in.curve_segments + shape.first_triangle, 0, sizeof(std::uint32_t), shape.triangle_count);
  rtcSetGeometryIntersectFilterFunction(geometry, cull_inside);
  rtcSetGeometryOccludedFilterFunction(geometry, cull_inside);
  if (!linear) return geometry;
  // With these flags, Embree joins neighbouring segments without a surface in between.
  auto* flags = static_cast<std::uint8_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR, 1, shape.triangle_count));
  const std::uint32_t* first = in.curve_segments + shape.first_triangle;
  for (std::uint32_t i = 0; flags != nullptr && i < shape.triangle_count; ++i) {
    const bool after = i > 0 && first[i - 1] + 1 == first[i];
    const bool before = i + 1 < shape.triangle_count && first[i] + 1 == first[i + 1];
    flags[i] = static_cast<std::uint8_t>((after ? RTC_CURVE_FLAG_NEIGHBOR_LEFT : 0) |
                                         (before ? RTC_CURVE_FLAG_NEIGHBOR_RIGHT : 0));
  }
  return geometry;
}

/// Geometry of shape `i`. Views of SDF grids are appended to `grids`.
RTCGeometry make_shape(RTCDevice device, const AccelInput& in, std::uint32_t i, std::deque<SdfGridView>& grids) {
  const ShapeRow& shape = in.shapes[i];
  switch (static_cast<ShapeKind>(shape.kind)) {
    case ShapeKind::kMesh:
      return make_mesh(device, in, shape, in.vertex_counts[i]);
    case ShapeKind::kLinearCurves:
    case ShapeKind::kBsplineCurves:
      return make_curves(device, in, shape, in.vertex_counts[i]);
    case ShapeKind::kSdfGrid:
      grids.push_back(sdf_grid_view(in.quadrics, in.sdf_grids[shape.first_vertex], shape, in.sdf_values, in.sdf_cells));
      return make_sdf_geometry(device, grids.back(), shape.triangle_count);
    default:
      return make_quadric_geometry(device, in.quadrics[shape.first_triangle]);
  }
}

/// Builds the same structure on every machine.
void commit_alike(RTCScene scene) {
  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism, kBuildConcurrency);
  tbb::task_arena arena(kBuildConcurrency);
  arena.execute([scene] { rtcJoinCommitScene(scene); });
}

RTCScene make_scene(RTCDevice device, bool watertight) {
  RTCScene scene = rtcNewScene(device);
  if (watertight) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  return scene;
}

/// Throws Error (exit code 1) if an address-space limit leaves too little for the stacks and heaps of Embree's threads.
/// These would otherwise deadlock.
void check_addresses() {
  constexpr double kEmbreeAddresses = 160e6;
  if (available_addresses() >= kEmbreeAddresses) return;
  const MemoryUse embree{"addresses of Embree and its threads", kEmbreeAddresses, "raise the limit, see `ulimit -v`"};
  throw not_enough_memory("building the acceleration structure", {&embree, 1});
}

void EmbreeScene::start(bool watertight) {
  check_addresses();
  device = rtcNewDevice(nullptr);
  if (!device) throw Error(ExitCode::kRuntime, "Embree cannot be started on this machine");
  rtcSetDeviceMemoryMonitorFunction(device, count_memory, &bytes);
  scene = make_scene(device, watertight);
}

void EmbreeScene::check() const {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE) throw Error(ExitCode::kRuntime, "Embree could not build the acceleration structure");
}

void attach(RTCScene scene, RTCGeometry geometry, std::uint32_t id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

/// Attaches the shapes of `range` with ids from 0: the size of Embree's tables depends on the largest id.
void attach_shapes(RTCDevice device, RTCScene scene, const AccelInput& in, ShapeRange range,
                   std::deque<SdfGridView>& grids) {
  if (is_worth_splitting(in, range)) rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  for (std::uint32_t id = 0; id < range.shape_count; ++id) {
    const std::uint32_t i = range.first_shape + id;
    const ShapeRow& shape = in.shapes[i];
    if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh && shape.triangle_count == 0) continue;
    attach(scene, make_shape(device, in, i, grids), id);
  }
}

/// Attaches all instances, with ids from `first_id`.
void attach_instances(RTCDevice device, RTCScene scene, const AccelInput& in, std::uint32_t first_id,
                      std::deque<SdfGridView>& grids) {
  std::vector<RTCScene> groups;
  for (std::uint32_t i = 0; i < in.group_count; ++i) {
    groups.push_back(make_scene(device, in.watertight));
    attach_shapes(device, groups.back(), in, in.groups[i], grids);
    commit_alike(groups.back());
  }
  for (std::uint32_t i = 0; i < in.instance_count; ++i) {
    const InstanceRow& row = in.instances[i];
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, groups[row.group]);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, row.to_world);
    attach(scene, geometry, first_id + i);
  }
  for (RTCScene group : groups) rtcReleaseScene(group);  // the instances hold references
}

/// Converts group-relative shape ids to scene ids, and normals from the group's space to world space.
void resolve_instances(RayPacket& packet, int count, const InstanceRow* instances, std::uint32_t first_instance) {
  using L = Wide;
  for (int at = 0; at < count; at += L::width) {
    Uint<L> shape, instance;
    load(packet.shape + at, shape);
    load(packet.instance + at, instance);
    const auto instanced = L::first(count - at) & (shape != Uint<L>(kNone)) & (instance != Uint<L>(kNone));
    const Uint<L> row = instance - Uint<L>(first_instance);
    store(packet.instance + at, select(instanced, row, Uint<L>(kNone)));
    if (!any(instanced)) continue;
    const InstanceRecord<L> record = gather_rows<L>(instances, select(instanced, row, Uint<L>(0u)));
    const InstancePlacement<L> placed(record);
    store(packet.shape + at, select(instanced, shape + record.first_shape, shape));
    Vec3<L> normal;
    load(packet.normal_x + at, normal.x);
    load(packet.normal_y + at, normal.y);
    load(packet.normal_z + at, normal.z);
    normal = select<L>(instanced, placed.normal(normal), normal);
    store(packet.normal_x + at, normal.x);
    store(packet.normal_y + at, normal.y);
    store(packet.normal_z + at, normal.z);
  }
}

}  // namespace

Accel::Accel(const AccelInput& input) : impl_(std::make_unique<Impl>()) {
  impl_->start(input.watertight);
  attach_shapes(impl_->device, impl_->scene, input, {0, input.shape_count}, impl_->sdf_grids);
  if (input.instance_count > 0) {
    impl_->instances = input.instances;
    impl_->first_instance = input.shape_count;
    attach_instances(impl_->device, impl_->scene, input, input.shape_count, impl_->sdf_grids);
  }
  commit_alike(impl_->scene);
  impl_->check();
}

Accel::~Accel() = default;

#if SHEAF_EMBREE_MAJOR >= 4
void Accel::intersect(RayPacket& packet, int count) const noexcept {
  RTCIntersectArguments args;
  rtcInitIntersectArguments(&args);
  args.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcIntersect16(kValid.masks[count], impl_->scene, reinterpret_cast<RTCRayHit16*>(&packet), &args);
  if (impl_->instances) resolve_instances(packet, count, impl_->instances, impl_->first_instance);
}

void Accel::occluded(RayPacket& packet, int count) const noexcept {
  RTCOccludedArguments args;
  rtcInitOccludedArguments(&args);
  args.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcOccluded16(kValid.masks[count], impl_->scene, reinterpret_cast<RTCRay16*>(&packet), &args);
}
#else
void Accel::intersect(RayPacket& packet, int count) const noexcept {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect16(kValid.masks[count], impl_->scene, &context, reinterpret_cast<RTCRayHit16*>(&packet));
  if (impl_->instances) resolve_instances(packet, count, impl_->instances, impl_->first_instance);
}

void Accel::occluded(RayPacket& packet, int count) const noexcept {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcOccluded16(kValid.masks[count], impl_->scene, &context, reinterpret_cast<RTCRay16*>(&packet));
}
#endif

std::size_t Accel::bytes() const { return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, impl_->bytes.load())); }

const char* Accel::library_version() { return RTC_VERSION_STRING; }

struct PointAccel::Impl : EmbreeScene {};

namespace {

#if SHEAF_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

/// A query along one ray. Embree passes the context to the filter.
struct NearQuery {
  QueryContext context;
  Vec3f origin, direction;
  float length;
};
struct PointQuery : NearQuery {
  const AccelPoint* points;
  std::vector<NearPoint>* found;
};

/// Runs the filter of the scene's geometry for everything closer to the ray than `radius`.
void look_along(RTCScene scene, NearQuery& query, float radius) {
  // Embree ignores hits closer than twice the radius of a point or curve, to avoid self-intersection.
  const float ahead = 2.1f * radius, margin = 0.01f * radius;
  const Vec3f start = query.origin - query.direction * ahead;
  RTCRay ray{};
  ray.org_x = start.x, ray.org_y = start.y, ray.org_z = start.z;
  ray.dir_x = query.direction.x, ray.dir_y = query.direction.y, ray.dir_z = query.direction.z;
  ray.tfar = ahead + query.length + margin;
  ray.mask = 0xffffffffu;
#if SHEAF_EMBREE_MAJOR >= 4
  rtcInitRayQueryContext(&query.context);
  RTCOccludedArguments args;
  rtcInitOccludedArguments(&args);
  args.context = &query.context;
  rtcOccluded1(scene, &ray, &args);
#else
  rtcInitIntersectContext(&query.context);
  rtcOccluded1(scene, &query.context, &ray);
#endif
}

/// Records each point that passes our own distance test, and continues the ray.
void collect_point(const RTCFilterFunctionNArguments* args) {
  const auto* query = static_cast<const PointQuery*>(reinterpret_cast<const NearQuery*>(args->context));
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    args->valid[i] = 0;
    const std::uint32_t index = RTCHitN_primID(args->hit, args->N, i);
    const AccelPoint& point = query->points[index];
    const Vec3f from = Vec3f{point.x, point.y, point.z} - query->origin;
    const float t = dot(from, query->direction);
    const Vec3f across = from - query->direction * t;
    const float squared = dot(across, across) / (point.radius * point.radius);
    if (t > 0.0f && t < query->length && squared < 1.0f) query->found->push_back({t, squared, index});
  }
}

}  // namespace

PointAccel::PointAccel() = default;
PointAccel::~PointAccel() = default;
PointAccel::PointAccel(PointAccel&&) noexcept = default;
PointAccel& PointAccel::operator=(PointAccel&&) noexcept = default;

PointAccel::PointAccel(std::vector<AccelPoint> points) : points_(std::move(points)) {
  if (points_.empty()) return;
  for (const AccelPoint& point : points_) largest_radius_ = max(largest_radius_, point.radius);
  impl_ = std::make_unique<Impl>();
  impl_->start(false);
  RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_DISC_POINT);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, points_.data(), 0,
                             sizeof(AccelPoint), points_.size());
  rtcSetGeometryOccludedFilterFunction(geometry, collect_point);
  attach(impl_->scene, geometry, 0);
  rtcJoinCommitScene(impl_->scene);
  impl_->check();
}

void PointAccel::near_ray(Vec3f origin, Vec3f direction, float length, std::vector<NearPoint>& found) const noexcept {
  if (impl_ == nullptr) return;
  PointQuery query{{{}, origin, direction, length}, points_.data(), &found};
  look_along(impl_->scene, query, largest_radius_);
}

std::size_t PointAccel::bytes() const {
  return impl_ == nullptr ? 0 : static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, impl_->bytes.load()));
}

namespace {

/// A line as stored for the filter.
struct LineRow {
  Vec3f start;
  float length;
  Vec3f direction;
  float pieces;
};
struct LinePiece {
  std::uint32_t line, number;
};

}  // namespace

struct LineAccel::Impl : EmbreeScene {
  std::vector<LineRow> lines;
  std::vector<LinePiece> pieces;
  std::vector<AccelPoint> ends;       ///< ends of pieces, consecutive for each line
  std::vector<std::uint32_t> begins;  ///< index of each piece's first end
  float radius = 0;
};

namespace {

/// Maximum number of pieces per line.
constexpr float kMaxPieces = 64;
/// Factor by which Embree's curves are wider, to allow for its rounding.
constexpr float kWider = 1.02f;
/// Squared sine below which directions count as parallel.
constexpr float kParallel = 1e-8f;

struct LineQuery : NearQuery {
  const LineRow* lines;
  const LinePiece* pieces;
  float radius;
  std::vector<NearLine>* found;
};

/// Records a line once: only for the piece that contains the point nearest to the ray, by the geometry of the whole
/// line.
void collect_line(const RTCFilterFunctionNArguments* args) {
  const auto* query = static_cast<const LineQuery*>(reinterpret_cast<const NearQuery*>(args->context));
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    args->valid[i] = 0;
    const LinePiece piece = query->pieces[RTCHitN_primID(args->hit, args->N, i)];
    const LineRow& line = query->lines[piece.line];
    const Vec3f from = line.start - query->origin, normal = cross(query->direction, line.direction);
    const float square = dot(normal, normal);
    if (!(square > kParallel)) continue;
    const float inverse = 1.0f / square, t = dot(cross(from, line.direction), normal) * inverse,
                along = dot(cross(from, query->direction), normal) * inverse,
                squared = sqr(dot(from, normal) / query->radius) * inverse;
    if (!(t > 0.0f && t < query->length && along >= 0.0f && along < line.length && squared < 1.0f)) continue;
    if (min(std::floor(along / line.length * line.pieces), line.pieces - 1.0f) != static_cast<float>(piece.number))
      continue;
    query->found->push_back({t, along, squared, dot(query->direction, line.direction), std::sqrt(square), piece.line});
  }
}

}  // namespace

LineAccel::LineAccel() = default;
LineAccel::~LineAccel() = default;
LineAccel::LineAccel(LineAccel&&) noexcept = default;
LineAccel& LineAccel::operator=(LineAccel&&) noexcept = default;

LineAccel::LineAccel(const std::vector<AccelLine>& lines, float radius, float piece) : size_(lines.size()) {
  if (lines.empty()) return;
  impl_ = std::make_unique<Impl>();
  Impl& in = *impl_;
  in.radius = radius;
  in.lines.reserve(lines.size());
  for (std::uint32_t k = 0; k < lines.size(); ++k) {
    const AccelLine& line = lines[k];
    const float pieces = clamp(std::ceil(line.length / piece), 1.0f, kMaxPieces);
    in.lines.push_back({line.start, line.length, line.direction, pieces});
    for (std::uint32_t i = 0; static_cast<float>(i) <= pieces; ++i) {
      if (static_cast<float>(i) < pieces) {
        in.pieces.push_back({k, i});
        in.begins.push_back(static_cast<std::uint32_t>(in.ends.size()));
      }
      const Vec3f end = line.start + line.direction * (line.length * (static_cast<float>(i) / pieces));
      in.ends.push_back({end.x, end.y, end.z, kWider * radius});
    }
  }
  in.start(false);
  RTCGeometry geometry = rtcNewGeometry(in.device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, in.ends.data(), 0,
                             sizeof(AccelPoint), in.ends.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, in.begins.data(), 0,
                             sizeof(std::uint32_t), in.begins.size());
  rtcSetGeometryOccludedFilterFunction(geometry, collect_line);
  attach(in.scene, geometry, 0);
  rtcJoinCommitScene(in.scene);
  in.check();
}

void LineAccel::near_ray(Vec3f origin, Vec3f direction, float length, std::vector<NearLine>& found) const noexcept {
  if (impl_ == nullptr) return;
  LineQuery query{{{}, origin, direction, length}, impl_->lines.data(), impl_->pieces.data(), impl_->radius, &found};
  look_along(impl_->scene, query, kWider * impl_->radius);
}

std::size_t LineAccel::bytes() const {
  if (impl_ == nullptr) return 0;
  return impl_->lines.size() * sizeof(LineRow) + impl_->pieces.size() * (sizeof(LinePiece) + sizeof(std::uint32_t)) +
         impl_->ends.size() * sizeof(AccelPoint) +
         static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, impl_->bytes.load()));
}

}  // namespace sheaf
