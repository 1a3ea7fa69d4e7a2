// EM for mixtures of von Mises-Fisher lobes and a BSDF; see fit_mixture.h.
#include "kernels/guiding/fit_mixture.h"

#include "core/sampling/octahedral.h"
#include "core/soa/lane_array.h"

namespace sheaf {

namespace {

/// EM iterations per training pass.
constexpr int kRounds = 3;
/// Factor on the earlier passes' effective sample counts.
constexpr float kMemory = 0.5f;
/// Maximum fraction of the total weight that one record may have.
constexpr double kLargestPart = 0.01;
/// Priors, in effective samples: on the weight of each lobe, on each lobe being isotropic, and on equal weights of BSDF
/// and lobes.
constexpr float kLobeWeightPrior = 0.05f, kEvenPrior = 0.1f, kBsdfPrior = 4;
/// Bounds on the weight of the BSDF: the lobes may have missed light, and the BSDF may hardly ever find it.
constexpr float kMinBsdf = 0.3f, kMaxBsdf = 0.95f;
/// Initial concentration of the lobes on a hemisphere: roughly that of evenly spread lobes.
constexpr float kFirstKappa = 8;

/// Training samples, one per lane of a register.
struct alignas(64) Samples {
  float x[kWidth] = {}, y[kWidth] = {}, z[kWidth] = {};
  float weight[kWidth] = {};  ///< effective sample count
  float bsdf_pdf[kWidth] = {};
};

/// Factor that turns weights into effective sample counts: their sum becomes the number of equal weights with the same
/// variance (Kish 1965). `largest`: output, the bound to which weights are clamped.
float weight_scale(std::span<const GuideRecord> records, float& largest) {
  double sum = 0, squares = 0;
  for (const GuideRecord& r : records) sum += double{r.weight};
  largest = static_cast<float>(sum * kLargestPart);
  sum = 0;
  for (const GuideRecord& r : records) {
    const double w = std::min(r.weight, largest);
    sum += w;
    squares += w * w;
  }
  return squares > 0 ? static_cast<float>(sum / squares) : 0.0f;
}

std::vector<Samples> samples_of(std::span<const GuideRecord> records) {
  float largest = 0;
  const float scale = weight_scale(records, largest);
  std::vector<Samples> out((records.size() + kWidth - 1) / kWidth);
  for (std::size_t i = 0; i < records.size(); ++i) {
    Samples& to = out[i / kWidth];
    const std::size_t lane = i % kWidth;
    const Vec3f d = decode_octahedral<Scalar>(records[i].direction);
    to.x[lane] = d.x, to.y[lane] = d.y, to.z[lane] = d.z;
    to.weight[lane] = std::min(records[i].weight, largest) * scale;
    to.bsdf_pdf[lane] = records[i].bsdf_pdf;
  }
  return out;
}

/// GuideSums in registers.
struct WideSums {
  static constexpr int kRegisters = kGuideLobes / kWidth;
  WideFloat count[kRegisters], x[kRegisters], y[kRegisters], z[kRegisters];

