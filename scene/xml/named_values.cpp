// Checks of named values, and messages about them.
#include "scene/xml/named_values.h"

#include "scene/xml/xml.h"

#include <fmt/format.h>

#include <algorithm>

namespace sheaf {

namespace {

bool is_inside(double number, NumberRange range) {
  return range.open ? number > range.low && number < range.high : number >= range.low && number <= range.high;
}

std::string range_text(NumberRange range) {
  const bool bounded = range.high < std::numeric_limits<double>::infinity();
  if (!bounded && range.low == 0) return range.open ? "a positive number" : "a non-negative number";
  if (!bounded) return "a number of at least " + number_text(range.low);
  return fmt::format("a number {}{}{}{}", range.open ? "between " : "from ", number_text(range.low),
                     range.open ? " and " : " to ", number_text(range.high));
}

}  // namespace

std::string number_text(double number) {
  std::string text = std::to_string(number);
  if (text.find('.') == text.npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

void NamedValues::record(const char* name, const char* type, std::string default_value) const {
  QueryRecorder::active()->queries.push_back({title(), name, type, std::move(default_value)});
}

bool NamedValues::has(const char* name) {
  note_query(name, "");
  queried_.emplace_back(name);
  return find_value(name) != nullptr;
}

NamedValue* NamedValues::use(const char* name) {
  queried_.emplace_back(name);
  NamedValue* value = find_value(name);
  if (value != nullptr) value->used = true;
  return value;
}

void NamedValues::check_range(const NamedValue& value, const Number& number, NumberRange range) const {
  if (!is_inside(number.value, range))
    fail_value(value, fmt::format("is {}, expected {}", number.text, range_text(range)), SceneErrorCode::kOutOfRange);
}

std::optional<float> NamedValues::find_number(const char* name, NumberRange range) {
  note_query(name, "float");
  NamedValue* value = use(name);
  if (value == nullptr) return std::nullopt;
  return attempt(*value, [&] {
    const Number number = read_number(*value);
    check_range(*value, number, range);
    return static_cast<float>(number.value);
  });
}

float NamedValues::number(const char* name, float default_value, NumberRange range) {
  note_query(name, "float", default_value);
  return find_number(name, range).value_or(default_value);
}

int NamedValues::integer(const char* name, int default_value, int low, int high) {
  note_query(name, "integer", default_value);
  NamedValue* value = use(name);
  if (value == nullptr) return default_value;
  const auto read = [&] {
    const Number number = read_integer(*value);
    if (number.value < low || number.value > high)
      fail_value(*value, fmt::format("is {}, expected an integer from {} to {}", number.text, low, high),
                 SceneErrorCode::kOutOfRange);
    return static_cast<int>(number.value);
  };
  return attempt(*value, read).value_or(default_value);
}

bool NamedValues::boolean(const char* name, bool default_value) {
  note_query(name, "boolean", default_value);
  NamedValue* value = use(name);
  return value != nullptr ? attempt(*value, [&] { return read_boolean(*value); }).value_or(default_value)
                          : default_value;
}

std::optional<std::string> NamedValues::find_string(const char* name) {
  note_query(name, "string");
  NamedValue* value = use(name);
  if (value == nullptr) return std::nullopt;
  return attempt(*value, [&] { return read_string(*value); });
}

std::string NamedValues::string(const char* name, const std::string& default_value) {
  note_query(name, "string", default_value);
  return find_string(name).value_or(default_value);
}

std::string NamedValues::required_string(const char* name) {
  note_query(name, "string", std::string("required"));
  if (const NamedValue* value = use(name)) return read_string(*value);
  fail(fmt::format("needs the string '{}'", name), SceneErrorCode::kMissing);
}

std::optional<Vec3f> NamedValues::find_vec3(const char* name) {
  const std::optional<Vec3d> point = find_point(name);
  return point ? std::optional<Vec3f>(point->rounded()) : std::nullopt;
}

Vec3f NamedValues::vec3(const char* name, Vec3f default_value) {
  note_query(name, "vector", default_value);
  return find_vec3(name).value_or(default_value);
}

std::optional<Vec3d> NamedValues::find_point(const char* name) {
  note_query(name, "vector");
  NamedValue* value = use(name);
  if (value == nullptr) return std::nullopt;
  return attempt(*value, [&] { return read_vec3(*value); });
}

Vec3d NamedValues::point(const char* name, Vec3d default_value) {
  note_query(name, "vector", default_value.rounded());
  return find_point(name).value_or(default_value);
}

std::filesystem::path NamedValues::file(const char* name) {
  note_query(name, "file", std::string("required"));
  const NamedValue* value = use(name);
  if (value == nullptr) fail(fmt::format("needs the string '{}', a file", name), SceneErrorCode::kMissing);
  return find_file(read_string(*value), *value);
}

void NamedValues::ignore(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    note_query(name, "ignored");
    use(name);
  }
}

void NamedValues::reject(NamedValue& value) const {
  std::vector<std::string> keys;
  for (const std::string& name : queried_) keys.push_back(key_of(name));
  std::string message = "unknown " + subject(value);
  const std::string nearest = nearest_name(key_of(value.name), keys);
  const auto at = std::find(keys.begin(), keys.end(), nearest) - keys.begin();
  if (!nearest.empty()) message += fmt::format(", did you mean '{}'?", queried_[static_cast<std::size_t>(at)]);
  drop(value, make_error(&value, message, SceneErrorCode::kUnknownName));
}

std::string NamedValues::subject(const NamedValue& value) const {
  return fmt::format("{} {} of {}", value_kind(), in_quotes(value.name), title());
}

SceneError NamedValues::make_error(const NamedValue* value, const std::string& message, SceneErrorCode code) const {
  return SceneError(position_of(value), message, code).about(value != nullptr ? subject(*value) : title());
}

void NamedValues::drop(NamedValue& value, const SceneError& error) const {
  value.used = value.dropped = true;
  errors().report(error.about(subject(value)), "ignored");
}

void NamedValues::fail_value(const NamedValue& value, const std::string& message, SceneErrorCode code) const {
  raise(&value, fmt::format("{} {}", subject(value), message), code);
}

void NamedValues::fail(const std::string& message, SceneErrorCode code) const {
  raise(nullptr, fmt::format("{} {}", title(), message), code);
}

void NamedValues::fail_at(const char* name, const std::string& message, SceneErrorCode code) {
  const NamedValue* value = find_value(name);
  if (value == nullptr) fail(fmt::format("{} '{}' {}", value_kind(), name, message), code);
  fail_value(*value, message, code);
}

void NamedValues::report_at(const char* name, const std::string& message, SceneErrorCode code) {
  NamedValue* value = find_value(name);
  if (value == nullptr) fail_at(name, message, code);
  drop(*value, make_error(value, fmt::format("{} {}", subject(*value), message), code));
}

std::string NamedValues::choice_message(std::string_view text, const std::vector<std::string>& known) {
  return fmt::format("is {}, expected {}{}", in_quotes(text), one_of(known), did_you_mean(text, known));
}

void NamedValues::fail_choice(const char* name, std::string_view text, const std::vector<std::string>& known) {
  fail_at(name, choice_message(text, known), SceneErrorCode::kUnknownName);
}

}  // namespace sheaf
