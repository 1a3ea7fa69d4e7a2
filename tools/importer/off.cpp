// OFF models in the form in which Assimp passes on those of other formats.
#include "tools/importer/conversion.h"

#include <algorithm>
#include <cmath>

namespace sheaf::importer {

namespace {

template <class T> void replace_by_copies(T*& values, const std::vector<unsigned>& sources) {
  if (values == nullptr) return;
  T* const copies = new T[sources.size()];
  std::transform(sources.begin(), sources.end(), copies, [&](unsigned source) { return values[source]; });
  delete[] values;
  values = copies;
}

/// Gives each corner of a face a vertex of its own, so that normals can differ.
void split_vertices(aiMesh& mesh) {
  std::vector<unsigned> sources;
  for (unsigned i = 0; i < mesh.mNumFaces; ++i)
    for (unsigned k = 0; k < mesh.mFaces[i].mNumIndices; ++k) {
      unsigned& vertex = mesh.mFaces[i].mIndices[k];
      if (vertex >= mesh.mNumVertices) throw ImportError("has a face with a vertex that does not exist");
      sources.push_back(vertex);
      vertex = static_cast<unsigned>(sources.size() - 1);
    }
  if (sources.size() > 0xffffffffu) throw ImportError("has too many faces");
  replace_by_copies(mesh.mVertices, sources);
  replace_by_copies(mesh.mNormals, sources);
  replace_by_copies(mesh.mTextureCoords[0], sources);
  replace_by_copies(mesh.mColors[0], sources);
  mesh.mNumVertices = static_cast<unsigned>(sources.size());
}

/// Inverse of the transfer function of sRGB (IEC 61966-2-1).
float srgb_to_linear(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

/// Makes colors linear. They are bytes in sRGB if one of them is larger than 1.
void convert_colors(aiColor4D* colors, unsigned count) {
  constexpr float kByte = 255;
  const auto is_byte = [](const aiColor4D& c) { return std::max({c.r, c.g, c.b}) > 1; };
  if (std::none_of(colors, colors + count, is_byte)) return;
  for (unsigned i = 0; i < count; ++i)
    for (unsigned k = 0; k < 3; ++k) colors[i][k] = srgb_to_linear(colors[i][k] / kByte);
}

}  // namespace

void prepare_off(aiScene& scene) {
  const aiColor3D white(1, 1, 1);
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    aiMesh& mesh = *scene.mMeshes[i];
    split_vertices(mesh);
    if (mesh.mColors[0] == nullptr) continue;
    convert_colors(mesh.mColors[0], mesh.mNumVertices);
    // Assimp's material is gray, which would multiply the colors
    scene.mMaterials[mesh.mMaterialIndex]->AddProperty(&white, 1, AI_MATKEY_COLOR_DIFFUSE);
  }
}

}  // namespace sheaf::importer
