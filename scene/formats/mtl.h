// Material libraries of Wavefront OBJ files, as they are written. What becomes of them: scene/dialects/obj_materials.h.
#pragma once

#include "core/error.h"
#include "core/vec.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// A picture that an MTL file names.
struct MtlTexture {
  std::filesystem::path file;  ///< below the library's folder, unless absolute; '/' between folders
  Vec2f scale{1, 1};           ///< -s
  Vec2f offset{0, 0};          ///< -o; the picture's uv are scale * uv + offset
  bool clamp = false;          ///< -clamp on
  float bump_multiplier = 1;   ///< -bm
  SourceLocation where;
};

/// One material; what the file does not say is absent.
struct MtlMaterial {
  std::string name;
  SourceLocation where;
  std::optional<Vec3f> diffuse, specular, transmission, emission;  ///< Kd, Ks, Tf, Ke: linear Rec.709
  std::optional<float> shininess;                                  ///< Ns, the exponent of Phong's model
  std::optional<float> ior;                                        ///< Ni
  std::optional<float> dissolve;                                   ///< d, or 1 - Tr: 1 is opaque
  std::optional<int> illum;                                        ///< illumination model, 0 to 10
  /// Pr, Pm, Ps, Pc, Pcr, aniso; all from 0 to 1.
  std::optional<float> roughness, metallic, sheen, clearcoat, clearcoat_roughness, anisotropy;
  std::optional<MtlTexture> map_diffuse, map_specular, map_dissolve, map_roughness, map_metallic, map_sheen;
  std::optional<MtlTexture> bump;    ///< map_Bump, bump: heights
  std::optional<MtlTexture> normal;  ///< norm: normals in tangent space
};

struct MtlLibrary {
  std::vector<MtlMaterial> materials;  ///< in file order
  std::vector<std::string> notes;      ///< for the user: what is not understood or not supported, with file and line
};

/// Reads an MTL file. Backslashes in names of files become slashes. Throws SceneError with the line for numbers that
/// are missing, malformed or not finite, and for properties in front of the first 'newmtl'.
MtlLibrary read_mtl(const std::filesystem::path& file);

}  // namespace sheaf
