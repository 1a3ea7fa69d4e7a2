// Settings of film, sampler and integrator, as scene files give them and as kernels read them.
#pragma once

#include "core/image/pixel_rect.h"
#include "core/math/transform.h"
#include "core/sampling/sampler.h"
#include "scene/tables/filter.h"
#include "scene/tables/integrator_list.h"
#include "scene/tables/photon_settings.h"

#include <cstdint>
#include <optional>

namespace sheaf {

struct FilmSettings {
  int width = 768, height = 576;
  std::optional<PixelRect> crop;
  PixelFilter filter;
  FilterMode filter_mode = FilterMode::kWeighted;
  /// kWeighted: also take samples around the frame, within the filter's radius. Otherwise pixels at the border use only
  /// the part of the filter inside the frame. kImportance always covers the whole filter.
  bool sample_border = false;
};

struct SamplerSettings {
  SamplerKind kind = SamplerKind::kSobol;
  std::uint32_t sample_count = 4;  ///< per pixel
  std::uint32_t seed = 0;
};

/// Selection of a light for sampling.
enum class LightSelector {
  kUniform,  ///< with equal probability
  kPower,    ///< by power
  kBvh,      ///< by a bound on the contribution to the point, with a light tree (Conty Estevez and Kulla 2018)
};
/// Estimator of distances in media and of transmittance.
enum class MediumEstimator {
  kNullMis,   ///< null-scattering path integral with MIS over wavelengths (Miller et al. 2019)
  kDelta,     ///< delta tracking for both, with one wavelength's extinction
  kRatio,     ///< delta tracking for distances, ratio tracking for transmittance, with one wavelength's extinction
  kMarching,  ///< ray marching in equal steps for both; biased
};
/// Maximum number of light candidates per vertex.
inline constexpr int kMaxCandidates = 1024;

struct IntegratorSettings {
  /// A name of kIntegrators, as the scene or the user gives it; null: the name of the kind.
  const char* given_name = nullptr;
  IntegratorKind kind = IntegratorKind::kPath;
  LightStrategy strategy = LightStrategy::kMis;
  int max_depth = -1;           ///< -1 unlimited, 1 emission only, 2 direct light, ...
  std::optional<int> rr_depth;  ///< overrides the default of roulette_depth()
  LightSelector light_selector = LightSelector::kBvh;
  /// Light candidates per vertex, of which RIS keeps one; in [1, kMaxCandidates]. Empty: the number that the training
  /// passes of guiding recommend, or 1 without them.
  std::optional<int> candidates;
  bool hide_emitters = false;    ///< lights are invisible to camera rays (alpha 0)
  bool ends_at_diffuse = false;  ///< paths continue only at mirrors and smooth glass (Whitted 1980)
  /// Transmission through thin dielectrics does not cost depth (Mitsuba's volpath)
  bool thin_dielectrics_are_free = false;
  MediumEstimator medium_estimator = MediumEstimator::kNullMis;
  float step_size = 0;                  ///< kMarching: meters; 0: 1/100 of the diagonal of the medium's bounding box
  float visibility_length = kInfinity;  ///< kVisibility: meters within which surfaces occlude
  PhotonMappingSettings photons;        ///< for kPhotonMapper

  const IntegratorTraits& traits() const { return traits_of(kind); }
  /// Name for reports and messages.
  std::string name() const { return given_name != nullptr ? given_name : traits().name; }
  /// Depth from which Russian roulette applies.
  int roulette_depth() const { return rr_depth.value_or(traits().roulette_depth); }
};

/// The settings that scenes have.
struct SceneSettings {
  FilmSettings film;
  SamplerSettings sampler;
  IntegratorSettings integrator;
};

}  // namespace sheaf
