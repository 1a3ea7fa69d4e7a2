// Parses numbers, vectors and transforms.
#include "scene/xml/xml_values.h"

#include "scene/xml/named_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sheaf {

namespace {

bool is_separator(char c) { return c == ',' || c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_separator(text.front()) && text.front() != ',') text.remove_prefix(1);
  while (!text.empty() && is_separator(text.back()) && text.back() != ',') text.remove_suffix(1);
  return text;
}

/// A number that was read from a text, or what was expected instead.
struct ParsedNumber {
  double value;
  const char* expected = nullptr;  ///< null if the text is a number
};

ParsedNumber read_number(std::string_view text) {
  std::string_view digits = trimmed(text);
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc::result_out_of_range) return {0, "a number in the range of a float"};
  if (error != std::errc() || end != digits.data() + digits.size()) return {0, "a number"};
  if (!std::isfinite(value)) return {0, "a finite number"};
  const float narrow = static_cast<float>(value);
  if (!std::isfinite(narrow)) return {0, "a number in the range of a float"};
  return {narrow == 0 ? 0 : value};
}

[[noreturn]] void fail_value(std::string_view text, const SourceLocation& where, std::string_view what,
                             const char* expected) {
  throw SceneError(where, fmt::format("{} is {}, expected {}", what, in_quotes(text), expected),
                   SceneErrorCode::kWrongType);
}

std::string displayed(const XmlElement& element) { return fmt::format("<{}>", element.name); }

/// Rotation axis in the syntax of either dialect.
Vec3d rotation_axis(const XmlElement& element) {
  if (const std::string* axis = element.find_attribute("axis")) {
    element.expect_attributes({"axis", "angle"});
    return parse_vec3(*axis, element.where, "the axis of <rotate>");
  }
  element.expect_attributes({"x", "y", "z", "value", "angle"});
  XmlElement axis = element;
  std::erase_if(axis.attributes, [](const XmlAttribute& a) { return a.name == "angle"; });
  return parse_vec3_element(axis, 0);
}

/// A default up direction for a lookat without one: the first tangent of Duff et al. 2017, "Building an Orthonormal
/// Basis, Revisited", as in Mitsuba. Perpendicular to `forward`.
Vec3f any_up(Vec3f forward) {
  const Vec3f n = normalize(forward);
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  return {1.0f + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x};
}

Transform parse_lookat(const XmlElement& element) {
  element.expect_attributes({"origin", "target", "up"});
  const Vec3d origin = parse_vec3(element.attribute("origin"), element.where, "the origin of <lookat>");
  const Vec3d target = parse_vec3(element.attribute("target"), element.where, "the target of <lookat>");
  Vec3d up = any_up((target - origin).rounded());
  if (const std::string* given = element.find_attribute("up"))
    up = parse_vec3(*given, element.where, "the up of <lookat>");
  return Transform::look_at(origin, target, up);
}

Transform parse_matrix(const XmlElement& element) {
  element.expect_attributes({"value"});
  const std::vector<double> values = parse_numbers(element.attribute("value"), element.where, "the value of <matrix>");
  if (values.size() != 16 && values.size() != 9)
    throw SceneError(element.where, fmt::format("<matrix> has {} numbers, expected 16 or 9", values.size()));
  const std::size_t size = values.size() == 16 ? 4 : 3;
  Matrix4 matrix;
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t j = 0; j < size; ++j) matrix.m[i][j] = values[i * size + j];
  const auto& last = matrix.m[3];
  if (last[0] != 0 || last[1] != 0 || last[2] != 0 || last[3] != 1)
    throw SceneError(element.where, "the last row of <matrix> is invalid, expected 0 0 0 1");
  return Transform(matrix);
}

Transform parse_step(const XmlElement& element) {
  if (!element.children.empty())
    throw SceneError(element.where, displayed(element) + " has nested elements, expected none");
  if (element.name == "translate") return Transform::translate(parse_vec3_element(element, 0));
  if (element.name == "scale") return Transform::scale(parse_vec3_element(element, 1));
  if (element.name == "rotate") {
    const Vec3d axis = rotation_axis(element);
    return Transform::rotate(axis, parse_number(element.attribute("angle"), element.where, "the angle of <rotate>"));
  }
  if (element.name == "lookat" || element.name == "lookAt") return parse_lookat(element);
  if (element.name == "matrix") return parse_matrix(element);
  throw SceneError(element.where,
                   fmt::format("unknown transform step {}{}", displayed(element),
                               did_you_mean(element.name, {"translate", "scale", "rotate", "lookat", "matrix"})));
}

}  // namespace

