// Which properties of a PLY element are mesh attributes, named as Mitsuba names them.
#pragma once

#include "scene/formats/ply_header.h"

#include <string>
#include <vector>

namespace sheaf {

/// An attribute and the properties that it is made of.
struct PlyAttribute {
  std::string name;                     ///< begins with "vertex_" or "face_"
  std::vector<std::size_t> properties;  ///< one per channel: indices into PlyElement::properties; 1 or 3
};

/// The attributes among the properties of `element`, which are called "vertex_..." or "face_..." after it. Properties
/// `r g b` or `red green blue` are the attribute `color`. Neighbours with a common prefix and the endings _x _y _z,
/// _r _g _b, _0 _1 _2 or _1 _2 _3 are one attribute of three channels, one with the first of these endings alone is an
/// attribute of one channel. It has the prefix for its name, followed by "_color" for _r _g _b. Adds a warning for each
/// attribute with another number of channels, or with the name of an earlier one: they are left out, and their
/// properties added to `left_out`.
std::vector<PlyAttribute> find_ply_attributes(const PlyElement& element, std::vector<std::string>& warnings,
                                              std::vector<std::size_t>& left_out);

/// A warning that names the properties with these indices, which are not understood; empty without indices.
std::string unknown_properties_warning(const PlyElement& element, const std::vector<std::size_t>& properties);

/// The value of an attribute's property as the renderer uses it: integers are fractions of the largest of their type,
/// decoded by the sRGB curve; what is not finite is 0.
float ply_attribute_value(PlyType type, double value);

}  // namespace sheaf
