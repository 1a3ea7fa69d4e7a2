// Dispersion formulas. Unless stated otherwise, the coefficients of published measurements are from the database of M.
// N. Polyanskiy, refractiveindex.info, which is in the public domain (CC0).
#include "scene/data/glasses.h"

#include "core/color/color.h"

namespace sheaf {

namespace {

using Form = Dispersion::Form;

constexpr float square(float a) { return a * a; }

/// Schott N-BK7, borosilicate crown. Schott AG, optical glass catalog, January 2017.
constexpr Dispersion kBk7{
    Form::kSellmeier, 1, {{{1.03961212f, 0.00600069867f}, {0.231792344f, 0.0200179144f}, {1.01046945f, 103.560653f}}}};
/// Schott N-BAF10, barium flint. As above.
constexpr Dispersion kBaf10{
    Form::kSellmeier, 1, {{{1.5851495f, 0.00926681282f}, {0.143559385f, 0.0424489805f}, {1.08521269f, 105.613573f}}}};
/// Schott N-FK51A, fluorite crown. As above.
constexpr Dispersion kFk51a{
    Form::kSellmeier, 1, {{{0.971247817f, 0.00472301995f}, {0.216901417f, 0.0153575612f}, {0.904651666f, 168.68133f}}}};
/// Schott N-LASF9, lanthanum flint. As above.
constexpr Dispersion kLasf9{
    Form::kSellmeier, 1, {{{2.00029547f, 0.0121426017f}, {0.298926886f, 0.0538736236f}, {1.80691843f, 156.530829f}}}};
/// Schott SF5 and SF10, lead flints. As above.
constexpr Dispersion kSf5{
    Form::kSellmeier, 1, {{{1.52481889f, 0.011254756f}, {0.187085527f, 0.0588995392f}, {1.42729015f, 129.141675f}}}};
constexpr Dispersion kSf10{
    Form::kSellmeier, 1, {{{1.62153902f, 0.0122241457f}, {0.256287842f, 0.0595736775f}, {1.64447552f, 147.468793f}}}};
/// Schott SF11, a dense lead flint. As above.
constexpr Dispersion kSf11{
    Form::kSellmeier, 1, {{{1.73848403f, 0.0136068604f}, {0.311168974f, 0.0615960463f}, {1.17490871f, 121.922711f}}}};
/// Schott N-SF11, its lead-free successor. As above.
constexpr Dispersion kNSf11{
    Form::kSellmeier, 1, {{{1.73759695f, 0.013188707f}, {0.313747346f, 0.0623068142f}, {1.89878101f, 155.23629f}}}};
/// Fused silica. I. H. Malitson, "Interspecimen comparison of the refractive index of fused silica", J. Opt. Soc.
/// Am. 55, 1965.
constexpr Dispersion kFusedSilica{
    Form::kSellmeier,
    1,
    {{{0.6961663f, square(0.0684043f)}, {0.4079426f, square(0.1162414f)}, {0.8974794f, square(9.896161f)}}}};
/// Diamond. F. Peter, "Ueber Brechungsindizes und Absorptionskonstanten des Diamanten zwischen 644 und 226 mmu", Z.
/// Phys. 15, 1923.
constexpr Dispersion kDiamond{Form::kSellmeier, 1, {{{0.3306f, square(0.1750f)}, {4.3356f, square(0.1060f)}}}};
/// Sapphire, ordinary ray. I. H. Malitson and M. J. Dodge, "Refractive index and birefringence of synthetic sapphire",
/// J. Opt. Soc. Am. 62, 1972; the formula in M. J. Dodge, "Refractive index", Handbook of Laser Science and Technology
/// IV, 1986.
constexpr Dispersion kSapphire{
    Form::kSellmeier,
    1,
    {{{1.4313493f, square(0.0726631f)}, {0.65054713f, square(0.1193242f)}, {5.3414021f, square(18.028251f)}}}};
/// Rock salt. H. H. Li, "Refractive index of alkali halides and its wavelength and temperature derivatives", J. Phys.
/// Chem. Ref. Data 5, 1976.
constexpr Dispersion kSodiumChloride{Form::kSellmeier,
                                     1.00055f,
                                     {{{0.19800f, square(0.050f)},
                                       {0.48398f, square(0.100f)},
                                       {0.38696f, square(0.128f)},
                                       {0.25998f, square(0.158f)},
                                       {0.08796f, square(40.50f)},
                                       {3.17064f, square(60.98f)},
                                       {0.30038f, square(120.34f)}}}};
/// Distilled water at 20 degrees Celsius. M. Daimon and A. Masumura, "Measurement of the refractive index of distilled
/// water from the near-infrared region to the ultraviolet region", Appl. Opt. 46, 2007.
constexpr Dispersion kWater{Form::kSellmeier,
                            1,
                            {{{0.5684027565f, 0.005101829712f},
                              {0.1726177391f, 0.01821153936f},
                              {0.02086189578f, 0.02620722293f},
                              {0.1130748688f, 10.69792721f}}}};
/// Ice at -7 degrees Celsius. Fitted for Sheaf, within 8e-5, to the table from 350 to 830 nm of S. G. Warren and R. E.
/// Brandt, "Optical constants of ice from the ultraviolet to the microwave: a revised compilation", J. Geophys. Res.
/// 113, 2008.
constexpr Dispersion kIce{Form::kSellmeier, 1, {{{0.70041228f, 0.0091f}, {0.11160444f, 10.0f}}}};
/// Poly(methyl methacrylate). G. Beadie et al., "Refractive index measurements of poly(methyl methacrylate) (PMMA) from
/// 0.4-1.6 um", Appl. Opt. 54, 2015.
constexpr Dispersion kAcrylicGlass{
    Form::kSquarePowers,
    2.1778f,
    {{{6.1209e-3f, 2}, {-1.5004e-3f, 4}, {2.3678e-2f, -2}, {-4.2137e-3f, -4}, {7.3417e-4f, -6}, {-4.5042e-5f, -8}}}};
/// Benzene at 27 degrees Celsius. K. Moutzouris et al., "Refractive, dispersive and thermo-optic properties of twelve
/// organic solvents in the visible and near-infrared", Appl. Phys. B 116, 2013.
constexpr Dispersion kBenzene{Form::kSquarePowers,
                              2.170184597f,
                              {{{0.00059399f, 2}, {0.02303464f, -2}, {-0.000499485f, -4}, {0.000178796f, -6}}}};
/// Ethanol and acetone at 20 degrees Celsius. J. Rheims, J. Koeser and T. Wriedt, "Refractive-index measurements in the
/// near-IR using an Abbe refractometer", Meas. Sci. Technol. 8, 1997.
constexpr Dispersion kEthanol{Form::kPowers, 1.35265f, {{{0.00306f, -2}, {0.00002f, -4}}}};
constexpr Dispersion kAcetone{Form::kPowers, 1.34979f, {{{0.00306f, -2}, {0.00006f, -4}}}};

struct NamedDispersion {
  const char* name;
  const Dispersion* dispersion;
};
constexpr NamedDispersion kNamed[] = {{"acetone", &kAcetone},
                                      {"acrylic glass", &kAcrylicGlass},
                                      {"baf10", &kBaf10},
                                      {"benzene", &kBenzene},
                                      {"bk7", &kBk7},
                                      {"diamond", &kDiamond},
                                      {"ethanol", &kEthanol},
                                      {"fk51a", &kFk51a},
                                      {"fused quartz", &kFusedSilica},
                                      {"fused silica", &kFusedSilica},
                                      {"lasf9", &kLasf9},
                                      {"n-sf11", &kNSf11},
                                      {"sapphire", &kSapphire},
                                      {"sf10", &kSf10},
                                      {"sf11", &kSf11},
                                      {"sf5", &kSf5},
                                      {"sodium chloride", &kSodiumChloride},
                                      {"water", &kWater},
                                      {"water ice", &kIce}};

}  // namespace

const Dispersion* find_dispersion(std::string_view name) {
  for (const NamedDispersion& entry : kNamed)
    if (name == entry.name) return entry.dispersion;
  return nullptr;
}

std::vector<std::string> dispersion_names() {
  std::vector<std::string> names;
  for (const NamedDispersion& entry : kNamed) names.emplace_back(entry.name);
  return names;
}

}  // namespace sheaf
