#include "tools/preview/camera_request.h"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>

namespace sheaf {

namespace {

using Json = nlohmann::json;

/// Largest motion of a request: heights of the image, and steps of dolly().
constexpr double kMaxMotion = 10, kMaxSteps = 10;

/// Reads a number of at most this size. Returns false for anything else.
bool read_number(const Json& json, double limit, double& number) {
  if (!json.is_number()) return false;
  number = json.get<double>();
  return std::abs(number) <= limit;  // false for NaN
}

bool read_pair(const Json& json, double limit, double& x, double& y) {
  return json.is_array() && json.size() == 2 && read_number(json[0], limit, x) && read_number(json[1], limit, y);
}

bool is_inside(ImagePosition p) { return p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1; }

bool read_position(const Json& json, std::optional<ImagePosition>& position) {
  ImagePosition read;
  if (!read_pair(json, 1, read.x, read.y) || !is_inside(read)) return false;
  position = read;
  return true;
}

bool read_member(const std::string& name, const Json& json, CameraRequest& request) {
  if (name == "orbit") return read_pair(json, kMaxMotion, request.orbit[0], request.orbit[1]);
  if (name == "pan") return read_pair(json, kMaxMotion, request.pan[0], request.pan[1]);
  if (name == "dolly") return read_number(json, kMaxSteps, request.dolly);
  if (name == "target") return read_position(json, request.target);
  if (name == "focus") return read_position(json, request.focus);
  request.reset = name == "reset" && json.is_boolean() && json.get<bool>();
  return request.reset;
}

std::optional<double> parse_fraction(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

std::optional<CameraRequest> parse_camera_request(std::string_view body) {
  if (body.size() > kMaxCameraRequest) return std::nullopt;
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object() || json.empty()) return std::nullopt;
  CameraRequest request;
  for (const auto& [name, value] : json.items())
    if (!read_member(name, value, request)) return std::nullopt;
  return request;
}

std::optional<ImagePosition> parse_image_position(std::string_view x, std::string_view y) {
  const std::optional<double> px = parse_fraction(x), py = parse_fraction(y);
  if (!px || !py || !is_inside({*px, *py})) return std::nullopt;
  return ImagePosition{*px, *py};
}

}  // namespace sheaf
