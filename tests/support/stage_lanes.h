// Lane policies for tests of stages: registers, and one path at a time (Single) as the reference. Sanitizer builds run
// registers only, because renders use nothing else. There Single is Wide, which saves compiling every stage twice.
#pragma once

#include "core/simd/simd.h"

namespace sheaf {

#ifdef SHEAF_SCALAR_STAGES
using Single = Scalar;
#define SHEAF_STAGE_LANES Wide, Scalar
#else
using Single = Wide;
#define SHEAF_STAGE_LANES Wide
#endif

}  // namespace sheaf
