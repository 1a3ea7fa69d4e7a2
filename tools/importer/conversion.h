// Conversion of a scene of Assimp to glTF. Only this folder includes Assimp.
#pragma once

#include "tools/importer/glb.h"

#include <assimp/scene.h>

#include <string>
#include <unordered_map>
#include <vector>

namespace sheaf::importer {

/// What the parts of the conversion share.
struct Conversion {
  const aiScene& scene;
  std::string format;  ///< file extension in lower case, without dot
  Glb glb = {};
  std::vector<std::string> notes = {};                ///< what could not be converted
  std::unordered_map<std::string, int> node_of = {};  ///< indices of nodes by name
};

/// Converts a scene to a binary glTF file. Names of images remain as they are in the file. The notes are in the
/// document, as asset.extras.notes. Throws ImportError.
std::string to_glb(const aiScene& scene, const std::string& format);

/// Adds all materials, in order, with their textures and embedded images.
void add_materials(Conversion& to);

/// Adds the hierarchy with its meshes, skins, cameras and lights.
void add_nodes(Conversion& to);

/// Adds the animations of nodes.
void add_animations(Conversion& to);

/// Returns the mesh of glTF that holds one mesh of the scene, without its bones.
nlohmann::json mesh_of(Conversion& to, const aiMesh& mesh);

inline std::string text(const aiString& from) { return {from.C_Str(), from.length}; }

}  // namespace sheaf::importer
