#include "scene/dialects/gltf/animation_keys.h"

#include "core/io/error.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace sheaf::gltf {

namespace {

using Values = std::vector<double>;

/// Position of a time between two keys.
struct KeyPair {
  std::size_t first = 0, second = 0;
  double t = 0;         ///< from 0 at the first to 1 at the second
  double duration = 0;  ///< seconds in between
};

KeyPair find_keys(const std::vector<float>& times, double time) {
  const auto after = std::upper_bound(times.begin(), times.end(), static_cast<float>(time));
  if (after == times.begin()) return {};
  const auto second = static_cast<std::size_t>(after - times.begin());
  if (second == times.size()) return {second - 1, second - 1, 0, 0};
  const double begin = times[second - 1], end = times[second];
  return {second - 1, second, std::clamp((time - begin) / (end - begin), 0.0, 1.0), end - begin};
}

double dot(const Values& a, const Values& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Interpolation of unit quaternions at constant angular speed, along the shorter arc.
Values slerp(const Values& a, Values b, double t) {
  double cosine = dot(a, b);
  if (cosine < 0) {
    for (double& x : b) x = -x;
    cosine = -cosine;
  }
  constexpr double kNearlyEqual = 0.9995;
  double weight_a = 1 - t, weight_b = t;
  if (cosine < kNearlyEqual) {
    const double angle = std::acos(std::min(cosine, 1.0));
    weight_a = std::sin((1 - t) * angle) / std::sin(angle);
    weight_b = std::sin(t * angle) / std::sin(angle);
  }
  Values out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = weight_a * a[i] + weight_b * b[i];
  return out;
}

}  // namespace

Values AnimationKeys::part(std::size_t key, Part part) const {
  const bool is_cubic = interpolation == GltfAnimation::Channel::Interpolation::kCubic;
  const std::size_t first = (is_cubic ? 3 * key + part : key) * size;
  return {values.begin() + static_cast<std::ptrdiff_t>(first),
          values.begin() + static_cast<std::ptrdiff_t>(first + size)};
}

Values AnimationKeys::at(double time) const {
  const KeyPair pair = find_keys(times, time);
  Values first = part(pair.first, kValue);
  const Values second = part(pair.second, kValue);
  if (interpolation == GltfAnimation::Channel::Interpolation::kStep || pair.first == pair.second) return first;
  if (interpolation == GltfAnimation::Channel::Interpolation::kLinear) {
    if (is_rotation) return slerp(first, second, pair.t);
    Values out(first.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = first[i] + pair.t * (second[i] - first[i]);
    return out;
  }
  // Cubic Hermite spline (glTF 2.0, appendix C)
  const Values leaving = part(pair.first, kOut), arriving = part(pair.second, kIn);
  const double t = pair.t, t2 = t * t, t3 = t2 * t;
  Values out(first.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = (2 * t3 - 3 * t2 + 1) * first[i] + pair.duration * (t3 - 2 * t2 + t) * leaving[i] +
             (3 * t2 - 2 * t3) * second[i] + pair.duration * (t3 - t2) * arriving[i];
  return out;
}

AnimationKeys load_keys(const GltfFile& file, const GltfAnimation::Channel& channel, const std::string& part) {
  AnimationKeys keys;
  keys.interpolation = channel.interpolation;
  keys.is_rotation = channel.path == GltfAnimation::Channel::Path::kRotation;
  keys.times = read_floats(file, channel.times, 1);
  constexpr int kComponents[] = {3, 4, 3, 1};
  const int components = kComponents[static_cast<int>(channel.path)];
  keys.values = read_floats(file, channel.values, components);
  const bool is_cubic = channel.interpolation == GltfAnimation::Channel::Interpolation::kCubic;
  const std::size_t parts = keys.times.size() * (is_cubic ? 3 : 1);
  if (parts == 0 || keys.values.size() % parts != 0 || keys.values.empty())
    throw file.error(
        part, fmt::format("its keys do not match: {} times and {} numbers", keys.times.size(), keys.values.size()));
  keys.size = keys.values.size() / parts;
  if (channel.path != GltfAnimation::Channel::Path::kWeights && keys.size != static_cast<std::size_t>(components))
    throw file.error(part, fmt::format("has {} numbers per key, expected {}", keys.size, components));
  const auto bad = [](float x) { return !std::isfinite(x); };
  if (!std::is_sorted(keys.times.begin(), keys.times.end()) || std::any_of(keys.times.begin(), keys.times.end(), bad) ||
      std::any_of(keys.values.begin(), keys.values.end(), bad))
    throw file.error(part, "its times do not increase, or its values are not finite");
  return keys;
}

const GltfAnimation* find_animation(const GltfFile& file, const AnimationTime& moment) {
  if (!moment.time) return nullptr;
  if (file.animations.empty()) {
    if (moment.animation.empty()) return nullptr;
    throw SceneError({file.file.string(), 0}, "has no animation");
  }
  if (moment.animation.empty()) return &file.animations.front();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < file.animations.size(); ++i) {
    const GltfAnimation& animation = file.animations[i];
    if (animation.name == moment.animation || std::to_string(i) == moment.animation) return &animation;
    names.push_back(animation.name);
  }
  throw SceneError({file.file.string(), 0}, fmt::format("has no animation {}{}", in_quotes(moment.animation),
                                                        did_you_mean(moment.animation, names)));
}

std::optional<std::array<double, 2>> time_range(const GltfFile& file, const GltfAnimation& animation) {
  std::optional<std::array<double, 2>> range;
  std::set<int> read;  // channels share their times
  for (const GltfAnimation::Channel& channel : animation.channels) {
    if (!read.insert(channel.times).second) continue;
    try {
      for (const float each : read_floats(file, channel.times, 1)) {
        const double time{each};
        range = range ? std::array{std::min((*range)[0], time), std::max((*range)[1], time)} : std::array{time, time};
      }
    } catch (const SceneError&) { return std::nullopt; }
  }
  return range;
}

std::string channel_name(const GltfAnimation& animation, std::size_t channel) {
  return fmt::format("animation {}, channel {}", in_quotes(animation.name), channel);
}

}  // namespace sheaf::gltf
