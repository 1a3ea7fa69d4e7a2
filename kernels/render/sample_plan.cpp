// Divides samples into rounds and tasks, and adds the results of the tasks to the film.
#include "kernels/render/sample_plan.h"

#include "core/io/error.h"
#include "scene/scene.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Samples per pixel that adaptive sampling takes at once.
constexpr std::uint32_t kAdaptiveBatch = kTaskSamples / (kAdaptiveSide * kAdaptiveSide);

/// Photons per task, and tasks per round. The splats of a round are kept until it ends.
constexpr int kTaskPhotons = 16384, kRoundTasks = 64;

[[noreturn]] void refuse_checkpoint() {
  throw Error(ExitCode::kCheckpoint, "the checkpoint belongs to another render");
}

}  // namespace

SamplePlan::SamplePlan(const Scene& scene, const RenderSettings& settings, RenderState* resume)
    : settings_(settings),
      light_groups_(light_group_layers(scene, settings)),
      filter_weights_(scene.view().sensor.filter_weights) {
  state_.film = Film(settings.film.width, settings.film.height, settings.crop,
                     film_layout(settings.aovs, settings.has_variances, light_groups_.names), settings.spectral_bins,
                     settings.unit, settings.aovs.contains(AovSource::kSurfaceId));
  state_.division = settings;
  state_.first_sample = settings.range.first;
  if (settings.adapts) set_adaptive({settings.noise_target, settings.spp});
  if (settings.integrator.traits().connects_photons()) set_photons(scene);
  if (resume != nullptr) resume_from(*resume);
  is_trained_ = settings.training.empty() || state_.first_sample == settings.range.end();
}

void SamplePlan::set_adaptive(const AdaptiveGoal& goal) {
  tiles_ = make_tiles(settings_.sampled, kAdaptiveSide);
  std::vector<PixelRect> squares;
  for (const Tile& tile : tiles_) squares.push_back(tile.pixels);
  state_.adaptive.emplace(state_.film, squares, settings_.reach, goal);
}

/// Sets the number of photons, and allocates the film of their splats.
void SamplePlan::set_photons(const Scene& scene) {
  const int width = state_.film.width(), height = state_.film.height();
  // One photon per sample of the whole frame, so that a crop gets the same photons.
  const auto count = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) * settings_.spp;
  const bool splats = settings_.integrator.max_depth != 1 && scene.view().lights.count > 0;
  const bool is_panorama = scene.view().sensor.camera.rays == CameraRays::kSpherical;
  const PixelRect frame{0, 0, width, height};
  photons_.emplace(PhotonRounds{splats ? count : 0, SplatFilter(settings_.film.filter, settings_.film.filter_mode,
                                                                frame.grown(settings_.frame.border),
                                                                is_panorama ? static_cast<float>(width) : 0.0f)});
  state_.splats.emplace(settings_.crop);
}

void SamplePlan::resume_from(RenderState& from) {
  const bool same = from.film.width() == state_.film.width() && from.film.height() == state_.film.height() &&
                    from.film.crop() == state_.film.crop() && from.film.layout() == state_.film.layout() &&
                    from.film.spectral_bins() == state_.film.spectral_bins() &&
                    from.film.variance_unit() == state_.film.variance_unit() &&
                    from.film.has_surface_ids() == state_.film.has_surface_ids() &&
                    from.splats.has_value() == state_.splats.has_value() &&
                    from.adaptive.has_value() == state_.adaptive.has_value() &&
                    from.first_sample >= settings_.range.first && from.first_sample <= settings_.range.end() &&
                    from.photons <= photon_count();
  if (!same) refuse_checkpoint();
  const std::uint32_t taken = from.tiles.empty() ? from.first_sample : from.first_sample + 1;
  if (from.adaptive ? !(settings_ == from.division) : !begins_with(settings_, from.division, taken))
    refuse_checkpoint();
  state_ = std::move(from);
  state_.division = settings_;
  dropped_before_ = state_.dropped;
  if (state_.tiles.empty()) return;
  if (state_.adaptive || state_.first_sample == settings_.range.end()) refuse_checkpoint();
  begin_pass();
}

std::uint64_t SamplePlan::sample_total() const {
  const std::uint64_t others =
      training_samples(state_.film.width(), state_.film.height(), settings_.training) + photon_count();
  if (!state_.adaptive) return others + settings_.sampled.area() * settings_.range.count;
  double samples = 0;
  for (std::size_t i = 0; i < tiles_.size(); ++i)
    samples += state_.adaptive->expected_samples(i) * static_cast<double>(tiles_[i].sampled.area());
  return others + static_cast<std::uint64_t>(samples);
}

std::uint64_t SamplePlan::min_sample_total() const {
  std::uint64_t samples = training_samples(state_.film.width(), state_.film.height(), settings_.training);
  if (!state_.adaptive || may_end_early()) return samples;
  for (const AdaptiveUnit& unit : state_.adaptive->units()) samples += tiles_[unit.tile].sampled.area() * unit.samples;
  return samples;
}

std::uint64_t SamplePlan::samples_before() const {
  std::uint64_t samples = settings_.sampled.area() * (state_.first_sample - settings_.range.first) + state_.photons;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    if (state_.adaptive) samples += tiles_[i].sampled.area() * state_.adaptive->taken_samples(i);
    if (!state_.tiles.empty() && state_.tiles[i] != 0)
      samples += tiles_[i].sampled.area() * settings_.pass_samples(state_.first_sample);
  }
  return samples;
}

