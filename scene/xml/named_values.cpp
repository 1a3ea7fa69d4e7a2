// Checks of named values, and messages about them.
#include "scene/xml/named_values.h"

#include "scene/xml/xml.h"

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
  return "a number " + std::string(range.open ? "between " : "from ") + number_text(range.low) +
         (range.open ? " and " : " to ") + number_text(range.high);
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
  return look(name) != nullptr;
}

const NamedValue* NamedValues::use(const char* name) {
  queried_.emplace_back(name);
  NamedValue* value = look(name);
  if (value != nullptr) value->used = true;
  return value;
}

void NamedValues::check_range(const char* name, const Number& number, NumberRange range) {
  if (!is_inside(number.value, range)) fail_at(name, "is " + number.text + ", expected " + range_text(range));
}

std::optional<float> NamedValues::find_number(const char* name, NumberRange range) {
  note_query(name, "float");
  const NamedValue* value = use(name);
  if (value == nullptr) return std::nullopt;
  const Number number = read_number(*value);
  check_range(name, number, range);
  return static_cast<float>(number.value);
}

float NamedValues::number(const char* name, float default_value, NumberRange range) {
  note_query(name, "float", default_value);
  return find_number(name, range).value_or(default_value);
}

int NamedValues::integer(const char* name, int default_value, int low, int high) {
  note_query(name, "integer", default_value);
  const NamedValue* value = use(name);
  if (value == nullptr) return default_value;
  const Number number = read_integer(*value);
  if (number.value < low || number.value > high)
    fail_at(name,
            "is " + number.text + ", expected an integer from " + std::to_string(low) + " to " + std::to_string(high));
  return static_cast<int>(number.value);
}

bool NamedValues::boolean(const char* name, bool default_value) {
  note_query(name, "boolean", default_value);
  const NamedValue* value = use(name);
  return value != nullptr ? read_boolean(*value) : default_value;
}

std::optional<std::string> NamedValues::find_string(const char* name) {
  note_query(name, "string");
  const NamedValue* value = use(name);
  return value != nullptr ? std::optional<std::string>(read_string(*value)) : std::nullopt;
}

std::string NamedValues::string(const char* name, const std::string& default_value) {
  note_query(name, "string", default_value);
  return find_string(name).value_or(default_value);
}

std::string NamedValues::required_string(const char* name) {
  note_query(name, "string", std::string("required"));
  if (std::optional<std::string> text = find_string(name)) return *std::move(text);
  fail("needs the string '" + std::string(name) + "'");
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
  const NamedValue* value = use(name);
  return value != nullptr ? std::optional<Vec3d>(read_vec3(*value)) : std::nullopt;
}

Vec3d NamedValues::point(const char* name, Vec3d default_value) {
  note_query(name, "vector", default_value.rounded());
  return find_point(name).value_or(default_value);
}

std::filesystem::path NamedValues::file(const char* name) {
  note_query(name, "file", std::string("required"));
  const NamedValue* value = use(name);
  if (value == nullptr) fail("needs the string '" + std::string(name) + "', a file");
  return find_file(read_string(*value), *value);
}

void NamedValues::ignore(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    note_query(name, "ignored");
    use(name);
  }
}

void NamedValues::reject(const NamedValue& value) const {
  std::vector<std::string> keys;
  for (const std::string& name : queried_) keys.push_back(key_of(name));
  std::string message = "unknown " + subject(value);
  const std::string nearest = nearest_name(key_of(value.name), keys);
  const auto at = std::find(keys.begin(), keys.end(), nearest) - keys.begin();
  if (!nearest.empty()) message += ", did you mean '" + queried_[static_cast<std::size_t>(at)] + "'?";
  leave_out(value, message);
}

std::string NamedValues::subject(const NamedValue& value) const {
  return std::string(value_kind()) + " " + in_quotes(value.name) + " of " + title();
}

void NamedValues::fail_value(const NamedValue& value, const std::string& message) const {
  raise(&value, subject(value) + " " + message);
}

void NamedValues::fail(const std::string& message) const { raise(nullptr, title() + " " + message); }

void NamedValues::fail_at(const char* name, const std::string& message) {
  const NamedValue* value = look(name);
  if (value == nullptr) fail(std::string(value_kind()) + " '" + name + "' " + message);
  fail_value(*value, message);
}

void NamedValues::fail_choice(const char* name, std::string_view text, const std::vector<std::string>& known) {
  fail_at(name, "is " + in_quotes(text) + ", expected " + one_of(known) + did_you_mean(text, known));
}

}  // namespace sheaf
