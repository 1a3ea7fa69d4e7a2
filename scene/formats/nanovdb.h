// NanoVDB files: sparse volumes with names. The only file that knows NanoVDB.
#pragma once

#include "scene/description/voxels.h"

#include <filesystem>
#include <span>
#include <string>

namespace sheaf {

/// Reads a grid of a .nvdb file: the one called `grid`, or the file's first if that is empty. Values are single floats
/// (NanoVDB's float, or quantised Fp4, Fp8, Fp16, FpN), or three of them (Vec3f); all voxels count, active or not. The
/// file may be uncompressed, deflated, or compressed with Blosc if the library was there when this was built. Throws
/// SceneError for a file that is missing, truncated or corrupt, for OpenVDB files (saying how to convert them), grids
/// that the file does not have, level sets, other types of values, and values that are not finite.
SparseVolume read_nanovdb(const std::filesystem::path& file, const std::string& grid);

/// Whether the file has a grid of this name. Throws as read_nanovdb() does for what is no such file.
bool has_nanovdb_grid(const std::filesystem::path& file, const std::string& grid);

enum class NanoVdbCodec { kUncompressed, kZip, kBlosc };

/// Whether this build compresses and decompresses with Blosc.
bool has_nanovdb_blosc();

/// A grid to be written.
struct NanoVdbGrid {
  /// kFloat: Vec3f for three channels, of which there is no other.
  enum class Values { kFloat, kFp4, kFp8, kFp16, kFpN };
  std::string name;
  const VoxelBlocks* voxels = nullptr;
  Transform index_to_world;
  Values values = Values::kFloat;
  bool is_level_set = false;
};

/// Writes a .nvdb file of fog volumes, whole or not at all. Throws Error (exit code 4) if that fails or the codec is
/// not there.
void write_nanovdb(const std::filesystem::path& file, std::span<const NanoVdbGrid> grids,
                   NanoVdbCodec codec = NanoVdbCodec::kZip);

}  // namespace sheaf
