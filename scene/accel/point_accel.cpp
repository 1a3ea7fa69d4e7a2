// Points near rays: Embree's discs that face the ray.
#include "scene/accel/accel.h"
#include "scene/accel/near_query.h"

#include <utility>

namespace sheaf {

struct PointAccel::Impl : EmbreeScene {};

namespace {

struct PointQuery : NearQuery {
  const AccelPoint* points;
  std::vector<NearPoint>* found;
};

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
  impl_->start({});
  RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_DISC_POINT);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, points_.data(), 0,
                             sizeof(AccelPoint), points_.size());
  rtcSetGeometryOccludedFilterFunction(geometry, collect_point);
  attach_geometry(impl_->scene, geometry, 0);
  rtcJoinCommitScene(impl_->scene);
  impl_->check();
}

void PointAccel::near_ray(Vec3f origin, Vec3f direction, float length, std::vector<NearPoint>& found) const noexcept {
  if (impl_ == nullptr) return;
  PointQuery query{{{}, origin, direction, length}, points_.data(), &found};
  look_along(impl_->scene, query, largest_radius_);
}

std::size_t PointAccel::bytes() const { return impl_ == nullptr ? 0 : impl_->allocated(); }

}  // namespace sheaf