  SHEAF_INLINE void add(const float (&parts)[kGuideLobes], float weight, Vec3f d) {
    for (int k = 0; k < kRegisters; ++k) {
      WideFloat part;
      load(parts + k * kWidth, part);
      part *= WideFloat(weight);
      count[k] += part;
      x[k] = fma(part, WideFloat(d.x), x[k]);
      y[k] = fma(part, WideFloat(d.y), y[k]);
      z[k] = fma(part, WideFloat(d.z), z[k]);
    }
  }
  GuideSums rows() const {
    GuideSums out;
    for (int k = 0; k < kRegisters; ++k) {
      store(out.count + k * kWidth, count[k]);
      store(out.x + k * kWidth, x[k]), store(out.y + k * kWidth, y[k]), store(out.z + k * kWidth, z[k]);
    }
    return out;
  }
};

/// E step: sums the responsibilities of each lobe and of the BSDF.
GuideSums expectation(const GuideMixture& mixture, const std::vector<Samples>& samples) {
  WideSums sums;
  WideFloat of_bsdf;
  const float a = mixture.bsdf_probability;
  for (const Samples& s : samples) {
    alignas(64) float parts[kWidth][kGuideLobes];
    for (int lane = 0; lane < kWidth; ++lane) lobe_parts(mixture, {s.x[lane], s.y[lane], s.z[lane]}, parts[lane]);
    WideFloat bsdf_pdf, weight;
    load(s.bsdf_pdf, bsdf_pdf), load(s.weight, weight);
    const WideFloat bsdf = bsdf_pdf * WideFloat(a);
    const WideFloat pdf = fma(sum_parts<Wide>(parts), WideFloat(1 - a), bsdf);
    const WideFloat per_pdf = weight / max(pdf, WideFloat(1e-20f));
    of_bsdf += bsdf * per_pdf;
    const LaneArray factor(per_pdf * WideFloat(1 - a));
    for (int lane = 0; lane < kWidth; ++lane) sums.add(parts[lane], factor[lane], {s.x[lane], s.y[lane], s.z[lane]});
  }
  GuideSums out = sums.rows();
  for (const float bsdf : LaneArray(of_bsdf)) out.bsdf += bsdf;
  return out;
}

/// Returns `fraction` * `a` + `b`.
GuideSums weighted_sum(const GuideSums& a, float fraction, const GuideSums& b) {
  GuideSums out;
  for (int k = 0; k < kGuideLobes; ++k) {
    out.count[k] = a.count[k] * fraction + b.count[k];
    out.x[k] = a.x[k] * fraction + b.x[k];
    out.y[k] = a.y[k] * fraction + b.y[k];
    out.z[k] = a.z[k] * fraction + b.z[k];
  }
  out.bsdf = a.bsdf * fraction + b.bsdf;
  return out;
}

/// Sets peaks and cumulative weights from unnormalized weights.
void set_lobe_weights(GuideMixture& mixture, const float (&weights)[kGuideLobes]) {
  double sum = 0, below = 0;
  for (const float s : weights) sum += double{s};
  for (int k = 0; k < kGuideLobes; ++k) {
    const double fraction = double{weights[k]} / sum;
    below += fraction;
    mixture.peak[k] = static_cast<float>(fraction) * lobe_peak(mixture.kappa[k]);
    mixture.below[k] = static_cast<float>(below);
  }
  mixture.below[kGuideLobes - 1] = 1;
}

/// M step: the mixture of maximum likelihood for these sums. The concentration is that of Banerjee et al., "Clustering
/// on the Unit Hypersphere using von Mises-Fisher Distributions", 2005, equation 4.4.
void maximization(const GuideSums& sums, GuideMixture& mixture) {
  float weights[kGuideLobes], lobes = 0;
  for (int k = 0; k < kGuideLobes; ++k) {
    lobes += sums.count[k];
    weights[k] = sums.count[k] + kLobeWeightPrior;
    const Vec3f sum{sums.x[k], sums.y[k], sums.z[k]};
    const float along = length(sum);
    if (!(along > 1e-6f)) continue;
    mixture.x[k] = sum.x / along, mixture.y[k] = sum.y / along, mixture.z[k] = sum.z / along;
    const float mean = std::min(along / (sums.count[k] + kEvenPrior), 0.99999f);
    mixture.kappa[k] = clamp(mean * (3 - mean * mean) / (1 - mean * mean), kMinKappa, kMaxKappa);
  }
  set_lobe_weights(mixture, weights);
  mixture.bsdf_probability = clamp((sums.bsdf + kBsdfPrior) / (sums.bsdf + lobes + 2 * kBsdfPrior), kMinBsdf, kMaxBsdf);
}

}  // namespace

GuideMixture first_mixture(Vec3f axis) {
  const bool half = length(axis) > 0;
  const Frame<Scalar> frame = Frame<Scalar>::from_normal(half ? axis : Vec3f{0, 0, 1});
  GuideMixture out;
  float weights[kGuideLobes];
  for (int k = 0; k < kGuideLobes; ++k) {
    // Evenly spaced directions on a spiral (Vogel 1979).
    const float u = (static_cast<float>(k) + 0.5f) / kGuideLobes, z = half ? 1 - u : 1 - 2 * u;
    const float azimuth = 0.61803398875f * static_cast<float>(k), r = std::sqrt(1 - z * z);
    const auto angle = sincos_2pi<Scalar>(azimuth - std::floor(azimuth));
    const Vec3f d = frame.to_world({r * angle.cos, r * angle.sin, z});
    out.x[k] = d.x, out.y[k] = d.y, out.z[k] = d.z;
    out.kappa[k] = half ? kFirstKappa : 0.5f * kFirstKappa;
    weights[k] = 1;
  }
  set_lobe_weights(out, weights);
  out.bsdf_probability = 0.5f;
  return out;
}

void fit_mixture(std::span<const GuideRecord> records, GuideMixture& mixture, GuideSums& sums) {
  const std::vector<Samples> samples = samples_of(records);
  GuideSums found;
  for (int round = 0; round < kRounds; ++round) {
    found = weighted_sum(sums, kMemory, expectation(mixture, samples));
    maximization(found, mixture);
  }
  sums = found;
}

void halve(GuideSums& sums) { sums = weighted_sum(sums, 0.5f, {}); }

}  // namespace sheaf
