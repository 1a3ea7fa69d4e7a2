// Perlin noise ("Improving Noise", SIGGRAPH 2002) and the density of pbrt's cloud medium.
#include "scene/dialects/pbrt/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace sheaf::pbrt {

namespace {

/// Perlin's permutation of 0 to 255.
constexpr std::uint8_t kPermutation[256] = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,  69,  142,
    8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,  94,  252, 219, 203,
    117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136, 171, 168, 68,  175, 74,  165,
    71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122, 60,  211, 133, 230, 220, 105, 92,  41,
    55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161, 1,   216, 80,  73,  209, 76,  132, 187, 208, 89,
    18,  169, 200, 196, 135, 130, 116, 188, 159, 86,  164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250,
    124, 123, 5,   202, 38,  147, 118, 126, 255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189,
    28,  42,  223, 183, 170, 213, 119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,
    129, 22,  39,  253, 19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,
    242, 193, 238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,  222, 114,
    67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

std::uint8_t permuted(int i) { return kPermutation[static_cast<unsigned>(i) & 255u]; }

/// Dot product of a lattice corner's gradient and the vector from the corner to the point.
double slope(int cell_x, int cell_y, int cell_z, double x, double y, double z) {
  const unsigned hash = permuted(permuted(permuted(cell_x) + cell_y) + cell_z) & 15u;
  const double u = hash < 8 || hash == 12 || hash == 13 ? x : y;
  const double v = hash < 4 || hash == 12 || hash == 13 ? y : z;
  return ((hash & 1u) != 0 ? -u : u) + ((hash & 2u) != 0 ? -v : v);
}

double fade(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

/// step size for finite differences of the noise
constexpr double kSlopeStep = 0.01;

}  // namespace

double noise(double x, double y, double z) {
  const double at[3] = {x, y, z};
  int cell[3];
  double inside[3], weight[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double whole = std::floor(at[axis]);
    cell[axis] = static_cast<int>(std::fmod(whole, 256.0));
    inside[axis] = at[axis] - whole;
    weight[axis] = fade(inside[axis]);
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const double factor = (i != 0 ? weight[0] : 1 - weight[0]) * (j != 0 ? weight[1] : 1 - weight[1]) *
                          (k != 0 ? weight[2] : 1 - weight[2]);
    sum += factor * slope(cell[0] + i, cell[1] + j, cell[2] + k, inside[0] - i, inside[1] - j, inside[2] - k);
  }
  return sum;
}

double cloud_density(const CloudShape& cloud, double x, double y, double z) {
  // Displace the point by the gradient of finer noise
  double p[3] = {cloud.frequency * x, cloud.frequency * y, cloud.frequency * z};
  if (cloud.wispiness > 0) {
    double shift = 0.05 * cloud.wispiness, scale = 10;
    for (int octave = 0; octave < 2; ++octave, shift *= 0.5, scale *= 1.99) {
      const double q[3] = {scale * p[0], scale * p[1], scale * p[2]}, here = noise(q[0], q[1], q[2]);
      p[0] += shift * (noise(q[0] + kSlopeStep, q[1], q[2]) - here) / kSlopeStep;
      p[1] += shift * (noise(q[0], q[1] + kSlopeStep, q[2]) - here) / kSlopeStep;
      p[2] += shift * (noise(q[0], q[1], q[2] + kSlopeStep) - here) / kSlopeStep;
    }
  }
  // Sum octaves, and thin the cloud with y
  double sum = 0, factor = 0.5, scale = 1;
  for (int octave = 0; octave < 5; ++octave, factor *= 0.5, scale *= 1.99)
    sum += factor * noise(scale * p[0], scale * p[1], scale * p[2]);
  const double thinned = std::clamp((1 - y) * 4.5 * cloud.density * sum, 0.0, 1.0);
  return std::clamp(thinned + 2 * std::max(0.0, 0.5 - y), 0.0, 1.0);
}

}  // namespace sheaf::pbrt
