// File layout: a magic number, versions, a flag, a UUID, metadata, and the number of grids. Each grid has a descriptor
// (name, type, name of the grid whose tree it shares, positions of its begin, voxels and end), followed by the grid:
// compression, metadata, transform, the topology of the tree, and the voxels of its leaves. The tree has a root, two
// levels of nodes with 32^3 and 16^3 entries, and leaves of 8^3 voxels. All sizes and positions are validated.
#include "scene/formats/openvdb.h"

#include "core/io/error.h"
#include "core/io/inflate.h"
#include "core/math/half.h"
#include "scene/formats/blosc.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/sparse_volume.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

namespace sheaf {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie in memory");

/// Reads from a part of a file. Never reads beyond it.
class VdbBytes {
 public:
  /// `subject` precedes the error messages.
  VdbBytes(std::string_view bytes, const std::string& file, std::string subject = "")
      : bytes_(bytes), file_(file), subject_(std::move(subject)) {}

  std::string_view take(std::uint64_t size) {
    if (size > left()) fail("the file is truncated");
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  template <class T> T get() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string_view text() { return take(get<std::uint32_t>()); }
  /// The part between two positions, the first of which is not before this position.
  std::string_view part(std::uint64_t begin, std::uint64_t end) {
    if (begin < at_ || begin > end) fail("the position of a grid is corrupt");
    if (end > bytes_.size()) fail("the file is truncated");
    return bytes_.substr(begin, end - begin);
  }
  void seek(std::uint64_t position) { at_ = position; }
  std::uint64_t left() const { return bytes_.size() - at_; }
  const std::string& file() const { return file_; }
  [[noreturn]] void fail(const std::string& message) const {
    throw SceneError(SourceLocation{file_}, subject_ + message);
  }

 private:
  std::string_view bytes_;
  const std::string& file_;
  std::string subject_;
  std::uint64_t at_ = 0;
};

/// Skips named values. Returns the text named `name`, if there is one.
std::string_view read_metadata(VdbBytes& in, std::string_view name) {
  std::string_view found;
  for (auto left = in.get<std::uint32_t>(); left > 0; --left) {
    const std::string_view key = in.text(), type = in.text(), value = in.text();
    if (key == name && type == "string") found = value;
  }
  return found;
}

struct VdbGrid {
  std::string name;         ///< of the user; 'name[1]' if it is not unique
  std::string unique_name;  ///< for references
  std::string tree_of;      ///< unique name of the grid whose tree this grid shares, or empty
  std::string type;
  std::string_view stored;
};

std::vector<VdbGrid> read_vdb_directory(std::string_view bytes, const std::string& file) {
  constexpr std::string_view kMagic("\x20\x42\x44\x56\0\0\0\0", 8);
  constexpr std::uint32_t kOldestVersion = 222;
  constexpr std::uint64_t kLibraryVersion = 8, kUuid = 36, kMinDescriptor = 36;
  VdbBytes in(bytes, file);
  // Read the header
  if (!bytes.starts_with(kMagic)) in.fail("expected an OpenVDB file, which begins with a space and the letters BDV");
  in.take(kMagic.size());
  if (const auto version = in.get<std::uint32_t>(); version < kOldestVersion)
    in.fail(fmt::format(
        "expected version {} or newer of OpenVDB's format, found {} (write it anew with OpenVDB 1.0 or newer)",
        kOldestVersion, version));
  in.take(kLibraryVersion);
  if (in.get<std::uint8_t>() == 0)
    in.fail("was written as a stream, without the positions of its grids (write it as a file)");
  in.take(kUuid);
  read_metadata(in, "");
  // Read the descriptors
  const auto count = in.get<std::uint32_t>();
  if (count > in.left() / kMinDescriptor) in.fail("the file is truncated");
  std::vector<VdbGrid> grids;
  for (std::uint32_t i = 0; i < count; ++i) {
    VdbGrid grid;
    grid.unique_name = in.text();
    grid.type = in.text();
    grid.tree_of = in.text();
    const auto begin = in.get<std::uint64_t>();
    in.get<std::uint64_t>();  // the voxels follow the topology
    const auto end = in.get<std::uint64_t>();
    grid.stored = in.part(begin, end);
    in.seek(end);
    const std::size_t separator = grid.unique_name.find('\x1e');  // before the number of a name that is not unique
    grid.name = grid.unique_name.substr(0, separator);
    if (separator != std::string::npos) grid.name += "[" + grid.unique_name.substr(separator + 1) + "]";
    grids.push_back(std::move(grid));
  }
  return grids;
}

std::vector<std::string> names_of(const std::vector<VdbGrid>& grids) {
  std::vector<std::string> names;
  for (const VdbGrid& grid : grids) names.push_back(grid.name);
  return names;
}

/// 'name' refers to the first of several grids with this name, 'name[0]'.
std::string first_of_name(const std::vector<std::string>& names, const std::string& name) {
  const auto has = [&](const std::string& n) { return std::find(names.begin(), names.end(), n) != names.end(); };
  return !has(name) && has(name + "[0]") ? name + "[0]" : name;
}

/// How values are stored.
struct VdbValues {
  enum class Number { kHalf, kFloat, kDouble, kInt32, kInt64 };
  Number number = Number::kFloat;
  int channels = 1;

