// Optical constants of metals from publications, at the wavelengths at which they were published. Those of Johnson and
// Christy are taken from the database of M. N. Polyanskiy, refractiveindex.info, which is in the public domain (CC0).
#include "scene/data/metals.h"

#include "scene/data/palik.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Silver. P. B. Johnson and R. W. Christy, "Optical constants of the noble metals", Phys. Rev. B 6, 1972.
constexpr MetalSample kSilver[] = {
    {354.2f, 0.1f, 1.419f}, {367.9f, 0.07f, 1.657f}, {381.5f, 0.05f, 1.864f}, {397.4f, 0.05f, 2.07f},
    {413.3f, 0.05f, 2.275f}, {430.5f, 0.04f, 2.462f}, {450.9f, 0.04f, 2.657f}, {471.4f, 0.05f, 2.869f},
    {495.9f, 0.05f, 3.093f}, {520.9f, 0.05f, 3.324f}, {548.6f, 0.06f, 3.586f}, {582.1f, 0.05f, 3.858f},
    {616.8f, 0.06f, 4.152f}, {659.5f, 0.05f, 4.483f}, {704.5f, 0.04f, 4.838f}, {756.0f, 0.03f, 5.242f},
    {821.1f, 0.04f, 5.727f}, {892.0f, 0.04f, 6.312f}};
/// Aluminium. A. D. Rakic, "Algorithm for the determination of intrinsic optical constants of metal films:
/// application to aluminum", Appl. Opt. 34, 1995.
constexpr MetalSample kAluminium[] = {
    {326.28f, 0.31474f, 3.9165f}, {364.66f, 0.39877f, 4.3957f}, {413.28f, 0.52135f, 5.0008f},
    {442.8f, 0.6079f, 5.3676f}, {476.87f, 0.7278f, 5.7781f}, {516.6f, 0.8734f, 6.2418f}, {563.57f, 1.0728f, 6.7839f},
    {619.93f, 1.366f, 7.4052f}, {652.25f, 1.5724f, 7.7354f}, {688.81f, 1.8301f, 8.0601f}, {729.32f, 2.1606f, 8.3565f},
    {774.91f, 2.6154f, 8.4914f}, {794.78f, 2.7675f, 8.3866f}, {815.69f, 2.7668f, 8.2573f}, {837.74f, 2.6945f, 8.1878f}};
/// Gold. P. B. Johnson and R. W. Christy, "Optical constants of the noble metals", Phys. Rev. B 6, 1972.
constexpr MetalSample kGold[] = {
    {354.2f, 1.5f, 1.866f}, {367.9f, 1.48f, 1.895f}, {381.5f, 1.46f, 1.933f}, {397.4f, 1.47f, 1.952f},
    {413.3f, 1.46f, 1.958f}, {430.5f, 1.45f, 1.948f}, {450.9f, 1.38f, 1.914f}, {471.4f, 1.31f, 1.849f},
    {495.9f, 1.04f, 1.833f}, {520.9f, 0.62f, 2.081f}, {548.6f, 0.43f, 2.455f}, {582.1f, 0.29f, 2.863f},
    {616.8f, 0.21f, 3.272f}, {659.5f, 0.14f, 3.697f}, {704.5f, 0.13f, 4.103f}, {756.0f, 0.14f, 4.542f},
    {821.1f, 0.16f, 5.083f}, {892.0f, 0.17f, 5.663f}};
/// Chromium. P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9, 1974.
constexpr MetalSample kChromium[] = {
    {354.0f, 1.84f, 2.64f}, {368.0f, 1.87f, 2.69f}, {381.0f, 1.92f, 2.74f}, {397.0f, 2.0f, 2.83f},
    {413.0f, 2.08f, 2.93f}, {431.0f, 2.19f, 3.04f}, {451.0f, 2.33f, 3.14f}, {471.0f, 2.51f, 3.24f},
    {496.0f, 2.75f, 3.3f}, {521.0f, 2.94f, 3.33f}, {549.0f, 3.18f, 3.33f}, {582.0f, 3.22f, 3.3f},
    {617.0f, 3.17f, 3.3f}, {659.0f, 3.09f, 3.34f}, {704.0f, 3.05f, 3.39f}, {756.0f, 3.08f, 3.42f},
    {821.0f, 3.2f, 3.48f}, {892.0f, 3.3f, 3.52f}};
