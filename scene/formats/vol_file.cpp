// Parser of Mitsuba's ".vol" grid volumes.
#include "scene/formats/vol_file.h"

#include "core/math/half.h"
#include "scene/formats/little_endian.h"
#include "scene/formats/mesh_io.h"

#include <bit>
#include <cmath>
#include <concepts>
#include <string>

namespace sheaf {

namespace {

enum Encoding : std::int32_t { kFloat32 = 1, kFloat16 = 2, kUint8 = 3 };

constexpr std::size_t kHeaderSize = 48;

std::int32_t int_at(const char* bytes) { return static_cast<std::int32_t>(little_endian<std::uint32_t>(bytes)); }
float float_at(const char* bytes) { return std::bit_cast<float>(little_endian<std::uint32_t>(bytes)); }

/// Contents of the file header.
struct VolHeader {
  std::int32_t encoding = 0, channels = 0;
  std::array<int, 3> size{};
  float box[6] = {};

  std::size_t value_size() const { return encoding == kFloat32 ? 4 : encoding == kFloat16 ? 2 : 1; }
};

class VolReader {
 public:
  VolReader(const std::string& bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  VolHeader header(VolChannels expected) const {
    if (bytes_.size() < kHeaderSize && bytes_.compare(0, 3, "VOL") == 0) fail("the file is truncated");
    if (bytes_.compare(0, 3, "VOL") != 0) fail("expected a grid volume, which begins with the letters VOL");
    const int version = static_cast<unsigned char>(bytes_[3]);
    if (version != 3) fail(fmt::format("expected version 3 of the format, found {}", version));
    VolHeader h;
    h.encoding = int_at(bytes_.data() + 4);
    for (std::size_t axis = 0; axis < 3; ++axis) h.size[axis] = int_at(bytes_.data() + 8 + 4 * axis);
    h.channels = int_at(bytes_.data() + 20);
    for (std::size_t i = 0; i < 6; ++i) h.box[i] = float_at(bytes_.data() + 24 + 4 * i);
    if (h.encoding < kFloat32 || h.encoding > kUint8) {
      fail(fmt::format("expected values of encoding 1 (float32), 2 (float16) or 3 (uint8), found {}", h.encoding));
    }
    const bool matrices = expected == VolChannels::kMatrices;
    if (matrices ? h.channels != 6 : h.channels != 1 && h.channels != 3)
      fail(fmt::format("expected {} channels, found {}", matrices ? "6" : "1 or 3", h.channels));
    check_size(h);
    return h;
  }

  std::vector<float> values(const VolHeader& h) const {
    std::vector<float> result((bytes_.size() - kHeaderSize) / h.value_size());
    const char* at = bytes_.data() + kHeaderSize;
    for (std::size_t i = 0; i < result.size(); ++i, at += h.value_size()) {
      switch (h.encoding) {
        case kFloat32:
          result[i] = float_at(at);
          break;
        case kFloat16:
          result[i] = half_to_float(little_endian<std::uint16_t>(at));
          break;
        default:
          result[i] = static_cast<float>(static_cast<unsigned char>(*at)) / 255.0f;
      }
      if (!std::isfinite(result[i])) fail_at(h, i);
    }
    return result;
  }

  /// Returns the transform from index space to the unit cube or the file's bounding box.
  Transform grid_to_local(const VolHeader& h, bool use_grid_bbox) const {
    Matrix4 m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double lo = use_grid_bbox ? static_cast<double>(h.box[axis]) : 0.0;
      const double hi = use_grid_bbox ? static_cast<double>(h.box[axis + 3]) : 1.0;
      if (!(lo < hi) || !std::isfinite(hi - lo)) fail("the file's bounding box is empty or not finite");
      m.m[axis][axis] = (hi - lo) / h.size[axis];
      m.m[axis][3] = lo + 0.5 * m.m[axis][axis];
    }
    return Transform(m);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw SceneError(SourceLocation{file_}, message); }

  [[noreturn]] void fail_at(const VolHeader& h, std::size_t i) const {
    const std::size_t voxel = i / static_cast<std::size_t>(h.channels), x = static_cast<std::size_t>(h.size[0]),
                      y = static_cast<std::size_t>(h.size[1]);
    fail(fmt::format("the value of voxel ({}, {}, {}) is not finite", voxel % x, voxel / x % y, voxel / x / y));
  }

  /// Throws unless the file size matches its header.
  void check_size(const VolHeader& h) const {
    const std::string size = fmt::format("{} x {} x {} voxels", h.size[0], h.size[1], h.size[2]);
    std::uint64_t expected = static_cast<std::uint64_t>(h.channels) * h.value_size();
    for (const int side : h.size) {
      if (side < 1 || side > kMaxGridSide) {
        fail(fmt::format("a grid of {} (expected sides from 1 to {})", size, kMaxGridSide));
      }
      expected *= static_cast<std::uint64_t>(side);
    }
    const std::uint64_t found = bytes_.size() - kHeaderSize;
    if (found == expected) return;
    fail(fmt::format("a grid of {} with {} channels of {} bytes takes {} bytes, found {}{}", size, h.channels,
                     h.value_size(), expected, found, found < expected ? ": truncated?" : ""));
  }

  const std::string& bytes_;
  const std::string& file_;
};

}  // namespace

DenseVolume read_vol(const std::filesystem::path& file, bool use_grid_bbox, VolChannels expected) {
  const std::string name = file.string();
  const std::string bytes = read_mesh_bytes(file, "grid volume");
  const VolReader reader(bytes, name);
  const VolHeader header = reader.header(expected);
  DenseVolume volume;
  volume.channels = header.channels;
  volume.size = header.size;
  volume.grid_to_local = reader.grid_to_local(header, use_grid_bbox);
  volume.values = reader.values(header);
  return volume;
}

Transform vol_box(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::string bytes = read_mesh_bytes(file, "grid volume");
  const VolReader reader(bytes, name);
  VolHeader header = reader.header(VolChannels::kAny);
  header.size = {1, 1, 1};
  return reader.grid_to_local(header, true) * Transform::translate({-0.5f, -0.5f, -0.5f});
}

}  // namespace sheaf
