// Lines near rays: Embree's flat curves. Long lines are divided into pieces, which have tighter bounds.
#include "scene/accel/accel.h"
#include "scene/accel/near_query.h"

#include <cmath>

namespace sheaf {

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
  // Divide the lines into pieces
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
  // Build the curves
  in.start({});
  RTCGeometry geometry = rtcNewGeometry(in.device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, in.ends.data(), 0,
                             sizeof(AccelPoint), in.ends.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, in.begins.data(), 0,
                             sizeof(std::uint32_t), in.begins.size());
  rtcSetGeometryOccludedFilterFunction(geometry, collect_line);
  attach_geometry(in.scene, geometry, 0);
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
         impl_->ends.size() * sizeof(AccelPoint) + impl_->allocated();
}

}  // namespace sheaf