/// Copper. P. B. Johnson and R. W. Christy, "Optical constants of the noble metals", Phys. Rev. B 6, 1972.
constexpr MetalSample kCopper[] = {
    {354.2f, 1.37f, 1.916f}, {367.9f, 1.36f, 1.975f}, {381.5f, 1.33f, 2.045f}, {397.4f, 1.32f, 2.116f},
    {413.3f, 1.28f, 2.207f}, {430.5f, 1.25f, 2.305f}, {450.9f, 1.24f, 2.397f}, {471.4f, 1.25f, 2.483f},
    {495.9f, 1.22f, 2.564f}, {520.9f, 1.18f, 2.608f}, {548.6f, 1.02f, 2.577f}, {582.1f, 0.7f, 2.704f},
    {616.8f, 0.3f, 3.205f}, {659.5f, 0.22f, 3.747f}, {704.5f, 0.21f, 4.205f}, {756.0f, 0.24f, 4.665f},
    {821.1f, 0.26f, 5.18f}, {892.0f, 0.3f, 5.768f}};
/// Iron. P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9, 1974.
constexpr MetalSample kIron[] = {
    {354.0f, 1.93f, 2.35f}, {368.0f, 2.02f, 2.43f}, {381.0f, 2.12f, 2.5f}, {397.0f, 2.24f, 2.58f},
    {413.0f, 2.35f, 2.65f}, {431.0f, 2.48f, 2.71f}, {451.0f, 2.59f, 2.77f}, {471.0f, 2.67f, 2.82f},
    {496.0f, 2.74f, 2.88f}, {521.0f, 2.86f, 2.91f}, {549.0f, 2.95f, 2.93f}, {582.0f, 2.94f, 2.99f},
    {617.0f, 2.88f, 3.05f}, {659.0f, 2.92f, 3.1f}, {704.0f, 2.86f, 3.19f}, {756.0f, 2.87f, 3.28f},
    {821.0f, 2.94f, 3.39f}, {892.0f, 2.96f, 3.56f}};
/// Mercury. T. Inagaki, E. T. Arakawa and M. W. Williams, "Optical properties of liquid mercury", Phys. Rev. B 23,
/// 1981.
constexpr MetalSample kMercury[] = {
    {344.4f, 0.64425f, 2.85991f}, {364.66f, 0.71303f, 3.0735f}, {387.45f, 0.79824f, 3.29351f},
    {413.28f, 0.898f, 3.53785f}, {442.8f, 1.02698f, 3.80193f}, {476.86f, 1.186f, 4.08981f},
    {516.6f, 1.38332f, 4.40608f}, {563.56f, 1.62088f, 4.7505f}, {619.92f, 1.90988f, 5.14953f},
    {688.8f, 2.28417f, 5.58189f}, {774.9f, 2.74611f, 6.05402f}, {885.6f, 3.3238f, 6.55726f}};
