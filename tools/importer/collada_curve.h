// Animation curves of COLLADA.
#pragma once

#include "tools/importer/collada_document.h"

#include <optional>

namespace sheaf::importer {

/// The values of a <sampler> over time.
class ColladaCurve {
 public:
  /// Reads a sampler. Nothing if it has no keys, if its times do not increase, or if a number is not finite.
  static std::optional<ColladaCurve> read(const ColladaDocument& document, const pugi::xml_node& sampler);

  const std::vector<double>& times() const { return times_; }
  std::size_t size() const { return size_; }  ///< numbers per value
  bool is_curved() const { return is_curved_; }

  /// Component k at a time; that of the first or last key outside of their range. At the time of a key, the limit from
  /// before or from after it: these differ after a segment of steps.
  double at(double time, bool from_before, std::size_t k) const;

 private:
  enum class Method { kStep, kLinear, kBezier, kHermite };

  double value(std::size_t key, std::size_t k) const { return values_[key * size_ + k]; }
  double curved(std::size_t segment, double time, std::size_t k) const;

  std::vector<double> times_, values_;
  std::vector<Method> methods_;  ///< of the segment after each key
  ColladaSource in_, out_;       ///< tangents of Hermite curves, control points of Bezier curves
  std::size_t size_ = 1;
  bool is_curved_ = false;
};

}  // namespace sheaf::importer
