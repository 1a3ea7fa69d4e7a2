// NanoVDB files: named sparse volumes. The only file that depends on NanoVDB.
#pragma once

#include "scene/description/voxels.h"

#include <filesystem>
#include <span>
#include <string>

namespace sheaf {

/// Reads a grid of a .nvdb file: the grid named `grid`, or the first one if `grid` is empty. Values are single floats
/// (float, or quantized Fp4, Fp8, Fp16, FpN), doubles, integers of 16 to 64 bits, or vectors of three floats or
/// doubles. They are converted to 32-bit floats. Inactive voxels count, too. The file may be uncompressed, deflated, or
/// compressed with Blosc if the build includes it. Throws SceneError for a missing, truncated or corrupt file, unknown
/// grid names, level sets, other value types, and values that are not finite.
SparseVolume read_nanovdb(const std::filesystem::path& file, const std::string& grid);

/// Whether the file has a grid of this name. Throws as read_nanovdb() does for invalid files.
bool has_nanovdb_grid(const std::filesystem::path& file, const std::string& grid);

enum class NanoVdbCodec { kUncompressed, kZip, kBlosc };

/// A grid to write.
struct NanoVdbGrid {
  /// kFloat: Vec3f if there are three channels; no other type supports three.
  enum class Values { kFloat, kFp4, kFp8, kFp16, kFpN };
  std::string name;
  const VoxelBlocks* voxels = nullptr;
  Transform index_to_world;
  Values values = Values::kFloat;
  bool is_level_set = false;
};

/// Writes a .nvdb file of fog volumes atomically. Throws Error (exit code 4) if writing fails or the codec is not
/// available.
void write_nanovdb(const std::filesystem::path& file, std::span<const NanoVdbGrid> grids,
                   NanoVdbCodec codec = NanoVdbCodec::kZip);

}  // namespace sheaf
