// The scene's acceleration structure: building it, with instances, and tracing packets of rays.
#include "scene/accel/accel.h"

#include "scene/accel/embree_shapes.h"
#include "scene/tables/instance.h"
#include "scene/tables/motion_sample.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

namespace sheaf {

// RayPacket has the layout of Embree's RTCRayHit16, with room at the end for fields that newer versions append.
static_assert(offsetof(RTCRayHit16, ray.tfar) == offsetof(RayPacket, t_far));
static_assert(offsetof(RTCRayHit16, hit.Ng_x) == offsetof(RayPacket, normal_x));
static_assert(offsetof(RTCRayHit16, hit.geomID) == offsetof(RayPacket, shape));
static_assert(offsetof(RTCRayHit16, hit.instID) == offsetof(RayPacket, instance));
static_assert(sizeof(RTCRayHit16) <= sizeof(RayPacket));
static_assert(sizeof(RTCRayHit8) * 2 == sizeof(RTCRayHit16));

RayPacket::RayPacket() {
  std::memset(static_cast<void*>(this), 0, sizeof(*this));
  for (int i = 0; i < kPacketWidth; ++i) {
    mask[i] = 0xffffffffu;
    shape[i] = instance[i] = instance_primitive[i] = kNone;
  }
}

struct Accel::Impl : EmbreeScene {
  bool traces_sixteen = false;             ///< in one packet
  const InstanceRow* instances = nullptr;  ///< null: no instances
  std::uint32_t first_instance = 0;        ///< geometry id of the first instance
  MotionView motion;
  std::deque<SdfGridView> sdf_grids;  ///< Embree holds pointers to these
};

namespace {

/// Embree's valid masks for 0 to kPacketWidth rays.
struct ValidMasks {
  alignas(64) int masks[kPacketWidth + 1][kPacketWidth];
  constexpr ValidMasks() : masks{} {
    for (int count = 0; count <= kPacketWidth; ++count)
      for (int i = 0; i < count; ++i) masks[count][i] = -1;
  }
};
constexpr ValidMasks kValid;

/// Attaches the shapes of `range` with ids from 0: the size of Embree's tables depends on the largest id. `structure`:
/// index in AccelInput::builds.
void attach_shapes(RTCDevice device, RTCScene scene, const AccelInput& in, std::size_t structure, ShapeRange range,
                   std::deque<SdfGridView>& grids) {
  const BvhBuild build = in.updatable || structure >= in.builds.size() ? BvhBuild::kSurface : in.builds[structure];
  if (build == BvhBuild::kSpatial) rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  if (build == BvhBuild::kMorton) build_meshes_apart(scene);
  for (std::uint32_t id = 0; id < range.shape_count; ++id) {
    const std::uint32_t i = range.first_shape + id;
    const ShapeRow& shape = in.shapes[i];
    const bool is_mesh = static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh;
    if ((is_mesh && shape.triangle_count == 0) || (shape.flags & kUntraced) != 0) continue;
    RTCGeometry geometry = make_embree_shape(device, in, i, grids);
    if (is_mesh && build == BvhBuild::kMorton) rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
    attach_geometry(scene, geometry, id);
  }
}

/// Sets the transform of an instance, at all time steps if it moves.
void set_transforms(RTCGeometry geometry, const InstanceRow& row, const MotionRow& motion, const MotionView& motions) {
  if (motion.segment_count == 0)
    return rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, row.to_world);
  rtcSetGeometryTimeStepCount(geometry, motion.segment_count + 1);
  for (std::uint32_t step = 0; step <= motion.segment_count; ++step)
    rtcSetGeometryTransform(geometry, step, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                            motions.steps[motion.first_step + step].matrix);
}

/// Attaches all instances, with ids from `first_id`.
void attach_instances(RTCDevice device, RTCScene scene, const AccelInput& in, std::uint32_t first_id,
                      std::deque<SdfGridView>& grids) {
  std::vector<RTCScene> groups;
  for (std::uint32_t i = 0; i < in.group_count; ++i) {
    groups.push_back(make_embree_scene(device, {in.watertight, in.layout == BvhLayout::kCompact}));
    attach_shapes(device, groups.back(), in, i + 1, in.groups[i], grids);
    commit_scene(groups.back());
  }
  for (std::uint32_t i = 0; i < in.instance_count; ++i) {
    const InstanceRow& row = in.instances[i];
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, groups[row.group]);
    set_transforms(geometry, row, in.motion.instances != nullptr ? in.motion.instances[i] : MotionRow{}, in.motion);
    attach_geometry(scene, geometry, first_id + i);
  }
  for (RTCScene group : groups) rtcReleaseScene(group);  // the instances hold references
}

/// Makes the rays from `count` on empty.
void empty_unused(RayPacket& packet, int count) {
  for (int i = count; i < kPacketWidth; ++i) packet.t_far[i] = -kInfinity;
}

