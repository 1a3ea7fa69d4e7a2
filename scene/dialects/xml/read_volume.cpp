// Volumes shared by the Nori and Mitsuba dialects: constants, grids in files, and their bounds.
#include "scene/dialects/xml/read_volume.h"

#include "scene/description/voxels.h"
#include "scene/formats/vol_file.h"
#include "scene/xml/read_arrays.h"
#include "scene/xml/xml_values.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>

namespace sheaf {

namespace {

using Grid = GridVolumeDescription;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Returns the first 8 bytes of a file, or fewer if it is shorter.
std::string first_bytes(const std::filesystem::path& file) {
  std::array<char, 8> bytes{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<std::size_t>(stream.gcount())};
}

Grid::Format format_of(Properties& p, const std::filesystem::path& file) {
  const std::string extension = lower(file.extension().string());
  if (extension == ".vol") return Grid::Format::kVol;
  if (extension == ".nvdb" || extension == ".vdb") return Grid::Format::kSparse;
  const std::string head = first_bytes(file);
  if (head.starts_with("VOL")) return Grid::Format::kVol;
  if (head.starts_with("NanoVDB") || head.starts_with(" BDV")) return Grid::Format::kSparse;
  p.fail_at("filename", fmt::format("is {}, expected a .vol, .nvdb or .vdb file", in_quotes(file.filename().string())));
}

GridFilter read_grid_filter(Properties& p) {
  static constexpr NameTable<GridFilter> kFilters{
      {{"trilinear", GridFilter::kTrilinear}, {"nearest", GridFilter::kNearest}}};
  return p.choice("filter_type", kFilters, GridFilter::kTrilinear);
}

Grid::Wrap read_wrap(Properties& p) {
  static constexpr NameTable<Grid::Wrap> kWraps{
      {{"clamp", Grid::Wrap::kClamp}, {"repeat", Grid::Wrap::kRepeat}, {"mirror", Grid::Wrap::kMirror}}};
  return p.choice("wrap_mode", kWraps, Grid::Wrap::kClamp);
}

/// Interpolates the keys of a motion about the center of the unit cube, so that a cube that turns stays in place, as
/// shapes around their origin do.
Placement about_center(const Placement& placement) {
  if (!placement.motion) return placement;
  const Transform center = Transform::translate({0.5f, 0.5f, 0.5f});
  std::vector<AnimatedTransform::Key> keys;
  for (const double time : placement.motion->key_times()) keys.push_back({time, placement.motion->at(time) * center});
  return Placement(AnimatedTransform(std::move(keys)) * AnimatedTransform(center.inverse()));
}

/// Reads where a volume lies. `in_cube`: it fills the unit cube.
Placement read_to_world(Properties& p, bool may_move, bool in_cube) {
  if (!may_move) return Placement(p.transform("to_world"));
  return in_cube ? about_center(p.placement("to_world")) : p.placement("to_world");
}

void read_placement(Properties& p, const VolumeDialect& dialect, Grid& grid) {
  const bool placed = p.has("to_world");
  grid.use_grid_bbox = p.boolean("use_grid_bbox", dialect.bbox_of_file);
  const bool in_cube = grid.format != Grid::Format::kSparse && !grid.use_grid_bbox;
  const Placement placement = read_to_world(p, dialect.may_move, in_cube);
  grid.to_world = placement.to_world;
  grid.motion = add_motion(p.context().description.motions, placement);
  if (!dialect.fits_shapes) return;
  grid.fit_to_shape = p.boolean("fitToShape", dialect.in_shape && !placed);
  if (!grid.fit_to_shape || (!placed && dialect.in_shape)) return;
  p.report_at("fitToShape",
              placed ? "is true together with 'toWorld', expected one of them" : "is true in a medium without a shape");
  grid.fit_to_shape = dialect.in_shape && !placed;
}

VolumeInput read_volume(const XmlElement& element, ReadContext& context, SpectrumRole role,
                        const VolumeDialect& dialect);

VolumeInput read_constant(Properties& p, SpectrumRole role, const VolumeDialect&) {
  const auto value = p.find_spectrum("value", role);
  if (!value) p.fail("needs the spectrum 'value'", SceneErrorCode::kMissing);
  p.ignore({"to_world"});
  return *value;
}

VolumeInput read_any_grid(Properties& p, SpectrumRole, const VolumeDialect& dialect) { return read_grid(p, dialect); }

template <Grid::Format kFormat> VolumeInput read_grid_of(Properties& p, SpectrumRole, const VolumeDialect& dialect) {
  return read_grid(p, dialect, kFormat);
}

/// Reads the nested volume of a cache.
VolumeInput read_cache(Properties& p, SpectrumRole role, const VolumeDialect& dialect) {
  p.ignore({"block_size", "voxel_width", "memory_limit", "step_size_multiplier"});
  const XmlElement* cached = p.object("volume");
  if (cached == nullptr) p.fail("has no <volume>, expected one", SceneErrorCode::kMissing);
  return read_volume(*cached, p.context(), role, dialect);
}

constexpr NameTable<VolumeInput (*)(Properties&, SpectrumRole, const VolumeDialect&)> kVolumes{
    {{"constantvolume", read_constant},
     {"constvolume", read_constant},
     {"gridvolume", read_any_grid},
     {"nanovdb", read_grid_of<Grid::Format::kSparse>},
     {"vol", read_grid_of<Grid::Format::kVol>},
     {"volcache", read_cache}}};

VolumeInput read_volume(const XmlElement& element, ReadContext& context, SpectrumRole role,
                        const VolumeDialect& dialect) {
  Properties p(element, context);
  VolumeInput volume = p.plugin(kVolumes)(p, role, dialect);
  p.reject_unused();
  return volume;
}

using MatrixVolume = std::variant<std::array<float, 6>, Grid>;

MatrixVolume read_constant_matrix(Properties& p, const VolumeDialect&) {
  const auto text = p.find_string("value");
  if (!text) p.fail("needs the string 'value': six numbers, xx yy zz xy xz yz", SceneErrorCode::kMissing);
  const std::vector<float> numbers = parse_floats(*text, p.where(), "value");
  std::array<float, 6> matrix;
  if (numbers.size() != matrix.size())
    p.fail_at("value", fmt::format("has {} numbers, expected six: xx yy zz xy xz yz", numbers.size()));
  std::copy(numbers.begin(), numbers.end(), matrix.begin());
  p.ignore({"to_world"});
  return matrix;
}

MatrixVolume read_matrix_grid(Properties& p, const VolumeDialect& dialect) {
  return read_grid(p, dialect, Grid::Format::kVol);
}

constexpr NameTable<MatrixVolume (*)(Properties&, const VolumeDialect&)> kMatrixVolumes{
    {{"constantvolume", read_constant_matrix},
     {"constvolume", read_constant_matrix},
     {"gridvolume", read_matrix_grid},
     {"vol", read_matrix_grid}}};

/// Returns the `to_world` of a constant volume, which may be nested in caches.
Placement placement_of_constant(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  const XmlElement* cached = p.object("volume");
  return cached != nullptr ? placement_of_constant(*cached, context) : read_to_world(p, true, true);
}

/// Whether the transform maps axes to axes, in any order, up to rounding.
bool keeps_axes(const Transform& t) {
  const auto& m = t.matrix().m;
  for (std::size_t column = 0; column < 3; ++column) {
    double largest = 0, sum = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      largest = std::max(largest, std::fabs(m[row][column]));
      sum += std::fabs(m[row][column]);
    }
    if (sum - largest > 1e-6 * largest) return false;
  }
  return true;
}

}  // namespace

