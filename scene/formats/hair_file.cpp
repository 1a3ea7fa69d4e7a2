// Parser of Mitsuba 0.6's hair files, text and binary.
#include "scene/formats/hair_file.h"

#include "scene/formats/mesh_io.h"
#include "scene/formats/number_lines.h"

#include <bit>
#include <cmath>

namespace sheaf {

namespace {

/// Builds linear curves hair by hair; drops points where the direction changes little.
class HairBuilder {
 public:
  explicit HairBuilder(const HairReading& reading)
      : reading_(reading), straight_(std::cos(reading.angle_threshold * (kPi / 180))) {
    curves_.basis = Curves::Basis::kLinear;
  }

  /// Starts a new hair at the next point.
  void begin() {
    end();
    left_out_ = u01_of_hair(hairs_++) < reading_.reduction;
  }

  void add(Vec3f p) {
    if (left_out_) return;
    if (reading_.keep_straight) return points_.push_back(p);
    if (!points_.empty() && p == points_.back()) return;
    const std::size_t n = points_.size();
    if (n >= 2) {
      const Vec3f before = normalize(points_[n - 1] - points_[n - 2]);
      if (dot(normalize(p - points_[n - 1]), before) > straight_) points_.pop_back();
    }
    points_.push_back(p);
  }

  Curves finish() {
    end();
    return std::move(curves_);
  }

 private:
  /// Returns a hash of the hair's index in [0, 1).
  static float u01_of_hair(std::uint32_t hair) {
    std::uint32_t bits = hair * 0x9e3779b9u + 0x7f4a7c15u;  // Weyl sequence, mixed as in MurmurHash3
    bits = (bits ^ bits >> 16) * 0x85ebca6bu;
    bits = (bits ^ bits >> 13) * 0xc2b2ae35u;
    return static_cast<float>((bits ^ bits >> 16) >> 8) * 0x1p-24f;
  }

  void end() {
    if (points_.size() >= 2) {
      curves_.starts.push_back(static_cast<std::uint32_t>(curves_.points.size()));
      const float radius = reading_.radius / (1 - reading_.reduction);
      for (const Vec3f p : points_) curves_.points.push_back({p, radius});
    }
    points_.clear();
  }

  const HairReading reading_;
  const float straight_;  ///< cosine of the angle threshold
  std::vector<Vec3f> points_;
  std::uint32_t hairs_ = 0;
  bool left_out_ = false;
  Curves curves_;
};

constexpr std::string_view kBinary = "BINARY_HAIR";

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

void read_binary(std::string_view bytes, const std::string& file, HairBuilder& hairs) {
  std::size_t at = kBinary.size();
  const auto take = [&](std::size_t point) {
    if (bytes.size() - at < 4)
      throw SceneError(SourceLocation{file}, fmt::format("the file is truncated: it ends within point {}", point + 1));
    at += 4;
    return word_at(bytes, at - 4);
  };
  // Read the number of points
  if (bytes.size() < at + 4)
    throw SceneError(SourceLocation{file}, "the file is truncated: it has no number of points");
  const std::size_t count = take(0);
  hairs.begin();
  for (std::size_t point = 0; point < count; ++point) {
    float x = std::bit_cast<float>(take(point));
    // An infinite coordinate starts a new hair
    if (std::isinf(x)) {
      hairs.begin();
      x = std::bit_cast<float>(take(point));
    }
    const float y = std::bit_cast<float>(take(point));
    const Vec3f p{x, y, std::bit_cast<float>(take(point))};
    if (!is_finite(p)) throw SceneError(SourceLocation{file}, fmt::format("point {} is not finite", point + 1));
    hairs.add(p);
  }
}

}  // namespace

Curves read_hair_file(const std::filesystem::path& file, const HairReading& reading) {
  const std::string name = file.string(), bytes = read_mesh_text(file, "hair file");
  HairBuilder hairs(reading);
  if (bytes.starts_with(kBinary)) {
    read_binary(bytes, name, hairs);
  } else {
    NumberLines lines(bytes, name);
    bool inside = false;
    while (lines.next()) {
      const bool between = lines.line().empty() || lines.line().starts_with('#');
      if (!between) {
        float p[3];
        lines.read(p, "x y z");
        if (!inside) hairs.begin();
        hairs.add({p[0], p[1], p[2]});
      }
      inside = !between;
    }
  }
  Curves curves = hairs.finish();
  if (curves.points.empty()) throw SceneError(SourceLocation{name}, "the file holds no hair of two points or more");
  return curves;
}

}  // namespace sheaf