/// Iridium. J. H. Weaver, C. G. Olson and D. W. Lynch, "Optical investigation of the electronic structure of bulk Rh
/// and Ir", Phys. Rev. B 15, 1977, as in Palik 1991.
constexpr MetalSample kIridium[] = {
    {354.2f, 1.5f, 2.93f}, {364.7f, 1.53f, 3.05f}, {375.7f, 1.57f, 3.15f}, {387.5f, 1.62f, 3.26f},
    {399.9f, 1.68f, 3.35f}, {413.3f, 1.73f, 3.43f}, {427.5f, 1.77f, 3.51f}, {442.8f, 1.81f, 3.61f},
    {459.2f, 1.85f, 3.73f}, {476.9f, 1.91f, 3.86f}, {495.9f, 1.98f, 4.0f}, {516.6f, 2.07f, 4.14f},
    {539.1f, 2.18f, 4.26f}, {563.6f, 2.29f, 4.38f}, {590.4f, 2.4f, 4.48f}, {619.9f, 2.5f, 4.57f},
    {652.5f, 2.57f, 4.68f}, {688.8f, 2.64f, 4.81f}, {729.3f, 2.69f, 4.92f}, {774.9f, 2.68f, 5.08f},
    {826.6f, 2.65f, 5.39f}, {885.6f, 2.72f, 5.74f}};
/// Nickel. P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9, 1974.
constexpr MetalSample kNickel[] = {
    {354.0f, 1.74f, 2.32f}, {368.0f, 1.7f, 2.4f}, {381.0f, 1.72f, 2.48f}, {397.0f, 1.72f, 2.57f},
    {413.0f, 1.7f, 2.69f}, {431.0f, 1.71f, 2.82f}, {451.0f, 1.73f, 2.95f}, {471.0f, 1.78f, 3.09f},
    {496.0f, 1.82f, 3.25f}, {521.0f, 1.85f, 3.42f}, {549.0f, 1.92f, 3.61f}, {582.0f, 1.96f, 3.8f},
    {617.0f, 1.99f, 4.02f}, {659.0f, 1.99f, 4.26f}, {704.0f, 2.06f, 4.5f}, {756.0f, 2.13f, 4.73f},
    {821.0f, 2.26f, 4.97f}, {892.0f, 2.4f, 5.23f}};
/// Platinum. A. D. Rakic et al., "Optical properties of metallic films for vertical-cavity optoelectronic devices",
/// Appl. Opt. 37, 1998: Lorentz-Drude model fitted to measurements.
constexpr MetalSample kPlatinum[] = {
    {359.72f, 1.6142f, 2.6009f}, {379.99f, 1.6698f, 2.7309f}, {399.83f, 1.7237f, 2.8515f}, {420.71f, 1.7784f, 2.9734f},
    {440.96f, 1.8291f, 3.0887f}, {460.36f, 1.876f, 3.1981f}, {480.63f, 1.9238f, 3.312f}, {499.82f, 1.969f, 3.4201f},
    {519.78f, 2.0164f, 3.5328f}, {540.54f, 2.0671f, 3.6502f}, {559.93f, 2.1161f, 3.7597f}, {580.02f, 2.169f, 3.8725f},
    {600.82f, 2.2261f, 3.9881f}, {619.95f, 2.2806f, 4.0928f}, {639.67f, 2.3388f, 4.1989f}, {660.03f, 2.4007f, 4.3061f},
    {681.03f, 2.4661f, 4.4139f}, {699.96f, 2.5263f, 4.5083f}, {719.41f, 2.5889f, 4.6028f}, {739.41f, 2.6538f, 4.697f},
    {759.96f, 2.7207f, 4.7909f}, {781.08f, 2.7893f, 4.8844f}, {799.64f, 2.8494f, 4.9642f}, {821.87f, 2.9205f, 5.057f},
    {841.41f, 2.9823f, 5.1363f}};
/// Titanium. P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9, 1974.
constexpr MetalSample kTitanium[] = {
    {354.0f, 1.82f, 2.87f}, {368.0f, 1.9f, 2.9f}, {381.0f, 1.99f, 2.93f}, {397.0f, 2.08f, 2.95f},
    {413.0f, 2.14f, 2.98f}, {431.0f, 2.21f, 3.01f}, {451.0f, 2.27f, 3.04f}, {471.0f, 2.32f, 3.1f},
    {496.0f, 2.36f, 3.19f}, {521.0f, 2.44f, 3.3f}, {549.0f, 2.54f, 3.43f}, {582.0f, 2.6f, 3.58f},
    {617.0f, 2.67f, 3.72f}, {659.0f, 2.76f, 3.84f}, {704.0f, 2.86f, 3.96f}, {756.0f, 3.0f, 4.01f},
    {821.0f, 3.21f, 4.01f}, {892.0f, 3.29f, 3.96f}};
