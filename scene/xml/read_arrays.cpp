#include "scene/xml/read_arrays.h"

#include "core/color/color.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sheaf {

namespace {

constexpr const char* type_name(ArrayValue::Type type) {
  return type == ArrayValue::Type::kFloat ? "float32" : type == ArrayValue::Type::kIndex ? "uint32" : "uint8";
}

/// Throws unless the array has this type and `rows` rows (any number if 0) of `columns` numbers.
void expect(Properties& p, const char* name, const ArrayValue& array, ArrayValue::Type type, std::size_t rows,
            std::size_t columns) {
  const std::size_t length = array.shape.empty() ? 0 : array.shape[0];
  const bool fits = array.type == type && array.shape.size() == 2 && array.shape[1] == columns &&
                    (rows == 0 ? length > 0 : length == rows);
  if (fits) return;
  const std::string count = rows == 0 ? "N" : std::to_string(rows);
  p.fail_at(name,
            fmt::format("is an array of {}, expected {} ({}, {})", array.text(), type_name(type), count, columns));
}

/// Throws if a number is not finite.
void expect_finite(Properties& p, const char* name, std::span<const float> values) {
  const auto bad = std::find_if(values.begin(), values.end(), [](float value) { return !std::isfinite(value); });
  if (bad != values.end())
    p.fail_at(name, fmt::format("has the value {} at index {} of the flat array, expected finite numbers",
                                number_text(static_cast<double>(*bad)), bad - values.begin()));
}

/// Reads rows of floats into a vector of structs that consist of floats.
template <class Row>
std::vector<Row> read_rows(Properties& p, const char* name, const ArrayValue& array, std::size_t rows) {
  constexpr std::size_t kColumns = sizeof(Row) / sizeof(float);
  expect(p, name, array, ArrayValue::Type::kFloat, rows, kColumns);
  expect_finite(p, name, array.floats());
  std::vector<Row> out(array.shape[0]);
  std::memcpy(static_cast<void*>(out.data()), array.data, out.size() * sizeof(Row));
  return out;
}

/// Reads the indices of each triangle, which must be below `vertices`.
std::vector<std::array<std::uint32_t, 3>> read_faces(Properties& p, std::size_t vertices) {
  const ArrayValue* faces = p.find_array("faces");
  if (faces == nullptr) p.fail("has the array 'vertices', but not 'faces'");
  expect(p, "faces", *faces, ArrayValue::Type::kIndex, 0, 3);
  const std::span<const std::uint32_t> indices = faces->indices();
  const auto bad = std::find_if(indices.begin(), indices.end(), [&](std::uint32_t i) { return i >= vertices; });
  if (bad != indices.end())
    p.fail_at("faces", fmt::format("has the index {} in face {}, but there are {} vertices", *bad,
                                   (bad - indices.begin()) / 3, vertices));
  std::vector<std::array<std::uint32_t, 3>> out(faces->shape[0]);
  std::memcpy(out.data(), faces->data, indices.size_bytes());
  return out;
}

/// Appends the attributes whose names begin with `prefix`, which have `rows` values.
void read_attributes(Properties& p, std::string_view prefix, std::size_t rows, Mesh& mesh) {
  for (const auto& [name, array] : p.arrays_with_prefix(prefix)) {
    const std::size_t channels = array->shape.size() == 1   ? 1
                                 : array->shape.size() == 2 ? array->shape[1]
                                                            : std::size_t{0};
    if (array->type != ArrayValue::Type::kFloat || (channels != 1 && channels != 3) || array->shape[0] != rows)
      p.fail_at(name.c_str(),
                fmt::format("is an array of {}, expected float32 ({}) or ({}, 3)", array->text(), rows, rows));
    expect_finite(p, name.c_str(), array->floats());
    const std::span<const float> values = array->floats();
    mesh.attributes.push_back({name, static_cast<int>(channels), {values.begin(), values.end()}});
  }
}

/// Returns the array, which must have `dimensions` dimensions besides channels, with at most `max_side` per side and a
/// number of channels in `channels`.
const ArrayValue& grid_of(Properties& p, const char* name, std::size_t dimensions, std::size_t max_side,
                          std::initializer_list<std::size_t> channels, const char* expected) {
  const ArrayValue* array = p.find_array(name);
  if (array == nullptr) p.fail(fmt::format("needs the array '{}'", name));
  const std::vector<std::size_t>& shape = array->shape;
  const bool has_channels = shape.size() == dimensions + 1;
  bool fits = (shape.size() == dimensions || has_channels) && array->type != ArrayValue::Type::kIndex;
  for (std::size_t axis = 0; fits && axis < dimensions; ++axis) fits = shape[axis] >= 1 && shape[axis] <= max_side;
  if (fits && has_channels) fits = std::find(channels.begin(), channels.end(), shape[dimensions]) != channels.end();
  if (!fits) p.fail_at(name, fmt::format("is an array of {}, expected {}", array->text(), expected));
  if (array->type == ArrayValue::Type::kFloat) expect_finite(p, name, array->floats());
  return *array;
}

}  // namespace

