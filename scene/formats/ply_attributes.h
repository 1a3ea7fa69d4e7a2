// Mesh attributes among the properties of a PLY element, named as in Mitsuba.
#pragma once

#include "scene/formats/ply_header.h"

#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// Vertex properties that become parts of the mesh.
enum PlySlot : std::size_t { kPlyX, kPlyY, kPlyZ, kPlyNormalX, kPlyNormalY, kPlyNormalZ, kPlyU, kPlyV, kPlySlots };

/// The slot of a property of vertices, if it has one.
std::optional<PlySlot> ply_slot(const PlyProperty& property);

/// An attribute and its properties.
struct PlyAttribute {
  std::string name;  ///< starts with "vertex_" or "face_"
  /// One per channel, 1 or 3: indices into PlyElement::properties.
  std::vector<std::size_t> properties;
};

/// Finds the attributes among the properties of `element`. Their names start with "vertex_" or "face_", by the element.
/// Properties `r g b` or `red green blue` become the attribute `color`. Adjacent properties with a common prefix and
/// the suffixes _x _y _z, _r _g _b, _0 _1 _2 or _1 _2 _3 become one attribute of three channels. A property with only
/// the first of these suffixes becomes an attribute of one channel. The name is the prefix, followed by "_color" for
/// _r _g _b. Attributes with another number of channels or a duplicate name are dropped with a warning, and their
/// properties appended to `left_out`.
std::vector<PlyAttribute> find_ply_attributes(const PlyElement& element, std::vector<std::string>& warnings,
                                              std::vector<std::size_t>& left_out);

/// Returns a warning that lists these unknown properties by name; empty without indices.
std::string unknown_properties_warning(const PlyElement& element, const std::vector<std::size_t>& properties);

/// Converts a property value to an attribute value. Integers become fractions of their type's maximum, decoded from
/// sRGB. Values that are not finite become 0.
float ply_attribute_value(PlyType type, double value);

}  // namespace sheaf