  std::size_t number_bytes() const {
    return number == Number::kHalf ? 2 : number == Number::kFloat || number == Number::kInt32 ? 4 : 8;
  }
};

/// Values of a type such as Tree_float_5_4_3 or Tree_vec3s_5_4_3_HalfFloat; `halves`: of voxels stored as halves.
struct VdbType {
  VdbValues values;
  bool halves = false;
};

VdbType parse_vdb_type(const VdbBytes& in, std::string_view type) {
  using Type = VdbValues::Number;
  constexpr std::string_view kTree = "Tree_", kNodes = "_5_4_3", kHalf = "_HalfFloat";
  constexpr std::pair<std::string_view, VdbValues> kTypes[] = {
      {"float", {Type::kFloat, 1}}, {"double", {Type::kDouble, 1}}, {"int32", {Type::kInt32, 1}},
      {"int64", {Type::kInt64, 1}}, {"vec3s", {Type::kFloat, 3}},   {"vec3d", {Type::kDouble, 3}}};
  std::string_view name = type;
  const bool halves = name.ends_with(kHalf);
  if (halves) name.remove_suffix(kHalf.size());
  for (const auto& [known, values] : kTypes) {
    if (name != fmt::format("{}{}{}", kTree, known, kNodes)) continue;
    return {values, halves && (values.number == Type::kFloat || values.number == Type::kDouble)};
  }
  in.fail(fmt::format("expected values of type float, double, int32, int64, vec3s or vec3d in a tree 5_4_3, found '{}'",
                      displayed_grid(std::string(type))));
}

/// Converts numbers to floats.
void convert_vdb_numbers(std::string_view stored, VdbValues::Number number, std::span<float> out) {
  const auto convert = [&]<class T>(T) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      T value;
      std::memcpy(&value, stored.data() + i * sizeof(T), sizeof(T));
      if constexpr (std::is_same_v<T, std::uint16_t>)
        out[i] = half_to_float(value);
      else
        out[i] = to_float(value);
    }
  };
  switch (number) {
    case VdbValues::Number::kHalf:
      return convert(std::uint16_t{});
    case VdbValues::Number::kFloat:
      return convert(float{});
    case VdbValues::Number::kDouble:
      return convert(double{});
    case VdbValues::Number::kInt32:
      return convert(std::int32_t{});
    case VdbValues::Number::kInt64:
      return convert(std::int64_t{});
  }
}

