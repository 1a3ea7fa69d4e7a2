// From the pieces of an OBJ file to one mesh.
#pragma once

#include "scene/formats/obj.h"
#include "scene/formats/obj_lines.h"

#include <exception>
#include <string>
#include <vector>

namespace sheaf {

/// The content of a piece of an OBJ file, which was read without knowledge of the pieces before it.
struct ObjPiece {
  /// 32-bit numbers, because a piece has fewer than 2^32 bytes.
  struct Face {
    std::uint32_t end;   ///< end in `corners`
    std::uint32_t line;  ///< position of its line in the piece
  };
  /// A face with negative indices, and the numbers of values of the piece before it.
  struct RelativeFace {
    std::size_t face;
    int positions, uvs, normals;
  };
  /// A line that applies to the faces that follow, or the name of a library.
  struct Statement {
    std::size_t face;  ///< number of faces of the piece before it
    ObjLine::Kind kind;
    std::string name;
    std::uint32_t group;
    int line;  ///< in the piece, from 0
  };

  std::size_t begin = 0;  ///< position in the file
  int line_count = 0;
  std::vector<Vec3f> positions, normals;
  std::vector<Vec2f> uvs;
  /// Of all faces in sequence: positive indices are reduced by 1, absent ones are -1, negative ones -n are -n - 1.
  std::vector<ObjCorner> corners;
  std::vector<Face> faces;
  std::vector<RelativeFace> relative_faces;
  std::vector<Statement> statements;
  std::size_t short_faces = 0;    ///< number of dropped faces with fewer than three corners
  ObjCorner highest{-1, -1, -1};  ///< maximum over `corners`
  std::exception_ptr error;       ///< of the line after those that are here; may be null
};

/// The content of a file.
struct ObjContent {
  /// One of the attribute lists, and the maximum index that faces use.
  template <class T> struct Attributes {
    std::vector<T> values;
    int highest = -1;
    std::string first_bad = {};  ///< error message for the first index out of range

    /// Whether a value with this index exists.
    bool has(int index) const { return index >= 0 && index < static_cast<int>(values.size()); }
  };
  /// Consecutive faces with the same material and smoothing group.
  struct Run {
    std::size_t first_face;
    std::uint32_t material, smoothing_group;
  };

  Attributes<Vec3f> positions, normals;
  Attributes<Vec2f> uvs;
  std::vector<ObjPiece> pieces;  ///< only corners, as indices of the lists, and faces
  std::size_t short_faces = 0;
  std::vector<Run> runs;
  bool has_smoothing_groups = false;
  std::vector<std::string> materials;  ///< as in ObjFile
  std::vector<int> material_lines;
  std::vector<ObjLibrary> libraries;
};

/// Resolves indices, materials and smoothing groups in the order of the file. Throws SceneError for indices out of
/// range, or notes the first one.
ObjContent join_obj_pieces(const ObjSource& source, std::vector<ObjPiece> pieces, BadFaces bad_faces);

/// Merges equal corners into vertices.
ObjFile build_obj_mesh(ObjContent content);

}  // namespace sheaf
