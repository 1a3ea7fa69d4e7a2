// Blends and mixtures: reading, and their rows.
#include "scene/materials/blend.h"

#include "scene/materials/flattener.h"
#include "scene/materials/reading.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace sheaf {

namespace {

constexpr std::size_t kMaxMixture = 256;
/// Tolerance for rounded weights that should sum to 1.
constexpr float kMaxWeight = 1.0001f;

struct WeightedMaterial {
  MaterialId material;
  float weight;
};

BlendDescription halves(Properties& p, std::span<const WeightedMaterial> parts);

/// Combines materials into a balanced tree of blends, because a chain would nest too deeply.
WeightedMaterial combined(Properties& p, std::span<const WeightedMaterial> parts) {
  float sum = 0;
  for (const WeightedMaterial& part : parts) sum += part.weight;
  if (parts.size() == 1) return parts[0];
  MaterialDescription blend;
  blend.model = halves(p, parts);
  blend.where = p.where();
  return {add_material(p.context(), std::move(blend)), sum};
}

BlendDescription halves(Properties& p, std::span<const WeightedMaterial> parts) {
  const WeightedMaterial first = combined(p, parts.first(parts.size() / 2));
  const WeightedMaterial second = combined(p, parts.subspan(parts.size() / 2));
  const float sum = first.weight + second.weight;
  return {sum > 0 ? second.weight / sum : 0.5f, {first.material, second.material}};
}

}  // namespace

BlendDescription BlendDescription::read(Properties& p, const BsdfDialect& dialect) {
  const std::vector<const XmlElement*> both = nested_bsdfs(p, 2, 2, "two");
  const ScalarInput weight = p.scalar_input("weight", 0.5f, kUnitInterval);
  const MaterialId first = dialect.nested(*both[0]);
  return {weight, {first, dialect.nested(*both[1])}};
}

BlendDescription BlendDescription::read_mixture(Properties& p, const BsdfDialect& dialect) {
  const std::vector<const XmlElement*> nested = nested_bsdfs(p, 1, kMaxMixture, "1 to 256");
  const std::vector<float> weights = read_numbers(p, "weights");
  if (weights.size() != nested.size())
    p.fail_at("weights", fmt::format("has {} numbers, expected as many as there are nested <bsdf>, {}", weights.size(),
                                     nested.size()));
  std::vector<WeightedMaterial> parts;
  float sum = 0;
  for (std::size_t i = 0; i < nested.size(); ++i) {
    if (!(weights[i] >= 0.0f)) p.fail_at("weights", "has a negative number, expected non-negative numbers");
    parts.push_back({dialect.nested(*nested[i]), weights[i]});
    sum += weights[i];
  }
  if (!(sum > 0.0f) || !std::isfinite(sum))
    p.fail_at("weights", fmt::format("add up to {}, expected more than 0", sum));
  const bool conserves = p.boolean("ensure_energy_conservation", true);
  // Normalize the weights, or fill up with black
  if (sum > kMaxWeight) {
    if (!conserves) p.fail_at("weights", "add up to more than 1, expected at most 1");
    p.context().note(p.where(), fmt::format("weights add up to {}, normalized to 1", sum));
  }
  if (sum < 2.0f - kMaxWeight || parts.size() == 1)
    parts.push_back({add_black_material(p), std::max(1.0f - sum, 0.0f)});
  return halves(p, parts);
}

std::uint32_t BlendDescription::flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                                        const SourceLocation&) const {
  MaterialWrappers inside = around;
  inside.part = true;
  const std::uint32_t first = flattener.flatten(nested[0], inside);
  return flattener.push_choice(first, flattener.flatten(nested[1], inside), weight);
}

}  // namespace sheaf
