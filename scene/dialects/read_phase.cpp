#include "scene/dialects/read_phase.h"

#include "scene/dialects/read_volume.h"

namespace sheaf {

namespace {

constexpr NumberRange kMeanCosine{-1, 1, true};

std::vector<const XmlElement*> nested_phases(Properties& p) {
  std::vector<const XmlElement*> found = p.objects("phase");
  const std::vector<const XmlElement*> others = p.objects("phasefunction");
  found.insert(found.end(), others.begin(), others.end());
  return found;
}

BlendPhaseDescription read_blend(Properties& p) {
  BlendPhaseDescription blend;
  if (const auto weight = find_constant_volume(p, "weight", SpectrumRole::kReflectance, {}))
    blend.weight = number_of(p, "weight", *weight);
  const std::vector<const XmlElement*> both = nested_phases(p);
  if (both.size() != 2) p.fail("holds " + std::to_string(both.size()) + " nested <phase>, expected two");
  for (std::size_t i = 0; i < 2; ++i) blend.nested[i] = read_phase(*both[i], p.context());
  return blend;
}

}  // namespace

PhaseId read_phase(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  PhaseDescription phase;
  phase.where = element.where;
  if (p.type() == "isotropic") {
    phase.model = IsotropicPhaseDescription{};
  } else if (p.type() == "hg") {
    const HenyeyGreensteinDescription otherwise;
    phase.model = HenyeyGreensteinDescription{p.number("g", otherwise.g, kMeanCosine)};
  } else if (p.type() == "rayleigh") {
    phase.model = RayleighDescription{};
  } else if (p.type() == "blendphase" || p.type() == "blend") {
    phase.model = read_blend(p);
  } else {
    p.fail_plugin({"blend", "blendphase", "hg", "isotropic", "rayleigh"});
  }
  p.finish();
  std::vector<PhaseDescription>& phases = context.description.phases;
  phases.push_back(std::move(phase));
  return static_cast<PhaseId>(phases.size() - 1);
}

std::optional<PhaseId> find_phase(Properties& p) {
  const std::vector<const XmlElement*> found = nested_phases(p);
  if (found.size() > 1) p.fail("holds " + std::to_string(found.size()) + " nested <phase>, expected one");
  if (found.empty()) return std::nullopt;
  return read_phase(*found[0], p.context());
}

}  // namespace sheaf
