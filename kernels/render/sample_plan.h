// The plan of a render: the samples that remain to be taken.
//
// A render is a sequence of rounds. The tasks of a round may run in any order and on any number of threads, and all of
// them end before the next round begins. There are rounds of training samples, from which only the guide learns; of
// camera samples, which are passes with equally many samples for all pixels or rounds of adaptive sampling; and of
// photons that light tracing connects to the camera. Checkpoints are the state of the plan.
#pragma once

#include "kernels/render/light_group_layers.h"
#include "kernels/render/render_settings.h"
#include "kernels/render/render_state.h"
#include "kernels/render/tiles.h"

namespace sheaf {

enum class RoundKind { kTraining, kCamera, kPhotons };

/// A task of a camera round: the samples [first_sample, first_sample + sample_count) of each pixel of a tile.
struct TileTask {
  Tile tile;
  std::uint32_t first_sample = 0, sample_count = 0;
  std::uint32_t samples_at_once = 0;                   ///< per pixel, of each camera task that the task consists of
  std::uint32_t replicate = 0, replicate_samples = 0;  ///< see sampler_of_replicate()
};

/// A task of a photon round: the photons [first, first + count).
struct PhotonTask {
  std::uint64_t first = 0;
  int count = 0;
};

class SamplePlan {
 public:
  /// The plan of a new render, or of the rest of `resume`, which is moved from; null: a new one. Throws Error
  /// (checkpoint) if that state belongs to another render.
  SamplePlan(const Scene& scene, const RenderSettings& settings, RenderState* resume = nullptr);

  const RenderSettings& settings() const { return settings_; }
  const LightGroupLayers& light_groups() const { return light_groups_; }
  const RenderState& state() const { return state_; }
  /// Number of samples and photons of the whole render; an estimate in adaptive sampling.
  std::uint64_t sample_total() const;
  /// Whether sample_total() is an estimate rather than an upper bound; see AdaptiveFilm::has_estimates().
  bool knows_sample_total() const { return !state_.adaptive || state_.adaptive->has_estimates(); }
  /// Number of samples before which may_end_early() is false, in adaptive sampling.
  std::uint64_t min_sample_total() const;
  /// Number of samples and photons taken before the render was resumed.
  std::uint64_t samples_before() const;
  /// Whether the time limit may end the render: every tile has samples, and adaptive sampling decides their number.
  bool may_end_early() const { return state_.adaptive && state_.adaptive->has_image(); }

  /// Begins the next round, or continues an unfinished one. Returns false if no samples remain.
  bool begin_round();
  RoundKind round() const { return round_; }
  /// Number of tasks of the round. The plan does not divide training into tasks.
  std::size_t task_count() const;
  /// Whether a task is finished. Different threads may finish different tasks concurrently.
  bool is_done(std::size_t task) const;
  TileTask tile_task(std::size_t task) const;
  PhotonTask photon_task(std::size_t task) const;
  /// Begins the worker's tile for the samples of a task.
  void begin_tile(const TileTask& task, FilmTile& tile) const;
  /// Film positions that splats may have.
  SplatFilter::Bounds splat_bounds() const { return photons_->filter.bounds(settings_.crop); }
  /// Finishes a task with its samples, or with its splats.
  void finish_tile(std::size_t task, const FilmTile& samples);
  void finish_photons(std::size_t task, std::vector<Splat> splats);
  /// Ends the round if all of its tasks are done; returns whether they are.
  bool end_round();

  /// The state for a checkpoint. `dropped`: by all renders since the first.
  const RenderState& checkpoint(const Stats::Dropped& dropped);
  /// Dropped rays and samples before the render was resumed.
  const Stats::Dropped& dropped_before() const { return dropped_before_; }
  /// Ends sampling: no rounds follow. `stopped`: by RenderControl::stop.
  void end(bool stopped);
  /// After end(): whether the render was stopped before all samples were taken.
  bool is_incomplete() const { return is_incomplete_; }
  /// Call this after the last checkpoint: adds the samples of an unfinished pass to the film.
  void complete_film();
  RenderState take_state() { return std::move(state_); }

 private:
  /// Light tracing: the photons of the render, and the tasks of the current round.
  struct PhotonRounds {
    std::uint64_t count;  ///< number of photons to emit
    SplatFilter filter;
    std::vector<std::vector<Splat>> splats = {};  ///< of each task
    std::vector<std::uint8_t> done = {};          ///< 1 for tasks that are done
  };

  std::uint64_t photon_count() const { return photons_ ? photons_->count : 0; }
  void set_photons(const Scene& scene);
  void set_adaptive(const AdaptiveGoal& goal);
  void resume_from(RenderState& from);
  void begin_pass();
  void end_pass();
  void end_photons();

  const RenderSettings settings_;
  LightGroupLayers light_groups_;
  const FilterWeights* filter_weights_;  ///< optional: see SensorView::filter_weights
  RenderState state_;
  Stats::Dropped dropped_before_;
  RoundKind round_ = RoundKind::kCamera;
  bool is_incomplete_ = false;
  bool is_trained_ = false;  ///< or training is not needed
  std::vector<Tile> tiles_;  ///< of the pass, or of adaptive sampling
  std::optional<PhotonRounds> photons_;
};

}  // namespace sheaf
