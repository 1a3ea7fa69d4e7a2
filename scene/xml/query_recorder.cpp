// Recording of queries, and texts of default values.
#include "scene/xml/query_recorder.h"

#include <fmt/format.h>

#include <cassert>
#include <charconv>

namespace sheaf {

QueryRecorder* QueryRecorder::current = nullptr;

QueryRecorder::QueryRecorder() {
  assert(current == nullptr);
  current = this;
}

QueryRecorder::~QueryRecorder() { current = nullptr; }

std::string default_text(bool value) { return value ? "true" : "false"; }

std::string default_text(float value) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  return {text, end};
}

std::string default_text(int value) { return std::to_string(value); }

std::string default_text(Vec2f value) { return fmt::format("({}, {})", default_text(value.x), default_text(value.y)); }

std::string default_text(Vec3f value) {
  return fmt::format("({}, {}, {})", default_text(value.x), default_text(value.y), default_text(value.z));
}

std::string default_text(const std::string& value) { return value; }

std::string default_text(const SpectrumDescription& value) {
  if (const auto* constant = std::get_if<SpectrumDescription::Constant>(&value.value))
    return default_text(constant->value);
  if (const auto* rgb = std::get_if<SpectrumDescription::Rgb>(&value.value)) return default_text(rgb->value);
  return {};
}

std::string default_text(const SpectrumInput& value) {
  const auto* spectrum = std::get_if<SpectrumDescription>(&value);
  return spectrum != nullptr ? default_text(*spectrum) : std::string();
}

std::string default_text(const ScalarInput& value) {
  const auto* number = std::get_if<float>(&value);
  return number != nullptr ? default_text(*number) : std::string();
}

}  // namespace sheaf
