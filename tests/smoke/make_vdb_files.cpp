// make_vdb_files: writes, with the library, the OpenVDB and NanoVDB files that tests read, which lie compressed in
// tests/scene/formats/vdb. Built only if OpenVDB is installed.
//   make_vdb_files FOLDER && gzip -n9 FOLDER/*
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

/// The values, multiples of 1/16: they are exact in every type but integers.
int sixteenths(const openvdb::Coord& p) { return (7 * p.x() + 3 * p.y() + 5 * p.z()) & 15; }

template <class Value> Value value_at(const openvdb::Coord& p) {
  if constexpr (openvdb::VecTraits<Value>::IsVec) {
    return Value(sixteenths(p) / 16.0, sixteenths(p + openvdb::Coord(1)) / 16.0,
                 sixteenths(p + openvdb::Coord(2)) / 16.0);
  } else if constexpr (std::is_integral_v<Value>) {
    return static_cast<Value>(sixteenths(p));
  } else {
    return static_cast<Value>(sixteenths(p) / 16.0);
  }
}

template <class Value> Value all(double value) {
  if constexpr (std::is_integral_v<Value>)
    return static_cast<Value>(value * 4);
  else
    return Value(value);
}

/// Blocks of 8^3 voxels, one with each way to store inactive values, and tiles on all levels.
template <class Grid> typename Grid::Ptr make_grid(const std::string& name) {
  using Value = typename Grid::ValueType;
  const Value background = all<Value>(0.25);
  const auto grid = Grid::create(background);
  grid->setName(name);
  auto accessor = grid->getAccessor();
  for (int block = 0; block < 8; ++block)
    for (int i = 0; i < 512; ++i) {
      const openvdb::Coord p(8 * block - 24 + (i >> 6), (i >> 3 & 7) - 8 * (block % 3), (i & 7) + 128 * (block / 5));
      const Value other[] = {background, openvdb::math::negative(background), all<Value>(0.5), all<Value>(0.75)};
      if (block == 0 || i % 3 == 0) {
        accessor.setValueOn(p, value_at<Value>(p));
      } else {  // inactive
        const bool odd = i % 2 == 1;
        const int kinds[8][2] = {{0, 0}, {0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {2, 3}, {0, 0}};
        accessor.setValueOff(p, block == 7 ? value_at<Value>(p) : other[kinds[block][odd]]);
      }
    }
  auto& tree = grid->tree();
  tree.addTile(1, openvdb::Coord(48, 0, 0), all<Value>(0.5), true);  // 8^3 voxels
  tree.addTile(1, openvdb::Coord(56, 0, 0), all<Value>(0.75), false);
  tree.addTile(2, openvdb::Coord(128, 128, 0), all<Value>(0.5), true);  // 128^3 voxels
  return grid;
}

template <class Grid>
openvdb::GridBase::Ptr placed(const std::string& name, openvdb::math::MapBase::Ptr map, bool half = false) {
  const auto grid = make_grid<Grid>(name);
  grid->setTransform(std::make_shared<openvdb::math::Transform>(map));
  grid->setSaveFloatAsHalf(half);
  return grid;
}

openvdb::GridPtrVec make_grids() {
  using namespace openvdb::math;
  const openvdb::Mat4d affine(2.0, 0.5, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.25, 0.0, -1.0, 0.0, 5.0, 6.0, 7.0,
                              1.0);  // for row vectors
  openvdb::GridPtrVec grids;
  grids.push_back(placed<openvdb::FloatGrid>("density", std::make_shared<AffineMap>(affine)));
  grids.push_back(placed<openvdb::FloatGrid>("half", std::make_shared<UniformScaleMap>(0.5), true));
  grids.push_back(
      placed<openvdb::Vec3SGrid>("color", std::make_shared<UniformScaleTranslateMap>(0.5, openvdb::Vec3d(1, 2, 3))));
  grids.push_back(placed<openvdb::Vec3SGrid>("half color", std::make_shared<ScaleMap>(openvdb::Vec3d(1, 2, 4)), true));
  grids.push_back(placed<openvdb::DoubleGrid>(
      "double", std::make_shared<ScaleTranslateMap>(openvdb::Vec3d(1, 2, 4), openvdb::Vec3d(1, 2, 3))));
  grids.push_back(
      placed<openvdb::Vec3DGrid>("double color", std::make_shared<TranslationMap>(openvdb::Vec3d(1, 2, 3))));
  grids.push_back(placed<openvdb::Int32Grid>("int", std::make_shared<UnitaryMap>(openvdb::Vec3d(0, 0, 1), M_PI / 2)));
  grids.push_back(placed<openvdb::Int64Grid>("long", std::make_shared<UniformScaleMap>(0.5)));
  grids[0]->setGridClass(openvdb::GRID_FOG_VOLUME);  // then never deflated
  // A grid that shares the tree of another
  const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(grids[0]);
  const auto copy = openvdb::FloatGrid::create(density->treePtr());
  copy->setName("instance");
  copy->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
  grids.push_back(copy);
  // Grids with the same name, and grids that cannot be volumes
  for (const double value : {0.5, 0.75}) {
    const auto twin = openvdb::FloatGrid::create(0);
    twin->tree().addTile(1, openvdb::Coord(0), static_cast<float>(value), true);
    twin->setName("twin");
    grids.push_back(twin);
  }
  const auto surface = openvdb::createLevelSet<openvdb::FloatGrid>(0.1);
  surface->setName("surface");
  grids.push_back(surface);
  grids.push_back(openvdb::BoolGrid::create(false));
  grids.back()->setName("mask");
  grids.push_back(openvdb::FloatGrid::create(0));
  grids.back()->setName("frustum");
  grids.back()->setTransform(
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(9)), 0.5, 2));
  grids.push_back(openvdb::FloatGrid::create(0));
  grids.back()->setName("empty");
  return grids;
}

