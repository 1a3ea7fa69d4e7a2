// The context of a stage: all that it reads besides its wave.
#pragma once

#include "kernels/guiding/candidate_moments.h"
#include "kernels/guiding/guide_view.h"
#include "scene/scene.h"

#include <cassert>

namespace sheaf {

class CameraTask;
class LightTask;
class CausticCasters;
class TrainingSamples;
struct PhotonMaps;

/// The quantity that a pass transports, and where its paths start.
enum class PassKind {
  kPath,    ///< radiance along paths from the camera to the film
  kLight,   ///< importance along paths from the lights, whose vertices are connected to the camera
  kPhoton,  ///< photons from the lights, which are stored
  kDebug,   ///< plain values of the first surface, such as normals; no media
};

/// The scene, the settings of the pass, and the data that its kind of pass adds. One per task. Stages do not modify it,
/// except through its references to the task and the training samples.
class StageContext {
 public:
  /// A pass from the camera: kPath, or kDebug if the integrator transports no light. `settings` must outlive it.
  StageContext(const Scene& of, const IntegratorSettings& settings)
      : scene(of.view()),
        integrator(settings),
        sampler(of.sampler_view()),
        max_depth(settings.max_depth),
        candidates(settings.candidates.value_or(1)),
        pass_(settings.traits().uses_lights() ? PassKind::kPath : PassKind::kDebug) {}
  /// The same with the settings of the scene.
  explicit StageContext(const Scene& of) : StageContext(of, of.integrator()) {}
  /// The same for one task.
  StageContext(const Scene& of, CameraTask& task) : StageContext(of) { set_camera_task(task); }

  const SceneView& scene;
  const IntegratorSettings& integrator;
  SamplerView sampler;
  /// Maximum depth of the pass's paths; see IntegratorSettings::max_depth, which it may be below.
  int max_depth;
  int candidates;  ///< light candidates per vertex, of which RIS keeps one
  /// Number in [0, 1) from which the wavelengths of all paths are derived; -1: each path draws its own.
  float wavelength_sample = -1;

  PassKind pass() const { return pass_; }
  bool transports_light() const { return pass_ != PassKind::kDebug; }
  bool starts_at_lights() const { return pass_ == PassKind::kLight || pass_ == PassKind::kPhoton; }
  /// Whether camera paths look up photons in photon_maps().
  bool gathers_photons() const { return gathers_photons_; }
  /// Whether camera paths sample directions from the guide() as well as from BSDFs.
  bool samples_guide() const { return samples_guide_; }
  /// Whether camera paths record training_samples() for the guide.
  bool trains_guide() const { return trains_guide_; }
  /// Whether the pass compares numbers of light candidates; see kernels/guiding/candidate_moments.h.
  bool compares_candidates() const { return compares_candidates_; }
  /// Whether camera paths are connected to lights by specular chains (kernels/stages/chain_state.h).
  bool connects_caustics() const { return caustic_casters_ != nullptr; }

  /// Passes from the camera: sets the samples to take.
  void set_camera_task(CameraTask& task) { camera_task_ = &task; }
  /// Path passes: gathers photons from `maps`.
  void gather_from(const PhotonMaps& maps) {
    gathers_photons_ = true;
    photon_maps_ = &maps;
  }
  /// Path passes: samples directions from `guide` as well.
  void sample_from(const GuideView& guide) {
    samples_guide_ = true;
    guide_ = guide;
  }
  /// Path passes: samples directions from BSDFs only.
  void sample_bsdfs_only() { samples_guide_ = false; }
  /// Path passes: records samples for the guide in `samples`.
  void record_in(TrainingSamples& samples) {
    trains_guide_ = true;
    training_samples_ = &samples;
  }
  /// Path passes that record training samples: also compares numbers of light candidates, with kMaxComparedCandidates
  /// of them.
  void start_candidate_comparison() {
    compares_candidates_ = true;
    candidates = kMaxComparedCandidates;
  }
  /// Path passes without media and transparency: connects paths to lights by specular chains over `casters`.
  void connect_caustics(const CausticCasters& casters) {
    assert(!scene.needs_transmittance && !gathers_photons_);
    caustic_casters_ = &casters;
  }
  /// Turns the pass into one from the lights, kLight or kPhoton, which emits the photons of `task`.
  void start_at_lights(PassKind kind, LightTask& task) {
    pass_ = kind;
    light_task_ = &task;
    gathers_photons_ = samples_guide_ = trains_guide_ = compares_candidates_ = false;
    caustic_casters_ = nullptr;
  }

  /// Passes from the camera: the samples to take, and their results.
  CameraTask& camera_task() const {
    assert(!starts_at_lights() && camera_task_ != nullptr);
    return *camera_task_;
  }
  /// Passes from the lights: the photons to emit, and their results.
  LightTask& light_task() const {
    assert(starts_at_lights());
    return *light_task_;
  }
  /// The photon maps. Requires gathers_photons().
  const PhotonMaps& photon_maps() const {
    assert(gathers_photons_);
    return *photon_maps_;
  }
  /// The guide. Requires samples_guide().
  const GuideView& guide() const {
    assert(samples_guide_);
    return guide_;
  }
  /// The training samples. Requires trains_guide().
  TrainingSamples& training_samples() const {
    assert(trains_guide_);
    return *training_samples_;
  }
  /// The surfaces that cast caustics. Requires connects_caustics().
  const CausticCasters& caustic_casters() const {
    assert(connects_caustics());
    return *caustic_casters_;
  }

 private:
  PassKind pass_;
  bool gathers_photons_ = false, samples_guide_ = false, trains_guide_ = false, compares_candidates_ = false;
  CameraTask* camera_task_ = nullptr;
  LightTask* light_task_ = nullptr;
  const PhotonMaps* photon_maps_ = nullptr;
  GuideView guide_;
  TrainingSamples* training_samples_ = nullptr;
  const CausticCasters* caustic_casters_ = nullptr;
};

/// Whether next-event estimation is used.
inline bool samples_lights(const StageContext& context) {
  return context.scene.lights.count > 0 && context.integrator.strategy != LightStrategy::kBsdfOnly;
}

/// Whether paths in media are connected to lights by segments of their rays; see kernels/stages/segment_lights.cpp.
inline bool connects_segments(const StageContext& context) {
  const SceneView& scene = context.scene;
  return context.pass() == PassKind::kPath && scene.media.connects_segments && scene.lights.tree.node_count > 0 &&
         samples_lights(context) && !context.gathers_photons() &&
         context.integrator.medium_estimator != MediumEstimator::kMarching && scene.motion.media == nullptr;
}

/// Whether vertices in such media sample directions towards lights; see kernels/guiding/glow_lobes.h.
inline bool samples_glow(const StageContext& context) {
  return connects_segments(context) && !context.samples_guide() && context.scene.lights.tree.glow_source_count > 0;
}
/// Whether vertices sample directions other than from their BSDFs.
inline bool guides_directions(const StageContext& context) { return context.samples_guide() || samples_glow(context); }

/// Whether the candidates of a vertex share a cut of the light tree. Worthwhile from 4 candidates and 32 lights.
inline bool shares_light_cut(const StageContext& context) {
  constexpr int kMinCandidates = 4;
  constexpr std::uint32_t kMinLights = 32;
  return context.candidates >= kMinCandidates && context.scene.light_selector == LightSelector::kBvh &&
         context.scene.lights.bounded_count >= kMinLights;
}

}  // namespace sheaf
