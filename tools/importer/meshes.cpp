// Meshes: vertices, triangles and morph targets.
#include "tools/importer/conversion.h"

#include <fmt/format.h>

#include <algorithm>

namespace sheaf::importer {

namespace {

using nlohmann::json;

/// Adds an accessor with vectors of an array of Assimp.
int add_vectors(Conversion& to, const aiVector3D* from, std::size_t count) {
  std::vector<float> values;
  values.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) values.insert(values.end(), {from[i].x, from[i].y, from[i].z});
  return to.glb.add_accessor(values, count, "VEC3");
}

/// Adds an accessor with the differences of two arrays.
int add_differences(Conversion& to, const aiVector3D* from, const aiVector3D* base, std::size_t count) {
  std::vector<aiVector3D> differences(count);
  for (std::size_t i = 0; i < count; ++i) differences[i] = from[i] - base[i];
  return add_vectors(to, differences.data(), count);
}

json attributes_of(Conversion& to, const aiMesh& mesh) {
  const std::size_t count = mesh.mNumVertices;
  json attributes = {{"POSITION", add_vectors(to, mesh.mVertices, count)}};
  if (mesh.mNormals != nullptr) attributes["NORMAL"] = add_vectors(to, mesh.mNormals, count);
  std::vector<float> values;
  for (unsigned set = 0; set < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh.mTextureCoords[set] != nullptr; ++set) {
    values.clear();
    // Assimp's v points upwards, that of glTF downwards.
    for (std::size_t i = 0; i < count; ++i)
      values.insert(values.end(), {mesh.mTextureCoords[set][i].x, 1 - mesh.mTextureCoords[set][i].y});
    attributes[fmt::format("TEXCOORD_{}", set)] = to.glb.add_accessor(values, count, "VEC2");
  }
  if (mesh.mColors[0] == nullptr) return attributes;
  values.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const aiColor4D& c = mesh.mColors[0][i];
    values.insert(values.end(), {c.r, c.g, c.b, c.a});
  }
  attributes["COLOR_0"] = to.glb.add_accessor(values, count, "VEC4");
  return attributes;
}

/// The vertices of all triangles.
std::vector<std::uint32_t> corners_of(const aiMesh& mesh) {
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * std::size_t{mesh.mNumFaces});
  for (unsigned i = 0; i < mesh.mNumFaces; ++i)
    if (mesh.mFaces[i].mNumIndices == 3)
      corners.insert(corners.end(), mesh.mFaces[i].mIndices, mesh.mFaces[i].mIndices + 3);
  return corners;
}

}  // namespace

json mesh_of(Conversion& to, const aiMesh& mesh) {
  json primitive;
  primitive["attributes"] = attributes_of(to, mesh);
  const std::vector<std::uint32_t> corners = corners_of(mesh);
  primitive["indices"] = to.glb.add_accessor(corners, corners.size(), "SCALAR");
  primitive["material"] = mesh.mMaterialIndex;
  json weights = json::array();
  for (unsigned i = 0; i < mesh.mNumAnimMeshes; ++i) {
    const aiAnimMesh& target = *mesh.mAnimMeshes[i];
    if (target.mNumVertices != mesh.mNumVertices || target.mVertices == nullptr) continue;
    json differences = {{"POSITION", add_differences(to, target.mVertices, mesh.mVertices, mesh.mNumVertices)}};
    if (target.mNormals != nullptr && mesh.mNormals != nullptr)
      differences["NORMAL"] = add_differences(to, target.mNormals, mesh.mNormals, mesh.mNumVertices);
    primitive["targets"].push_back(std::move(differences));
    weights.push_back(finite(target.mWeight));
  }
  json out = {{"name", text(mesh.mName)}};
  out["primitives"].push_back(std::move(primitive));
  if (!weights.empty()) out["weights"] = std::move(weights);
  return out;
}

}  // namespace sheaf::importer
