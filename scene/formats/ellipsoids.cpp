// Ellipsoids in PLY files, converted to transforms of the unit sphere.
#include "scene/formats/ellipsoids.h"

#include "scene/formats/mesh_io.h"
#include "scene/formats/ply_source.h"

namespace sheaf {

namespace {

constexpr std::array<const char*, 10> kColumns = {"x",       "y",     "z",     "scale_0", "scale_1",
                                                  "scale_2", "rot_0", "rot_1", "rot_2",   "rot_3"};
/// Minimum semi-axis before scaling (as in Mitsuba 3).
constexpr double kShortestAxis = 1e-6;
constexpr int kUnwanted = -1;

using Row = std::array<double, kColumns.size()>;

/// Returns for each property its index in kColumns, or kUnwanted.
std::vector<int> columns_of(const PlyElement& element, const std::string& file) {
  std::vector<int> columns(element.properties.size(), kUnwanted);
  for (std::size_t c = 0; c < kColumns.size(); ++c) {
    const auto found = std::find_if(element.properties.begin(), element.properties.end(),
                                    [&](const PlyProperty& p) { return !p.count_type && p.name == kColumns[c]; });
    if (found == element.properties.end())
      throw SceneError(SourceLocation{file}, fmt::format("the element '{}' has no property '{}' (expected ellipsoids)",
                                                         element.name, kColumns[c]));
    columns[static_cast<std::size_t>(found - element.properties.begin())] = static_cast<int>(c);
  }
  return columns;
}

/// Returns the transform of the unit sphere: semi-axes, rotation by the quaternion (w, x, y, z), which is normalized,
/// and center.
Transform placement(const Row& row, double scale) {
  double q[4], squared = 0;
  for (std::size_t i = 0; i < 4; ++i) squared += row[6 + i] * row[6 + i];
  for (std::size_t i = 0; i < 4; ++i) q[i] = row[6 + i] / std::sqrt(squared);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double rotation[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                                 {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                                 {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  Matrix4 m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      m.m[i][j] = rotation[i][j] * std::max(std::exp(row[3 + j]), kShortestAxis) * scale;
    m.m[i][3] = row[i];
  }
  return Transform(m);
}

/// Whether single precision can represent the ellipsoid.
bool is_usable(const Row& row) {
  constexpr double kLargest = 1e12, kLargestLogarithm = 27;
  for (std::size_t i = 0; i < 3; ++i)
    if (!(std::abs(row[i]) <= kLargest) || !(row[3 + i] <= kLargestLogarithm)) return false;
  const double squared = row[6] * row[6] + row[7] * row[7] + row[8] * row[8] + row[9] * row[9];
  return squared > 0 && std::isfinite(squared);
}

}  // namespace

std::vector<Transform> read_ellipsoids(const std::filesystem::path& file, float scale) {
  const std::string name = file.string(), bytes = read_mesh_text(file, "PLY file");
  // Find the columns of the ellipsoids
  const PlyHeader header = parse_ply_header(bytes, name);
  if (header.elements.empty() || header.elements[0].count == 0)
    throw SceneError(SourceLocation{name}, "the file holds no ellipsoids");
  const PlyElement& element = header.elements[0];
  const std::vector<int> columns = columns_of(element, name);
  // Read the rows
  std::vector<Transform> out;
  out.reserve(element.count);
  with_ply_source(bytes, header, name, [&](auto& source) {
    source.enter(element);
    Row row{};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      source.enter_row(i);
      for (std::size_t k = 0; k < columns.size(); ++k) {
        if (columns[k] == kUnwanted)
          skip_property(source, element.properties[k]);
        else
          row[static_cast<std::size_t>(columns[k])] = source.number(element.properties[k].type);
      }
      if (!is_usable(row)) source.fail("an ellipsoid that is not finite, too large, or whose quaternion is 0");
      out.push_back(placement(row, static_cast<double>(scale)));
    }
  });
  return out;
}

}  // namespace sheaf
