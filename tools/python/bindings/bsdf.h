// Values and samples of the BSDF of a material, as arrays.
#pragma once

#include "core/math/vec.h"
#include "scene/scene.h"

#include <string>
#include <vector>

namespace sheaf {

/// Values of a BSDF for pairs of directions.
struct BsdfValues {
  std::vector<Vec3f> f_cos;  ///< f |cos(wi)|, linear RGB
  std::vector<float> pdf;    ///< of sampling wi, per solid angle; without delta lobes
};

/// Directions sampled from a BSDF.
struct BsdfSamples {
  std::vector<Vec3f> wi;         ///< zero if absorbed
  std::vector<Vec3f> weight;     ///< f |cos(wi)| / pdf, linear RGB; zero if absorbed
  std::vector<float> pdf;        ///< per solid angle; 0 for delta lobes and if absorbed
  std::vector<float> eta_scale;  ///< 1, or the squared relative index of the medium entered
  std::vector<unsigned char> valid;
};

/// The row of the material with this name. Throws Error (exit code 2): no shape of the scene has it.
std::uint32_t material_row(const Scene& scene, const std::string& name);

/// Evaluates the BSDF of a material of an RGB scene, with the parameters of its row. Directions are unit vectors in the
/// shading frame and point away from the surface; `wi` is as long as `wo`. Throws Error (exit code 2) if textures or
/// maps vary it.
BsdfValues evaluate_bsdf(const Scene& scene, std::uint32_t row, const std::vector<Vec3f>& wo,
                         const std::vector<Vec3f>& wi);

/// Samples it. `u`: uniform numbers in [0, 1), three per direction.
BsdfSamples sample_bsdf(const Scene& scene, std::uint32_t row, const std::vector<Vec3f>& wo,
                        const std::vector<Vec3f>& u);

}  // namespace sheaf
