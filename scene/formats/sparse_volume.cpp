#include "scene/formats/sparse_volume.h"

#include "core/io/error.h"
#include "scene/formats/nanovdb.h"
#include "scene/formats/openvdb.h"

#include <algorithm>
#include <array>
#include <fstream>

namespace sheaf {

namespace {

/// Files without the first bytes of either format are left to the reader that their extension names.
bool is_openvdb(const std::filesystem::path& file) {
  std::array<char, 8> bytes{};
  std::ifstream(file, std::ios::binary).read(bytes.data(), bytes.size());
  const std::string_view head(bytes.data(), bytes.size());
  return head.starts_with(" BDV") || (!head.starts_with("NanoVDB") && file.extension() == ".vdb");
}

}  // namespace

SparseVolume read_sparse_volume(const std::filesystem::path& file, const std::string& grid) {
  return is_openvdb(file) ? read_openvdb(file, grid) : read_nanovdb(file, grid);
}

bool has_sparse_grid(const std::filesystem::path& file, const std::string& grid) {
  return is_openvdb(file) ? has_openvdb_grid(file, grid) : has_nanovdb_grid(file, grid);
}

std::string displayed_grid(const std::string& name) {
  constexpr std::size_t kLongest = 60;
  return name.size() <= kLongest ? name : name.substr(0, kLongest) + "...";
}

std::size_t find_grid(const std::vector<std::string>& names, const std::string& name, const std::string& file) {
  const SourceLocation where{file};
  if (names.empty()) throw SceneError(where, "the file holds no grids");
  if (name.empty()) return 0;
  if (const auto found = std::find(names.begin(), names.end(), name); found != names.end())
    return static_cast<std::size_t>(found - names.begin());
  constexpr std::size_t kMaxListed = 16;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxListed); ++i)
    list += (i == 0 ? "'" : ", '") + displayed_grid(names[i]) + "'";
  if (names.size() > kMaxListed) list += " and others";
  throw SceneError(where, fmt::format("no grid '{}' (the file holds {}){}", name, list, did_you_mean(name, names)));
}

}  // namespace sheaf
