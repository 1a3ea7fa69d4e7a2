#include "kernels/passes/render.h"

#include "core/error.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/passes/passes.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/passes/render_report.h"
#include "kernels/passes/tiles.h"
#include "kernels/passes/train_guiding.h"
#include "kernels/passes/worker.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cmath>
#include <thread>

namespace sheaf {

namespace {

/// Camera samples per task: enough that refilling dwarfs draining, few enough that the buffer stays in the caches.
constexpr int kTaskSamples = 16384;
/// Most samples per pixel and pass; passes are separated by a barrier, within one a tile has one owner.
constexpr std::uint32_t kPassSamples = 256;

/// Side of the tiles of adaptive sampling, pixels, and their samples per pixel and task.
constexpr int kAdaptiveSide = 32;
constexpr std::uint32_t kUnitSamples = 16;

/// Replicates where they cost nothing.
constexpr std::uint32_t kFreeReplicates = 8;

/// Most samples per pixel that gather rays may make.
constexpr std::uint32_t kMostSamples = 1 << 24;
/// Photons per task, and tasks whose splats are kept until they are added to the film.
constexpr int kTaskPhotons = 16384, kRoundTasks = 64;

PixelRect checked_crop(const Scene& scene, const RenderOptions& options) {
  const FilmDescription& film = scene.film();
  const PixelRect whole{0, 0, film.width, film.height};
  const PixelRect crop = options.crop ? *options.crop : film.crop ? *film.crop : whole;
  if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > film.width || crop.y1 > film.height || crop.width() <= 0 ||
      crop.height() <= 0)
    throw Error(ExitCode::kUsage, "crop must be a rectangle inside the frame of " + std::to_string(film.width) + " x " +
                                      std::to_string(film.height) + " pixels");
  return crop;
}

/// Adds a finished task's samples to its tile, every pixel's in order.
void reduce(const CameraTask& task, FilmTile& tile) {
  std::size_t sample = 0;
  for (const PixelSamples& p : task.pixels()) {
    const int x = task.frame().x(p.pixel), y = task.frame().y(p.pixel);
    for (std::uint32_t i = 0; i < p.sample_count; ++i, ++sample) tile.add(x, y, task.samples, sample);
  }
}

void check_spectral_bins(const Scene& scene, int bins) {
  if (bins == 0) return;
  if (bins < 0 || bins > kMaxSpectralBins)
    throw Error(ExitCode::kUsage, "spectral bins must be from 1 to " + std::to_string(kMaxSpectralBins));
  if (scene.color() != ColorMode::kSpectral || scene.integrator().kind != IntegratorKind::kPath)
    throw Error(ExitCode::kUsage,
                "spectral bins need spectral mode and an integrator that follows light from the camera");
}

/// Samples per pixel unless told otherwise.
std::uint32_t default_samples(const Scene& scene) {
  const IntegratorDescription& integrator = scene.integrator();
  const bool passes = integrator.kind == IntegratorKind::kPhotonMapper && integrator.photons.progressive;
  if (passes && integrator.photons.max_passes > 0) return static_cast<std::uint32_t>(integrator.photons.max_passes);
  return scene.sampler().sample_count;
}

void check_guiding(const IntegratorDescription& integrator) {
  if (integrator.kind == IntegratorKind::kPath && !integrator.ends_at_diffuse) return;
  throw Error(ExitCode::kUsage, "guiding needs an integrator that follows paths from the camera, such as path; " +
                                    integrator_name(integrator) + " is none");
}

/// The scene's own settings, and what its integrator makes of them.
StageContext context_of(const Scene& scene, const RenderOptions& options) {
  StageContext context(scene);
  if (options.guiding) check_guiding(context.transport);
  context.guides = options.guiding;
  // Hidden lights must let photons' rays to the camera pass.
  if (context.transport.kind == IntegratorKind::kLightTracer && context.transport.hide_emitters)
    context.scene.has_transparency = true;
  return context;
}

/// One render in progress.
class Renderer {
 public:
  Renderer(const Scene& scene, const RenderOptions& options)
      : scene_(scene),
        context_(context_of(scene, options)),
        needs_(WaveNeeds::of(context_)),
        options_(options),
        spp_(rounded_sample_count(scene.sampler().kind, options.samples_per_pixel.value_or(default_samples(scene)))),
        threads_(options.threads > 0 ? options.threads
                                     : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))),
        wave_size_(options.wave_size > 0 ? options.wave_size : Wave::default_capacity(needs_)) {
    const bool maps_photons = context_.transport.kind == IntegratorKind::kPhotonMapper;
    if (maps_photons) {
      const PhotonMappingDescription& mapping = context_.transport.photons;
      const auto rays =
          static_cast<std::uint32_t>(mapping.gathering == PhotonGathering::kFinal ? mapping.gather_rays : 1);
      if (spp_ > kMostSamples / rays)
        throw Error(ExitCode::kUsage,
                    "samples per pixel times gather rays must be at most " + std::to_string(kMostSamples));
      spp_ *= rays;
      rays_ = rays;
    }
    if (spp_ == 0) throw Error(ExitCode::kUsage, "samples per pixel must be at least 1");
    if (wave_size_ > kMaxWaveSize)
      throw Error(ExitCode::kUsage, "wave size must be at most " + std::to_string(kMaxWaveSize));
    const PixelRect crop = checked_crop(scene, options);
    check_spectral_bins(scene, options.spectral_bins);
    set_film(scene, crop);
    set_adaptive(scene);
    set_range();
    context_.sampler = make_sampler(scene.sampler().kind, options.seed.value_or(scene.sampler().seed),
                                    replicate_samples_, static_cast<std::uint32_t>(frame_.row_length()));
    total_ = wanted_.area() * range_.count;
    context_.guide = guide_.view();
    if (options.guiding) training_passes_ = training_passes(state_.film.width(), state_.film.height(), spp_);
    total_ += training_samples(state_.film.width(), state_.film.height(), training_passes_);
    if (maps_photons) {
      photon_mapping_.emplace(context_, spp_, std::max(state_.film.width(), state_.film.height()));
      total_ += photon_mapping_->wanted();
    }
    if (context_.transport.kind == IntegratorKind::kLightTracer) set_photons(scene, crop);
    adaptive_before_ = total_ - wanted_.area() * range_.count;
    if (options.resume != nullptr) resume(*options.resume);
  }

  RenderResult run() {
    start_ = std::chrono::steady_clock::now();
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads_));
    tbb::task_arena arena(threads_);
    arena.execute([this] {
      if (state_.first_sample < range_.end() && !training_passes_.empty()) train();
      if (state_.adaptive)
        take_adaptive_samples();
      else
        while (state_.first_sample < range_.end() && !stopped()) take_samples();
      if (state_.first_sample == range_.end() && range_.end() < half_samples_) state_.film.end_first_half();
      while (state_.photons < photons_ && !stopped()) {
        run_photons();
        if (pauses()) pause();
      }
      pause();
      // A render that was stopped shows what there is.
      if (!state_.adaptive) {
        state_.film.add(state_.borders);
        state_.film.end_replicate();
      }
    });
    return finish();
  }

 private:
  /// What photons there are to be, and where they are summed up.
  void set_photons(const Scene& scene, const PixelRect& crop) {
    // As many as a picture of the whole frame has samples, so that a crop has the same.
    photons_ =
        static_cast<std::uint64_t>(state_.film.width()) * static_cast<std::uint64_t>(state_.film.height()) * spp_;
    if (context_.transport.max_depth == 1 || context_.scene.light_count == 0) photons_ = 0;
    total_ += photons_;
    state_.splats.emplace(crop, scene.film().filter);
  }

  /// What is sampled, in how many replicates, and where it is summed up.
  void set_film(const Scene& scene, const PixelRect& crop) {
    const FilmDescription& film = scene.film();
    const FilterWeights* weights = context_.scene.filter_weights;
    const int reach = weights != nullptr ? weights->reach() : 0;
    frame_ = {film.width, film.sample_border ? reach : 0};
    wanted_ = crop.grown(reach).intersection(PixelRect{0, 0, film.width, film.height}.grown(frame_.border));
    const bool adapts = options_.noise_target > 0 || options_.time_limit > 0;
    const bool independent = scene.sampler().kind == SamplerKind::kIndependent;
    check_layers();
    std::uint32_t replicates = options_.replicates > 0 ? static_cast<std::uint32_t>(options_.replicates)
                                                       : default_replicates(scene.sampler().kind, spp_);
    if (wants_halves()) replicates = std::max(replicates, 2u);
    const bool by_samples = independent && reach == 0 && !adapts;
    replicate_samples_ = by_samples ? spp_ : (spp_ + replicates - 1) / replicates;
    const std::uint32_t made = (spp_ + replicate_samples_ - 1) / replicate_samples_;
    half_samples_ = by_samples ? spp_ / 2 : made / 2 * replicate_samples_;
    state_.film =
        Film(film.width, film.height, crop,
             film_layout(options_.aovs, by_samples || adapts || replicate_samples_ < spp_, group_lights(scene.names())),
             options_.spectral_bins, by_samples ? VarianceUnit::kSample : VarianceUnit::kReplicate,
             options_.aovs.contains(AovSource::kSurfaceId));
  }

  /// Begins the sums of an adaptive render, if it is one.
  void set_adaptive(const Scene& scene) {
    if (options_.noise_target <= 0 && options_.time_limit <= 0) return;
    const SamplerKind kind = scene.sampler().kind;
    if (kind != SamplerKind::kSobol && kind != SamplerKind::kIndependent)
      throw Error(ExitCode::kUsage,
                  "a noise target or a time limit needs a sampler that may be ended anywhere: sobol or independent");
    if (context_.transport.kind != IntegratorKind::kPath)
      throw Error(ExitCode::kUsage,
                  "a noise target or a time limit needs an integrator that follows paths from the "
                  "camera, such as path; " +
                      integrator_name(context_.transport) + " is none");
    if (spp_ < AdaptiveFilm::kSets)
      throw Error(ExitCode::kUsage, "a noise target or a time limit needs four samples per pixel or more");
    adaptive_tiles_ = make_tiles(wanted_, kAdaptiveSide);
    std::vector<PixelRect> squares;
    for (const Tile& tile : adaptive_tiles_) squares.push_back(tile.pixels);
    const FilterWeights* weights = context_.scene.filter_weights;
    state_.adaptive.emplace(state_.film, squares, weights != nullptr ? weights->reach() : 0,
                            AdaptiveGoal{options_.noise_target, spp_});
  }

  /// Which samples are taken. Throws Error (usage) for those that cannot be taken alone.
  void set_range() {
    range_ = {0, spp_};
    if (!options_.samples) return;
    const auto fail = [](const std::string& text) { throw Error(ExitCode::kUsage, text); };
    const SampleRange& asked = *options_.samples;
    if (asked.count == 0 || asked.first >= spp_ / rays_ || asked.count > spp_ / rays_ - asked.first)
      fail("the samples " + std::to_string(asked.first) + ":" + std::to_string(asked.count) + " are none of the " +
           std::to_string(spp_ / rays_) + " samples per pixel, which count from 0");
    if (context_.transport.kind == IntegratorKind::kLightTracer)
      fail("some of the samples can be taken alone where they come from the camera; " +
           integrator_name(context_.transport) + " follows light the other way");
    if (state_.adaptive) fail("a noise target or a time limit cannot judge some of the samples alone");
    range_ = {asked.first * rays_, asked.count * rays_};
    state_.first_sample = range_.first;
    if (range_.first % replicate_samples_ == 0 && (range_.end() % replicate_samples_ == 0 || range_.end() == spp_))
      return;
    if (replicate_samples_ == spp_) return;  // one set, which may be cut anywhere
    const std::uint32_t sets = (spp_ + replicate_samples_ - 1) / replicate_samples_;
    const std::string size = std::to_string(replicate_samples_);
    fail("the samples " + std::to_string(asked.first) + ":" + std::to_string(asked.count) + " cut through one of the " +
         std::to_string(sets) + " sets of " + size + " samples that tell the variance: they must begin and end at " +
         "multiples of " + size + (rays_ > 1 ? " gather rays" : "") + ", or --replicates make other sets");
  }

  bool stopped() const { return options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed); }

  void train() {
    guide_ =
        train_guide(context_, workers_, state_.film.width(), state_.film.height(), training_passes_, guide_training_);
    context_.guide = guide_.view();
  }

  /// Takes up where another render has paused.
  void resume(RenderState& from) {
    const bool same = from.film.width() == state_.film.width() && from.film.height() == state_.film.height() &&
                      from.film.crop() == state_.film.crop() && from.film.layout() == state_.film.layout() &&
                      from.film.spectral_bins() == state_.film.spectral_bins() &&
                      from.film.variance_unit() == state_.film.variance_unit() &&
                      from.film.tells_surfaces() == state_.film.tells_surfaces() &&
                      from.splats.has_value() == state_.splats.has_value() &&
                      from.adaptive.has_value() == state_.adaptive.has_value() && from.first_sample >= range_.first &&
                      from.first_sample <= range_.end() && from.photons <= photons_;
    if (!same) throw Error(ExitCode::kCheckpoint, "the checkpoint is of another render");
    state_ = std::move(from);
    done_ = wanted_.area() * (state_.first_sample - range_.first) + state_.photons;
    for (std::size_t i = 0; i < adaptive_tiles_.size(); ++i)
      done_ += adaptive_tiles_[i].wanted.area() * state_.adaptive->taken_samples(i);
  }

  /// Whether there are samples or photons to be taken yet.
  bool is_left() const {
    return state_.adaptive ? !adaptive_done_ : state_.first_sample < range_.end() || state_.photons < photons_;
  }

  /// Rounds until all tiles are content, or the time is up.
  void take_adaptive_samples() {
    AdaptiveFilm& film = *state_.adaptive;
    const auto is_late = [&] {
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
      return options_.time_limit > 0 && film.has_picture() && elapsed.count() >= options_.time_limit;
    };
    while (!stopped() && !is_late()) {
      if (!film.begin_round()) break;
      expect_adaptive();
      tbb::parallel_for(
          tbb::blocked_range<std::size_t>(0, film.units().size(), 1),
          [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i)
              if (film.units()[i].done == 0 && !stopped() && !is_late() && !pauses()) take_unit(i);
          },
          tbb::simple_partitioner());
      if (pausing_) pause();
    }
    adaptive_done_ = !stopped() || !film.begin_round();
    film.assemble(state_.film);
  }

  /// The samples of a unit, of which the buffers hold a few per pixel at a time.
  void take_unit(std::size_t index) {
    AdaptiveFilm& film = *state_.adaptive;
    const AdaptiveUnit& unit = film.units()[index];
    const Tile& tile = adaptive_tiles_[unit.tile];
    Worker& worker = workers_.local();
    state_.film.begin(worker.tile, tile.pixels, context_.scene.filter_weights);
    const SamplerView sampler = sampler_of_replicate(context_.sampler, unit.set, 0);
    for (std::uint32_t taken = 0; taken < unit.samples; taken += kUnitSamples)
      run_samples(tile, sampler, unit.first_sample + taken, std::min(kUnitSamples, unit.samples - taken));
    film.add(index, worker.tile);
  }

  /// How much there is to be done, as far as is known.
  void expect_adaptive() {
    double samples = 0;
    for (std::size_t i = 0; i < adaptive_tiles_.size(); ++i)
      samples += state_.adaptive->expected_samples(i) * static_cast<double>(adaptive_tiles_[i].wanted.area());
    total_ = static_cast<std::uint64_t>(samples) + adaptive_before_;
  }

  /// The next pass, or what is left of it.
  void take_samples() {
    const std::uint32_t first = state_.first_sample;
    std::uint32_t count =
        std::min({kPassSamples, range_.end() - first, replicate_samples_ - first % replicate_samples_});
    if (options_.aovs.contains(Aov::kHalf) && first < half_samples_) count = std::min(count, half_samples_ - first);
    if (photon_mapping_) {
      count = photon_mapping_->samples_alike(count);
      photon_mapping_->prepare(first, workers_, photon_tracing_, context_);
    }
    if (!run_pass(first, count)) return;
    if ((first + count) % replicate_samples_ == 0) state_.film.end_replicate();
    if (first + count == half_samples_) state_.film.end_first_half();
    state_.first_sample = first + count;
  }

  /// Whether the workers are to take no more tasks for now.
  bool pauses() {
    if (!pausing_ && options_.wants_pause && options_.wants_pause()) pausing_ = true;
    return pausing_;
  }
  /// Tells what there is; all workers have ended their tasks.
  void pause() {
    pausing_ = false;
    if (options_.on_report) {
      std::vector<std::string> warnings;
      options_.on_report(make_report(warnings));
    }
    if (!options_.on_pause) return;
    if (state_.adaptive) state_.adaptive->assemble(state_.film);
    const Stats::Dropped before = state_.dropped;
    state_.dropped = dropped();
    options_.on_pause(state_);
    state_.dropped = before;
  }
  /// In this render and those that it goes on from.
  Stats::Dropped dropped() const {
    Stats::Dropped all = state_.dropped;
    for (const Worker& worker : workers_) {
      all.rays += worker.wave.stats.dropped.rays;
      all.samples += worker.wave.stats.dropped.samples;
    }
    return all;
  }

  /// Returns whether all tiles of the pass are done: not if the render was stopped.
  bool run_pass(std::uint32_t first_sample, std::uint32_t sample_count) {
    int side = 8;
    while (side < 64 && 4 * side * side * static_cast<int>(sample_count) <= kTaskSamples) side *= 2;
    const std::vector<Tile> tiles = make_tiles(wanted_, side);
    begin_pass(tiles, sample_count);
    std::vector<std::uint8_t>& done = state_.tiles;
    while (std::find(done.begin(), done.end(), 0) != done.end()) {
      if (stopped()) return false;
      tbb::parallel_for(
          tbb::blocked_range<std::size_t>(0, tiles.size(), 1),
          [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
              if (done[i] != 0 || stopped() || pauses()) continue;
              const FilmTile& tile = run_task(tiles[i], first_sample, sample_count);
              if (!state_.borders.empty()) state_.borders[i] = tile.border();
              done[i] = 1;
            }
          },
          tbb::simple_partitioner());
      if (pausing_) pause();
    }
    state_.film.add(state_.borders);
    state_.tiles.clear();
    state_.borders.clear();
    return true;
  }

  /// Nothing of the pass is done yet, or as much as the render goes on from, which is told as progress.
  void begin_pass(const std::vector<Tile>& tiles, std::uint32_t sample_count) {
    const std::size_t borders = context_.scene.filter_weights != nullptr ? tiles.size() : 0;
    if (state_.tiles.empty()) {
      state_.tiles.assign(tiles.size(), 0);
      state_.borders.assign(borders, {});
    }
    if (state_.tiles.size() != tiles.size() || state_.borders.size() != borders)
      throw Error(ExitCode::kCheckpoint, "the checkpoint is of another render");
    if (options_.resume == nullptr || told_resumed_) return;
    told_resumed_ = true;
    std::uint64_t samples = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i)
      if (state_.tiles[i] != 0) samples += tiles[i].wanted.area() * sample_count;
    report_done(samples);
  }

  /// Throws Error (usage) for layers that the render cannot make.
  void check_layers() const {
    const bool of_paths = options_.light_groups || of_surfaces();
    const IntegratorKind kind = context_.transport.kind;
    const bool follows_paths = kind == IntegratorKind::kPath || kind == IntegratorKind::kPhotonMapper;
    if (of_paths && !follows_paths)
      throw Error(ExitCode::kUsage,
                  "layers of surfaces and of lights need an integrator that follows light from the "
                  "camera, such as path; " +
                      integrator_name(context_.transport) + " is none");
    if (of_surfaces() && context_.transport.max_depth == 1)
      throw Error(ExitCode::kUsage, "layers of surfaces need paths that may be scattered: a max depth of 2 or more");
    if (options_.aovs.contains(Aov::kHalf) && kind == IntegratorKind::kLightTracer)
      throw Error(ExitCode::kUsage,
                  "the layer half is of samples from the camera, and ptracer follows light the other way");
    if (wants_halves() && spp_ < 2)
      throw Error(ExitCode::kUsage, "the layers variance and half need two samples per pixel or more");
  }
  bool of_surfaces() const {
    return options_.aovs.contains(AovSource::kVertex) || options_.aovs.contains(AovSource::kSurfaceId);
  }
  /// Layers that come from replicates.
  bool wants_halves() const { return options_.aovs.contains(Aov::kVariance) || options_.aovs.contains(Aov::kHalf); }

  /// The groups of lights, where they have layers.
  std::vector<std::string> group_lights(const SceneNames& names) {
    if (!options_.light_groups) return {};
    std::vector<std::string> groups = names.lights;
    // The light that photon maps hold is mixed.
    if (names.has_other_light || context_.transport.kind == IntegratorKind::kPhotonMapper) groups.emplace_back("other");
    if (groups.size() > kMaxLightGroups)
      throw Error(ExitCode::kUsage,
                  "the scene has " + std::to_string(groups.size()) +
                      " lights with names of their own, "
                      "expected at most " +
                      std::to_string(kMaxLightGroups) +
                      " for light groups: those of the same id are one group, and those without an id");
    for (const std::uint32_t light : names.light_of_row) group_of_light_.push_back(static_cast<std::uint16_t>(light));
    light_groups_ = groups.size();
    return groups;
  }

  /// Where the light of groups goes from the worker's task.
  LightGroupSink group_sink(CameraTask& task) const {
    if (light_groups_ == 0) return {};
    const auto channels = static_cast<std::size_t>(state_.film.layout().size());
    const bool spectral = context_.scene.color == ColorMode::kSpectral;
    return {task.samples[0] + channels - 3 * light_groups_, channels, group_of_light_.data(),
            static_cast<std::uint16_t>(light_groups_ - 1), spectral ? context_.scene.spectral.sensor : nullptr};
  }

  void report_done(std::uint64_t more) {
    const std::uint64_t done = done_.fetch_add(more, std::memory_order_relaxed) + more;
    if (options_.on_progress) options_.on_progress(done, total_);
  }

  /// Takes samples of a tile, and adds its own pixels to the film. The tile that is returned is the worker's.
  const FilmTile& run_task(const Tile& tile, std::uint32_t first_sample, std::uint32_t sample_count) {
    Worker& worker = workers_.local();
    state_.film.begin(worker.tile, tile.pixels, context_.scene.filter_weights);
    run_samples(tile, sampler_of_replicate(context_.sampler, first_sample / replicate_samples_, replicate_samples_),
                first_sample, sample_count);
    state_.film.add(worker.tile);
    return worker.tile;
  }

  /// Takes samples, and adds them to the worker's tile.
  void run_samples(const Tile& tile, const SamplerView& sampler, std::uint32_t first_sample,
                   std::uint32_t sample_count) {
    const FlushDenormals flush;
    Worker& worker = workers_.local();
    const std::vector<PixelSamples> pixels = samples_of(tile.wanted, frame_, first_sample, sample_count);
    worker.camera.begin(pixels, frame_, state_.film.layout().size(), state_.film.spectral_bins(),
                        AovChannels(state_.film.layout(), options_.aovs));
    worker.wave.light_groups = group_sink(worker.camera);
    StageContext context = context_;
    context.camera = &worker.camera;
    context.sampler = sampler;
    // What photons cannot find is light that reaches the camera without having been scattered.
    if (context.transport.kind == IntegratorKind::kLightTracer) context.transport.max_depth = 1;
    camera_pass_of<Wide>(context.transport.kind)(context, worker.wave);
    worker.wave.light_groups = {};
    reduce(worker.camera, worker.tile);
    report_done(static_cast<std::uint64_t>(worker.camera.total()));
  }

  /// The next tasks of photons, whose splats are added to the film when all of them have ended.
  void run_photons() {
    const std::uint64_t left = photons_ - state_.photons;
    const std::uint64_t taken = std::min<std::uint64_t>(left, std::uint64_t{kTaskPhotons} * kRoundTasks);
    std::vector<std::vector<Splat>> splats((taken + kTaskPhotons - 1) / kTaskPhotons);
    std::atomic<bool> whole{true};
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, splats.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) {
            if (stopped()) {
              whole = false;
              return;
            }
            const std::uint64_t first = i * kTaskPhotons;
            run_photon_task(state_.photons + first,
                            static_cast<int>(std::min<std::uint64_t>(kTaskPhotons, taken - first)), splats[i]);
          }
        },
        tbb::simple_partitioner());
    // A round that was cut short says nothing of how many photons there were.
    if (!whole) return;
    state_.splats->add(splats);
    state_.photons += taken;
  }

  void run_photon_task(std::uint64_t first, int count, std::vector<Splat>& splats) {
    const FlushDenormals flush;
    Worker& worker = workers_.local();
    worker.photons.begin(first, count, state_.film.crop(), state_.splats->reach());
    StageContext context = context_;
    context.photons = &worker.photons;
    context.sampler = without_frame(context.sampler);
    run_light_pass<Wide>(context, worker.wave);
    worker.photons.sort_splats();
    splats = worker.photons.splats;
    report_done(static_cast<std::uint64_t>(count));
  }

  /// What there is to be told, but for the picture's noise. Adds to `warnings`.
  RenderReport make_report(std::vector<std::string>& warnings) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    RenderReport report;
    report.integrator = integrator_name(context_.transport);
    report.isa = kIsaName;
    report.width = state_.film.width();
    report.height = state_.film.height();
    report.spp = spp_;
    report.seed = context_.sampler.seed;
    report.threads = threads_;
    report.wave_size = wave_size_;
    report.render_seconds = elapsed.count();
    if (state_.adaptive) {
      report.adaptive = state_.adaptive->summary();
      report.spp = static_cast<std::uint32_t>(std::lround(report.adaptive->mean_samples));
    }
    report.photons = photon_tracing_.report;
    report.guiding = guide_training_.report;
    add_workers(workers_, frame_, dropped(), report, warnings);
    for (const SourceLocation& place : scene_.light_places())
      report.light_places.push_back(place.line > 0 ? place.file + ":" + std::to_string(place.line) : std::string());
    return report;
  }

  RenderResult finish() {
    RenderResult result;
    result.interrupted = stopped() && is_left();
    result.warnings = photon_tracing_.warnings;
    result.report = make_report(result.warnings);
    result.report.noise = state_.film.noise();
    result.film = std::move(state_.film);
    result.aovs = options_.aovs;
    if (result.film.tells_surfaces()) result.names = scene_.names();
    result.splats = std::move(state_.splats);
    result.photons = state_.photons;
    if (options_.samples) result.samples = range_;
    return result;
  }

  const Scene& scene_;
  StageContext context_;
  WaveNeeds needs_;
  const RenderOptions& options_;
  std::uint32_t spp_;
  int threads_, wave_size_;
  RenderState state_;
  SampledFrame frame_;
  PixelRect wanted_;  ///< pixels that are sampled: the crop, and those around from which samples reach into it
  std::uint32_t replicate_samples_ = 0;  ///< per pixel, of each replicate
  SampleRange range_;                    ///< of spp_ samples, those that are taken
  std::uint32_t rays_ = 1;               ///< samples that each one is made of
  std::uint32_t half_samples_ = 0;       ///< per pixel, of the first half
  std::size_t light_groups_ = 0;         ///< that have layers
  std::vector<std::uint16_t> group_of_light_;
  std::vector<Tile> adaptive_tiles_;
  std::uint64_t adaptive_before_ = 0;  ///< samples and photons besides those of the picture
  bool adaptive_done_ = false;
  std::optional<PhotonMapping> photon_mapping_;
  PhotonTracing photon_tracing_{[this] { return stopped(); }, [this](std::uint64_t more) { report_done(more); }};
  GuideField guide_;
  std::vector<TrainingPass> training_passes_;
  GuideTraining guide_training_{[this] { return stopped(); }, [this](std::uint64_t more) { report_done(more); }};
  std::uint64_t photons_ = 0;  ///< light tracing: to be emitted
  std::atomic<bool> pausing_{false};
  std::chrono::steady_clock::time_point start_;
  bool told_resumed_ = false;  ///< the tiles that were done already count as progress
  std::uint64_t total_ = 0;
  std::atomic<std::uint64_t> done_{0};
  Workers workers_{
      [this] { return Worker(wave_size_, needs_, options_.make_recorder ? options_.make_recorder() : nullptr); }};
};

}  // namespace

std::uint32_t default_replicates(SamplerKind kind, std::uint64_t samples) {
  if (kind == SamplerKind::kIndependent) return kFreeReplicates;
  if (samples < 32) return 1;
  return samples < 128 ? 2 : samples < 512 ? 4 : 8;
}

Image RenderResult::to_image() const {
  Image image = film.to_image();
  if (samples) film.add_part_layers(image);
  if (splats) splats->add_to(image, photons);
  add_id_layers(aovs, names, film, image);
  if (samples) add_part_ids(aovs, names, film, image);
  return image;
}

RenderResult render(const Scene& scene, const RenderOptions& options) { return Renderer(scene, options).run(); }

}  // namespace sheaf