std::vector<std::string_view> split_list(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t i = 0; i < text.size();) {
    if (is_separator(text[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && !is_separator(text[end])) ++end;
    parts.push_back(text.substr(i, end - i));
    i = end;
  }
  return parts;
}

double parse_number(std::string_view text, const SourceLocation& where, std::string_view what) {
  const ParsedNumber number = read_number(text);
  if (number.expected != nullptr) fail_value(text, where, what, number.expected);
  return number.value;
}

float parse_float(std::string_view text, const SourceLocation& where, std::string_view what) {
  return static_cast<float>(parse_number(text, where, what));
}

std::int64_t parse_integer(std::string_view text, const SourceLocation& where, std::string_view what) {
  std::string_view digits = trimmed(text);
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  const char* const last = digits.data() + digits.size();
  std::int64_t value = 0;
  const auto integer = std::from_chars(digits.data(), last, value);
  if (integer.ec == std::errc::result_out_of_range) fail_value(text, where, what, "an integer of at most 64 bits");
  if (integer.ec == std::errc() && integer.ptr == last) return value;
  // A float of integral value: "64.0", "1e6".
  constexpr double kMaxExactInteger = 9007199254740992.0;  // 2^53
  double number = 0;
  const auto decimal = std::from_chars(digits.data(), last, number);
  const bool is_number = decimal.ec == std::errc() && decimal.ptr == last;
  if (!is_number || !(std::fabs(number) <= kMaxExactInteger) || number != std::floor(number))
    fail_value(text, where, what, "an integer");
  return static_cast<std::int64_t>(number);
}

bool parse_boolean(std::string_view text, const SourceLocation& where, std::string_view what) {
  std::string lower(trimmed(text).substr(0, 8));
  for (char& c : lower) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  if (lower == "true") return true;
  if (lower == "false") return false;
  fail_value(text, where, what, "true or false");
}

std::vector<double> parse_numbers(std::string_view text, const SourceLocation& where, std::string_view what) {
  std::vector<double> values;
  for (std::string_view part : split_list(text)) values.push_back(parse_number(part, where, what));
  return values;
}

std::vector<float> parse_floats(std::string_view text, const SourceLocation& where, std::string_view what) {
  std::vector<float> values;
  for (std::string_view part : split_list(text)) values.push_back(parse_float(part, where, what));
  return values;
}

Vec3d parse_vec3(std::string_view text, const SourceLocation& where, std::string_view what) {
  const std::vector<double> v = parse_numbers(text, where, what);
  if (v.size() == 1) return {v[0], v[0], v[0]};
  if (v.size() != 3) fail_value(text, where, what, "three numbers");
  return {v[0], v[1], v[2]};
}

Vec3d parse_vec3_element(const XmlElement& element, double missing) {
  if (const std::string* value = element.find_attribute("value")) {
    element.expect_attributes({"name", "value"});
    return parse_vec3(*value, element.where, "the value of " + displayed(element));
  }
  element.expect_attributes({"name", "value", "x", "y", "z"});
  double result[3] = {missing, missing, missing};
  bool any = false;
  const char* const axes[3] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i)
    if (const std::string* text = element.find_attribute(axes[i])) {
      const ParsedNumber number = read_number(*text);
      if (number.expected != nullptr)
        fail_value(*text, element.where, fmt::format("attribute {} of {}", axes[i], displayed(element)),
                   number.expected);
      result[i] = number.value;
      any = true;
    }
  if (!any) throw SceneError(element.where, displayed(element) + " needs value=\"x, y, z\" or x, y and z");
  return {result[0], result[1], result[2]};
}

namespace {

/// Multiplies the steps of a <transform>.
Transform parse_steps(const XmlElement& element) {
  Transform result;
  for (const XmlElement& step : element.children) {
    try {
      result = parse_step(step) * result;
    } catch (const SceneError& error) {
      // Errors of Transform lack the location
      throw error.where().file.empty() ? SceneError(step.where, error) : error;
    }
  }
  return result;
}

/// A <transform> of an <animation>.
struct AnimationKey {
  double time;
  Transform value;
  SourceLocation where;
};

/// Throws SceneError for the first of the sorted keys that does not go with the key before it.
void check_keys(const std::vector<AnimationKey>& keys) {
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].time == keys[i - 1].time)
      throw SceneError(keys[i].where,
                       fmt::format("a second <transform> of the <animation> has the time {}, expected different times",
                                   number_text(keys[i].time)));
    if (keys[i].value.swaps_handedness() != keys[i - 1].value.swaps_handedness())
      throw SceneError(
          keys[i].where,
          fmt::format(
              "<transform> at the time {} is mirrored against the one before, expected both or neither to mirror",
              number_text(keys[i].time)));
  }
}

}  // namespace

Transform parse_transform(const XmlElement& element) {
  if (element.find_attribute("time") != nullptr)
    throw SceneError(element.where, "<transform> has a 'time', expected that inside an <animation> only");
  element.expect_attributes({"name", "id"});
  return parse_steps(element);
}

AnimatedTransform parse_animation(const XmlElement& element) {
  element.expect_attributes({"name", "id"});
  std::vector<AnimationKey> keys;
  for (const XmlElement& child : element.children) {
    if (child.name != "transform")
      throw SceneError(child.where, fmt::format("unexpected {} in <animation>, expected <transform time=\"...\">",
                                                displayed(child)));
    child.expect_attributes({"time", "name", "id"});
    const float time = parse_float(child.attribute("time"), child.where, "the time of <transform>");
    keys.push_back({double{time}, parse_steps(child), child.where});
  }
  if (keys.empty())
    throw SceneError(element.where, "<animation> has no <transform>, expected one or more with a 'time'");
  std::stable_sort(keys.begin(), keys.end(),
                   [](const AnimationKey& a, const AnimationKey& b) { return a.time < b.time; });
  check_keys(keys);
  std::vector<AnimatedTransform::Key> list;
  list.reserve(keys.size());
  for (const AnimationKey& key : keys) list.push_back({key.time, key.value});
  return AnimatedTransform(std::move(list));
}

}  // namespace sheaf
