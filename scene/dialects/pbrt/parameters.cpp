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
  enum class Values { kNumbers, kInteger, kBoolean, kStrings, kEither } values;
  std::size_t together;
};
using Values = Type::Values;
constexpr Type kTypes[] = {
    {"integer", Values::kInteger, 1}, {"float", Values::kNumbers, 1},  {"point2", Values::kNumbers, 2},
    {"vector2", Values::kNumbers, 2}, {"point3", Values::kNumbers, 3}, {"vector3", Values::kNumbers, 3},
    {"normal3", Values::kNumbers, 3}, {"point", Values::kNumbers, 3},  {"vector", Values::kNumbers, 3},
    {"normal", Values::kNumbers, 3},  {"rgb", Values::kNumbers, 3},    {"blackbody", Values::kNumbers, 1},
    {"spectrum", Values::kEither, 1}, {"bool", Values::kBoolean, 1},   {"string", Values::kStrings, 1},
    {"texture", Values::kStrings, 1}};

const Type& type_of(std::string_view name, const SourceLocation& where) {
  std::vector<std::string> known;
  for (const Type& type : kTypes) {
    if (name == type.name) return type;
    known.emplace_back(type.name);
  }
  throw SceneError(where, fmt::format("unknown type '{}' of a parameter{}{}", name.substr(0, 40),
                                      did_you_mean(name, known), known_names(known)));
}

void read_value(Tokens& tokens, const Type& type, Parameter& parameter) {
  const Token& token = tokens.current();
  const std::string expected = fmt::format("a value of the {} '{}'", parameter.type, parameter.name);
  if (token.kind == Token::Kind::kString && (type.values == Values::kStrings || type.values == Values::kEither)) {
    parameter.strings.emplace_back(token.text);
  } else if (type.values == Values::kBoolean && (token.text == "true" || token.text == "false")) {
    parameter.numbers.push_back(token.text == "true" ? 1 : 0);
  } else if (type.values == Values::kStrings || type.values == Values::kBoolean) {
    const char* what = type.values == Values::kBoolean ? ", true or false" : ", a string";
    throw SceneError(tokens.where(), fmt::format("found {}, expected {}{}", displayed(token), expected, what));
  } else {
    const double number = number_of(token, tokens.where(), expected);
    if (type.values == Values::kInteger && number != std::floor(number))
      throw SceneError(tokens.where(), fmt::format("found {}, expected {}, an integer", displayed(token), expected));
    if (std::fabs(number) > static_cast<double>(std::numeric_limits<float>::max()))
      throw SceneError(tokens.where(),
                       fmt::format("found {}, a number too large for single precision", displayed(token)));
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
    throw SceneError(
        where, fmt::format("found {}, expected a parameter's type and name, as in \"float radius\"", displayed(token)));
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
        throw SceneError(
            parameter.where,
            fmt::format("the values of '{}' are not closed at the end of the file, expected ']'", parameter.name));
      read_value(tokens, type, parameter);
    }
    tokens.advance();
  }
  if (!parameter.strings.empty() && !parameter.numbers.empty())
    throw SceneError(parameter.where,
                     fmt::format("'{}' has strings and numbers, expected one or the other", parameter.name));
  if (type.values != Values::kStrings && parameter.numbers.size() % type.together != 0)
    throw SceneError(parameter.where, fmt::format("'{}' has {} numbers, expected a multiple of {}", parameter.name,
                                                  parameter.numbers.size(), type.together));
  return parameter;
}

}  // namespace

std::vector<Parameter> read_parameters(Tokens& tokens) {
  std::vector<Parameter> list;
  while (tokens.current().kind == Token::Kind::kString) {
    list.push_back(read_parameter(tokens));
    const auto same = [&](const Parameter& other) { return other.name == list.back().name; };
    if (std::find_if(list.begin(), list.end() - 1, same) != list.end() - 1)
      throw SceneError(list.back().where, fmt::format("parameter '{}' is set twice, expected once", list.back().name));
  }
  return list;
}

Parameters::Parameters(Reader& reader, std::string title, SourceLocation where, std::vector<Parameter> list)
    : reader_(reader), title_(std::move(title)), where_(std::move(where)), list_(std::move(list)) {}

Parameter* Parameters::find_value(const char* name) {
  const auto found =
      std::find_if(list_.begin(), list_.end(), [&](const Parameter& p) { return p.name == name && !p.dropped; });
  return found != list_.end() ? &*found : nullptr;
}

const Parameter& Parameters::expect(const NamedValue& value, std::initializer_list<const char*> types,
                                    std::size_t count) const {
  const auto& parameter = static_cast<const Parameter&>(value);
  if (std::find(types.begin(), types.end(), parameter.type) == types.end())
    fail_value(value,
               fmt::format("is of the type {}, expected {}", parameter.type, one_of({types.begin(), types.end()})),
               SceneErrorCode::kWrongType);
  const std::size_t found = parameter.numbers.size() + parameter.strings.size();
  if (found != count)
    fail_value(value, fmt::format("has {} values, expected {}", found, count), SceneErrorCode::kWrongType);
  return parameter;
}

NamedValues::Number Parameters::read_number(const NamedValue& value) const {
  const double number = expect(value, {"float", "integer"}, 1).numbers[0];
  return {number, number_text(number)};
}

NamedValues::Number Parameters::read_integer(const NamedValue& value) const {
  const double number = expect(value, {"integer", "float"}, 1).numbers[0];
  if (number != std::floor(number)) fail_value(value, fmt::format("is {}, expected an integer", number_text(number)));
  return {number, number_text(number)};
}

bool Parameters::read_boolean(const NamedValue& value) const { return expect(value, {"bool"}, 1).numbers[0] != 0; }

std::string Parameters::read_string(const NamedValue& value) const { return expect(value, {"string"}, 1).strings[0]; }

Vec3d Parameters::read_vec3(const NamedValue& value) const {
  const auto& n = expect(value, {"point3", "vector3", "normal3", "point", "vector", "normal"}, 3).numbers;
  return {n[0], n[1], n[2]};
}

std::vector<float> Parameters::numbers(const char* name, std::size_t stride) {
  const Parameter* parameter = find(name);
  if (parameter == nullptr) return {};
  if (!parameter->strings.empty() || parameter->numbers.size() % stride != 0)
    fail_at(name, fmt::format("has {} numbers, expected a multiple of {}", parameter->numbers.size(), stride));
  return {parameter->numbers.begin(), parameter->numbers.end()};
}

std::filesystem::path Parameters::find_file(const std::string& file, const NamedValue& value) const {
  return reader_.find_file(file, static_cast<const Parameter&>(value).where);
}

void Parameters::reject_unused() {
  for (Parameter& parameter : list_)
    if (!parameter.used && !parameter.optional) reject(parameter);
}

const SourceLocation& Parameters::position_of(const NamedValue* value) const {
  return value != nullptr ? static_cast<const Parameter&>(*value).where : where_;
}

ErrorSink& Parameters::errors() const { return reader_.errors; }

void Parameters::unsupported(const std::string& what, const std::string& instead) const {
  reader_.unsupported(where_, fmt::format("{}: {}", title_, what), instead);
}

}  // namespace sheaf::pbrt
