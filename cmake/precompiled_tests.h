// Headers that nearly every test includes in addition, parsed once for all test programs.
#pragma once

#include "cmake/precompiled_scene.h"

#include "core/sampling/rng.h"

#include <doctest/doctest.h>