std::string ArrayValue::text() const {
  std::string sides;
  for (const std::size_t side : shape) sides += (sides.empty() ? "" : ", ") + std::to_string(side);
  return fmt::format("{} ({})", type_name(type), sides);
}

Mesh read_mesh_arrays(Properties& p) {
  Mesh mesh;
  const ArrayValue* vertices = p.find_array("vertices");
  if (vertices == nullptr) p.fail("needs the array 'vertices'");
  mesh.positions = read_rows<Vec3f>(p, "vertices", *vertices, 0);
  mesh.triangles = read_faces(p, mesh.positions.size());
  if (const ArrayValue* normals = p.find_array("normals"))
    mesh.normals = read_rows<Vec3f>(p, "normals", *normals, mesh.positions.size());
  if (const ArrayValue* uvs = p.find_array("uv")) mesh.uvs = read_rows<Vec2f>(p, "uv", *uvs, mesh.positions.size());
  read_attributes(p, "vertex_", mesh.positions.size(), mesh);
  read_attributes(p, "face_", mesh.triangles.size(), mesh);
  return mesh;
}

Image read_image_array(Properties& p, const char* name, bool raw) {
  const ArrayValue& array =
      grid_of(p, name, 2, kMaxImageSide, {1, 3, 4}, "float32 or uint8 (H, W), or (H, W, C) with 1, 3 or 4 channels");
  const std::size_t channels = array.shape.size() == 3 ? array.shape[2] : 1;
  std::vector<std::string> names{"Y"};
  if (channels >= 3) names = {"R", "G", "B"};
  if (channels == 4) names.emplace_back("A");
  Image image(static_cast<int>(array.shape[1]), static_cast<int>(array.shape[0]), std::move(names));
  if (array.type == ArrayValue::Type::kFloat) {
    std::copy(array.floats().begin(), array.floats().end(), image.data.begin());
    return image;
  }
  // Decode bytes
  const std::span<const std::uint8_t> bytes = array.bytes();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const float value = static_cast<float>(bytes[i]) / 255.0f;
    const bool is_alpha = channels == 4 && i % 4 == 3;
    image.data[i] = raw || is_alpha ? value : srgb_to_linear(value);
  }
  return image;
}

DenseVolume read_volume_array(Properties& p, const char* name) {
  const ArrayValue& array =
      grid_of(p, name, 3, kMaxGridSide, {1, 3}, "float32 (Z, Y, X), or (Z, Y, X, C) with 1 or 3 channels");
  if (array.type != ArrayValue::Type::kFloat)
    p.fail_at(name, fmt::format("is an array of {}, expected float32", array.text()));
  DenseVolume volume;
  volume.channels = array.shape.size() == 4 ? static_cast<int>(array.shape[3]) : 1;
  Matrix4 cells;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    volume.size[axis] = static_cast<int>(array.shape[2 - axis]);
    cells.m[axis][axis] = 1.0 / volume.size[axis];
    cells.m[axis][3] = 0.5 * cells.m[axis][axis];
  }
  volume.values.assign(array.floats().begin(), array.floats().end());
  volume.grid_to_local = Transform(cells);
  return volume;
}

}  // namespace sheaf
