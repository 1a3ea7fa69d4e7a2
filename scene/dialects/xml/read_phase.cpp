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
    p.fail("has " + std::to_string(both.size()) + " nested <phase>, expected two", SceneErrorCode::kMissing);
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
    p.fail("has " + std::to_string(elements.size()) + " nested <phase> and " + std::to_string(weights.size()) +
           " weights, expected equal numbers");
  for (const float weight : weights)
    if (!(weight >= 0.0f)) p.fail_at("weights", "has " + std::to_string(weight) + ", expected a non-negative number");
  const float all = std::accumulate(weights.begin(), weights.end(), 0.0f);
  if (!(all > 0.999f))
    p.fail_at("weights", "add up to " + std::to_string(all) + ", expected 1; absorption belongs in the albedo");
  if (all > 1.001f) p.context().note(p.where(), "the weights add up to " + std::to_string(all) + ", normalized to 1");
  std::vector<PhaseId> nested;
  for (const XmlElement* element : elements) nested.push_back(read_phase(*element, p.context()));
  return add_mixture(p, nested, weights, 0, nested.size());
}

PhaseModel read_table(Properties& p) {
  if (!p.has("values")) p.fail("needs the string 'values'", SceneErrorCode::kMissing);
  const std::vector<float> values = read_numbers(p, "values");
  if (values.size() < 2)
    p.fail_at("values", "has " + std::to_string(values.size()) + " numbers, expected at least two");
  if (values.size() > kMaxPhaseValues)
    p.fail_at("values",
              "has " + std::to_string(values.size()) + " numbers, expected at most " + std::to_string(kMaxPhaseValues));
  for (const float value : values)
    if (!(value >= 0.0f) || !std::isfinite(value))
      p.fail_at("values", "has " + std::to_string(value) + ", expected a non-negative number");
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  if (!(sum > 0)) p.fail_at("values", "add up to " + std::to_string(sum) + ", expected more than 0");
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
    p.fail("has " + std::to_string(found.size()) + " nested <phase>, expected one", SceneErrorCode::kDuplicate);
  std::optional<PhaseId> phase;
  if (!found.empty()) read_or_leave_out(*found[0], p.context(), [&] { phase = read_phase(*found[0], p.context()); });
  return phase;
}

}  // namespace sheaf