Grid world_box(const Transform& to_world) {
  // The extent along each world axis is the sum of the absolute values of a matrix row.
  const auto& m = to_world.matrix().m;
  DenseVolume voxel;
  voxel.size = {1, 1, 1};
  voxel.values = {1};
  Matrix4 box;
  for (std::size_t row = 0; row < 3; ++row) {
    box.m[row][row] = std::fabs(m[row][0]) + std::fabs(m[row][1]) + std::fabs(m[row][2]);
    box.m[row][3] = m[row][3] + 0.5 * (m[row][0] + m[row][1] + m[row][2]);
  }
  voxel.grid_to_local = Transform(box);
  Grid grid;
  grid.format = Grid::Format::kInMemory;
  grid.made = std::make_shared<const DenseVolume>(std::move(voxel));
  return grid;
}

std::optional<Grid> find_volume_bounds(Properties& p, const char* name, const VolumeInput& volume) {
  const auto* grid = std::get_if<Grid>(&volume);
  if (grid == nullptr) {
    const XmlElement* nested = p.named_object("volume", name);
    const Placement placement = nested != nullptr ? placement_of_constant(*nested, p.context()) : Placement();
    Grid box = world_box(placement.to_world);
    box.motion = add_motion(p.context().description.motions, placement);
    return box;
  }
  if (grid->format == Grid::Format::kSparse || keeps_axes(grid->to_world)) return std::nullopt;
  Transform to_world = grid->to_world;
  if (grid->use_grid_bbox && grid->format == Grid::Format::kVol) to_world = to_world * vol_box(grid->file);
  Grid box = world_box(to_world);
  box.motion = grid->motion;
  return box;
}

