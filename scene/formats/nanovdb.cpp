// File layout: a sequence of segments. Each has a magic number, a version, the number of grids and their codec, then
// for each grid a description of 176 bytes and its name, then the grids. A grid is one block of memory with internal
// offsets: a header, the tree's header, and nodes of four levels. All offsets are validated.
#include "scene/formats/nanovdb.h"

#include "core/io/inflate.h"
#include "scene/formats/blosc.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/sparse_volume.h"

#include <nanovdb/NanoVDB.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace sheaf {

namespace {

static_assert(std::endian::native == std::endian::little, "grids are read as they lie in memory");

/// Reads a T without alignment requirements.
template <class T> T value_at(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// Location of a grid in its file.
struct GridEntry {
  std::string name;
  std::uint16_t codec = 0;
  std::uint64_t size = 0;  ///< in memory
  std::string_view stored;
};

/// Directory of the grids in all segments of a file.
class Directory {
 public:
  Directory(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {
    check_kind();
    while (at_ < bytes_.size()) read_segment();
  }

  bool has(const std::string& name) const {
    return std::any_of(entries_.begin(), entries_.end(), [&](const GridEntry& entry) { return entry.name == name; });
  }

  const GridEntry& find(const std::string& name) const {
    std::vector<std::string> names;
    for (const GridEntry& entry : entries_) names.push_back(entry.name);
    return entries_[find_grid(names, name, file_)];
  }

 private:
  static constexpr std::uint64_t kSegmentSize = 16, kEntrySize = 176;

  [[noreturn]] void fail(const std::string& message) const { throw SceneError(SourceLocation{file_}, message); }

  static bool is_magic(const char* bytes) {  // "NanoVDB0", or since version 11 "NanoVDB2"
    return std::memcmp(bytes, "NanoVDB", 7) == 0 && (bytes[7] == '0' || bytes[7] == '2');
  }

  void check_kind() const {
    if (bytes_.size() < 8 || !is_magic(bytes_.data())) {
      fail("expected a NanoVDB file, which begins with the letters NanoVDB0 or NanoVDB2");
    }
  }

  std::uint64_t left() const { return bytes_.size() - at_; }

  const char* take(std::uint64_t size) {
    if (size > left()) fail("the file is truncated");
    const char* const taken = bytes_.data() + at_;
    at_ += size;
    return taken;
  }

  void read_segment() {
    const char* const header = take(kSegmentSize);
    if (!is_magic(header)) fail(fmt::format("expected a segment of grids at byte {}", at_ - kSegmentSize));
    const std::uint32_t major = value_at<std::uint32_t>(header + 8) >> 21;
    if (major != NANOVDB_MAJOR_VERSION_NUMBER) {
      fail(fmt::format("expected version {} of NanoVDB's format, found {}", NANOVDB_MAJOR_VERSION_NUMBER, major));
    }
    const auto count = value_at<std::uint16_t>(header + 12), codec = value_at<std::uint16_t>(header + 14);
    std::vector<std::uint64_t> sizes;
    const std::size_t first = entries_.size();
    for (std::uint16_t i = 0; i < count; ++i) {
      const char* const entry = take(kEntrySize);
      const auto name_size = value_at<std::uint32_t>(entry + 136);
      const std::string_view name(take(name_size), name_size);
      entries_.push_back({std::string(name.substr(0, name.find('\0'))), codec, value_at<std::uint64_t>(entry), {}});
      sizes.push_back(value_at<std::uint64_t>(entry + 8));
    }
    for (std::uint16_t i = 0; i < count; ++i) entries_[first + i].stored = {take(sizes[i]), sizes[i]};
  }

  std::string_view bytes_;
  const std::string& file_;
  std::uint64_t at_ = 0;
  std::vector<GridEntry> entries_;
};

/// The decompressed memory of a grid.
class GridMemory {
 public:
  GridMemory(const GridEntry& entry, const std::string& file) : entry_(entry), file_(file) {
    switch (entry.codec) {
      case 0:
        copy();
        break;
      case 1:
        inflate();
        break;
      case 2:
        decompress_chunks();
        break;
      default:
        fail(fmt::format("compressed with the unknown codec {}", entry.codec));
    }
  }

  const char* data() const { return chunks_.front().bytes; }
  std::uint64_t size() const { return entry_.size; }
  std::size_t stored_bytes() const { return entry_.stored.size(); }
  [[noreturn]] void fail(const std::string& message) const {
    throw SceneError(SourceLocation{file_}, fmt::format("grid '{}': {}", displayed_grid(entry_.name), message));
  }

 private:
  struct alignas(32) Chunk {
    char bytes[32];
  };

  /// Allocates the grid's memory. Throws if the claimed size exceeds `max_size`, the maximum that the stored data can
  /// produce.
  void allocate(std::uint64_t max_size) {
    if (entry_.size > max_size) {
      fail(fmt::format("claims {} bytes of memory, more than the file's size allows", entry_.size));
    }
    if (entry_.size < sizeof(nanovdb::GridData)) fail("the grid is smaller than its header");
    chunks_.resize((entry_.size + sizeof(Chunk) - 1) / sizeof(Chunk));
  }
  char* memory() { return chunks_.front().bytes; }

  void copy() {
    allocate(entry_.stored.size());
    std::memcpy(memory(), entry_.stored.data(), entry_.size);
  }

  void inflate() {
    if (entry_.stored.size() < 8) fail("the file is truncated");
    Inflater inflater(entry_.stored.substr(8));
    allocate(inflater.max_remaining());
    std::size_t found = 0;
    try {
      found = inflater.read({memory(), entry_.size});
    } catch (const Error& error) { fail(error.what()); }
    if (found < entry_.size) fail("the file is truncated");
  }

  void decompress_chunks() {
    constexpr std::uint64_t kMaxPerByte = 256, kChunk = std::uint64_t{1} << 30;
    if (!has_blosc()) fail(kNoBlosc);
    allocate(entry_.stored.size() * kMaxPerByte);
    std::string_view left = entry_.stored;
    for (std::uint64_t done = 0; done < entry_.size;) {
      const std::uint64_t chunk = std::min(entry_.size - done, kChunk);
      const std::uint64_t stored = left.size() < 8 ? left.size() : value_at<std::uint64_t>(left.data());
      if (left.size() < 8 || stored > left.size() - 8) fail("the file is truncated");
      if (!decompress_blosc(left.substr(8, stored), {memory() + done, chunk})) {
        fail("the Blosc-compressed data is corrupt");
      }
      done += chunk;
      left.remove_prefix(8 + stored);
    }
  }

  const GridEntry& entry_;
  const std::string& file_;
  std::vector<Chunk> chunks_;
};

constexpr int kRootTileSide = 4096;

/// Reads the tree of a grid with build type BuildT.
template <class BuildT> class TreeReader {
 public:
  explicit TreeReader(const GridMemory& memory) : memory_(memory) {}

  VoxelBlocks read() {
    // The tree's header starts with the offsets of the first leaf, lower, upper and root node.
    if (memory_.size() < kTree + 64) fail();
    const std::uint64_t position = kTree + value_at<std::uint64_t>(memory_.data() + kTree + 24);
    const Root& root = *node<Root>(position);
    if (root.mTableSize > (memory_.size() - position - sizeof(Root)) / sizeof(typename Root::Tile)) fail();
    std::array<float, 3> background{};
    set(root.mBackground, background.data());
    check_finite(background);
    VoxelBlocks blocks(kChannels, background);
    // Read the root's tiles and children
    for (std::uint32_t i = 0; i < root.mTableSize; ++i) {
      const auto& tile = *root.tile(i);
      const auto origin = tile.origin();
      std::array<int, 3> at{};
      for (int axis = 0; axis < 3; ++axis) {
        if (origin[axis] % kRootTileSide != 0 || std::abs(std::int64_t{origin[axis]}) > (1 << 30)) fail();
        at[static_cast<std::size_t>(axis)] = origin[axis] / VoxelBlocks::kSide;
      }
      if (tile.child == 0)
        add_tile(blocks, at, tile.value, kRootTileSide / VoxelBlocks::kSide);
      else
        read_internal<Upper>(blocks, at, position + static_cast<std::uint64_t>(tile.child));
    }
    return blocks;
  }

 private:
  using Root = typename nanovdb::NanoRoot<BuildT>::DataType;
  using Upper = typename nanovdb::NanoUpper<BuildT>::DataType;
  using Lower = typename nanovdb::NanoLower<BuildT>::DataType;
  using Leaf = typename nanovdb::NanoLeaf<BuildT>::DataType;
  using Value = typename Root::ValueT;
  static constexpr bool kIsVector = std::is_same_v<Value, nanovdb::Vec3f> || std::is_same_v<Value, nanovdb::Vec3d>;
  static constexpr int kChannels = kIsVector ? 3 : 1;
  static constexpr std::uint64_t kTree = sizeof(nanovdb::GridData);

  [[noreturn]] void fail() const { memory_.fail("the tree of its voxels is corrupt"); }

  /// Returns the node at an offset in memory. Throws for invalid offsets.
  template <class Node> const Node* node(std::uint64_t position) const {
    if (position % 32 != 0 || position < kTree + 64 || position >= memory_.size() ||
        memory_.size() - position < sizeof(Node)) {
      fail();
    }
    return reinterpret_cast<const Node*>(memory_.data() + position);
  }

  static void set(const Value& value, float* out) {
    if constexpr (kIsVector) {
      for (int c = 0; c < 3; ++c) out[c] = to_float(value[c]);
    } else {
      *out = to_float(value);
    }
  }

  void check_finite(std::span<const float> values) const {
    for (const float v : values)
      if (!std::isfinite(v)) memory_.fail("has a value that is not finite");
  }

  void add_tile(VoxelBlocks& blocks, const std::array<int, 3>& at, const Value& value, int edge) const {
    std::array<float, 3> floats{};
    set(value, floats.data());
    check_finite(floats);
    if (floats != blocks.background()) blocks.add_constant(at, std::span(floats).first(kChannels), edge);
  }

  /// Limits the number of nodes to what fits into memory, because corrupt trees may share nodes and would take very
  /// long.
  void count_node(std::uint64_t size, std::uint64_t& counter) const {
    if (++counter > memory_.size() / size) fail();
  }

  template <class Node> void read_internal(VoxelBlocks& blocks, const std::array<int, 3>& at, std::uint64_t position) {
    constexpr bool kIsUpper = std::is_same_v<Node, Upper>;
    constexpr int kLog = kIsUpper ? 5 : 4, kEdge = kIsUpper ? 16 : 1, kMask = (1 << kLog) - 1;
    count_node(sizeof(Node), kIsUpper ? uppers_ : lowers_);
    const Node& n = *node<Node>(position);
    for (int i = 0; i < 1 << 3 * kLog; ++i) {
      const std::array<int, 3> child_at{at[0] + (i >> 2 * kLog) * kEdge, at[1] + (i >> kLog & kMask) * kEdge,
                                        at[2] + (i & kMask) * kEdge};
      const auto& entry = n.mTable[i];
      if (!n.mChildMask.isOn(static_cast<std::uint32_t>(i))) {
        add_tile(blocks, child_at, entry.value, kEdge);
        continue;
      }
      const std::uint64_t child = position + static_cast<std::uint64_t>(entry.child);
      if constexpr (kIsUpper)
        read_internal<Lower>(blocks, child_at, child);
      else
        read_leaf(blocks, child_at, child);
    }
  }

  void read_leaf(VoxelBlocks& blocks, const std::array<int, 3>& at, std::uint64_t position) {
    count_node(sizeof(Leaf), leaves_);
    const Leaf& leaf = *node<Leaf>(position);
    if constexpr (std::is_same_v<BuildT, nanovdb::FpN>) {  // FpN values follow the leaf
      constexpr int kMaxLog = 4;
      const int log = leaf.mFlags >> 5;
      if (log > kMaxLog || memory_.size() - position - sizeof(Leaf) < std::uint64_t{64} << log) fail();
    }
    const std::span<float> values = blocks.add(at);
    for (std::uint32_t i = 0; i < VoxelBlocks::kVoxels; ++i) {  // z fastest
      const std::uint32_t ours = (i & 7) << 6 | (i & 0x38) | i >> 6;
      set(leaf.getValue(i), values.data() + ours * kChannels);
    }
    check_finite(values);
  }

  const GridMemory& memory_;
  std::uint64_t uppers_ = 0, lowers_ = 0, leaves_ = 0;
};

VoxelBlocks read_tree(const GridMemory& memory, nanovdb::GridType type) {
  switch (type) {
    case nanovdb::GridType::Float:
      return TreeReader<float>(memory).read();
    case nanovdb::GridType::Fp4:
      return TreeReader<nanovdb::Fp4>(memory).read();
    case nanovdb::GridType::Fp8:
      return TreeReader<nanovdb::Fp8>(memory).read();
    case nanovdb::GridType::Fp16:
      return TreeReader<nanovdb::Fp16>(memory).read();
    case nanovdb::GridType::FpN:
      return TreeReader<nanovdb::FpN>(memory).read();
    case nanovdb::GridType::Double:
      return TreeReader<double>(memory).read();
    case nanovdb::GridType::Int16:
      return TreeReader<std::int16_t>(memory).read();
    case nanovdb::GridType::Int32:
      return TreeReader<std::int32_t>(memory).read();
    case nanovdb::GridType::Int64:
      return TreeReader<std::int64_t>(memory).read();
    case nanovdb::GridType::UInt32:
      return TreeReader<std::uint32_t>(memory).read();
    case nanovdb::GridType::Vec3f:
      return TreeReader<nanovdb::Vec3f>(memory).read();
    case nanovdb::GridType::Vec3d:
      return TreeReader<nanovdb::Vec3d>(memory).read();
    default:
      break;
  }
  const std::string name =
      type < nanovdb::GridType::End ? nanovdb::toStr(type) : std::to_string(static_cast<std::uint32_t>(type));
  memory.fail("expected values of type float, Fp4, Fp8, Fp16, FpN, double, an integer, Vec3f or Vec3d, found type " +
              name);
}

SparseVolume read_volume(const GridMemory& memory) {
  const auto* const header = reinterpret_cast<const nanovdb::GridData*>(memory.data());
  if (std::memcmp(memory.data(), "NanoVDB", 7) != 0) memory.fail("the grid's memory is corrupt");
  // Check the grid class
  switch (header->mGridClass) {
    case nanovdb::GridClass::LevelSet:
      memory.fail("is a level set (expected a fog volume)");
    case nanovdb::GridClass::Unknown:
    case nanovdb::GridClass::FogVolume:
    case nanovdb::GridClass::Staggered:
    case nanovdb::GridClass::VoxelVolume:
      break;
    default:
      memory.fail("is not a fog volume");
  }
  // Convert the transform
  Matrix4 m;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) m.m[row][column] = header->mMap.mMatD[3 * row + column];
    m.m[row][3] = header->mMap.mVecD[row];
  }
  SparseVolume volume;
  volume.stored_bytes = memory.stored_bytes();
  try {
    volume.grid_to_local = Transform(m);
  } catch (const SceneError& error) { memory.fail(error.what()); }
  // Read the voxels
  volume.voxels = read_tree(memory, header->mGridType);
  return volume;
}

}  // namespace

SparseVolume read_nanovdb(const std::filesystem::path& file, const std::string& grid) {
  const std::string name = file.string();
  const std::string bytes = read_mesh_bytes(file, "NanoVDB file");
  const Directory directory(bytes, name);
  return read_volume(GridMemory(directory.find(grid), name));
}

bool has_nanovdb_grid(const std::filesystem::path& file, const std::string& grid) {
  const std::string name = file.string();
  const std::string bytes = read_mesh_bytes(file, "NanoVDB file");
  return Directory(bytes, name).has(grid);
}

}  // namespace sheaf
