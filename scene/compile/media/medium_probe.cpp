#include "scene/compile/media/medium_probe.h"

#include "core/sampling/warp.h"
#include "scene/accel/accel.h"
#include "scene/surfaces/shape.h"
#include "scene/tables/exterior_medium.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace sheaf {

namespace {

/// Maximum number of surfaces that a probe ray crosses.
constexpr int kMaxCrossings = 1000;

/// One probe ray.
struct Probe {
  Vec3f origin, direction;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> entered;  ///< crossings into each shape and instance
  std::optional<std::uint32_t> found;
};

/// Processes the hit of lane `i`: sets the result, or continues the probe behind the surface.
void cross(const SceneView& scene, const RayPacket& packet, int i, PlacedShape ignored, Probe& probe) {
  const std::uint32_t index = packet.shape[i];
  const ShapeRow& shape = scene.geometry.shapes[index];
  const Vec3f d = probe.direction;
  const auto y = surface_point<Scalar, false>(scene, shape, packet.primitive[i], packet.u[i], packet.v[i],
                                              probe.origin + d * packet.t_far[i], packet.instance[i], packet.time[i]);
  probe.origin = offset_origin<Scalar>(y.p, y.ng, y.offset, d);
  if (shape.boundary == kNone || (index == ignored.shape && packet.instance[i] == ignored.instance)) return;
  int& inside = probe.entered[{index, packet.instance[i]}];
  if (dot(y.ng, d) < 0.0f) {
    ++inside;
  } else if (inside > 0) {
    --inside;
  } else {
    probe.found = scene.media.boundaries[shape.boundary].interior;
  }
}

/// Well-distributed directions on the sphere, unlikely to be aligned with the scene.
Vec3f spread_direction(int i) {
  const float golden = 0.61803398875f * static_cast<float>(i) + 0.137f;
  return square_to_sphere<Scalar>((static_cast<float>(i) + 0.43f) / kPacketWidth, golden - std::floor(golden));
}

std::uint32_t majority(std::vector<std::uint32_t> votes) {
  std::sort(votes.begin(), votes.end());
  std::uint32_t best = votes.front();
  std::ptrdiff_t longest = 0;
  for (auto first = votes.begin(); first != votes.end();) {
    const auto last = std::upper_bound(first, votes.end(), *first);
    if (last - first > longest) longest = last - first, best = *first;
    first = last;
  }
  return best;
}

/// The `i`th of `count` points on a shape at a time, in the space in which it was compiled.
SurfacePoint<Scalar> place_on(const SceneView& scene, const ShapeRow& row, std::uint32_t i, std::uint32_t count,
                              float time) {
  const auto kind = static_cast<ShapeKind>(row.kind);
  const auto part = static_cast<std::uint32_t>(std::uint64_t{row.triangle_count} * i / count);
  if (kind == ShapeKind::kMesh) return surface_point<Scalar, false>(scene, row, part, 0.3f, 0.3f, {}, kNone, time);
  if (kind == ShapeKind::kSdfGrid) {
    const SdfGridRow& grid = scene.geometry.sdf_grids[row.first_vertex];
    const std::uint32_t* words = scene.geometry.sdf_cells + 2 * (std::size_t{grid.first_cell} + part);
    const Vec3f corner{static_cast<float>(words[0] & 0xffffu), static_cast<float>(words[0] >> 16),
                       static_cast<float>(words[1])};
    const Vec3f middle = scene.geometry.quadrics[row.first_triangle].world_point(corner + Vec3f{0.5f, 0.5f, 0.5f});
    return surface_point<Scalar, false>(scene, row, part, 0, 0, middle, kNone, time);
  }
  const QuadricRow& q = scene.geometry.quadrics[row.first_triangle];
  const Vec3f x = spread_direction(static_cast<int>(3 * i));
  return surface_point<Scalar, false>(scene, row, 0, 0, 0, q.world_point(x), kNone, time);
}

}  // namespace