GridVolumeDescription read_grid(Properties& p, const VolumeDialect& dialect, std::optional<Grid::Format> format) {
  Grid grid;
  if (!format && p.find_array("data") != nullptr) {
    grid.format = Grid::Format::kInMemory;
    grid.made = std::make_shared<const DenseVolume>(read_volume_array(p, "data"));
  } else {
    grid.file = p.file("filename");
    grid.format = format_of(p, grid.file);
  }
  if (format && *format != grid.format)
    p.fail_at("filename", fmt::format("is {}, expected a {} file", in_quotes(grid.file.filename().string()),
                                      *format == Grid::Format::kVol ? ".vol" : ".nvdb or .vdb"));
  grid.grid = p.string("grid_name", "");
  if (!grid.grid.empty() && grid.format != Grid::Format::kSparse) {
    p.report_at("grid_name", "is set for a .vol file or an array, expected a .nvdb or .vdb file");
    grid.grid.clear();
  }
  read_placement(p, dialect, grid);
  grid.filter = read_grid_filter(p);
  grid.wrap = read_wrap(p);
  grid.raw = p.boolean("raw", false);
  p.ignore({"accel", "send_data"});
  return grid;
}

std::optional<VolumeInput> find_volume_input(Properties& p, const char* name, SpectrumRole role,
                                             const VolumeDialect& dialect) {
  const XmlElement* nested = p.named_object("volume", name);
  if (nested != nullptr && p.has(name)) p.report_conflict(name, "a <volume> of this name");
  std::optional<VolumeInput> volume;
  if (nested != nullptr) {
    const auto read = [&] { volume = read_volume(*nested, p.context(), role, dialect); };
    if (!read_or_omit(*nested, p.context(), read)) p.drop_object(*nested);
  } else if (const auto spectrum = p.find_spectrum(name, role)) {
    volume = *spectrum;
  }
  return volume;
}

VolumeInput volume_input(Properties& p, const char* name, const SpectrumDescription& default_value, SpectrumRole role,
                         const VolumeDialect& dialect) {
  if (const std::optional<VolumeInput> found = find_volume_input(p, name, role, dialect)) return *found;
  return p.spectrum(name, default_value, role);
}

bool has_volume_input(Properties& p, const char* name) {
  return p.has(name) || p.named_object("volume", name) != nullptr;
}

std::optional<SpectrumDescription> find_constant_volume(Properties& p, const char* name, SpectrumRole role,
                                                        const VolumeDialect& dialect) {
  const std::optional<VolumeInput> input = find_volume_input(p, name, role, dialect);
  if (!input) return std::nullopt;
  if (const auto* spectrum = std::get_if<SpectrumDescription>(&*input)) return *spectrum;
  p.fail(fmt::format("has a grid for '{}', expected the same value everywhere", name));
}

MatrixVolume read_matrix_volume(const XmlElement& element, ReadContext& context, const VolumeDialect& dialect) {
  Properties p(element, context);
  MatrixVolume volume = p.plugin(kMatrixVolumes)(p, dialect);
  p.reject_unused();
  return volume;
}

float number_of(Properties& p, const char* name, const SpectrumDescription& spectrum) {
  if (const auto* constant = std::get_if<SpectrumDescription::Constant>(&spectrum.value)) return constant->value;
  p.fail(fmt::format("has a color for '{}', expected a number", name));
}

}  // namespace sheaf
