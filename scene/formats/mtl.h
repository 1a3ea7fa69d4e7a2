// Material libraries (MTL) of Wavefront OBJ files, as written in the file. See scene/dialects/model/obj_materials.h
// for their conversion.
//
// tinyobj::LoadMtl() does not suffice: it does not distinguish missing properties from default values, takes the color
// "Kd 0.5" for (0.5, 0, 0), takes options behind an image for its name, reads malformed numbers as 0, and reports
// neither lines nor unknown statements.
#pragma once

#include "core/io/error.h"
#include "core/math/vec.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// A texture image of an MTL file.
struct MtlTexture {
  std::filesystem::path file;  ///< in the library's folder unless absolute; separated by '/'
  Vec2f scale{1, 1};           ///< -s
  Vec2f offset{0, 0};          ///< -o; image uv = scale * uv + offset
  bool clamp = false;          ///< -clamp on
  float bump_multiplier = 1;   ///< -bm
  SourceLocation where;
};

/// One material; properties missing in the file are absent.
struct MtlMaterial {
  std::string name;
  SourceLocation where;
  std::optional<Vec3f> diffuse, specular, transmission, emission;  ///< Kd, Ks, Tf, Ke: linear Rec.709
  std::optional<float> shininess;                                  ///< Ns, the Phong exponent
  std::optional<float> ior;                                        ///< Ni
  std::optional<float> dissolve;                                   ///< d, or 1 - Tr: 1 is opaque
  std::optional<int> illum;                                        ///< illumination model, 0 to 10
  /// Pr, Pm, Ps, Pc, Pcr, aniso; all in [0, 1].
  std::optional<float> roughness, metallic, sheen, clearcoat, clearcoat_roughness, anisotropy;
  std::optional<MtlTexture> map_diffuse, map_specular, map_dissolve, map_roughness, map_metallic, map_sheen;
  std::optional<MtlTexture> bump;    ///< map_Bump, bump: height map
  std::optional<MtlTexture> normal;  ///< norm: tangent-space normal map
};

struct MtlLibrary {
  std::vector<MtlMaterial> materials;  ///< in file order
  std::vector<std::string> notes;      ///< for the user: unknown and unsupported statements, with file and line
};

/// Reads an MTL file. Backslashes in file names become slashes. Throws SceneError with the line for numbers that are
/// missing, malformed or not finite, and for properties before the first 'newmtl'.
MtlLibrary read_mtl(const std::filesystem::path& file);

}  // namespace sheaf
