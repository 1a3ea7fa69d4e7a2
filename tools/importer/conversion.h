// Conversion of a scene of Assimp to glTF. Only this folder includes Assimp.
#pragma once

#include "tools/importer/glb.h"
#include "tools/importer/parts.h"

#include <assimp/scene.h>

#include <string>
#include <unordered_map>
#include <vector>

namespace sheaf::importer {

/// State shared by the parts of the conversion.
struct Conversion {
  const aiScene& scene;
  std::string format;  ///< file extension in lower case, without dot
  FileParts parts;
  Glb glb = {};
  std::vector<std::string> notes = {};  ///< what could not be converted
  /// Indices of nodes by name, parents first.
  std::unordered_map<std::string, std::vector<int>> nodes_of = {};
};

/// Converts a scene to a binary glTF file. `parts` has the cameras and lights. Names of images remain as they are in
/// the file. The notes are in the document, as asset.extras.notes. Throws ImportError.
std::string to_glb(const aiScene& scene, const std::string& format, FileParts parts);

/// Adds all materials, in order, with their textures and embedded images.
void add_materials(Conversion& to);

/// Adds the hierarchy with its meshes, skins, cameras and lights.
void add_nodes(Conversion& to);

/// Adds the animations of nodes: those of the parts, or else those of the scene.
void add_animations(Conversion& to);

/// Returns the mesh of glTF that holds one mesh of the scene, without its bones.
nlohmann::json mesh_of(Conversion& to, const aiMesh& mesh);

/// Replaces all polygons by triangles. Adds a note if some intersect themselves.
void triangulate(aiScene& scene, std::vector<std::string>& notes);

/// Splits the vertices of an OFF model, which its faces share, and makes its colors linear. Throws ImportError.
void prepare_off(aiScene& scene);

/// The cameras and lights that Assimp has read, by their nodes.
FileParts assimp_parts(const aiScene& scene);

inline std::string text(const aiString& from) { return {from.C_Str(), from.length}; }

}  // namespace sheaf::importer
