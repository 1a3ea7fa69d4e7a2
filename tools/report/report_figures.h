// Figures that the table and the JSON text of a report derive from its counters.
#pragma once

#include "kernels/passes/render_report.h"

#include <string_view>
#include <vector>

namespace sheaf {

/// a / b; 0 if b is not positive.
double ratio(double a, double b);

/// Maximum number of lights in a report.
inline constexpr std::size_t kReportedLights = 10;
/// Indices of the lights with the most shadow rays, in descending order. Omits lights without shadow rays.
std::vector<std::size_t> costliest_lights(const Stats& stats, std::size_t count = kReportedLights);

/// Sum over all lights of the radiance that they contribute.
double total_light_radiance(const Stats& stats);

/// The time of a stage per query of photon maps and per photon, if the render has any.
struct GatheringTime {
  double ns_per_query = 0, ns_per_photon = 0, photons_per_query = 0;

  GatheringTime(const RenderReport& report, std::string_view stage, const Stats::Gathering& counts);
};

}  // namespace sheaf
