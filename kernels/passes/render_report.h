// Report of a finished render: statistics of its workers, and warnings.
#pragma once

#include "core/stats.h"
#include "kernels/passes/worker.h"

#include <string>
#include <vector>

namespace sheaf {

struct IntegratorSettings;

/// Name of the integrator in scene files, e.g. "path_mats".
std::string integrator_name(const IntegratorSettings& integrator);

/// Adds the statistics of the workers to the report, and warnings about dropped samples and abandoned rays. `dropped`:
/// by all workers, and by the renders that this one resumes. `frame`: of the samples.
void add_workers(const Workers& workers, const SampledFrame& frame, const Stats::Dropped& dropped, RenderReport& report,
                 std::vector<std::string>& warnings);

}  // namespace sheaf
