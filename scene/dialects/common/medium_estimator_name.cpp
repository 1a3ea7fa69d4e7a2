// Table of medium estimator names.
#include "scene/dialects/common/medium_estimator_name.h"

#include "scene/dialects/common/known_names.h"

namespace sheaf {

namespace {

struct NamedEstimator {
  const char* name;
  MediumEstimator estimator;
};
constexpr NamedEstimator kEstimators[] = {{"null_mis", MediumEstimator::kNullMis},
                                          {"delta", MediumEstimator::kDelta},
                                          {"ratio", MediumEstimator::kRatio},
                                          {"marching", MediumEstimator::kMarching}};

}  // namespace

std::optional<MediumEstimator> find_medium_estimator(std::string_view name) {
  for (const NamedEstimator& named : kEstimators)
    if (name == named.name) return named.estimator;
  return std::nullopt;
}

std::vector<std::string> medium_estimator_names() {
  std::vector<std::string> names;
  for (const NamedEstimator& named : kEstimators) names.emplace_back(named.name);
  return names;
}

const char* medium_estimator_name(MediumEstimator estimator) {
  for (const NamedEstimator& named : kEstimators)
    if (estimator == named.estimator) return named.name;
  return "";
}

MediumEstimator medium_estimator_from_name(std::string_view name) {
  if (const auto estimator = find_medium_estimator(name)) return *estimator;
  throw Error(ExitCode::kUsage, "unknown medium estimator '" + std::string(name) + "'" +
                                    did_you_mean(name, medium_estimator_names()) +
                                    known_names(medium_estimator_names()));
}

void read_medium_estimation(Properties& p, IntegratorSettings& integrator) {
  integrator.step_size = p.number("step_size", integrator.step_size, kPositive);
  const auto name = p.find_string("medium_estimator");
  if (!name) return;
  const auto estimator = find_medium_estimator(*name);
  if (!estimator)
    p.fail_at("medium_estimator", "is '" + *name + "', expected null_mis, delta, ratio or marching" +
                                      did_you_mean(*name, medium_estimator_names()));
  integrator.medium_estimator = *estimator;
}

}  // namespace sheaf