/// Reads the map from index space to the grid's space.
Transform read_vdb_transform(VdbBytes& in) {
  const std::string_view type = in.text();
  Matrix4 m;
  const auto translation = [&] {
    for (std::size_t row = 0; row < 3; ++row) m.m[row][3] = in.get<double>();
  };
  const auto scale = [&] {
    for (std::size_t row = 0; row < 3; ++row) m.m[row][row] = in.get<double>();
    in.take(4 * 3 * sizeof(double));  // values derived from the scale
  };
  if (type == "AffineMap" || type == "UnitaryMap") {
    std::array<double, 16> rows;  // for row vectors
    for (double& value : rows) value = in.get<double>();
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 4; ++column) m.m[row][column] = rows[4 * column + row];
  } else if (type == "ScaleMap" || type == "UniformScaleMap") {
    scale();
  } else if (type == "ScaleTranslateMap" || type == "UniformScaleTranslateMap") {
    translation();
    scale();
  } else if (type == "TranslationMap") {
    translation();
  } else {
    in.fail(
        fmt::format("has a transform of type '{}' (expected an affine transform)", displayed_grid(std::string(type))));
  }
  try {
    return Transform(m);
  } catch (const SceneError& error) { in.fail(error.what()); }
}

/// Reads the tree of a grid, behind its transform.
class VdbTree {
 public:
  VdbTree(VdbBytes& in, const VdbType& type, std::uint32_t compression)
      : in_(in), type_(type), compression_(compression) {
    if ((compression & kBlosc) != 0 && !has_blosc()) in.fail(kNoBlosc);
  }

  VoxelBlocks read() {
    if (in_.get<std::uint32_t>() != 1) corrupt();  // buffers per leaf
    const Value background = read_value();
    background_ = background;
    VoxelBlocks blocks(type_.values.channels, background);
    read_root(blocks);
    std::vector<float> values;
    for (const std::array<int, 3>& leaf : leaves_) {
      const std::string_view active = in_.take(VoxelBlocks::kVoxels / 8);
      read_values(active, VoxelBlocks::kVoxels, values);
      const std::span<float> out = blocks.add(leaf);
      const std::size_t channels = static_cast<std::size_t>(type_.values.channels);
      for (std::size_t i = 0; i < VoxelBlocks::kVoxels; ++i) {  // z fastest
        const std::size_t ours = (i & 7) << 6 | (i & 0x38) | i >> 6;
        std::copy_n(values.data() + i * channels, channels, out.data() + ours * channels);
      }
    }
    return blocks;
  }

 private:
  using Value = std::array<float, 3>;
  enum : std::uint32_t { kZip = 1, kActiveMask = 2, kBlosc = 4 };
  static constexpr int kRootTileSide = 4096;

  [[noreturn]] void corrupt() const { in_.fail("the tree of its voxels is corrupt"); }

  static bool is_on(std::string_view mask, std::size_t i) { return (mask[i / 8] >> i % 8 & 1) != 0; }
  static std::size_t count_on(std::string_view mask) {
    std::size_t count = 0;
    for (const char byte : mask) count += static_cast<std::size_t>(std::popcount(static_cast<unsigned char>(byte)));
    return count;
  }

  void check_finite(std::span<const float> values) const {
    for (const float v : values)
      if (!std::isfinite(v)) in_.fail("has a value that is not finite");
  }

  /// A value outside of an array, which is never stored as halves.
  Value read_value() {
    Value value{};
    const auto out = std::span(value).first(static_cast<std::size_t>(type_.values.channels));
    convert_vdb_numbers(in_.take(out.size() * type_.values.number_bytes()), type_.values.number, out);
    check_finite(out);
    return value;
  }

