// The pbrt dialect: directives that modify the current transformation matrix.
#include "scene/dialects/pbrt/scene.h"

#include <array>

namespace sheaf::pbrt {

namespace {

/// Reads N numbers, with or without brackets.
template <std::size_t N> std::array<double, N> read_numbers(Tokens& tokens, const char* expected) {
  std::array<double, N> numbers;
  const bool brackets = tokens.current().kind == Token::Kind::kOpen;
  if (brackets) tokens.advance();
  for (double& number : numbers) {
    number = number_of(tokens.current(), tokens.where(), expected);
    tokens.advance();
  }
  if (!brackets) return numbers;
  if (tokens.current().kind != Token::Kind::kClose)
    throw SceneError(tokens.where(), fmt::format("found {}, expected ']'", displayed(tokens.current())));
  tokens.advance();
  return numbers;
}

Vec3d vec3(const double* n) { return {n[0], n[1], n[2]}; }

/// Reads 16 numbers in column-major order.
Matrix4 read_matrix(Tokens& tokens) {
  const auto numbers = read_numbers<16>(tokens, "16 numbers of a matrix");
  Matrix4 matrix;
  for (std::size_t i = 0; i < 16; ++i) matrix.m[i % 4][i / 4] = numbers[i];
  for (std::size_t j = 0; j < 4; ++j)
    if (matrix.m[3][j] != (j == 3 ? 1.0 : 0.0))
      throw SceneError(tokens.where(), "the matrix has another last row, expected 0 0 0 1");
  return matrix;
}

/// Returns make(); adds the location to its errors.
template <class Make> Transform transform_at(const SourceLocation& where, Make make) {
  try {
    return make();
  } catch (const SceneError& error) { throw SceneError(where, error); }
}

}  // namespace

template <class Change> void SceneBuilder::change_transforms(Change&& change) {
  Attributes& attributes = reader_.attributes;
  if (attributes.start_is_active) attributes.transform.start = change(attributes.transform.start);
  if (attributes.end_is_active) attributes.transform.end = change(attributes.transform.end);
}

void SceneBuilder::apply_transform(const Transform& transform) {
  change_transforms([&](const Transform& before) { return before * transform; });
}

void SceneBuilder::active_transform(Tokens& tokens) {
  const std::string_view word = tokens.current().text;
  if (word != "StartTime" && word != "EndTime" && word != "All")
    throw SceneError(tokens.where(),
                     fmt::format("found {}, expected StartTime, EndTime or All", displayed(tokens.current())));
  reader_.attributes.start_is_active = word != "EndTime";
  reader_.attributes.end_is_active = word != "StartTime";
  tokens.advance();
}

void SceneBuilder::concat_transform(Tokens& tokens) {
  const Matrix4 matrix = read_matrix(tokens);
  apply_transform(transform_at(where_, [&] { return Transform(matrix); }));
}

void SceneBuilder::coord_sys_transform(Tokens& tokens) {
  const std::string name = read_string(tokens, "a coordinate system");
  const auto found = coordinate_systems_.find(name);
  if (found == coordinate_systems_.end())
    throw SceneError(where_, fmt::format("the coordinate system '{}' is not defined yet", name));
  // As in pbrt, whichever matrices are active
  reader_.attributes.transform = found->second;
}

void SceneBuilder::coordinate_system(Tokens& tokens) {
  coordinate_systems_[read_string(tokens, "a name")] = reader_.attributes.transform;
}

void SceneBuilder::identity(Tokens&) {
  change_transforms([](const Transform&) { return Transform(); });
}

void SceneBuilder::look_at(Tokens& tokens) {
  const auto n = read_numbers<9>(tokens, "nine numbers: eye, target and up");
  apply_transform(
      transform_at(where_, [&] { return Transform::look_at(vec3(&n[0]), vec3(&n[3]), vec3(&n[6])).inverse(); }));
}

void SceneBuilder::reverse_orientation(Tokens&) {
  reader_.attributes.reverse_orientation = !reader_.attributes.reverse_orientation;
}

void SceneBuilder::rotate(Tokens& tokens) {
  const auto n = read_numbers<4>(tokens, "four numbers: degrees and an axis");
  apply_transform(transform_at(where_, [&] { return Transform::rotate(vec3(&n[1]), n[0]); }));
}

void SceneBuilder::scale(Tokens& tokens) {
  const auto n = read_numbers<3>(tokens, "three factors");
  apply_transform(transform_at(where_, [&] { return Transform::scale(vec3(n.data())); }));
}

void SceneBuilder::transform(Tokens& tokens) {
  const Matrix4 matrix = read_matrix(tokens);
  const Transform made = transform_at(where_, [&] { return Transform(matrix); });
  change_transforms([&](const Transform&) { return made; });
}

void SceneBuilder::transform_begin(Tokens&) { save("TransformBegin"); }

void SceneBuilder::transform_end(Tokens&) {
  Attributes before;
  restore("TransformBegin", before);
  reader_.attributes.transform = before.transform;
  reader_.attributes.start_is_active = before.start_is_active;
  reader_.attributes.end_is_active = before.end_is_active;
}

void SceneBuilder::transform_times(Tokens& tokens) {
  const auto times = read_numbers<2>(tokens, "two times");
  if (!(times[0] < times[1])) throw SceneError(where_, "TransformTimes: the motion ends before it starts");
  reader_.start_time = times[0];
  reader_.end_time = times[1];
}

void SceneBuilder::translate(Tokens& tokens) {
  const auto n = read_numbers<3>(tokens, "three lengths");
  apply_transform(transform_at(where_, [&] { return Transform::translate(vec3(n.data())); }));
}

}  // namespace sheaf::pbrt
