// Headers that nearly every file of scene/ and of later layers includes in addition.
#pragma once

#include "cmake/precompiled.h"

#include "core/io/error.h"
#include "scene/description.h"
