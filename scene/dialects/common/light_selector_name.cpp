// Table of light selector names.
#include "scene/dialects/common/light_selector_name.h"

#include "scene/dialects/common/known_names.h"

namespace sheaf {

namespace {

struct NamedSelector {
  const char* name;
  LightSelector selector;
};
constexpr NamedSelector kSelectors[] = {
    {"uniform", LightSelector::kUniform}, {"power", LightSelector::kPower}, {"bvh", LightSelector::kBvh}};

}  // namespace

std::optional<LightSelector> find_light_selector(std::string_view name) {
  for (const NamedSelector& named : kSelectors)
    if (name == named.name) return named.selector;
  return std::nullopt;
}

std::vector<std::string> light_selector_names() {
  std::vector<std::string> names;
  for (const NamedSelector& named : kSelectors) names.emplace_back(named.name);
  return names;
}

const char* light_selector_name(LightSelector selector) {
  for (const NamedSelector& named : kSelectors)
    if (selector == named.selector) return named.name;
  return "";
}

LightSelector light_selector_from_name(std::string_view name) {
  if (const auto selector = find_light_selector(name)) return *selector;
  throw Error(ExitCode::kUsage, "unknown light sampler '" + std::string(name) + "'" +
                                    did_you_mean(name, light_selector_names()) + known_names(light_selector_names()));
}

void read_light_sampling(Properties& p, IntegratorSettings& integrator) {
  integrator.candidates = p.integer("candidates", integrator.candidates, 1, kMaxCandidates);
  const auto name = p.find_string("light_sampler");
  if (!name) return;
  const auto selector = find_light_selector(*name);
  if (!selector)
    p.fail_at("light_sampler",
              "is '" + *name + "'" + did_you_mean(*name, light_selector_names()) + known_names(light_selector_names()));
  integrator.light_selector = *selector;
}

}  // namespace sheaf