  void read_root(VoxelBlocks& blocks) {
    const auto tiles = in_.get<std::uint32_t>(), children = in_.get<std::uint32_t>();
    const auto read_position = [&] {
      std::array<int, 3> at{};
      for (int& coordinate : at) {
        const auto voxel = in_.get<std::int32_t>();
        if (voxel % kRootTileSide != 0 || std::abs(std::int64_t{voxel}) > (1 << 30)) corrupt();
        coordinate = voxel / VoxelBlocks::kSide;
      }
      return at;
    };
    for (std::uint32_t i = 0; i < tiles; ++i) {
      const std::array<int, 3> at = read_position();
      add_tile(blocks, at, read_value(), kRootTileSide / VoxelBlocks::kSide);
      in_.take(1);  // whether it is active
    }
    for (std::uint32_t i = 0; i < children; ++i) read_internal<5>(blocks, read_position());
  }

  void add_tile(VoxelBlocks& blocks, const std::array<int, 3>& at, const Value& value, int edge) const {
    if (value == background_) return;
    blocks.add_constant(at, std::span(value).first(static_cast<std::size_t>(type_.values.channels)), edge);
  }

  /// Reads a node with 2^kLog entries along each axis, and the nodes below. Leaves are collected in leaves_.
  template <int kLog> void read_internal(VoxelBlocks& blocks, const std::array<int, 3>& at) {
    constexpr int kEdge = kLog == 5 ? 16 : 1, kMask = (1 << kLog) - 1;
    constexpr std::size_t kEntries = std::size_t{1} << 3 * kLog;
    const std::string_view is_child = in_.take(kEntries / 8), active = in_.take(kEntries / 8);
    std::vector<float> values;
    read_values(active, kEntries, values);
    const std::size_t channels = static_cast<std::size_t>(type_.values.channels);
    for (std::size_t i = 0; i < kEntries; ++i) {
      const int n = static_cast<int>(i);
      const std::array<int, 3> entry_at{at[0] + (n >> 2 * kLog) * kEdge, at[1] + (n >> kLog & kMask) * kEdge,
                                        at[2] + (n & kMask) * kEdge};
      if (!is_on(is_child, i)) {
        Value value{};
        std::copy_n(values.data() + i * channels, channels, value.data());
        add_tile(blocks, entry_at, value, kEdge);
      } else if constexpr (kLog == 5) {
        read_internal<4>(blocks, entry_at);
      } else {
        in_.take(VoxelBlocks::kVoxels / 8);  // the mask of active voxels, which the voxels repeat
        leaves_.push_back(entry_at);
      }
    }
  }

  /// Reads the values of all entries of a node. Inactive ones may be left out of the file: they then have one of two
  /// values, which a mask selects.
  void read_values(std::string_view active, std::size_t count, std::vector<float>& out) {
    enum : std::uint8_t {  // of the inactive values; the background is an implicit value
      kBackground,
      kMinusBackground,
      kOneValue,
      kMaskOfBackgrounds,
      kMaskAndOneValue,
      kMaskAndTwoValues,
      kAllStored
    };
    const auto kind = in_.get<std::uint8_t>();
    if (kind > kAllStored) corrupt();
    // Read the inactive values
    Value inactive[2] = {background_, background_};
    if (kind != kBackground)
      for (float& v : inactive[0]) v = -v;
    if (kind == kOneValue || kind == kMaskAndOneValue || kind == kMaskAndTwoValues) inactive[0] = read_value();
    if (kind == kMaskAndTwoValues) inactive[1] = read_value();
    std::string_view selected;
    if (kind >= kMaskOfBackgrounds && kind <= kMaskAndTwoValues) selected = in_.take(count / 8);
    // Read the stored values
    const bool leaves_out = (compression_ & kActiveMask) != 0 && kind != kAllStored;
    const std::size_t stored = leaves_out ? count_on(active) : count;
    const std::size_t channels = static_cast<std::size_t>(type_.values.channels);
    out.resize(count * channels);
    read_array(std::span(out).first(stored * channels));
    if (stored == count) return;
    // Move them to their places, from the last to the first
    std::size_t from = stored;
    for (std::size_t i = count; i-- > 0;) {
      const bool is_stored = is_on(active, i);
      const Value& other = inactive[!selected.empty() && is_on(selected, i) ? 1 : 0];
      const float* const value = is_stored ? out.data() + --from * channels : other.data();
      std::copy_n(value, channels, out.data() + i * channels);
    }
  }

