// Triangulation of all polygons. Assimp's own one is wrong for some concave polygons.
#include "scene/formats/triangulate.h"
#include "tools/importer/conversion.h"

#include <fmt/format.h>

#include <algorithm>

namespace sheaf::importer {

namespace {

/// Replaces the faces of a mesh by triangles; points and lines remain. Returns the number of polygons that intersect
/// themselves.
std::size_t triangulate_mesh(aiMesh& mesh) {
  struct Face {
    unsigned count;
    std::array<unsigned, 3> vertices;
  };
  std::vector<Face> faces;
  std::vector<Vec3f> outline;
  std::vector<PolygonTriangle> triangles;
  std::size_t crossed = 0;
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    outline.clear();
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= mesh.mNumVertices) throw ImportError("has a face with a vertex that does not exist");
      const aiVector3D& p = mesh.mVertices[face.mIndices[k]];
      outline.push_back({p.x, p.y, p.z});
    }
    if (face.mNumIndices <= 3) {
      faces.push_back({face.mNumIndices, {}});
      std::copy_n(face.mIndices, face.mNumIndices, faces.back().vertices.begin());
      continue;
    }
    if (!triangulate_polygon(outline, triangles)) ++crossed;
    for (const PolygonTriangle& t : triangles)
      faces.push_back({3, {face.mIndices[t[0]], face.mIndices[t[1]], face.mIndices[t[2]]}});
  }
  if (faces.size() > 0xffffffffu) throw ImportError("has a mesh with too many triangles");
  delete[] mesh.mFaces;
  mesh.mFaces = new aiFace[faces.size()];
  mesh.mNumFaces = static_cast<unsigned>(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    aiFace& face = mesh.mFaces[i];
    face.mNumIndices = faces[i].count;
    face.mIndices = new unsigned[face.mNumIndices];
    std::copy_n(faces[i].vertices.begin(), face.mNumIndices, face.mIndices);
  }
  return crossed;
}

}  // namespace

void triangulate(aiScene& scene, std::vector<std::string>& notes) {
  std::size_t crossed = 0;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    aiMesh& mesh = *scene.mMeshes[i];
    if ((mesh.mPrimitiveTypes & aiPrimitiveType_POLYGON) == 0) continue;
    crossed += triangulate_mesh(mesh);
    mesh.mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
    mesh.mPrimitiveTypes |= aiPrimitiveType_TRIANGLE;
  }
  if (crossed > 0)
    notes.push_back(fmt::format("{} self-intersecting polygons are triangulated approximately", crossed));
}

}  // namespace sheaf::importer