/// Eight rays of a packet, for processors without AVX-512: Embree would divide packets of sixteen in the same way, in
/// more time. `Rays`: RTCRayHit8 or RTCRay8, whose rows are those of RayPacket.
template <class Rays> struct HalfPacket {
  static constexpr std::size_t kRow = 8 * sizeof(float), kRows = sizeof(Rays) / kRow;
  static constexpr std::size_t kFirstResult = offsetof(RTCRay8, tfar) / kRow;
  Rays rays;

  HalfPacket(const RayPacket& packet, int first) {
    for (std::size_t row = 0; row < kRows; ++row)
      std::memcpy(at(row), reinterpret_cast<const std::byte*>(&packet) + offset(row, first), kRow);
  }
  /// Writes what Embree may have changed.
  void write(RayPacket& packet, int first) {
    for (std::size_t row = kFirstResult; row < kRows; ++row)
      std::memcpy(reinterpret_cast<std::byte*>(&packet) + offset(row, first), at(row), kRow);
  }

 private:
  std::byte* at(std::size_t row) { return reinterpret_cast<std::byte*>(&rays) + row * kRow; }
  static std::size_t offset(std::size_t row, int first) {
    return (row * kPacketWidth + static_cast<std::size_t>(first)) * sizeof(float);
  }
};

#if SHEAF_EMBREE_MAJOR >= 4
RTCIntersectArguments intersect_arguments() {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  return arguments;
}
RTCOccludedArguments occluded_arguments() {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  return arguments;
}
#else
RTCIntersectContext intersect_arguments() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}
RTCIntersectContext occluded_arguments() { return intersect_arguments(); }
#endif

/// Calls a function of Embree, whose versions differ in the order of the arguments.
template <class F, class Rays, class Arguments>
void call(F&& trace, RTCScene scene, const int* valid, Rays* rays, Arguments arguments) {
#if SHEAF_EMBREE_MAJOR >= 4
  trace(valid, scene, rays, &arguments);
#else
  trace(valid, scene, &arguments, rays);
#endif
}

/// Converts group-relative shape ids to scene ids, and normals from the group's space to world space.
void resolve_instances(RayPacket& packet, int count, const InstanceRow* instances, std::uint32_t first_instance,
                       const MotionView& motion) {
  using L = Wide;
  for (int at = 0; at < count; at += L::width) {
    // Find the rays that hit an instance
    Uint<L> shape, instance;
    load(packet.shape + at, shape);
    load(packet.instance + at, instance);
    const auto instanced = L::first(count - at) & (shape != Uint<L>(kNone)) & (instance != Uint<L>(kNone));
    const Uint<L> row = instance - Uint<L>(first_instance);
    store(packet.instance + at, select(instanced, row, Uint<L>(kNone)));
    if (!any(instanced)) continue;
    // Convert shapes and normals to world space
    const InstanceRecord<L> record = gather_rows<L>(instances, select(instanced, row, Uint<L>(0u)));
    Float<L> time;
    load(packet.time + at, time);
    const InstancePlacement<L> placed = placement_at<L>(motion, record, row, instanced, time).placed;
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
  impl_->start({input.watertight, input.layout == BvhLayout::kCompact, input.updatable});
  impl_->traces_sixteen = rtcGetDeviceProperty(impl_->device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
  attach_shapes(impl_->device, impl_->scene, input, 0, {0, input.shape_count}, impl_->sdf_grids);
  if (input.instance_count > 0) {
    impl_->instances = input.instances;
    impl_->first_instance = input.shape_count;
    impl_->motion = input.motion;
    attach_instances(impl_->device, impl_->scene, input, input.shape_count, impl_->sdf_grids);
  }
  commit_scene(impl_->scene);
  impl_->check();
}

Accel::~Accel() = default;

void Accel::update(const std::vector<std::uint32_t>& shapes) {
  for (const std::uint32_t shape : shapes) {
    RTCGeometry geometry = rtcGetGeometry(impl_->scene, shape);
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
  }
  commit_scene(impl_->scene);
  impl_->check();
}

void Accel::intersect(RayPacket& packet, int count) const noexcept {
  empty_unused(packet, count);
  if (impl_->traces_sixteen) {
    call(rtcIntersect16, impl_->scene, kValid.masks[count], reinterpret_cast<RTCRayHit16*>(&packet),
         intersect_arguments());
  } else {
    for (int first = 0; first < count; first += 8) {
      HalfPacket<RTCRayHit8> half(packet, first);
      call(rtcIntersect8, impl_->scene, kValid.masks[std::min(count - first, 8)], &half.rays, intersect_arguments());
      half.write(packet, first);
    }
  }
  if (impl_->instances) resolve_instances(packet, count, impl_->instances, impl_->first_instance, impl_->motion);
}

void Accel::occluded(RayPacket& packet, int count) const noexcept {
  empty_unused(packet, count);
  if (impl_->traces_sixteen)
    return call(rtcOccluded16, impl_->scene, kValid.masks[count], reinterpret_cast<RTCRay16*>(&packet),
                occluded_arguments());
  for (int first = 0; first < count; first += 8) {
    HalfPacket<RTCRay8> half(packet, first);
    call(rtcOccluded8, impl_->scene, kValid.masks[std::min(count - first, 8)], &half.rays, occluded_arguments());
    half.write(packet, first);
  }
}

std::size_t Accel::bytes() const { return impl_->allocated(); }

}  // namespace sheaf
