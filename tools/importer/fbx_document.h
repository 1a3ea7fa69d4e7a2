// The elements of an FBX file, in its binary and its text form (version 7).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf::importer {

/// A value of an element: a text, a number, or both.
struct FbxValue {
  std::string text;
  double number = 0;
  std::int64_t integer = 0;
};

/// An element with its values and the elements below it.
struct FbxElement {
  std::string name;
  std::vector<FbxValue> values;
  std::vector<FbxElement> children;
};

/// Returns the elements at the top of a file that describe objects, their properties and their connections; geometry
/// and animation are omitted. Reading ends without an error where the file is damaged, because Assimp reports that.
std::vector<FbxElement> read_fbx(std::string_view bytes);

}  // namespace sheaf::importer
