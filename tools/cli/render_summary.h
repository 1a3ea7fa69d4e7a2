// The result of a render in one line.
#pragma once

#include "kernels/passes/render_report.h"
#include "tools/job/image_files.h"

#include <string>

namespace sheaf {

/// The size, the samples per pixel, the time, the noise if it is known, and the files, such as "rendered 800x600, 64
/// spp in 9.9 s, noise 10 %; wrote out.exr".
std::string summarize(const RenderReport& report, const WrittenImages& written);

/// "wrote " and the names of the files, and the exposure if it was chosen automatically. Empty if there are none.
std::string written_files(const WrittenImages& written);

}  // namespace sheaf
