// Composite materials shared by the Nori and Mitsuba dialects: two-sided, masks, blends, bump and normal maps.
#include "scene/dialects/common/add_material.h"
#include "scene/dialects/common/read_bsdf.h"
#include "scene/dialects/common/read_texture.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace sheaf {

namespace {

constexpr std::size_t kMaxMixture = 256;
/// Tolerance for rounded weights that should sum to 1.
constexpr float kMaxWeight = 1.0001f;

const MaterialDescription& material_at(MaterialId id, const Properties& p) {
  return p.context().description.materials[static_cast<std::size_t>(id)];
}

/// Returns the material of one side of a two-sided material: the nested material, or its front if that is two-sided.
MaterialId front_of(MaterialId id, const Properties& p) {
  const MaterialDescription& child = material_at(id, p);
  if (transmits(p.context().description.materials, id))
    p.fail("has a nested material that transmits light (line " + std::to_string(child.where.line) + ")");
  if (const auto* both = std::get_if<TwoSidedDescription>(&child.model)) return both->front;
  return id;
}

/// Throws SceneError unless the object holds from `low` to `high` nested materials.
std::vector<const XmlElement*> children(Properties& p, std::size_t low, std::size_t high, const char* expected) {
  const std::vector<const XmlElement*> found = p.objects("bsdf");
  if (found.size() < low || found.size() > high)
    p.fail("has " + std::to_string(found.size()) + " nested <bsdf>, expected " + expected);
  return found;
}

MaterialId only_child(Properties& p, const BsdfDialect& dialect) {
  return dialect.nested(*children(p, 1, 1, "one")[0]);
}

const XmlElement& only_texture(Properties& p) {
  const XmlElement* texture = p.any_texture_or_color();
  if (texture == nullptr) p.fail("has no <texture>, expected one");
  return *texture;
}

TextureId read_map(const XmlElement& texture, ReadContext& context) {
  return texture_showing(context.readers.texture(texture, context), texture.where, context);
}

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

/// Reads the displacement of a bump map. In Mitsuba before version 2, an enclosing texture of type `scale` holds its
/// factor.
BumpMapDescription read_displacement(const XmlElement& texture, ReadContext& context) {
  const std::string* type = texture.find_attribute("type");
  if (type == nullptr || *type != "scale") return {read_map(texture, context), 1, {}};
  Properties p(texture, context);
  const float scale = p.number("scale", 1);
  BumpMapDescription result = read_displacement(only_texture(p), context);
  p.reject_unused();
  result.scale *= scale;
  return result;
}

}  // namespace

TwoSidedDescription read_two_sided(Properties& p, const BsdfDialect& dialect) {
  const std::vector<const XmlElement*> sides = children(p, 1, 2, "one or two");
  const MaterialId front = front_of(dialect.nested(*sides[0]), p);
  return {front, sides.size() == 2 ? front_of(dialect.nested(*sides[1]), p) : front};
}

MaskDescription read_mask(Properties& p, const BsdfDialect& dialect) {
  return {p.scalar_input("opacity", 0.5f, kUnitInterval), only_child(p, dialect)};
}

BlendDescription read_blend(Properties& p, const BsdfDialect& dialect) {
  const std::vector<const XmlElement*> both = children(p, 2, 2, "two");
  const ScalarInput weight = p.scalar_input("weight", 0.5f, kUnitInterval);
  const MaterialId first = dialect.nested(*both[0]);
  return {weight, {first, dialect.nested(*both[1])}};
}

BlendDescription read_mixture(Properties& p, const BsdfDialect& dialect) {
  const std::vector<const XmlElement*> nested = children(p, 1, kMaxMixture, "1 to 256");
  const std::vector<float> weights = read_numbers(p, "weights");
  if (weights.size() != nested.size())
    p.fail_at("weights", "has " + std::to_string(weights.size()) +
                             " numbers, expected as many as there are nested <bsdf>, " + std::to_string(nested.size()));
  std::vector<WeightedMaterial> parts;
  float sum = 0;
  for (std::size_t i = 0; i < nested.size(); ++i) {
    if (!(weights[i] >= 0.0f)) p.fail_at("weights", "has a negative number, expected no negative number");
    parts.push_back({dialect.nested(*nested[i]), weights[i]});
    sum += weights[i];
  }
  if (!(sum > 0.0f) || !std::isfinite(sum))
    p.fail_at("weights", "add up to " + std::to_string(sum) + ", expected more than 0");
  const bool conserves = p.boolean("ensure_energy_conservation", true);
  // Normalise the weights, or fill up with black
  if (sum > kMaxWeight) {
    if (!conserves) p.fail_at("weights", "add up to more than 1, expected at most 1");
    p.context().note(p.where(), "weights add up to " + std::to_string(sum) + ", normalized to 1");
  }
  if (sum < 2.0f - kMaxWeight || parts.size() == 1) {
    MaterialDescription black;
    black.model = DiffuseDescription{SpectrumDescription::constant(0)};
    black.where = p.where();
    parts.push_back({add_material(p.context(), std::move(black)), std::max(1.0f - sum, 0.0f)});
  }
  return halves(p, parts);
}

BumpMapDescription read_bump_map(Properties& p, const BsdfDialect& dialect) {
  const float scale = p.number("scale", 1);
  const MaterialId nested = only_child(p, dialect);
  BumpMapDescription result = read_displacement(only_texture(p), p.context());
  result.scale *= scale;
  result.nested = nested;
  return result;
}

NormalMapDescription read_normal_map(Properties& p, const BsdfDialect& dialect) {
  const bool flip_green = p.boolean("flip_green", false);
  const MaterialId nested = only_child(p, dialect);
  return {read_map(only_texture(p), p.context()), flip_green, nested};
}

}  // namespace sheaf
