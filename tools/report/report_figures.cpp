#include "tools/report/report_figures.h"

#include <algorithm>
#include <utility>

namespace sheaf {

double ratio(double a, double b) { return b > 0 ? a / b : 0.0; }

std::vector<std::size_t> costliest_lights(const Stats& stats, std::size_t count) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < stats.lights.size(); ++i)
    if (stats.lights[i].rays > 0) order.push_back(i);
  const auto more = [&](std::size_t a, std::size_t b) {
    return std::pair(stats.lights[b].rays, a) < std::pair(stats.lights[a].rays, b);
  };
  std::sort(order.begin(), order.end(), more);
  order.resize(std::min(order.size(), count));
  return order;
}

double total_light_radiance(const Stats& stats) {
  double total = 0;
  for (const LightStats& light : stats.lights) total += light.radiance;
  return total;
}

GatheringTime::GatheringTime(const RenderReport& report, std::string_view stage, const Stats::Gathering& counts) {
  double seconds = 0;
  for (std::size_t i = 0; i < report.stage_names.size(); ++i)
    if (report.stage_names[i] == stage) seconds = report.stats.stages[i].seconds();
  const auto queries = static_cast<double>(counts.queries), photons = static_cast<double>(counts.photons);
  ns_per_query = ratio(seconds * 1e9, queries);
  ns_per_photon = ratio(seconds * 1e9, photons);
  photons_per_query = ratio(photons, queries);
}

}  // namespace sheaf