/// Titanium nitride. J. Pflueger et al., "Dielectric properties of TiCx, TiNx, VCx, and VNx from 1.5 to 40 eV
/// determined by electron-energy-loss spectroscopy", Phys. Rev. B 30, 1984.
constexpr MetalSample kTitaniumNitride[] = {
    {354.2f, 2.14f, 1.06f}, {413.3f, 1.74f, 1.04f}, {495.9f, 1.2f, 1.65f}, {619.9f, 1.32f, 2.69f},
    {826.6f, 1.82f, 3.81f}, {1239.9f, 2.69f, 5.04f}};
/// Vanadium. P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9, 1974.
constexpr MetalSample kVanadium[] = {
    {354.0f, 2.51f, 3.34f}, {368.0f, 2.68f, 3.4f}, {381.0f, 2.87f, 3.45f}, {397.0f, 3.07f, 3.48f},
    {413.0f, 3.31f, 3.49f}, {431.0f, 3.52f, 3.49f}, {451.0f, 3.59f, 3.46f}, {471.0f, 3.81f, 3.38f},
    {496.0f, 3.92f, 3.26f}, {521.0f, 3.86f, 3.18f}, {549.0f, 4.0f, 3.04f}, {582.0f, 3.83f, 3.0f},
    {617.0f, 3.54f, 3.02f}, {659.0f, 3.25f, 3.09f}, {704.0f, 3.18f, 3.15f}, {756.0f, 3.2f, 3.2f},
    {821.0f, 3.16f, 3.25f}, {892.0f, 3.12f, 3.34f}};
/// Tungsten. J. H. Weaver, C. G. Olson and D. W. Lynch, "Optical properties of crystalline tungsten", Phys. Rev. B 12,
/// 1975.
constexpr MetalSample kTungsten[] = {
    {357.5f, 3.27f, 2.705f}, {366.2f, 3.373f, 2.677f}, {376.6f, 3.454f, 2.579f}, {386.6f, 3.458f, 2.49f},
    {400.2f, 3.406f, 2.415f}, {411.5f, 3.379f, 2.416f}, {425.3f, 3.346f, 2.439f}, {442.6f, 3.317f, 2.489f},
    {465.0f, 3.325f, 2.574f}, {492.1f, 3.38f, 2.664f}, {511.1f, 3.433f, 2.7f}, {529.8f, 3.49f, 2.716f},
    {548.9f, 3.522f, 2.739f}, {570.5f, 3.524f, 2.787f}, {599.7f, 3.557f, 2.86f}, {626.0f, 3.607f, 2.906f},
    {652.4f, 3.68f, 2.937f}, {671.2f, 3.746f, 2.937f}, {684.9f, 3.818f, 2.904f}, {700.8f, 3.871f, 2.879f},
    {717.3f, 3.896f, 2.85f}, {731.4f, 3.891f, 2.828f}, {752.8f, 3.862f, 2.788f}, {777.8f, 3.789f, 2.737f},
    {795.8f, 3.694f, 2.735f}, {814.7f, 3.596f, 2.757f}, {832.7f, 3.492f, 2.801f}};

const NamedMetal kMetals[] = {{"Ag", kSilver},  {"Al", kAluminium}, {"Au", kGold},     {"Cr", kChromium},
                              {"Cu", kCopper},  {"Fe", kIron},      {"Hg", kMercury},  {"Ir", kIridium},
                              {"Ni", kNickel},  {"Pt", kPlatinum},  {"Ti", kTitanium}, {"TiN", kTitaniumNitride},
                              {"V", kVanadium}, {"W", kTungsten}};

}  // namespace

std::span<const MetalSample> find_metal(std::string_view name) {
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
