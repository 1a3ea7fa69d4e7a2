// What nearly every file of scene/ and of the layers after it includes besides.
#pragma once

#include "cmake/precompiled.h"

#include "core/error.h"
#include "scene/description/description.h"
