// Lanes that the tests of stages run them with: registers, and one path at a time (Single), which they are compared
// with. Sanitizers are left to registers, which is what renders: there Single is the same once more, and not compiled
// twice.
#pragma once

#include "core/simd.h"

namespace sheaf {

#ifdef SHEAF_SCALAR_STAGES
using Single = Scalar;
#define SHEAF_STAGE_LANES Wide, Scalar
#else
using Single = Wide;
#define SHEAF_STAGE_LANES Wide
#endif

}  // namespace sheaf
