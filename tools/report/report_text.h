// The report of a render as text.
#pragma once

#include "kernels/passes/render_report.h"

#include <string>

namespace sheaf {

/// The report as JSON text: the content of `--stats`, one object.
std::string to_json(const RenderReport& report);

/// The report as a human-readable table; lines end in '\n'. Omits stages without items.
std::string to_table(const RenderReport& report);

}  // namespace sheaf
