// Parsing of pbrt parameters and typed access to them.
#include "scene/dialects/pbrt/parameters.h"

#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

/// Value type of a parameter and its number of components.
struct Type {
  const char* name;
  enum class Values { kNumbers, kWholeNumbers, kTruth, kStrings, kEither } values;
  std::size_t together;
};
using Values = Type::Values;
constexpr Type kTypes[] = {
    {"integer", Values::kWholeNumbers, 1}, {"float", Values::kNumbers, 1},  {"point2", Values::kNumbers, 2},
    {"vector2", Values::kNumbers, 2},      {"point3", Values::kNumbers, 3}, {"vector3", Values::kNumbers, 3},
    {"normal3", Values::kNumbers, 3},      {"point", Values::kNumbers, 3},  {"vector", Values::kNumbers, 3},
    {"normal", Values::kNumbers, 3},       {"rgb", Values::kNumbers, 3},    {"blackbody", Values::kNumbers, 1},
    {"spectrum", Values::kEither, 1},      {"bool", Values::kTruth, 1},     {"string", Values::kStrings, 1},
    {"texture", Values::kStrings, 1}};

const Type& type_of(std::string_view name, const SourceLocation& where) {
  std::vector<std::string> known;
  for (const Type& type : kTypes) {
    if (name == type.name) return type;
    known.emplace_back(type.name);
  }
  std::string list;
  for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
  throw SceneError(where, "unknown type '" + std::string(name.substr(0, 40)) + "' of a parameter" +
                              did_you_mean(name, known) + " (known: " + list + ")");
}

void read_value(Tokens& tokens, const Type& type, Parameter& parameter) {
  const Token& token = tokens.current();
  const std::string expected = "a value of the " + parameter.type + " '" + parameter.name + "'";
  if (token.kind == Token::Kind::kString && (type.values == Values::kStrings || type.values == Values::kEither)) {
    parameter.strings.emplace_back(token.text);
  } else if (type.values == Values::kTruth && (token.text == "true" || token.text == "false")) {
    parameter.numbers.push_back(token.text == "true" ? 1 : 0);
  } else if (type.values == Values::kStrings || type.values == Values::kTruth) {
    const char* what = type.values == Values::kTruth ? ", true or false" : ", a string";
    throw SceneError(tokens.where(), "found " + shown(token) + ", expected " + expected + what);
  } else {
    const double number = number_of(token, tokens.where(), expected);
    if (type.values == Values::kWholeNumbers && number != std::floor(number))
      throw SceneError(tokens.where(), "found " + shown(token) + ", expected " + expected + ", a whole number");
    if (std::fabs(number) > static_cast<double>(std::numeric_limits<float>::max()))
      throw SceneError(tokens.where(), "found " + shown(token) + ", a number too large for single precision");
    parameter.numbers.push_back(number);
  }
  tokens.advance();
}

/// Splits "type name".
Parameter declaration(const Token& token, const SourceLocation& where) {
  constexpr const char* kSpace = " \t";
  const std::string_view text = token.text;
  const std::size_t begin = text.find_first_not_of(kSpace);
  const std::size_t gap = text.find_first_of(kSpace, begin);
  const std::size_t name = text.find_first_not_of(kSpace, gap);
  if (begin == text.npos || gap == text.npos || name == text.npos)
    throw SceneError(where, "found " + shown(token) + ", expected a parameter's type and name, as in \"float radius\"");
  const std::size_t end = text.find_last_not_of(kSpace) + 1;
  Parameter parameter;
  parameter.type = text.substr(begin, gap - begin);
  parameter.name = text.substr(name, end - name);
  parameter.where = where;
  return parameter;
}

Parameter read_parameter(Tokens& tokens) {
  Parameter parameter = declaration(tokens.current(), tokens.where());
  const Type& type = type_of(parameter.type, parameter.where);
  tokens.advance();
  if (tokens.current().kind != Token::Kind::kOpen) {
    read_value(tokens, type, parameter);
  } else {
    for (tokens.advance(); tokens.current().kind != Token::Kind::kClose;) {
      if (tokens.current().kind == Token::Kind::kEnd)
        throw SceneError(parameter.where, "the values of '" + parameter.name +
                                              "' do not end before the file does, expected a closing ']'");
      read_value(tokens, type, parameter);
    }
    tokens.advance();
  }
  if (!parameter.strings.empty() && !parameter.numbers.empty())
    throw SceneError(parameter.where, "'" + parameter.name + "' has strings and numbers, expected one or the other");
  if (type.values != Values::kStrings && parameter.numbers.size() % type.together != 0)
    throw SceneError(parameter.where, "'" + parameter.name + "' has " + std::to_string(parameter.numbers.size()) +
                                          " numbers, expected a multiple of " + std::to_string(type.together));
  return parameter;
}

}  // namespace

std::vector<Parameter> read_parameters(Tokens& tokens) {
  std::vector<Parameter> list;
  while (tokens.current().kind == Token::Kind::kString) {
    list.push_back(read_parameter(tokens));
    const auto same = [&](const Parameter& other) { return other.name == list.back().name; };
    if (std::find_if(list.begin(), list.end() - 1, same) != list.end() - 1)
      throw SceneError(list.back().where, "the parameter '" + list.back().name + "' is given twice");
  }
  return list;
}

