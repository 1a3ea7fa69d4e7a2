// What nearly every test includes besides, parsed once for all programs of tests.
#pragma once

#include "cmake/precompiled_scene.h"

#include "core/rng.h"

#include <doctest/doctest.h>
