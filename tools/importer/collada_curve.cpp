// COLLADA 1.4.1, chapter 4: "Curve interpolation", and the elements <sampler> and <channel>.
#include "tools/importer/collada_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace sheaf::importer {

namespace {

double bezier(const std::array<double, 4>& p, double s) {
  const double r = 1 - s;
  return r * r * r * p[0] + 3 * r * r * s * p[1] + 3 * r * s * s * p[2] + s * s * s * p[3];
}

/// The parameter at which an increasing curve has the value x.
double solve(const std::array<double, 4>& p, double x) {
  double low = 0, high = 1;
  constexpr int kSteps = 48;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = (low + high) / 2;
    (bezier(p, middle) < x ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

std::optional<ColladaCurve> ColladaCurve::read(const ColladaDocument& document, const pugi::xml_node& sampler) {
  ColladaSource input, output, methods;
  ColladaCurve out;
  for (const pugi::xml_node& element : sampler.children("input")) {
    const std::string_view semantic = element.attribute("semantic").value();
    const pugi::xml_node source = document.target(element.attribute("source"));
    if (semantic == "INPUT") input = read_source(document, source);
    if (semantic == "OUTPUT") output = read_source(document, source);
    if (semantic == "INTERPOLATION") methods = read_source(document, source);
    if (semantic == "IN_TANGENT") out.in_ = read_source(document, source);
    if (semantic == "OUT_TANGENT") out.out_ = read_source(document, source);
  }
  const std::size_t keys = std::min(input.count, output.count);
  if (keys == 0) return std::nullopt;
  out.size_ = output.stride;
  for (std::size_t i = 0; i < keys; ++i) {
    out.times_.push_back(input.number(i, 0));
    for (std::size_t k = 0; k < out.size_; ++k) out.values_.push_back(output.number(i, k));
    const std::string_view name = i < methods.count ? std::string_view(methods.names[i]) : "LINEAR";
    Method method = name == "STEP" ? Method::kStep : Method::kLinear;
    const bool has_tangents = i < out.out_.count && i + 1 < out.in_.count && out.out_.stride == out.in_.stride;
    if (name == "BEZIER" && has_tangents) method = Method::kBezier;
    if (name == "HERMITE" && has_tangents) method = Method::kHermite;
    out.methods_.push_back(method);
    out.is_curved_ = out.is_curved_ || method == Method::kBezier || method == Method::kHermite;
  }
  const auto is_finite = [](const std::vector<double>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
  };
  if (!std::is_sorted(out.times_.begin(), out.times_.end()) || !is_finite(out.times_) || !is_finite(out.values_) ||
      !is_finite(out.in_.numbers) || !is_finite(out.out_.numbers))
    return std::nullopt;
  return out;
}

double ColladaCurve::at(double time, bool from_before, std::size_t k) const {
  const auto after = from_before ? std::lower_bound(times_.begin(), times_.end(), time)
                                 : std::upper_bound(times_.begin(), times_.end(), time);
  if (after == times_.begin()) return value(0, k);
  const auto end = static_cast<std::size_t>(after - times_.begin());
  if (end == times_.size()) return value(end - 1, k);
  const std::size_t segment = end - 1;
  if (methods_[segment] == Method::kStep) return value(segment, k);
  if (methods_[segment] != Method::kLinear) return curved(segment, time, k);
  const double t = (time - times_[segment]) / (times_[end] - times_[segment]);
  return value(segment, k) + t * (value(end, k) - value(segment, k));
}

double ColladaCurve::curved(std::size_t segment, double time, std::size_t k) const {
  // Tangents hold a value per component, or a time and a value per component, or one time and all values.
  const std::size_t stride = out_.stride;
  const bool has_times = stride > size_, has_pairs = stride >= 2 * size_;
  const std::size_t value_at = !has_times ? k : has_pairs ? 2 * k + 1 : k + 1, time_at = has_pairs ? 2 * k : 0;
  const double begin = times_[segment], end = times_[segment + 1];
  const double first = value(segment, k), last = value(segment + 1, k);
  double first_control = out_.number(segment, value_at), last_control = in_.number(segment + 1, value_at);
  double first_time = out_.number(segment, time_at), last_time = in_.number(segment + 1, time_at);
  if (methods_[segment] == Method::kHermite) {
    first_control = first + first_control / 3;
    last_control = last - last_control / 3;
    first_time = begin + first_time / 3;
    last_time = end - last_time / 3;
  }
  double s = (time - begin) / (end - begin);
  if (has_times) s = solve({begin, std::clamp(first_time, begin, end), std::clamp(last_time, begin, end), end}, time);
  return bezier({first, first_control, last_control, last}, s);
}

}  // namespace sheaf::importer
