// Published optical constants of metals, at the wavelengths of publication: metals that Palik's handbook (palik.cpp)
// lacks or that others measured. The tables of Johnson and Christy and of Querry are from the database of M. N.
// Polyanskiy, refractiveindex.info, which is in the public domain (CC0).
#include "scene/data/metals.h"

#include "scene/data/palik.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Brass, 70 % copper and 30 % zinc. M. R. Querry, "Optical constants", Contractor Report CRDC-CR-85034, 1985.
constexpr MetalSample kBrass[] = {
    {350.0f, 1.504f, 1.815f}, {360.0f, 1.503f, 1.815f}, {370.0f, 1.497f, 1.818f}, {380.0f, 1.487f, 1.818f},
    {390.0f, 1.471f, 1.813f}, {400.0f, 1.445f, 1.805f}, {410.0f, 1.405f, 1.794f}, {420.0f, 1.35f, 1.786f},
    {430.0f, 1.278f, 1.784f}, {440.0f, 1.191f, 1.797f}, {450.0f, 1.094f, 1.829f}, {460.0f, 0.994f, 1.883f},
    {470.0f, 0.9f, 1.957f},   {480.0f, 0.816f, 2.046f}, {490.0f, 0.745f, 2.145f}, {500.0f, 0.686f, 2.25f},
    {510.0f, 0.639f, 2.358f}, {520.0f, 0.602f, 2.464f}, {530.0f, 0.573f, 2.568f}, {540.0f, 0.549f, 2.668f},
    {550.0f, 0.527f, 2.765f}, {560.0f, 0.505f, 2.86f},  {570.0f, 0.484f, 2.958f}, {580.0f, 0.468f, 3.059f},
    {590.0f, 0.46f, 3.159f},  {600.0f, 0.45f, 3.253f},  {610.0f, 0.452f, 3.345f}, {620.0f, 0.449f, 3.434f},
    {630.0f, 0.445f, 3.522f}, {640.0f, 0.444f, 3.609f}, {650.0f, 0.444f, 3.695f}, {660.0f, 0.445f, 3.778f},
    {670.0f, 0.444f, 3.86f},  {680.0f, 0.444f, 3.943f}, {690.0f, 0.445f, 4.025f}, {700.0f, 0.446f, 4.106f},
    {710.0f, 0.448f, 4.186f}, {720.0f, 0.45f, 4.266f},  {730.0f, 0.452f, 4.346f}, {740.0f, 0.455f, 4.424f},
    {750.0f, 0.457f, 4.501f}, {760.0f, 0.458f, 4.579f}, {770.0f, 0.46f, 4.657f},  {780.0f, 0.464f, 4.737f},
    {790.0f, 0.469f, 4.814f}, {800.0f, 0.473f, 4.89f},  {810.0f, 0.478f, 4.965f}, {820.0f, 0.481f, 5.039f},
    {830.0f, 0.483f, 5.115f}, {840.0f, 0.486f, 5.192f}};
/// Iron. P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9, 1974.
constexpr MetalSample kIron[] = {{354.0f, 1.93f, 2.35f}, {368.0f, 2.02f, 2.43f}, {381.0f, 2.12f, 2.5f},
                                 {397.0f, 2.24f, 2.58f}, {413.0f, 2.35f, 2.65f}, {431.0f, 2.48f, 2.71f},
                                 {451.0f, 2.59f, 2.77f}, {471.0f, 2.67f, 2.82f}, {496.0f, 2.74f, 2.88f},
                                 {521.0f, 2.86f, 2.91f}, {549.0f, 2.95f, 2.93f}, {582.0f, 2.94f, 2.99f},
                                 {617.0f, 2.88f, 3.05f}, {659.0f, 2.92f, 3.1f},  {704.0f, 2.86f, 3.19f},
                                 {756.0f, 2.87f, 3.28f}, {821.0f, 2.94f, 3.39f}, {892.0f, 2.96f, 3.56f}};
/// Mercury. T. Inagaki, E. T. Arakawa and M. W. Williams, "Optical properties of liquid mercury", Phys. Rev. B 23,
/// 1981.
constexpr MetalSample kMercury[] = {
    {344.4f, 0.64425f, 2.85991f}, {364.66f, 0.71303f, 3.0735f}, {387.45f, 0.79824f, 3.29351f},
    {413.28f, 0.898f, 3.53785f},  {442.8f, 1.02698f, 3.80193f}, {476.86f, 1.186f, 4.08981f},
    {516.6f, 1.38332f, 4.40608f}, {563.56f, 1.62088f, 4.7505f}, {619.92f, 1.90988f, 5.14953f},
    {688.8f, 2.28417f, 5.58189f}, {774.9f, 2.74611f, 6.05402f}, {885.6f, 3.3238f, 6.55726f}};