bool SamplePlan::begin_round() {
  if (!is_trained_) {
    round_ = RoundKind::kTraining;
    return true;
  }
  round_ = RoundKind::kCamera;
  if (state_.adaptive) return state_.adaptive->begin_round();
  if (state_.first_sample < settings_.range.end()) {
    begin_pass();
    return true;
  }
  round_ = RoundKind::kPhotons;
  if (state_.photons == photon_count()) return false;
  const std::uint64_t taken = std::min(photon_count() - state_.photons, std::uint64_t{kTaskPhotons} * kRoundTasks);
  photons_->splats.assign((taken + kTaskPhotons - 1) / kTaskPhotons, {});
  photons_->done.assign(photons_->splats.size(), 0);
  return true;
}

/// Begins the next pass, or continues the one of a checkpoint.
void SamplePlan::begin_pass() {
  tiles_ = make_tiles(settings_.sampled, tile_side(settings_.pass_samples(state_.first_sample)));
  // Without filter weights, tiles add nothing to each other.
  const std::size_t borders = filter_weights_ != nullptr ? tiles_.size() : 0;
  if (state_.tiles.empty()) {
    state_.tiles.assign(tiles_.size(), 0);
    state_.borders.assign(borders, {});
  }
  if (state_.tiles.size() != tiles_.size() || state_.borders.size() != borders) refuse_checkpoint();
}

void SamplePlan::end_pass() {
  const std::uint32_t end = state_.first_sample + settings_.pass_samples(state_.first_sample);
  state_.film.add(state_.borders);
  state_.tiles.clear();
  state_.borders.clear();
  if (end % settings_.replicate_samples == 0) state_.film.end_replicate();
  if (end == settings_.half_samples || (end == settings_.range.end() && end < settings_.half_samples))
    state_.film.end_first_half();
  state_.first_sample = end;
}

std::size_t SamplePlan::task_count() const {
  if (round_ == RoundKind::kTraining) return 0;
  if (round_ == RoundKind::kPhotons) return photons_->done.size();
  return state_.adaptive ? state_.adaptive->units().size() : tiles_.size();
}

bool SamplePlan::is_done(std::size_t task) const {
  if (round_ == RoundKind::kPhotons) return photons_->done[task] != 0;
  return (state_.adaptive ? state_.adaptive->units()[task].done : state_.tiles[task]) != 0;
}

TileTask SamplePlan::tile_task(std::size_t task) const {
  if (state_.adaptive) {
    const AdaptiveUnit& unit = state_.adaptive->units()[task];
    return {tiles_[unit.tile], unit.first_sample, unit.samples, kAdaptiveBatch, unit.set, 0};
  }
  const std::uint32_t first = state_.first_sample, count = settings_.pass_samples(first),
                      set = settings_.replicate_samples;
  return {tiles_[task], first, count, count, first / set, set};
}

PhotonTask SamplePlan::photon_task(std::size_t task) const {
  const std::uint64_t first = state_.photons + task * kTaskPhotons;
  return {first, static_cast<int>(std::min<std::uint64_t>(kTaskPhotons, photon_count() - first))};
}

void SamplePlan::begin_tile(const TileTask& task, FilmTile& tile) const {
  state_.film.begin(tile, task.tile.pixels, filter_weights_);
}

void SamplePlan::finish_tile(std::size_t task, const FilmTile& samples) {
  if (state_.adaptive) return state_.adaptive->add(task, samples);
  state_.film.add(samples);
  if (!state_.borders.empty()) state_.borders[task] = samples.border();
  state_.tiles[task] = 1;
}

void SamplePlan::finish_photons(std::size_t task, std::vector<Splat> splats) {
  photons_->splats[task] = std::move(splats);
  photons_->done[task] = 1;
}

bool SamplePlan::end_round() {
  for (std::size_t i = 0; i < task_count(); ++i)
    if (!is_done(i)) return false;
  if (round_ == RoundKind::kTraining)
    is_trained_ = true;
  else if (round_ == RoundKind::kPhotons)
    end_photons();
  else if (!state_.adaptive)
    end_pass();
  return true;
}

void SamplePlan::end_photons() {
  const PhotonTask last = photon_task(photons_->done.size() - 1);
  state_.splats->add(photons_->splats, photons_->filter);
  state_.photons = last.first + static_cast<std::uint64_t>(last.count);
}

const RenderState& SamplePlan::checkpoint(const Stats::Dropped& dropped) {
  if (state_.adaptive) state_.adaptive->assemble(state_.film);
  state_.dropped = dropped;
  return state_;
}

void SamplePlan::end(bool stopped) {
  if (state_.adaptive) {
    is_incomplete_ = stopped && state_.adaptive->begin_round();
    state_.adaptive->assemble(state_.film);
  } else {
    is_incomplete_ = state_.first_sample < settings_.range.end() || state_.photons < photon_count();
  }
}

void SamplePlan::complete_film() {
  if (state_.adaptive) return;
  state_.film.add(state_.borders);
  state_.film.end_replicate();
}

}  // namespace sheaf
