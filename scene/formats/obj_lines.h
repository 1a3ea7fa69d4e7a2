// The grammar of the relevant lines of an OBJ file.
#pragma once

#include "core/math/vec.h"
#include "scene/formats/obj_text.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace sheaf {

/// Corner of a face, by indices into the lists of the file. In the file, they count from 1, or negative from the end.
struct ObjCorner {
  int position, uv, normal;
  bool operator==(const ObjCorner&) const = default;
};

/// The content of a line.
struct ObjLine {
  enum class Kind { kIrrelevant, kPosition, kNormal, kUv, kFace, kMaterial, kLibrary, kSmoothing };
  Kind kind = Kind::kIrrelevant;
  Vec3f numbers{};                 ///< of a position, normal or texture coordinate; missing ones are 0
  bool is_non_finite = false;      ///< `numbers` is not valid: a NaN or an infinity is among them
  std::vector<ObjCorner> corners;  ///< of a face: indices as in the file, 0 if absent
  std::string_view name;           ///< after 'usemtl', without quotation marks, or after 'mtllib'
  std::uint32_t group = 0;         ///< after 's': 0 for 'off'
};

/// Parses a line of the text, without its end. Numbers are correctly rounded. Throws SceneError for malformed numbers
/// and indices.
void parse_obj_line(const ObjText& text, std::string_view line, ObjLine& parsed);

}  // namespace sheaf