/// Iridium. J. H. Weaver, C. G. Olson and D. W. Lynch, "Optical investigation of the electronic structure of bulk Rh
/// and Ir", Phys. Rev. B 15, 1977, as in Palik 1991.
constexpr MetalSample kIridium[] = {
    {354.2f, 1.5f, 2.93f},  {364.7f, 1.53f, 3.05f}, {375.7f, 1.57f, 3.15f}, {387.5f, 1.62f, 3.26f},
    {399.9f, 1.68f, 3.35f}, {413.3f, 1.73f, 3.43f}, {427.5f, 1.77f, 3.51f}, {442.8f, 1.81f, 3.61f},
    {459.2f, 1.85f, 3.73f}, {476.9f, 1.91f, 3.86f}, {495.9f, 1.98f, 4.0f},  {516.6f, 2.07f, 4.14f},
    {539.1f, 2.18f, 4.26f}, {563.6f, 2.29f, 4.38f}, {590.4f, 2.4f, 4.48f},  {619.9f, 2.5f, 4.57f},
    {652.5f, 2.57f, 4.68f}, {688.8f, 2.64f, 4.81f}, {729.3f, 2.69f, 4.92f}, {774.9f, 2.68f, 5.08f},
    {826.6f, 2.65f, 5.39f}, {885.6f, 2.72f, 5.74f}};
/// Platinum. A. D. Rakic et al., "Optical properties of metallic films for vertical-cavity optoelectronic devices",
/// Appl. Opt. 37, 1998: Lorentz-Drude model fitted to measurements.
constexpr MetalSample kPlatinum[] = {
    {359.72f, 1.6142f, 2.6009f}, {379.99f, 1.6698f, 2.7309f}, {399.83f, 1.7237f, 2.8515f}, {420.71f, 1.7784f, 2.9734f},
    {440.96f, 1.8291f, 3.0887f}, {460.36f, 1.876f, 3.1981f},  {480.63f, 1.9238f, 3.312f},  {499.82f, 1.969f, 3.4201f},
    {519.78f, 2.0164f, 3.5328f}, {540.54f, 2.0671f, 3.6502f}, {559.93f, 2.1161f, 3.7597f}, {580.02f, 2.169f, 3.8725f},
    {600.82f, 2.2261f, 3.9881f}, {619.95f, 2.2806f, 4.0928f}, {639.67f, 2.3388f, 4.1989f}, {660.03f, 2.4007f, 4.3061f},
    {681.03f, 2.4661f, 4.4139f}, {699.96f, 2.5263f, 4.5083f}, {719.41f, 2.5889f, 4.6028f}, {739.41f, 2.6538f, 4.697f},
    {759.96f, 2.7207f, 4.7909f}, {781.08f, 2.7893f, 4.8844f}, {799.64f, 2.8494f, 4.9642f}, {821.87f, 2.9205f, 5.057f},
    {841.41f, 2.9823f, 5.1363f}};
/// Titanium. P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9, 1974.
constexpr MetalSample kTitanium[] = {{354.0f, 1.82f, 2.87f}, {368.0f, 1.9f, 2.9f},   {381.0f, 1.99f, 2.93f},
                                     {397.0f, 2.08f, 2.95f}, {413.0f, 2.14f, 2.98f}, {431.0f, 2.21f, 3.01f},
                                     {451.0f, 2.27f, 3.04f}, {471.0f, 2.32f, 3.1f},  {496.0f, 2.36f, 3.19f},
                                     {521.0f, 2.44f, 3.3f},  {549.0f, 2.54f, 3.43f}, {582.0f, 2.6f, 3.58f},
                                     {617.0f, 2.67f, 3.72f}, {659.0f, 2.76f, 3.84f}, {704.0f, 2.86f, 3.96f},
                                     {756.0f, 3.0f, 4.01f},  {821.0f, 3.21f, 4.01f}, {892.0f, 3.29f, 3.96f}};
/// Titanium nitride. J. Pflueger et al., "Dielectric properties of TiCx, TiNx, VCx, and VNx from 1.5 to 40 eV
/// determined by electron-energy-loss spectroscopy", Phys. Rev. B 30, 1984.
constexpr MetalSample kTitaniumNitride[] = {{354.2f, 2.14f, 1.06f}, {413.3f, 1.74f, 1.04f}, {495.9f, 1.2f, 1.65f},
                                            {619.9f, 1.32f, 2.69f}, {826.6f, 1.82f, 3.81f}, {1239.9f, 2.69f, 5.04f}};

const NamedMetal kMetals[] = {{"CuZn", kBrass},  {"Fe", kIron},     {"Hg", kMercury},         {"Ir", kIridium},
                              {"Pt", kPlatinum}, {"Ti", kTitanium}, {"TiN", kTitaniumNitride}};

}  // namespace

std::span<const MetalSample> find_metal(std::string_view name) {
  for (const NamedMetal& metal : palik_metals())
    if (name == metal.name) return metal.samples;
  constexpr std::string_view kSuffix = "_palik";
  if (name.ends_with(kSuffix)) name.remove_suffix(kSuffix.size());
  for (const NamedMetal& metal : kMetals)
    if (name == metal.name) return metal.samples;
  for (const NamedMetal& metal : palik_metals())
    if (name == metal.name) return metal.samples;
  return {};
}

std::vector<std::string> metal_names() {
  std::vector<std::string> names;
  for (const NamedMetal& metal : kMetals) names.emplace_back(metal.name);
  for (const NamedMetal& metal : palik_metals()) names.emplace_back(metal.name);
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace sheaf