Parameters::Parameters(Reader& reader, std::string title, SourceLocation where, std::vector<Parameter> list)
    : reader_(reader), title_(std::move(title)), where_(std::move(where)), list_(std::move(list)) {}

const Parameter* Parameters::look(const char* name) const {
  const auto found = std::find_if(list_.begin(), list_.end(), [&](const Parameter& p) { return p.name == name; });
  return found != list_.end() ? &*found : nullptr;
}

const Parameter* Parameters::find(const char* name) {
  asked_.emplace_back(name);
  for (Parameter& parameter : list_)
    if (parameter.name == name) parameter.used = true;
  return look(name);
}

bool Parameters::has(const char* name) {
  asked_.emplace_back(name);
  return look(name) != nullptr;
}

const Parameter& Parameters::expect(const char* name, std::initializer_list<const char*> types, std::size_t values) {
  const Parameter& parameter = *find(name);
  std::string list;
  bool fits = false;
  for (const char* type : types) {
    fits = fits || parameter.type == type;
    list += (list.empty() ? "" : " or ") + std::string(type);
  }
  if (!fits) fail_at(name, "is of the type " + parameter.type + ", expected " + list);
  const std::size_t count = parameter.numbers.size() + parameter.strings.size();
  if (values != 0 && count != values)
    fail_at(name, "has " + std::to_string(count) + " values, expected " + std::to_string(values));
  return parameter;
}

std::optional<float> Parameters::find_number(const char* name, NumberRange range) {
  if (!has(name)) return std::nullopt;
  const double value = expect(name, {"float", "integer"}, 1).numbers[0];
  if (value < range.low || value > range.high || (range.open && (value == range.low || value == range.high))) {
    const auto shown_end = [](double end) { return std::isinf(end) ? "infinity" : std::to_string(end); };
    fail_at(name, "is " + std::to_string(value) + ", expected a number " + (range.open ? "between " : "from ") +
                      shown_end(range.low) + (range.open ? " and " : " to ") + shown_end(range.high));
  }
  return static_cast<float>(value);
}

float Parameters::number(const char* name, float default_value, NumberRange range) {
  return find_number(name, range).value_or(default_value);
}

int Parameters::integer(const char* name, int default_value, int low, int high) {
  if (!has(name)) return default_value;
  const double value = expect(name, {"integer", "float"}, 1).numbers[0];
  if (value < low || value > high || value != std::floor(value))
    fail_at(name, "is " + std::to_string(value) + ", expected a whole number from " + std::to_string(low) + " to " +
                      std::to_string(high));
  return static_cast<int>(value);
}

bool Parameters::boolean(const char* name, bool default_value) {
  return has(name) ? expect(name, {"bool"}, 1).numbers[0] != 0 : default_value;
}

std::optional<std::string> Parameters::find_string(const char* name) {
  if (!has(name)) return std::nullopt;
  return expect(name, {"string"}, 1).strings[0];
}

std::string Parameters::string(const char* name, const std::string& default_value) {
  return find_string(name).value_or(default_value);
}

Vec3f Parameters::vec3(const char* name, Vec3f default_value) {
  if (!has(name)) return default_value;
  const auto& n = expect(name, {"point3", "vector3", "normal3", "point", "vector", "normal"}, 3).numbers;
  return {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
}

std::vector<float> Parameters::numbers(const char* name, std::size_t stride) {
  const Parameter* parameter = find(name);
  if (parameter == nullptr) return {};
  if (!parameter->strings.empty() || parameter->numbers.size() % stride != 0)
    fail_at(name, "has " + std::to_string(parameter->numbers.size()) + " numbers, expected a multiple of " +
                      std::to_string(stride));
  return {parameter->numbers.begin(), parameter->numbers.end()};
}

std::filesystem::path Parameters::file(const char* name) {
  const std::optional<std::string> text = find_string(name);
  if (!text) fail("needs the string '" + std::string(name) + "', a file");
  return reader_.find_file(*text, look(name)->where);
}

void Parameters::ignore(std::initializer_list<const char*> names) {
  for (const char* name : names) find(name);
}

void Parameters::reject_unused() {
  for (const Parameter& parameter : list_) {
    if (parameter.used || parameter.optional) continue;
    const std::string message =
        title_ + " has the unknown parameter '" + parameter.name + "'" + did_you_mean(parameter.name, asked_);
    if (!reader_.lenient) throw SceneError(parameter.where, message);
    reader_.stand_in(parameter.where, message + " (left out)");
  }
}

void Parameters::fail(const std::string& message) const { throw SceneError(where_, title_ + " " + message); }

void Parameters::fail_at(const char* name, const std::string& message) const {
  const Parameter* parameter = look(name);
  throw SceneError(parameter != nullptr ? parameter->where : where_, title_ + ": '" + name + "' " + message);
}

void Parameters::unsupported(const std::string& what, const std::string& instead) const {
  reader_.unsupported(where_, title_ + ": " + what, instead);
}

}  // namespace sheaf::pbrt
