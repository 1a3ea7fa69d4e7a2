#include "scene/dialects/gltf/deformation.h"

#include <algorithm>

namespace sheaf::gltf {

namespace {

constexpr int kMaxSegments = 64;

/// Maximum error of positions between keys, as a fraction of the size of the mesh and of the distance by which its
/// vertices move.
constexpr float kMaxDeformationError = 2e-4f;

using Primitives = std::map<int, std::vector<Primitive>>;

struct Extent {
  float size, largest;  ///< diagonal of the bounds; largest coordinate
};

Extent extent_of(const Mesh& mesh) {
  if (mesh.positions.empty()) return {0, 0};
  Vec3f lower = mesh.positions[0], upper = lower;
  for (const Vec3f p : mesh.positions) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  return {length(upper - lower), std::max(max_component(abs(lower)), max_component(abs(upper)))};
}

/// The largest distance of a vertex of primitive `k` from where it is at index 0.
float motion_of(const Primitives& at, std::size_t k) {
  float longest = 0;
  const std::vector<Vec3f>& first = at.at(0)[k].mesh.positions;
  for (const auto& [index, primitives] : at)
    for (std::size_t i = 0; i < first.size(); ++i)
      longest = std::max(longest, length(primitives[k].mesh.positions[i] - first[i]));
  return longest;
}

/// Whether linear interpolation between every `stride`th index reproduces all primitives.
bool interpolate(const Primitives& at, int stride) {
  std::vector<float> motions;
  for (std::size_t k = 0; k < at.at(0).size(); ++k) motions.push_back(motion_of(at, k));
  for (const auto& [index, primitives] : at) {
    const int first = index / stride * stride;
    if (first == index) continue;
    const auto t = static_cast<float>(index - first) / static_cast<float>(stride);
    const std::vector<Primitive>&a = at.at(first), &b = at.at(first + stride);
    for (std::size_t k = 0; k < primitives.size(); ++k) {
      const std::vector<Vec3f>&p = a[k].mesh.positions, &q = b[k].mesh.positions, &r = primitives[k].mesh.positions;
      const Extent before = extent_of(a[k].mesh), after = extent_of(b[k].mesh);
      constexpr float kRounding = 4e-7f;
      const float tolerance = std::max(kMaxDeformationError * std::min(motions[k], std::max(before.size, after.size)),
                                       kRounding * std::max(before.largest, after.largest));
      for (std::size_t i = 0; i < r.size(); ++i)
        if (length(p[i] * (1 - t) + q[i] * t - r[i]) > tolerance) return false;
    }
  }
  return true;
}

}  // namespace

const std::vector<float>& weights_of(const GltfFile& file, const Pose& pose, std::size_t node) {
  const std::vector<float>& own = pose.weights[node];
  return own.empty() ? file.meshes[static_cast<std::size_t>(file.nodes[node].mesh)].weights : own;
}

Vec3d skin_origin(const GltfFile& file, const Pose& pose, std::size_t node) {
  // The transforms of instances apply after those of the joints
  if (file.nodes[node].skin == kNoIndex || !file.nodes[node].instances.empty()) return {};
  const std::vector<int>& joints = file.skins[static_cast<std::size_t>(file.nodes[node].skin)].joints;
  if (joints.empty()) return {};
  const Matrix4& first = pose.to_world[static_cast<std::size_t>(joints[0])];
  return {first.m[0][3], first.m[1][3], first.m[2][3]};
}

Deformation deformation_of(const GltfFile& file, const Pose& pose, std::size_t node, Vec3d origin) {
  Deformation out{weights_of(file, pose, node), {}};
  if (file.nodes[node].skin == kNoIndex) return out;
  const GltfSkin& skin = file.skins[static_cast<std::size_t>(file.nodes[node].skin)];
  std::vector<float> inverse;
  if (skin.inverse_bind_matrices != kNoIndex) inverse = read_floats(file, skin.inverse_bind_matrices, 16);
  for (std::size_t joint = 0; joint < skin.joints.size(); ++joint) {
    Matrix4 bind;
    if (!inverse.empty())
      for (std::size_t k = 0; k < 16; ++k) bind.m[k % 4][k / 4] = inverse[16 * joint + k];
    Matrix4 to_skin = pose.to_world[static_cast<std::size_t>(skin.joints[joint])];
    to_skin.m[0][3] -= origin.x;
    to_skin.m[1][3] -= origin.y;
    to_skin.m[2][3] -= origin.z;
    out.joint_to_skin.push_back(to_skin * bind);
  }
  return out;
}

Deformations::Deformations(GltfFile& file, const AnimationTime& moment, const ShutterDescription& shutter, bool lenient)
    : file_(file), moment_(moment), shutter_(shutter), lenient_(lenient) {
  for (std::size_t i = 0; i < file.nodes.size(); ++i)
    deforms_.push_back(file.nodes[i].mesh != kNoIndex && deforms_mesh(file, moment, shutter, i));
}

std::vector<Primitive> Deformations::primitives_at(std::size_t node, int index) {
  if (!poses_.contains(index)) {
    const double t = static_cast<double>(index) / kMaxSegments;
    const double time = *moment_.time + shutter_.open + t * (shutter_.close - shutter_.open);
    poses_.emplace(index, pose_at(file_, {time, moment_.animation}));
  }
  // The mesh at the first time has already made the notes
  const std::size_t notes = file_.notes.size();
  std::vector<Primitive> primitives =
      load_mesh(file_, file_.nodes[node].mesh,
                deformation_of(file_, poses_.at(index), node, skin_origin(file_, poses_.at(0), node)), lenient_);
  file_.notes.resize(notes);
  return primitives;
}

std::vector<DeformingMesh> Deformations::meshes(std::size_t node) {
  // Halve the segments until interpolation is accurate
  Primitives at;
  int stride = kMaxSegments / 4;
  for (;; stride /= 2) {
    for (int index = 0; index <= kMaxSegments; index += stride)
      if (!at.contains(index)) at.emplace(index, primitives_at(node, index));
    if (stride == 1 || interpolate(at, 2 * stride)) break;
  }
  // Omit times that are not needed
  while (stride < kMaxSegments && interpolate(at, 2 * stride)) stride *= 2;
  std::vector<DeformingMesh> out(at.at(0).size());
  for (int index = 0; index <= kMaxSegments; index += stride) {
    std::vector<Primitive>& primitives = at.at(index);
    const double t = static_cast<double>(index) / kMaxSegments;
    for (std::size_t k = 0; k < out.size(); ++k)
      out[k].keys.push_back(
          {shutter_.open + t * (shutter_.close - shutter_.open), std::move(primitives[k].mesh), Transform()});
  }
  return out;
}

}  // namespace sheaf::gltf
