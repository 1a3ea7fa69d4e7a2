// The principled BSDFs: comparison with Mitsuba, sampling, energy, reciprocity, and SIMD lanes.
#include "kernels/bsdf/principled.h"
#include "kernels/bsdf/principled_thin.h"

#include "tests/support/bsdf_testing.h"

namespace sheaf::test_bsdf_principled {

namespace {

using Principled = PrincipledParameters<Scalar>;
using Thin = PrincipledThinParameters<Scalar>;

PrincipledBsdf<Scalar> principled(const Principled& p) {
  PrincipledBsdf<Scalar> bsdf;
  static_cast<Principled&>(bsdf) = p;
  return bsdf;
}
PrincipledThinBsdf<Scalar> thin(const Thin& p) {
  PrincipledThinBsdf<Scalar> bsdf;
  static_cast<Thin&>(bsdf) = p;
  return bsdf;
}

/// f |cos(wi)| as computed by Mitsuba 3.9.1 (scalar_rgb).
template <class Parameters> struct Reference {
  Parameters parameters;
  Vec3f wo, wi;
  Spectrum4 f_cos;
};

const Reference<Principled> kPrincipledReferences[] = {
    {{{0.4, 0.48, 0.18, 0}, 0.58, 1, 0, 0.64, 0.67, 0.61, 0.2, 0, 0.71, 0.27, 1.1},
     {0, 0, -1},
     {0.03504258, 0.01970553, 0.9991915},
     {6.61299, 7.244168, 4.436129, 0}},
    {{{0.28, 0.08, 0.48, 0}, 0.7, 0.41, 0.76, 0.33, 0.15, 0.94, 0.05, 0.88, 0.47, 0, 1.1},
     {-0.7096763, -0.07974652, -0.7},
     {0.7862983, 0.1106159, 0.6078644},
     {0.8481745, 0.4533683, 1.110521, 0}},
    {{{0.42, 0.58, 0.98, 0}, 0.3, 0.69, 0.44, 0.61, 0.14, 0, 0.98, 0, 0, 0.81, 0.7},
     {-0.5980878, 0.8008689, -0.03},
     {0.602458, -0.7945326, -0.07590942},
     {5.637744, 5.637744, 5.637744, 0}},
    {{{0.1, 0.16, 0.35, 0}, 0.7, 0.87, 1, 0, 0, 0.15, 0.4, 0.76, 0.63, 0, 1.33},
     {0.2348437, -0.9668756, 0.1},
     {-0.7194941, 0.3465053, 0.6018824},
     {0.002990204, 0.004250179, 0.008240097, 0}},
    {{{0.27, 0.76, 0.95, 0}, 1, 0.22, 0, 0.23, 0.96, 0.55, 0, 0.82, 0, 1, 1.86},
     {0.2502306, -0.1867744, 0.95},
     {-0.6408443, -0.736229, 0.217452},
     {0.01618708, 0.04521589, 0.05647196, 0}},
    {{{1, 1, 1, 0}, 0, 0.28, 0, 0, 0.22, 0.84, 1, 0.89, 0.78, 0.79, 1.5},
     {0.3309383, -0.9431754, 0.03},
     {-0.3309572, 0.9431795, 0.02965983},
     {1839982, 1839982, 1839982, 0}},
    {{{0.61, 0.43, 0.51, 0}, 0.5, 0, 0.35, 1, 0.93, 0.23, 1, 0.55, 0, 0.66, 1.33},
     {0.2244947, -0.6779396, 0.7},
     {-0.8971796, 0.3029127, 0.3214228},
     {0.009059587, 0.006469646, 0.00762073, 0}},
    {{{0.96, 0.83, 0.24, 0}, 0.3, 1, 0, 0.17, 0.4, 1, 0.1, 0, 0.59, 0.58, 1.5},
     {0.3821966, 0.8330221, -0.4},
     {-0.3964967, -0.8346317, -0.3823354},
     {3.937054, 3.937054, 3.937054, 0}},
    {{{0.65, 0.33, 0.2, 0}, 0.5, 0, 0, 1, 0, 0.42, 0, 0, 0, 0, 2.4},
     {0.4074405, 0.5865085, -0.7},
     {-0.1691213, 0.925577, -0.3386815},
     {0.00301805, 0.00301805, 0.00301805, 0}},
    {{{0.42, 0.64, 0.61, 0}, 0, 0.76, 0.44, 0.76, 0.25, 0.5, 0, 0.32, 0.94, 0.24, 0.7},
     {0, 0, 1},
     {-5.815937e-06, 5.020041e-05, 1},
     {15973.01, 23795.26, 22728.59, 0}},
    {{{0.77, 0.66, 0.15, 0}, 0, 0.58, 0, 0, 0.71, 0.66, 0, 0.25, 0, 0.39, 0.7},
     {0.07967868, 0.9963691, 0.03},
     {0.06237682, 0.3501621, 0.9346099},
     {0.1393412, 0.1194474, 0.0272125, 0}},
    {{{0.93, 0.67, 0.39, 0}, 0.1, 0, 0, 0.13, 1, 0.51, 0.53, 0.82, 1, 0, 2.4},
     {0, 0, 1},
     {0.02151674, -0.00754309, -0.99974},
     {0.6380247, 0.5415437, 0.4131696, 0}},
    {{{0.98, 0.86, 0.53, 0}, 0.7, 0, 0, 0.27, 0.75, 1, 1, 0.95, 0, 0.73, 1.33},
     {0.3096098, 0.04051916, 0.95},
     {-0.1398132, 0.1380103, 0.9805128},
     {0.1554419, 0.1366009, 0.08478802, 0}},
    {{{0.75, 0.81, 0.73, 0}, 1, 0, 0.1, 0.63, 0.54, 0.71, 0.92, 0.92, 0, 0.23, 1.5},
     {-0.8927923, 0.2071761, 0.4},
     {0.9615791, -0.2389706, 0.1351248},
     {0.04050195, 0.04315047, 0.03961911, 0}},
    {{{0.72, 0.81, 0.53, 0}, 0.1, 0.45, 0, 1, 0, 0, 0, 0.73, 1, 0.61, 0.64},
     {-0.564144, -0.8251313, 0.03},
     {0.5642868, 0.8250626, 0.02919249},
     {22534.91, 22534.91, 22534.91, 0}},
    {{{0.96, 0.51, 0.89, 0}, 0.1, 0.96, 0.29, 0.15, 1, 0, 0.67, 0, 0, 1, 2.4},
     {0.4891076, 0.866472, -0.1},
     {-0.4888518, -0.8681485, -0.08568657},
     {17.12877, 17.12877, 17.12877, 0}},
    {{{0.12, 0.69, 0.89, 0}, 0.86, 0.61, 0, 1, 0, 0, 0, 0.58, 0, 1, 0.7},
     {0, 0, 1},
     {0.1832407, -0.3787092, 0.9071947},
     {0.003591674, 0.003591674, 0.003591674, 0}},
    {{{0.6, 0.4, 0.95, 0}, 0.3, 1, 0, 0, 1, 0.91, 0, 0.31, 0.34, 0.07, 2.4},
     {0, 0, 1},
     {0.298646, -0.3640221, 0.8822123},
     {0.1549411, 0.1042807, 0.243597, 0}},
    {{{0.24, 0.05, 0.67, 0}, 0.35, 0, 0, 0.13, 1, 0.5, 0, 0.96, 0.54, 0, 1.1},
     {0, 0, 1},
     {-0.01581821, -0.01043665, 0.9998204},
     {0.100256, 0.04987736, 0.2142709, 0}},
    {{{0.85, 0.78, 0.52, 0}, 1, 0, 0.78, 0, 0.38, 0.86, 1, 0.11, 0.32, 0.27, 0.7},
     {-0.6845831, -0.7283172, 0.03},
     {0.7159998, 0.6459807, 0.2646756},
     {0.1007623, 0.09801032, 0.08778861, 0}},
    {{{0.08, 0.94, 0.31, 0}, 1, 0.78, 0, 0.64, 1, 1, 0.59, 1, 0.55, 0.74, 1.33},
     {0.6470223, -0.3022617, 0.7},
     {0.7000936, 0.03331579, 0.7132734},
     {0.006346384, 0.07087563, 0.02360421, 0}},
    {{{0.96, 0.96, 0.24, 0}, 0.16, 0.29, 0.08, 0.83, 0.45, 0.68, 0, 0.15, 0, 0.46, 2.4},
     {0, 0, 1},
     {-0.04757271, 0.02188099, 0.9986281},
     {8.136835, 8.136835, 4.232918, 0}},
    {{{0.67, 0.93, 0.6, 0}, 0.3, 0.93, 0.79, 0.81, 1, 0.35, 0.84, 0.87, 0.92, 0, 2.4},
     {-0.9728254, 0.2088319, 0.1},
     {0.3875254, -0.08904002, -0.9175489},
     {0.1870286, 0.2203495, 0.176989, 0}},
    {{{0.08, 0.7, 0.44, 0}, 0.1, 0, 0, 1, 0.87, 0, 0.06, 0, 1, 0.51, 1.1},
     {0.5896461, -0.4028864, 0.7},
     {-0.587778, 0.3942608, -0.7064527},
     {0.007315678, 0.02164007, 0.01715679, 0}},
    {{{0.87, 0.61, 0.39, 0}, 0.55, 0, 0.74, 0.69, 0, 0.75, 1, 0.09, 0.04, 0.29, 1.33},
     {0, 0, 1},
     {-0.5887812, 0.6731827, 0.4473944},
     {0.04721093, 0.03320894, 0.02136109, 0}},
    {{{0.58, 0.33, 0.31, 0}, 0.28, 0.88, 0.05, 0, 1, 0.37, 0.4, 1, 0.49, 0.41, 2.4},
     {-0.6940215, 0.7193289, 0.03},
     {-0.3313275, 0.02388556, 0.9432134},
     {0.1370999, 0.07807234, 0.07335012, 0}},
    {{{0.67, 0.24, 0.58, 0}, 0.29, 0.48, 0, 0.79, 0.98, 0.67, 0.23, 0.09, 0.04, 0.27, 0.7},
     {-0.7990236, -0.4489557, 0.4},
     {-0.3554282, 0.3207398, 0.8779503},
     {0.04023719, 0.01450008, 0.03485035, 0}},
    {{{0.62, 0.72, 0.61, 0}, 0.67, 0, 0.97, 0.52, 0.68, 0, 0.26, 0.26, 0, 0.69, 1.5},
     {0.08428979, 0.9959896, 0.03},
     {-0.02347635, -0.7110909, -0.702708},
     {0.002002759, 0.002158237, 0.001986542, 0}},
    {{{0.69, 0.13, 0.34, 0}, 0.93, 0.78, 0, 0.54, 0.79, 0, 0.5, 0.21, 0, 0, 2.11},
     {-0.03391092, 0.310403, 0.95},
     {0.02213465, -0.1477205, -0.9887814},
     {0.1266011, 0.05495211, 0.0888694, 0}},
    {{{0.82, 0.76, 0.18, 0}, 1, 0.93, 0, 0.36, 0.18, 1, 0.61, 0, 0, 1, 1.33},
     {-0.8912062, 0.2138959, 0.4},
     {0.7538285, -0.1466958, -0.6404865},
     {0.08694316, 0.08370191, 0.04073473, 0}},
    {{{0.62, 0.57, 0.59, 0}, 0.7, 0.6, 0.48, 0.47, 0, 0.26, 0.95, 1, 1, 0.28, 2.4},
     {-0.2402855, 0.1994063, -0.95},
     {0.2545434, 0.02453966, 0.96675},
     {0.1354241, 0.1298487, 0.1321071, 0}},
    {{{0.89, 0.27, 0.87, 0}, 0.45, 0.31, 0, 0.04, 0.8, 0.86, 0.67, 0.12, 0, 0.91, 1.5},
     {0.08170457, 0.3013708, -0.95},
     {-0.1072454, -0.390595, 0.9142943},
     {1.071448, 0.590144, 1.059341, 0}},
    {{{0.08, 0.79, 0.95, 0}, 0.08, 1, 0.33, 0.64, 0.87, 0, 0.06, 1, 1, 0.21, 1.1},
     {0, 0, -1},
     {0.0004923823, -0.0001142389, 0.9999999},
     {59939.27, 188356.2, 206551.5, 0}},
    {{{0.91, 0.12, 0.17, 0}, 0.3, 0.32, 0, 0.8, 0, 0.18, 0.54, 0.05, 0, 0.09, 1.5},
     {0.9770843, -0.2107279, -0.03},
     {-0.9770311, 0.2109869, 0.02991308},
     {0.1896978, 0.06888621, 0.08199099, 0}},
};

const Reference<Thin> kThinReferences[] = {
    {{{0.8, 0.11, 0.91, 0}, 0.43, 0.96, 0, 0.88, 0.71, 1, 1, 0.69, 0},
     {0.1960042, 0.6867185, 0.7},
     {-0.1046499, -0.7790878, 0.6181186},
     {0.1583373, 0.02177138, 0.1801087, 0}},
    {{{0.27, 0.91, 0.18, 0}, 0.1, 0.37, 0.1, 1.5, 1, 0.66, 0, 0.32, 0.62},
     {0.3450895, -0.9380902, 0.03},
     {-0.2300597, 0.6253935, -0.7456243},
     {0.01789892, 0.060326, 0.01193261, 0}},
    {{{0.22, 0.26, 0.31, 0}, 0.3, 0.09, 0, 2.4, 0, 0, 1, 0, 1.32},
     {0.7128102, 0.04360719, 0.7},
     {-0.5124537, -0.08947171, -0.854041},
     {0.03947257, 0.0466494, 0.05562045, 0}},
    {{{0, 0, 0, 0}, 0.83, 1, 0.19, 1.1, 0, 0, 0, 0.24, 1.1},
     {0.0481021, 0.915252, 0.4},
     {-0.04876475, -0.9160816, 0.3980157},
     {0.001933612, 0.001933612, 0.001933612, 0}},
    {{{0.39, 0.25, 0.67, 0}, 0.7, 0.6, 0.28, 2.4, 0.08, 0.5, 0.11, 0, 1.82},
     {-0.8805222, -0.2543239, -0.4},
     {0.7178818, 0.3858963, -0.579422},
     {0.0264563, 0.02418017, 0.03100856, 0}},
    {{{0.03, 0.18, 0.34, 0}, 0, 0, 0.05, 1.1, 0, 1, 0.94, 0, 2},
     {0.7831694, 0.6210843, 0.03},
     {-0.7831691, -0.6210774, 0.03014998},
     {96694.62, 96694.62, 96694.62, 0}},
    {{{0.92, 0.95, 0.76, 0}, 0.3, 0, 0.26, 1.1, 0, 0.38, 0.09, 0.73, 0},
     {-0.5067729, 0.85626, -0.1},
     {0.5064997, -0.8556736, 0.1062106},
     {722.1858, 745.7354, 596.5883, 0}},
    {{{0.66, 0.09, 0.63, 0}, 0.7, 0, 0, 1.33, 1, 0.25, 0.91, 0, 0.72},
     {0, 0, -1},
     {0.0001185274, -5.490042e-05, 1},
     {0.07563043, 0.01031324, 0.07219268, 0}},
    {{{0.08, 0.67, 0.59, 0}, 0, 0.68, 0, 1.5, 0.84, 1, 0, 0.76, 1.56},
     {0.8198196, -0.4097509, 0.4},
     {-0.8197837, 0.4103132, 0.3994968},
     {0.009765021, 0.03127354, 0.02835713, 0}},
    {{{0.93, 0.62, 0.87, 0}, 0.1, 0, 0, 1.1, 0, 0.34, 0, 0.88, 0.36},
     {-0.8796352, 0.474702, 0.03},
     {0.8792374, -0.4744763, -0.04258902},
     {0.002269359, 0.001512906, 0.002122949, 0}},
    {{{0.07, 0.21, 0.91, 0}, 0.3, 0.79, 0.67, 0.7, 0, 1, 0, 0.36, 0.1},
     {0.76951, 0.4978497, -0.4},
     {-0.7595818, -0.4942296, -0.422815},
     {15.28146, 15.28801, 15.32078, 0}},
    {{{0.25, 0.97, 0.6, 0}, 1, 0.77, 0.78, 1.1, 0.53, 0.22, 0, 1, 0.08},
     {0.142681, 0.2777447, 0.95},
     {-0.6729225, -0.5648056, -0.4776714},
     {0.01092668, 0.04239552, 0.02622403, 0}},
    {{{0.63, 0.51, 0.17, 0}, 0.5, 0.66, 0.75, 1.33, 0.53, 0, 0.74, 0.31, 2},
     {-0.08821006, -0.2995313, 0.95},
     {0.2592184, 0.04247293, -0.9648844},
     {0.114469, 0.09266537, 0.03088846, 0}},
    {{{0.46, 0.12, 0.91, 0}, 0.63, 1, 0, 1.5, 0.7, 0.48, 0.61, 0, 1.56},
     {0.3830024, -0.8326519, -0.4},
     {-0.4578007, 0.6961313, -0.5530097},
     {0.02073836, 0.006032868, 0.0402015, 0}},
    {{{0.53, 0.78, 0.07, 0}, 0.3, 0.63, 0, 1.1, 0.51, 0.46, 0, 0.42, 2},
     {0.3001023, -0.9486509, -0.1},
     {-0.2028267, -0.8880093, 0.4126751},
     {0.06962004, 0.1024597, 0.0091951, 0}},
    {{{0, 0, 0, 0}, 0.5, 0, 0.71, 2.4, 1, 0.19, 0.56, 0, 0.7},
     {0, 0, 1},
     {-0.5856458, -0.01972065, 0.8103271},
     {0.02590703, 0.02590703, 0.02590703, 0}},
    {{{0.34, 0.84, 0.33, 0}, 1, 0.88, 0, 1.33, 0.11, 0.19, 0.37, 0, 1.66},
     {-0.5045474, 0.7651353, -0.4},
     {0.6406757, -0.6640142, -0.3855124},
     {0.007659636, 0.01804014, 0.007452026, 0}},
    {{{0.81, 0.76, 0.05, 0}, 0.97, 0.75, 1, 2.4, 0.28, 0.43, 0.57, 0.92, 1.6},
     {0.5789623, 0.418094, -0.7},
     {-0.1824111, -0.4656401, 0.8659708},
     {0.02460195, 0.02308331, 0.001518639, 0}},
};

/// Maximum difference over the channels, relative to the brightest channel.
double reference_difference(const Spectrum4& f, const Spectrum4& expected) {
  const double scale = max_component(expected);
  return std::max({std::fabs(f.c0 - expected.c0), std::fabs(f.c1 - expected.c1), std::fabs(f.c2 - expected.c2)}) /
         scale;
}

/// Members: base color, roughness, anisotropic, metallic, spec_trans, spec_tint, sheen, sheen_tint, flatness,
/// clearcoat, clearcoat_gloss, eta.
const Principled kDefault{{0.5f, 0.5f, 0.5f, 0}, 0.5f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.5f};
const Principled kMetal{{1, 1, 1, 0}, 0.4f, 0.8f, 1, 0, 0, 0, 0, 0, 0, 0, 1.5f};
const Principled kGlass{{1, 1, 1, 0}, 0.6f, 0.5f, 0, 1, 0, 0, 0, 0, 0, 0, 1.5f};
const Principled kBubble{{0.9f, 0.5f, 0.2f, 0}, 0.7f, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1 / 1.5f};
const Principled kCoated{{0.7f, 0.2f, 0.1f, 0}, 0.6f, 0.3f, 0.5f, 0, 0.4f, 0, 0, 0, 1, 0, 1.5f};
const Principled kLacquer{{0, 0, 0, 0}, 0.6f, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1.1f};
const Principled kCloth{{0.1f, 0.2f, 0.6f, 0}, 1, 0, 0, 0, 0, 1, 0.5f, 0.7f, 0, 0, 1.4f};
const Principled kEverything{{0.8f, 0.5f, 0.3f, 0}, 0.5f, 0.6f, 0.3f, 0.5f, 0.7f, 0.8f, 0.6f, 0.5f, 1, 0.1f, 1.8f};
const Principled kMax{{1, 1, 1, 0}, 1, 1, 0, 1, 1, 1, 1, 1, 1, 0, 2};
const Principled kSmooth{{0.8f, 0.8f, 0.8f, 0}, 0, 0, 0, 0.5f, 0, 0, 0, 0, 1, 1, 1.5f};
const Principled kMaterials[] = {kDefault, kMetal, kGlass, kBubble, kCoated, kLacquer, kCloth, kEverything, kMax};

/// Members: base color, roughness, anisotropic, spec_trans, eta, spec_tint, sheen, sheen_tint, flatness, diff_trans.
const Thin kPaper{{0.8f, 0.7f, 0.6f, 0}, 0.8f, 0, 0, 1.5f, 0, 0.5f, 0.5f, 0.5f, 1.2f};
const Thin kPane{{1, 1, 1, 0}, 0.5f, 0.4f, 1, 1.5f, 0, 0, 0, 0, 0};
const Thin kLeaf{{0.2f, 0.8f, 0.1f, 0}, 0.6f, 0.2f, 0.5f, 1.3f, 0.5f, 1, 1, 1, 2};
const Thin kThinOnes{{1, 1, 1, 0}, 1, 1, 1, 1, 1, 1, 1, 1, 1};
const Thin kThinMaterials[] = {kPaper, kPane, kLeaf, kThinOnes};

constexpr int kDirections = 10;  // of outgoing_directions()
constexpr int kSamplingTests = kDirections * 13, kPeakTests = 8;

/// Checks that f is symmetric up to the squared index of refraction on the side of wo, which scales radiance. Values
/// near zero come from facets seen edge-on, whose cosines have large rounding errors.
template <class Bsdf> void check_reciprocity(const Bsdf& bsdf, double eta, bool transmits = true) {
  double worst = 0;
  const auto f = [&](Vec3f wo, Vec3f wi) {
    const Spectrum4 value = bsdf.evaluate(wo, wi).f_cos;
    const double scale = 1 / (std::fabs(double(wi.z)) * (wo.z < 0 ? eta * eta : 1.0));
    return std::array<double, 3>{value.c0 * scale, value.c1 * scale, value.c2 * scale};
  };
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3f a = random_direction(13, i), b = random_direction(14, i);
    if (!transmits && a.z * b.z < 0) continue;
    const auto there = f(a, b), back = f(b, a);
    for (std::size_t c = 0; c < 3; ++c)
      worst = std::max(worst, std::fabs(there[c] - back[c]) / std::max(there[c] + back[c], 0.05));
  }
  CHECK(worst < 1e-4);
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("principled: values match Mitsuba") {
  for (const auto& [parameters, wo, wi, expected] : kPrincipledReferences) {
    const float first = expected.c0;
    CAPTURE(first);
    CHECK(reference_difference(principled(parameters).evaluate(wo, wi).f_cos, expected) < 2e-4);
    CHECK(principled(parameters).evaluate(wo, wi).pdf_solid_angle > 0.0f);
  }
}

TEST_CASE("principled thin: values match Mitsuba") {
  for (const auto& [parameters, wo, wi, expected] : kThinReferences) {
    const float first = expected.c0;
    CAPTURE(first);
    CHECK(reference_difference(thin(parameters).evaluate(wo, wi).f_cos, expected) < 2e-4);
    CHECK(thin(parameters).evaluate(wo, wi).pdf_solid_angle > 0.0f);
  }
}

TEST_CASE("principled: samples follow their pdf") {
  for (const Principled& p : kMaterials) {
    CAPTURE(&p - kMaterials);
    check_bsdf_sampling_with_edges(principled(p), kSamplingTests);
    check_bsdf_weights(principled(p));
  }
}

TEST_CASE("principled thin: samples follow their pdf") {
  for (const Thin& p : kThinMaterials) {
    CAPTURE(&p - kThinMaterials);
    check_bsdf_sampling_with_edges(thin(p), kSamplingTests);
    check_bsdf_weights(thin(p));
  }
}

TEST_CASE("principled: samples of a perfectly smooth surface follow their pdf") {
  const auto both = principled(kSmooth);
  check_bsdf_weights(both);
  const Vec3f above{0.6f, 0, 0.8f}, below{0.3f, 0.4f, -0.8660254f};
  check_bsdf_peak_sampling(both, above, {-0.6f, 0, 0.8f}, 0.015, kPeakTests);
  check_bsdf_peak_sampling(both, above, {-0.4f, 0, -0.9165151f}, 0.01, kPeakTests);
  check_bsdf_peak_sampling(both, below, {-0.45f, -0.6f, 0.6614378f}, 0.02, kPeakTests);
  Principled mirror = kSmooth;
  mirror.metallic = 1;
  check_bsdf_peak_sampling(principled(mirror), above, {-0.6f, 0, 0.8f}, 0.015, kPeakTests);
  Principled hair = kMetal;
  hair.roughness = 0.1f;
  hair.anisotropic = 1;
  check_bsdf_peak_sampling(principled(hair), above, {-0.6f, 0, 0.8f}, 0.3, kPeakTests);
  const auto ones = principled({{1, 1, 1, 0}, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2});
  check_bsdf_peak_sampling(ones, {0, 0, 1}, {0, 0, 1}, 0.02, kPeakTests);
  const auto pane = thin({{1, 1, 1, 0}, 0, 0, 1, 1.5f, 0, 0, 0, 0, 0});
  check_bsdf_weights(pane);
  check_bsdf_peak_sampling(pane, above, {-0.6f, 0, -0.8f}, 0.01, kPeakTests);
}

TEST_CASE("principled: scattering is reciprocal up to the squared index of refraction") {
  for (const Principled& p : {kDefault, kMetal, kGlass, kBubble, kCoated, kCloth, kEverything}) {
    CAPTURE(p.metallic);
    check_reciprocity(principled(p), p.eta);
  }
}

TEST_CASE("principled thin: scattering is reciprocal except for specular transmission") {
  check_reciprocity(thin(kPaper), 1);
  for (const Thin& p : kThinMaterials) check_reciprocity(thin(p), 1, false);
}

TEST_CASE("principled: metals and glass do not gain energy") {
  for (const float roughness : {0.0f, 0.3f, 1.0f})
    for (const float anisotropic : {0.0f, 1.0f}) {
      Principled metal = kMetal, glass = kGlass, bubble = kBubble;
      for (Principled* p : {&metal, &glass, &bubble}) {
        p->roughness = roughness;
        p->anisotropic = anisotropic;
        p->base_color = {1, 1, 1, 0};
        check_white_furnace(principled(*p), false);
      }
      check_white_furnace(thin({{1, 1, 1, 0}, roughness, anisotropic, 1, 1.5f, 0, 0, 0, 0, 0}), false);
    }
  CHECK(sampled_albedo(principled({{1, 1, 1, 0}, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1.5f}), {0.6f, 0, 0.8f}) > 0.999);
  CHECK(sampled_albedo(principled({{1, 1, 1, 0}, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1.5f}), {0.6f, 0, 0.8f}) > 0.999);
  CHECK(sampled_albedo(principled({{1, 1, 1, 0}, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1.5f}), {0.6f, 0, -0.8f}) > 0.999);
}

TEST_CASE("principled: the albedo of layers on a white base exceeds 1 within bounds only") {
  const Vec3f above{0, 0, 1};
  for (const float roughness : {0.0f, 0.5f, 1.0f})
    for (const float flatness : {0.0f, 1.0f}) {
      Principled base{{1, 1, 1, 0}, roughness, 0, 0, 0, 0, 0, 0, flatness, 0, 0, 1.5f}, sheen = base, coat = base;
      sheen.sheen = 1;
      coat.clearcoat = 1;
      const double bare = largest_albedo(principled(base)), normal = sampled_albedo(principled(base), above);
      CHECK(bare > 1.1);
      CHECK(bare < 1.7);
      const double by_sheen = largest_albedo(principled(sheen)) - bare;
      CHECK(by_sheen > 0.07);
      CHECK(by_sheen < 0.1);
      const double by_coat = sampled_albedo(principled(coat), above) - normal;
      CHECK(by_coat > 0.02);
      CHECK(by_coat < 0.03);
    }
}

TEST_CASE("principled: lobes of weight zero have no effect") {
  const Vec3f below{0.6f, 0, -0.8f};
  for (const Principled& p : {kDefault, kMetal, kCoated, kCloth}) {
    CHECK(is_black(principled(p).evaluate(below, {0, 0.6f, -0.8f}).f_cos));
    CHECK(is_black(principled(p).evaluate(below, {0, 0.6f, 0.8f}).f_cos));
    CHECK(is_black(principled(p).evaluate({0.6f, 0, 0.8f}, below).f_cos));
    CHECK_FALSE(scatters(principled(p), below));
    CHECK_FALSE(scatters(principled(p), {1, 0, 0}));
  }
  Principled matched = kMetal;
  matched.eta = 1;
  CHECK(is_black(principled(matched).evaluate({0, 0, 1}, {0, 0, 1}).f_cos));
  const Principled black{{0, 0, 0, 0}, 0.5f, 0, 0, 0, 1, 1, 1, 1, 0, 0, 1.5f};
  const auto f = principled(black).evaluate({0.6f, 0, 0.8f}, {-0.6f, 0, 0.8f}).f_cos;
  CHECK(f.c0 > 0.0f);
  CHECK(f.c0 == f.c1);
}

TEST_CASE("principled: values are finite for all directions") {
  for (const Principled& p : kMaterials) check_bsdf_finite(principled(p));
  for (const Thin& p : kThinMaterials) check_bsdf_finite(thin(p));
  check_bsdf_finite(principled(kSmooth));
  check_bsdf_finite(principled({{0, 0, 0, 0}, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}));
}

TEST_CASE("principled: SIMD results equal scalar ones") {
  const auto fraction = [](int lane, int k) { return static_cast<float>((lane * 5 + k * 3) % 8) / 7.0f; };
  check_bsdf_lanes<PrincipledBsdf>([&](int lane) {
    const float roughness = 0.2f + 0.8f * fraction(lane, 3);
    return principled({{fraction(lane, 0), fraction(lane, 1), fraction(lane, 2), 0},
                       roughness,
                       fraction(lane, 4),
                       fraction(lane, 5),
                       fraction(lane, 6),
                       fraction(lane, 7),
                       fraction(lane, 8),
                       fraction(lane, 9),
                       fraction(lane, 10),
                       fraction(lane, 11),
                       0.5f * fraction(lane, 12),
                       0.6f + fraction(lane, 13)});
  });
  check_bsdf_lanes<PrincipledBsdf>([](int lane) { return principled(lane % 2 == 0 ? kDefault : kGlass); });
  check_bsdf_lanes<PrincipledThinBsdf>([&](int lane) {
    return thin({{fraction(lane, 0), fraction(lane, 1), fraction(lane, 2), 0},
                 0.2f + 0.8f * fraction(lane, 3),
                 fraction(lane, 4),
                 fraction(lane, 5),
                 0.8f + fraction(lane, 6),
                 fraction(lane, 7),
                 fraction(lane, 8),
                 fraction(lane, 9),
                 fraction(lane, 10),
                 2 * fraction(lane, 11)});
  });
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_principled
