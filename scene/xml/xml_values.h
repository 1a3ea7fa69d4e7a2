// Parses values of scene files: numbers, vectors and transforms. Each function throws SceneError with the location and
// the text found.
#pragma once

#include "core/math/animated_transform.h"
#include "scene/xml/xml.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace sheaf {

/// Splits at commas and white space; drops empty parts.
std::vector<std::string_view> split_list(std::string_view text);

/// A finite number in the range of a float, in double precision. Numbers that are too small for a float are 0. `what`
/// names the value in messages ("float 'fov'").
double parse_number(std::string_view text, const SourceLocation& where, std::string_view what);
/// parse_number(), rounded to a float.
float parse_float(std::string_view text, const SourceLocation& where, std::string_view what);
/// An integer, or a float of integral value ("64.0", "1e6") of at most 2^53.
std::int64_t parse_integer(std::string_view text, const SourceLocation& where, std::string_view what);
/// "true" or "false", case-insensitive.
bool parse_boolean(std::string_view text, const SourceLocation& where, std::string_view what);
/// A list of numbers.
std::vector<double> parse_numbers(std::string_view text, const SourceLocation& where, std::string_view what);
/// parse_numbers(), rounded to floats.
std::vector<float> parse_floats(std::string_view text, const SourceLocation& where, std::string_view what);
/// Three numbers, or one number for all three.
Vec3d parse_vec3(std::string_view text, const SourceLocation& where, std::string_view what);

/// The vector that an element gives as value="x, y, z" or as x="..." y="..." z="...", with `missing` for absent ones.
Vec3d parse_vec3_element(const XmlElement& element, double missing);

/// The children of a <transform>, each applied after the previous ones: translate, scale, rotate, lookat, matrix (16 or
/// 9 numbers, row by row).
Transform parse_transform(const XmlElement& element);

/// The keys of an <animation>: its <transform> elements, each with a time. Throws SceneError without keys, if two
/// have the same time, or if some mirror and others do not.
AnimatedTransform parse_animation(const XmlElement& element);

}  // namespace sheaf
