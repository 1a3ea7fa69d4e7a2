// vdb_to_nanovdb: converts the fog volumes of an OpenVDB file to NanoVDB, for programs that cannot read OpenVDB files.
#include "core/io/error.h"
#include "scene/formats/nanovdb.h"
#include "scene/formats/openvdb.h"

#include <cstdio>
#include <list>

namespace sheaf {

namespace {

int run(const std::string& in, const std::string& out) {
  std::list<SparseVolume> volumes;
  std::vector<NanoVdbGrid> grids;
  for (const std::string& name : openvdb_grid_names(in)) {
    try {
      const SparseVolume& volume = volumes.emplace_back(read_openvdb(in, name));
      grids.push_back({name, &volume.voxels, volume.grid_to_local});
    } catch (const SceneError& error) { std::fprintf(stderr, "vdb_to_nanovdb: %s (skipped)\n", error.what()); }
  }
  if (grids.empty()) throw SceneError(SourceLocation{in}, "contains no fog volumes that can be converted");
  write_nanovdb(out, grids);
  return 0;
}

}  // namespace

}  // namespace sheaf

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: vdb_to_nanovdb IN.vdb OUT.nvdb\n");
    return static_cast<int>(sheaf::ExitCode::kUsage);
  }
  try {
    return sheaf::run(argv[1], argv[2]);
  } catch (const sheaf::Error& error) {
    std::fprintf(stderr, "vdb_to_nanovdb: %s\n", error.what());
    return static_cast<int>(error.exit_code());
  }
}
