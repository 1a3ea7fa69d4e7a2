// What a render tells of itself when it has ended.
#pragma once

#include "core/stats.h"
#include "kernels/passes/worker.h"

#include <string>
#include <vector>

namespace sheaf {

struct IntegratorDescription;

/// What people call the integrator, e.g. "path_mats".
std::string integrator_name(const IntegratorDescription& integrator);

/// Adds what the workers have counted to the report, and warns of what went wrong. `dropped`: by all of them, and by
/// the renders that this one goes on from. `frame`: of the samples.
void add_workers(const Workers& workers, const SampledFrame& frame, const Stats::Dropped& dropped, RenderReport& report,
                 std::vector<std::string>& warnings);

}  // namespace sheaf
