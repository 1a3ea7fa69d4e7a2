// Tone-mapping curves: scene-referred to display-referred colors, both linear Rec.709.
//
// - filmic: the curve of John Hable, "Uncharted 2: HDR Lighting" (GDC 2010), with its published constants, per channel
// - aces: Stephen Hill's fit of the ACES reference rendering and sRGB output transforms (2015), published in "Baking
//   Lab" by Pettineo and Neubelt
// - agx: Troy Sobotka's AgX (2022), with the polynomial of Benjamin Wrensch, "Minimal AgX Implementation" (2023)
#pragma once

#include "core/io/name_table.h"
#include "core/math/vec.h"

namespace sheaf {

enum class ToneMap { kClamp, kFilmic, kAces, kAgx };
inline constexpr NameTable<ToneMap> kToneMaps{
    {{"none", ToneMap::kClamp}, {"filmic", ToneMap::kFilmic}, {"aces", ToneMap::kAces}, {"agx", ToneMap::kAgx}}};

/// The displayed color in [0, 1] of a color of the scene. kClamp only clamps. Negative components become 0, NaN
/// becomes 0, and infinity the largest float. Black maps to black, and grays to grays but for 0.001.
Vec3f tone_mapped(ToneMap map, Vec3f rgb);

}  // namespace sheaf
