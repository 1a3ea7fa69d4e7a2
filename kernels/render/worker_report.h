// Collects the statistics of all workers in the report of a render.
#pragma once

#include "kernels/passes/render_report.h"
#include "kernels/passes/worker.h"

#include <string>
#include <vector>

namespace sheaf {

/// Adds the statistics of the workers to the report, and warnings about dropped samples and abandoned rays. `dropped`:
/// by all workers, and by the renders that this one resumes. `frame`: of the samples.
void add_workers(const Workers& workers, const SampledFrame& frame, const Stats::Dropped& dropped, RenderReport& report,
                 std::vector<std::string>& warnings);

}  // namespace sheaf
