// Phase functions shared by the Nori and Mitsuba dialects, including blends and mixtures.
#include "scene/dialects/xml/read_phase.h"

#include "scene/dialects/xml/read_volume.h"
#include "scene/materials/reading.h"
#include "scene/xml/xml_values.h"

#include <cmath>
#include <numeric>

namespace sheaf {

namespace {

using PhaseModel = decltype(PhaseDescription::model);

constexpr NumberRange kMeanCosine{-1, 1, true};
constexpr std::size_t kMaxPhaseValues = std::size_t{1} << 20;

std::vector<const XmlElement*> nested_phases(Properties& p) {
  std::vector<const XmlElement*> found = p.objects("phase");
  const std::vector<const XmlElement*> others = p.objects("phasefunction");
  found.insert(found.end(), others.begin(), others.end());
  return found;
}

PhaseModel read_blend(Properties& p) {
  BlendPhaseDescription blend;
  if (const auto weight = find_constant_volume(p, "weight", SpectrumRole::kReflectance, {}))
    blend.weight = number_of(p, "weight", *weight);
  const std::vector<const XmlElement*> both = nested_phases(p);
  if (both.size() != 2)
    p.fail(fmt::format("has {} nested <phase>, expected two", both.size()), SceneErrorCode::kMissing);
  for (std::size_t i = 0; i < 2; ++i) blend.nested[i] = read_phase(*both[i], p.context());
  return blend;
}

PhaseModel read_sggx(Properties& p) {
  const XmlElement* matrix = p.named_object("volume", "S");
  if (matrix == nullptr) p.fail("needs the <volume> 'S'", SceneErrorCode::kMissing);
  return SggxDescription{read_matrix_volume(*matrix, p.context(), {.may_move = true})};
}

/// Combines the phase functions [first, last) with their weights into a balanced tree of blends.
PhaseId add_mixture(Properties& p, const std::vector<PhaseId>& nested, const std::vector<float>& weights,
                    std::size_t first, std::size_t last) {
  if (last - first == 1) return nested[first];
  const std::size_t middle = first + (last - first) / 2;
  const auto sum = [&](std::size_t from, std::size_t to) {
    return std::accumulate(weights.begin() + static_cast<std::ptrdiff_t>(from),
                           weights.begin() + static_cast<std::ptrdiff_t>(to), 0.0f);
  };
  BlendPhaseDescription blend;
  const float all = sum(first, last);
  blend.weight = all > 0.0f ? sum(middle, last) / all : 0.5f;
  blend.nested[0] = add_mixture(p, nested, weights, first, middle);
  blend.nested[1] = add_mixture(p, nested, weights, middle, last);
  std::vector<PhaseDescription>& phases = p.context().description.phases;
  phases.push_back({blend, p.where()});
  return static_cast<PhaseId>(phases.size() - 1);
}

/// Reads any number of phase functions with `weights` that sum to 1.
PhaseId read_mixture(Properties& p) {
  const std::vector<float> weights = parse_floats(p.required_string("weights"), p.where(), "weights");
  const std::vector<const XmlElement*> elements = nested_phases(p);
  if (elements.size() != weights.size() || elements.empty())
    p.fail(
        fmt::format("has {} nested <phase> and {} weights, expected equal numbers", elements.size(), weights.size()));
  for (const float weight : weights)
    if (!(weight >= 0.0f)) p.fail_at("weights", fmt::format("has {}, expected a non-negative number", weight));
  const float all = std::accumulate(weights.begin(), weights.end(), 0.0f);
  if (!(all > 0.999f))
    p.fail_at("weights", fmt::format("add up to {}, expected 1; absorption belongs in the albedo", all));
  if (all > 1.001f) p.context().note(p.where(), fmt::format("the weights add up to {}, normalized to 1", all));
  std::vector<PhaseId> nested;
  for (const XmlElement* element : elements) nested.push_back(read_phase(*element, p.context()));
  return add_mixture(p, nested, weights, 0, nested.size());
}

PhaseModel read_table(Properties& p) {
  if (!p.has("values")) p.fail("needs the string 'values'", SceneErrorCode::kMissing);
  const std::vector<float> values = read_numbers(p, "values");
  if (values.size() < 2) p.fail_at("values", fmt::format("has {} numbers, expected at least two", values.size()));
  if (values.size() > kMaxPhaseValues)
    p.fail_at("values", fmt::format("has {} numbers, expected at most {}", values.size(), kMaxPhaseValues));
  for (const float value : values)
    if (!(value >= 0.0f) || !std::isfinite(value))
      p.fail_at("values", fmt::format("has {}, expected a non-negative number", value));
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  if (!(sum > 0)) p.fail_at("values", fmt::format("add up to {}, expected more than 0", sum));
  return TabulatedPhaseDescription{values};
}

PhaseModel read_henyey_greenstein(Properties& p) {
  const HenyeyGreensteinDescription default_value;
  return HenyeyGreensteinDescription{p.number("g", default_value.g, kMeanCosine)};
}

constexpr NameTable<PhaseModel (*)(Properties&)> kPhases{
    {{"blend", read_blend},
     {"blendphase", read_blend},
     {"hg", read_henyey_greenstein},
     {"isotropic", [](Properties&) -> PhaseModel { return IsotropicPhaseDescription{}; }},
     {"rayleigh", [](Properties&) -> PhaseModel { return RayleighDescription{}; }},
     {"sggx", read_sggx},
     {"tabphase", read_table}}};
constexpr NameTable<PhaseId (*)(Properties&)> kMixtures{{{"mixturephase", read_mixture}}};

}  // namespace

PhaseId read_phase(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  if (const auto* read = kMixtures.find(p.type())) {
    const PhaseId mixture = (*read)(p);
    p.reject_unused();
    return mixture;
  }
  PhaseDescription phase;
  phase.where = element.where;
  phase.model = p.plugin(kPhases, kMixtures)(p);
  p.reject_unused();
  std::vector<PhaseDescription>& phases = context.description.phases;
  phases.push_back(std::move(phase));
  return static_cast<PhaseId>(phases.size() - 1);
}

std::optional<PhaseId> find_phase(Properties& p) {
  const std::vector<const XmlElement*> found = nested_phases(p);
  if (found.size() > 1)
    p.fail(fmt::format("has {} nested <phase>, expected one", found.size()), SceneErrorCode::kDuplicate);
  std::optional<PhaseId> phase;
  if (!found.empty()) read_or_omit(*found[0], p.context(), [&] { phase = read_phase(*found[0], p.context()); });
  return phase;
}

}  // namespace sheaf
