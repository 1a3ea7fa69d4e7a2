#include "scene/dialects/gltf/vertex_map.h"

#include <cmath>

namespace sheaf::gltf {

namespace {

using Vector = std::array<double, 3>;

Vector column_of(const Matrix4& m, std::size_t k) { return {m.m[0][k], m.m[1][k], m.m[2][k]}; }

Vector cross_product(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec3f rounded(const Vector& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

/// The image of (v, w).
Vec3f image_of(const Matrix4& m, Vec3f v, double w) {
  Vector out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = m.m[i][0] * v.x + m.m[i][1] * v.y + m.m[i][2] * v.z + m.m[i][3] * w;
  return rounded(out);
}

/// The normal by the matrix of cofactors, which is that of the inverse transpose up to the determinant. Unit length, or
/// zero.
Vec3f normal_by_cofactors(const Matrix4& m, Vec3f n) {
  const Vector x = column_of(m, 0), y = column_of(m, 1), z = column_of(m, 2);
  const Vector yz = cross_product(y, z), zx = cross_product(z, x), xy = cross_product(x, y);
  Vector out;
  double squared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = yz[i] * n.x + zx[i] * n.y + xy[i] * n.z;
    squared += out[i] * out[i];
  }
  if (!(squared > 0) || !std::isfinite(squared)) return {0, 0, 0};
  for (double& c : out) c /= std::sqrt(squared);
  return rounded(out);
}

}  // namespace

VertexMap::VertexMap(const Matrix4& matrix) : matrix_(matrix) {
  Matrix4 inverse;
  if (invert(matrix, inverse)) regular_.emplace(matrix);
}

void VertexMap::apply(Mesh& mesh, std::size_t vertex) const {
  Vec3f& p = mesh.positions[vertex];
  p = regular_ ? regular_->point(p) : image_of(matrix_, p, 1);
  if (!mesh.normals.empty()) {
    Vec3f& n = mesh.normals[vertex];
    n = regular_ ? regular_->normal(n) : normal_by_cofactors(matrix_, n);
  }
  if (!mesh.tangents.empty()) {
    MeshTangent& t = mesh.tangents[vertex];
    t.direction = image_of(matrix_, t.direction, 0);
    if (regular_ && regular_->swaps_handedness()) t.handedness = -t.handedness;
  }
}

}  // namespace sheaf::gltf
