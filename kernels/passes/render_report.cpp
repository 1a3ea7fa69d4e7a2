#include "kernels/passes/render_report.h"

namespace sheaf {

namespace {

double ratio(double a, double b) { return b > 0 ? a / b : 0.0; }

}  // namespace

double RenderReport::rays_per_second() const { return ratio(static_cast<double>(stats.rays.total()), render_seconds); }

double RenderReport::trace_fraction() const {
  return ratio(static_cast<double>(stats.trace_ticks) * seconds_per_tick(), render_seconds * threads);
}

double RenderReport::samples_factor(double target) const { return noise ? (*noise / target) * (*noise / target) : 0.0; }

}  // namespace sheaf