/// The leaves of a grid of vectors, which openToNanoVDB() does not convert.
nanovdb::GridHandle<nanovdb::HostBuffer> make_nano_vectors(const openvdb::Vec3DGrid& grid) {
  const auto convert = [](const openvdb::Vec3d& v) { return nanovdb::Vec3d(v[0], v[1], v[2]); };
  nanovdb::GridBuilder<nanovdb::Vec3d> builder(convert(grid.background()));
  auto accessor = builder.getAccessor();
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueAll(); value; ++value) {
      const openvdb::Coord p = value.getCoord();
      accessor.setValue({p.x(), p.y(), p.z()}, convert(*value));
    }
  return builder.getHandle(1.0, nanovdb::Vec3d(0, 0, 0), grid.getName());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_vdb_files FOLDER\n");
    return 2;
  }
  openvdb::initialize();
  const std::string folder = std::string(argv[1]) + "/";
  const openvdb::GridPtrVec grids = make_grids();
  using namespace openvdb::io;
  const std::pair<const char*, std::uint32_t> compressions[] = {
      {"none", COMPRESS_NONE},
      {"active", COMPRESS_ACTIVE_MASK},
      {"zip", COMPRESS_ZIP},
      {"zip_active", COMPRESS_ZIP | COMPRESS_ACTIVE_MASK},
      {"blosc_active", COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK}};
  for (const auto& [name, flags] : compressions) {
    File file(folder + name + ".vdb");
    file.setCompression(flags);
    file.write(grids);
  }
  // Small files, for mutations
  for (const auto& [name, flags] : {std::pair<const char*, std::uint32_t>{"small_zip", COMPRESS_ZIP},
                                    {"small_blosc", COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK}}) {
    const auto density = openvdb::FloatGrid::create(0.25f);
    density->setName("density");
    density->setSaveFloatAsHalf(true);
    const auto heat = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
    heat->setName("heat");
    for (int i = 0; i < (flags == COMPRESS_ZIP ? 300 : 150); ++i) {
      const openvdb::Coord p(i & 7, i >> 3 & 7, i >> 6);
      density->tree().setValueOn(p, value_at<float>(p));
      heat->tree().setValueOn(p, value_at<openvdb::Vec3s>(p));
    }
    File file(folder + name + ".vdb");
    file.setCompression(flags);
    file.write(openvdb::GridPtrVec{density, heat});
  }
  // The same values in types that write_nanovdb() does not write
  std::vector<nanovdb::GridHandle<nanovdb::HostBuffer>> handles;
  handles.push_back(nanovdb::openToNanoVDB(*openvdb::gridPtrCast<openvdb::DoubleGrid>(grids[4])));
  handles.push_back(make_nano_vectors(*openvdb::gridPtrCast<openvdb::Vec3DGrid>(grids[5])));
  handles.push_back(nanovdb::openToNanoVDB(*openvdb::gridPtrCast<openvdb::Int32Grid>(grids[6])));
  handles.push_back(nanovdb::openToNanoVDB(*openvdb::gridPtrCast<openvdb::Int64Grid>(grids[7])));
  nanovdb::io::writeGrids(folder + "types.nvdb", handles, nanovdb::io::Codec::NONE);
  return 0;
}