  /// Reads and decompresses an array.
  void read_array(std::span<float> out) {
    VdbValues values = type_.values;
    if (type_.halves) {
      values.number = VdbValues::Number::kHalf;
      if (out.empty()) return;
    }
    const std::size_t size = out.size() * values.number_bytes();
    std::string_view bytes;
    if ((compression_ & (kZip | kBlosc)) == 0) {
      bytes = in_.take(size);
    } else if (const auto compressed = in_.get<std::int64_t>(); compressed > 0) {
      decompressed_.resize(size);
      decompress(in_.take(static_cast<std::uint64_t>(compressed)));
      bytes = decompressed_;
    } else {  // not compressible
      if (std::uint64_t{0} - static_cast<std::uint64_t>(compressed) != size) corrupt();
      bytes = in_.take(size);
    }
    convert_vdb_numbers(bytes, values.number, out);
    check_finite(out);
  }

  void decompress(std::string_view stored) {
    bool is_valid = false;
    if ((compression_ & kBlosc) != 0) {
      is_valid = decompress_blosc(stored, decompressed_);
    } else {
      try {
        is_valid = Inflater(stored).read(decompressed_) == decompressed_.size();
      } catch (const Error&) {}  // reported below
    }
    if (!is_valid) in_.fail("the compressed data is corrupt");
  }

  VdbBytes& in_;
  VdbType type_;
  std::uint32_t compression_;
  Value background_{};
  std::vector<std::array<int, 3>> leaves_;  ///< positions / 8
  std::string decompressed_;
};

/// A grid, read up to its tree.
struct OpenedVdbGrid {
  VdbBytes in;
  VdbType type;
  std::uint32_t compression = 0;
  Transform transform;

  OpenedVdbGrid(const VdbGrid& grid, const std::string& file)
      : in(grid.stored, file, fmt::format("grid '{}': ", displayed_grid(grid.name))),
        type(parse_vdb_type(in, grid.type)),
        compression(in.get<std::uint32_t>()) {
    if (read_metadata(in, "class") == "level set") in.fail("is a level set (expected a fog volume)");
    transform = read_vdb_transform(in);
  }
};

}  // namespace

SparseVolume read_openvdb(const std::filesystem::path& file, const std::string& grid) {
  const std::string name = file.string();
  const std::string bytes = read_mesh_bytes(file, "OpenVDB file");
  const std::vector<VdbGrid> grids = read_vdb_directory(bytes, name);
  const std::vector<std::string> names = names_of(grids);
  const VdbGrid& found = grids[find_grid(names, first_of_name(names, grid), name)];
  OpenedVdbGrid opened(found, name);
  SparseVolume volume;
  volume.grid_to_local = opened.transform;
  volume.stored_bytes = bytes.size();
  if (found.tree_of.empty()) {
    volume.voxels = VdbTree(opened.in, opened.type, opened.compression).read();
    return volume;
  }
  const auto owner = std::find_if(grids.begin(), grids.end(), [&](const VdbGrid& each) {
    return each.unique_name == found.tree_of && each.tree_of.empty();
  });
  if (owner == grids.end()) opened.in.fail("shares the voxels of a grid that does not exist");
  OpenedVdbGrid shared(*owner, name);
  volume.voxels = VdbTree(shared.in, shared.type, shared.compression).read();
  return volume;
}

std::vector<std::string> openvdb_grid_names(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::string bytes = read_mesh_bytes(file, "OpenVDB file");
  return names_of(read_vdb_directory(bytes, name));
}

bool has_openvdb_grid(const std::filesystem::path& file, const std::string& grid) {
  const std::vector<std::string> names = openvdb_grid_names(file);
  return std::find(names.begin(), names.end(), first_of_name(names, grid)) != names.end();
}

}  // namespace sheaf