std::uint32_t medium_at(const SceneView& scene, Vec3f p, float time, PlacedShape ignored, std::uint32_t default_value) {
  // Start a probe in each direction
  std::vector<Probe> probes(kPacketWidth);
  for (int i = 0; i < kPacketWidth; ++i) {
    probes[static_cast<std::size_t>(i)].origin = p;
    probes[static_cast<std::size_t>(i)].direction = spread_direction(i);
  }
  for (int round = 0; round < kMaxCrossings; ++round) {
    RayPacket packet;
    bool unresolved = false;
    for (int i = 0; i < kPacketWidth; ++i) {
      const Probe& probe = probes[static_cast<std::size_t>(i)];
      packet.set_ray(i, probe.origin, probe.direction, probe.found ? 0.0f : kInfinity);
      packet.time[i] = time;
    }
    scene.accel->intersect(packet, kPacketWidth);
    for (int i = 0; i < kPacketWidth; ++i) {
      Probe& probe = probes[static_cast<std::size_t>(i)];
      if (probe.found) continue;
      if (packet.shape[i] == kNone) {
        probe.found = default_value;
      } else {
        cross(scene, packet, i, ignored, probe);
        unresolved = unresolved || !probe.found;
      }
    }
    if (!unresolved) break;
  }
  std::vector<std::uint32_t> votes;
  for (const Probe& probe : probes) votes.push_back(probe.found.value_or(default_value));
  return majority(std::move(votes));
}

std::uint32_t medium_outside(const SceneView& scene, std::uint32_t default_value) {
  std::vector<std::uint32_t> votes;
  for (int i = 0; i < kPacketWidth; ++i) {
    // Shoot a ray from far outside towards the scene
    const Vec3f from = scene.center + spread_direction(i) * (2.0f * scene.radius);
    const Vec3f to = scene.center + spread_direction((7 * i + 3) % kPacketWidth) * (0.5f * scene.radius);
    Vec3f origin = from;
    const Vec3f d = normalize(to - from);
    for (int round = 0; round < kMaxCrossings; ++round) {
      RayPacket packet;
      packet.set_ray(0, origin, d);
      packet.shape[0] = kNone;
      scene.accel->intersect(packet, 1);
      if (packet.shape[0] == kNone) break;
      const ShapeRow& shape = scene.geometry.shapes[packet.shape[0]];
      const auto y = surface_point<Scalar, false>(scene, shape, packet.primitive[0], packet.u[0], packet.v[0],
                                                  origin + d * packet.t_far[0], packet.instance[0], 0.0f);
      // Vote for the near side of the first boundary
      if (shape.boundary != kNone) {
        votes.push_back(dot(y.ng, d) < 0.0f ? exterior_medium(scene.media, shape.boundary, packet.instance[0], 0.0f)
                                            : scene.media.boundaries[shape.boundary].interior);
        break;
      }
      origin = offset_origin<Scalar>(y.p, y.ng, y.offset, d);
    }
  }
  return votes.empty() ? default_value : majority(std::move(votes));
}

std::uint32_t medium_around(const SceneView& scene, PlacedShape placed, float time, std::uint32_t default_value) {
  constexpr std::uint32_t kMaxPoints = 5;
  std::vector<std::uint32_t> votes;
  for (std::uint32_t i = 0; i < kMaxPoints; ++i) {
    SurfacePoint<Scalar> y = place_on(scene, scene.geometry.shapes[placed.shape], i, kMaxPoints, time);
    if (placed.instance != kNone) {
      const auto row = gather_rows<Scalar>(scene.geometry.instances, placed.instance);
      const InstanceAt<Scalar> at = placement_at<Scalar>(scene.motion, row, placed.instance, true, time, y.p);
      place_instance<Scalar, false>(at.placed, true, y);
      y.offset += at.error * kOffsetUlps;
    }
    // Vote for the medium just outside of it
    votes.push_back(medium_at(scene, y.p + y.ng * y.offset, time, placed, default_value));
  }
  return majority(std::move(votes));
}

}  // namespace sheaf
