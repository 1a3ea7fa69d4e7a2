// Headers that nearly every file includes and that rarely change. They are parsed once per build folder.
#pragma once

#include "core/color/spectrum.h"
#include "core/math/frame.h"
#include "core/math/vec.h"
#include "core/simd/simd.h"
#include "core/soa/soa.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>
