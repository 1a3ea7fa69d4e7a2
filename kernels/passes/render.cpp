// The render loop: training, passes of camera samples or adaptive rounds, photons, and pauses for checkpoints.
#include "kernels/passes/render.h"

#include "core/error.h"
#include "core/saturate.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/film/noise.h"
#include "kernels/passes/passes.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/passes/render_memory.h"
#include "kernels/passes/render_report.h"
#include "kernels/passes/sample_plan.h"
#include "kernels/passes/tiles.h"
#include "kernels/passes/train_guiding.h"
#include "kernels/passes/worker.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cmath>
#include <new>

namespace sheaf {

namespace {

/// Samples per pixel that adaptive sampling takes in one task.
constexpr std::uint32_t kUnitSamples = 16;

/// Photons per task, and tasks per round. The splats of a round are kept until it ends.
constexpr int kTaskPhotons = 16384, kRoundTasks = 64;

/// Adds the samples of a finished task to its tile, in the order of each pixel's samples.
void reduce(const CameraTask& task, FilmTile& tile) {
  std::size_t sample = 0;
  for (const PixelSamples& p : task.pixels()) {
    const int x = task.frame().x(p.pixel), y = task.frame().y(p.pixel);
    tile.add(x, y, task.samples, sample, p.sample_count);
    sample += p.sample_count;
  }
}

void check_guiding(const IntegratorSettings& integrator) {
  if (integrator.kind == IntegratorKind::kPath && !integrator.ends_at_diffuse) return;
  throw Error(ExitCode::kUsage, "guiding needs an integrator that follows paths from the camera, such as path; " +
                                    integrator_name(integrator) + " is none");
}

/// The context with the settings of the scene, adapted to options and integrator.
StageContext context_of(const Scene& scene, const RenderOptions& options) {
  StageContext context(scene);
  if (options.guiding) check_guiding(context.integrator);
  context.guides = options.guiding;
  // Shadow rays of photons to the camera must pass hidden lights.
  if (context.integrator.kind == IntegratorKind::kLightTracer && context.integrator.hide_emitters)
    context.scene.needs_transmittance = true;
  return context;
}

/// A render in progress.
class Renderer {
 public:
  Renderer(const Scene& scene, const RenderOptions& options, SamplePlan plan)
      : scene_(scene),
        context_(context_of(scene, options)),
        needs_(WaveNeeds::of(context_)),
        options_(options),
        plan_(std::move(plan)),
        threads_(threads_of(options)),
        wave_size_(wave_size_of(options, needs_)) {
    if (wave_size_ > kMaxWaveSize)
      throw Error(ExitCode::kUsage, "wave size must be at most " + std::to_string(kMaxWaveSize));
    state_.film = plan_.make_film(scene, options);
    state_.first_sample = plan_.range.first;
    if (!plan_.light_groups.empty())
      for (const std::uint32_t light : scene.names().light_of_row)
        group_of_light_.push_back(static_cast<std::uint16_t>(light));
    set_adaptive();
    context_.sampler = make_sampler(scene.sampler().kind, options.seed.value_or(scene.sampler().seed),
                                    plan_.replicate_samples, static_cast<std::uint32_t>(plan_.frame.row_length()));
    total_ = plan_.wanted.area() * plan_.range.count;
    context_.guide = guide_.view();
    if (options.guiding) training_passes_ = training_passes(state_.film.width(), state_.film.height(), plan_.spp);
    total_ += training_samples(state_.film.width(), state_.film.height(), training_passes_);
    if (context_.integrator.kind == IntegratorKind::kPhotonMapper) {
      photon_mapping_.emplace(context_, plan_.spp, std::max(state_.film.width(), state_.film.height()));
      total_ += photon_mapping_->wanted();
    }
    if (context_.integrator.kind == IntegratorKind::kLightTracer) set_photons(scene);
    adaptive_before_ = total_ - plan_.wanted.area() * plan_.range.count;
    if (options.resume != nullptr) resume(*options.resume);
  }

  RenderResult run() {
    start_ = std::chrono::steady_clock::now();
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads_));
    tbb::task_arena arena(threads_);
    arena.execute([this] {
      if (state_.first_sample < plan_.range.end() && !training_passes_.empty()) train();
      if (state_.adaptive)
        take_adaptive_samples();
      else
        while (state_.first_sample < plan_.range.end() && !stopped()) take_samples();
      if (state_.first_sample == plan_.range.end() && plan_.range.end() < plan_.half_samples)
        state_.film.end_first_half();
      while (state_.photons < photons_ && !stopped()) {
        run_photons();
        if (pauses()) pause();
      }
      pause();
      // A render that was stopped returns the unfinished pass as well.
      if (!state_.adaptive) {
        state_.film.add(state_.borders);
        state_.film.end_replicate();
      }
    });
    return finish();
  }

 private:
  double frame_pixels() const { return static_cast<double>(state_.film.width()) * state_.film.height(); }

  /// Sets the number of photons, and allocates the film of their splats.
  void set_photons(const Scene& scene) {
    // One photon per sample of the whole frame, so that a crop gets the same photons.
    photons_ =
        static_cast<std::uint64_t>(state_.film.width()) * static_cast<std::uint64_t>(state_.film.height()) * plan_.spp;
    if (context_.integrator.max_depth == 1 || context_.scene.lights.count == 0) photons_ = 0;
    total_ += photons_;
    const PixelRect frame{0, 0, state_.film.width(), state_.film.height()};
    const bool turns = context_.scene.sensor.camera.rays == CameraRays::kSpherical;
    splat_filter_.emplace(scene.film().filter, scene.film().filter_mode, frame.grown(plan_.frame.border),
                          turns ? static_cast<float>(frame.width()) : 0.0f);
    state_.splats.emplace(plan_.crop);
  }

  /// Initializes adaptive sampling, if it is enabled.
  void set_adaptive() {
    if (!plan_.adapts) return;
    adaptive_tiles_ = make_tiles(plan_.wanted, kAdaptiveSide);
    std::vector<PixelRect> squares;
    for (const Tile& tile : adaptive_tiles_) squares.push_back(tile.pixels);
    state_.adaptive.emplace(state_.film, squares, plan_.reach, AdaptiveGoal{options_.noise_target, plan_.spp});
  }

  bool stopped() const { return options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed); }

  void train() {
    guide_ =
        train_guide(context_, workers_, state_.film.width(), state_.film.height(), training_passes_, guide_training_);
    context_.guide = guide_.view();
  }

  /// Resumes from the state of a paused render.
  void resume(RenderState& from) {
    const bool same = from.film.width() == state_.film.width() && from.film.height() == state_.film.height() &&
                      from.film.crop() == state_.film.crop() && from.film.layout() == state_.film.layout() &&
                      from.film.spectral_bins() == state_.film.spectral_bins() &&
                      from.film.variance_unit() == state_.film.variance_unit() &&
                      from.film.has_surface_ids() == state_.film.has_surface_ids() &&
                      from.splats.has_value() == state_.splats.has_value() &&
                      from.adaptive.has_value() == state_.adaptive.has_value() &&
                      from.first_sample >= plan_.range.first && from.first_sample <= plan_.range.end() &&
                      from.photons <= photons_;
    if (!same) throw Error(ExitCode::kCheckpoint, "the checkpoint is of another render");
    state_ = std::move(from);
    done_ = plan_.wanted.area() * (state_.first_sample - plan_.range.first) + state_.photons;
    for (std::size_t i = 0; i < adaptive_tiles_.size(); ++i)
      done_ += adaptive_tiles_[i].wanted.area() * state_.adaptive->taken_samples(i);
  }

  /// Whether samples or photons remain to be taken.
  bool is_left() const {
    return state_.adaptive ? !adaptive_done_ : state_.first_sample < plan_.range.end() || state_.photons < photons_;
  }

  /// Takes rounds of samples until all tiles converge or the time limit is reached.
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

  /// Takes the samples of a unit, at most kUnitSamples per pixel at a time.
  void take_unit(std::size_t index) {
    AdaptiveFilm& film = *state_.adaptive;
    const AdaptiveUnit& unit = film.units()[index];
    const Tile& tile = adaptive_tiles_[unit.tile];
    Worker& worker = workers_.local();
    state_.film.begin(worker.tile, tile.pixels, context_.scene.sensor.filter_weights);
    const SamplerView sampler = sampler_of_replicate(context_.sampler, unit.set, 0);
    for (std::uint32_t taken = 0; taken < unit.samples; taken += kUnitSamples)
      run_samples(tile, sampler, unit.first_sample + taken, std::min(kUnitSamples, unit.samples - taken));
    film.add(index, worker.tile);
  }

  /// Estimates the total number of samples, for progress.
  void expect_adaptive() {
    double samples = 0;
    for (std::size_t i = 0; i < adaptive_tiles_.size(); ++i)
      samples += state_.adaptive->expected_samples(i) * static_cast<double>(adaptive_tiles_[i].wanted.area());
    total_ = static_cast<std::uint64_t>(samples) + adaptive_before_;
  }

  /// Takes the next pass, or the rest of the pass that was resumed.
  void take_samples() {
    const std::uint32_t first = state_.first_sample;
    std::uint32_t count =
        std::min({kPassSamples, plan_.range.end() - first, plan_.replicate_samples - first % plan_.replicate_samples});
    if (options_.aovs.contains(Aov::kHalf) && first < plan_.half_samples)
      count = std::min(count, plan_.half_samples - first);
    if (photon_mapping_) {
      count = photon_mapping_->samples_alike(count);
      photon_mapping_->prepare(first, workers_, photon_tracing_, context_);
    }
    if (!run_pass(first, count)) return;
    if ((first + count) % plan_.replicate_samples == 0) state_.film.end_replicate();
    if (first + count == plan_.half_samples) state_.film.end_first_half();
    state_.first_sample = first + count;
  }

  /// Whether workers must not start more tasks for now.
  bool pauses() {
    if (!pausing_ && options_.wants_pause && options_.wants_pause()) pausing_ = true;
    return pausing_;
  }
  /// Calls on_report and on_pause, after all workers have ended their tasks.
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
  /// Dropped rays and samples of this render and of those that it resumes.
  Stats::Dropped dropped() const {
    Stats::Dropped all = state_.dropped;
    for (const Worker& worker : workers_) {
      all.rays += worker.wave.stats.dropped.rays;
      all.samples += worker.wave.stats.dropped.samples;
    }
    return all;
  }

  /// Takes a pass. Returns false if the render was stopped before all tiles were done.
  bool run_pass(std::uint32_t first_sample, std::uint32_t sample_count) {
    const std::vector<Tile> tiles = make_tiles(plan_.wanted, tile_side(sample_count));
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

  /// Starts a pass, or continues a resumed one and reports its finished tiles as progress.
  void begin_pass(const std::vector<Tile>& tiles, std::uint32_t sample_count) {
    const std::size_t borders = context_.scene.sensor.filter_weights != nullptr ? tiles.size() : 0;
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

  /// Channels of the light groups in the samples of the worker's task.
  LightGroupSink group_sink(CameraTask& task) const {
    if (plan_.light_groups.empty()) return {};
    const auto channels = static_cast<std::size_t>(state_.film.layout().size());
    const bool spectral = context_.scene.color == ColorMode::kSpectral;
    return {task.samples[0] + channels - 3 * plan_.light_groups.size(), channels, group_of_light_.data(),
            static_cast<std::uint16_t>(plan_.light_groups.size() - 1),
            spectral ? context_.scene.spectral.sensor : nullptr};
  }

  void report_done(std::uint64_t more) {
    const std::uint64_t done = done_.fetch_add(more, std::memory_order_relaxed) + more;
    if (options_.on_progress) options_.on_progress(done, total_);
  }

  /// Takes samples of a tile, and adds its own pixels to the film. Returns the tile, which the worker owns.
  const FilmTile& run_task(const Tile& tile, std::uint32_t first_sample, std::uint32_t sample_count) {
    Worker& worker = workers_.local();
    state_.film.begin(worker.tile, tile.pixels, context_.scene.sensor.filter_weights);
    run_samples(tile,
                sampler_of_replicate(context_.sampler, first_sample / plan_.replicate_samples, plan_.replicate_samples),
                first_sample, sample_count);
    state_.film.add(worker.tile);
    return worker.tile;
  }

  /// Takes samples, and adds them to the worker's tile.
  void run_samples(const Tile& tile, const SamplerView& sampler, std::uint32_t first_sample,
                   std::uint32_t sample_count) {
    const FlushDenormals flush;
    Worker& worker = workers_.local();
    const std::vector<PixelSamples> pixels = samples_of(tile.wanted, plan_.frame, first_sample, sample_count);
    worker.camera.begin(pixels, plan_.frame, state_.film.layout().size(), state_.film.spectral_bins(),
                        AovChannels(state_.film.layout(), options_.aovs));
    worker.wave.light_groups = group_sink(worker.camera);
    StageContext context = context_;
    context.camera = &worker.camera;
    context.sampler = sampler;
    // Photons do not find light that reaches the camera unscattered, so the camera pass takes only that.
    if (context.integrator.kind == IntegratorKind::kLightTracer) context.integrator.max_depth = 1;
    sheaf::run_pass<Wide>(context, worker.wave);
    worker.wave.light_groups = {};
    reduce(worker.camera, worker.tile);
    report_done(static_cast<std::uint64_t>(worker.camera.total()));
  }

  /// Takes the next round of photon tasks, and adds their splats to the film when all have ended.
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
    // Discard an interrupted round: the number of its photons is not known.
    if (!whole) return;
    state_.splats->add(splats, *splat_filter_);
    state_.photons += taken;
  }

  void run_photon_task(std::uint64_t first, int count, std::vector<Splat>& splats) {
    const FlushDenormals flush;
    Worker& worker = workers_.local();
    worker.photons.begin(first, count, splat_filter_->bounds(state_.film.crop()));
    StageContext context = context_;
    context.pass = PassKind::kLight;
    context.photons = &worker.photons;
    context.sampler = without_frame(context.sampler);
    sheaf::run_pass<Wide>(context, worker.wave);
    worker.photons.sort_splats();
    splats = worker.photons.splats;
    report_done(static_cast<std::uint64_t>(count));
  }

  /// The report without the noise of the image. Adds to `warnings`.
  RenderReport make_report(std::vector<std::string>& warnings) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    RenderReport report;
    report.integrator = integrator_name(context_.integrator);
    report.isa = kIsaName;
    report.width = state_.film.width();
    report.height = state_.film.height();
    report.spp = plan_.spp;
    report.seed = context_.sampler.seed;
    report.threads = threads_;
    report.wave_size = wave_size_;
    report.render_seconds = elapsed.count();
    report.mean_samples = state_.film.mean_samples();
    if (state_.adaptive) {
      report.adaptive = state_.adaptive->summary();
      report.mean_samples = report.adaptive->mean_samples;
      report.spp = saturate<std::uint32_t>(std::round(report.mean_samples));
    }
    if (state_.splats) report.mean_samples = static_cast<double>(state_.photons) / frame_pixels();
    report.photons = photon_tracing_.report;
    report.guiding = guide_training_.report;
    add_workers(workers_, plan_.frame, dropped(), report, warnings);
    for (const SourceLocation& place : scene_.light_source_locations())
      report.light_source_locations.push_back(place.line > 0 ? place.file + ":" + std::to_string(place.line)
                                                             : std::string());
    return report;
  }

  RenderResult finish() {
    RenderResult result;
    result.interrupted = stopped() && is_left();
    result.warnings = photon_tracing_.warnings;
    result.report = make_report(result.warnings);
    result.report.interrupted = result.interrupted;
    result.report.noise = noise_of(state_.film, state_.splats, state_.photons);
    result.film = std::move(state_.film);
    result.aovs = options_.aovs;
    if (result.film.has_surface_ids()) result.names = scene_.names();
    result.splats = std::move(state_.splats);
    result.photons = state_.photons;
    if (options_.samples) result.samples = plan_.range;
    return result;
  }

  const Scene& scene_;
  StageContext context_;
  WaveNeeds needs_;
  const RenderOptions& options_;
  SamplePlan plan_;
  int threads_, wave_size_;
  RenderState state_;
  std::vector<std::uint16_t> group_of_light_;
  std::vector<Tile> adaptive_tiles_;
  std::uint64_t adaptive_before_ = 0;  ///< training samples, photons and others besides the image's samples
  bool adaptive_done_ = false;
  std::optional<PhotonMapping> photon_mapping_;
  PhotonTracing photon_tracing_{[this] { return stopped(); }, [this](std::uint64_t more) { report_done(more); }};
  GuideField guide_;
  std::vector<TrainingPass> training_passes_;
  GuideTraining guide_training_{[this] { return stopped(); }, [this](std::uint64_t more) { report_done(more); }};
  std::uint64_t photons_ = 0;  ///< light tracing: number of photons to emit
  std::optional<SplatFilter> splat_filter_;
  std::atomic<bool> pausing_{false};
  std::chrono::steady_clock::time_point start_;
  bool told_resumed_ = false;  ///< finished tiles of the resumed pass were reported
  std::uint64_t total_ = 0;
  std::atomic<std::uint64_t> done_{0};
  Workers workers_{
      [this] { return Worker(wave_size_, needs_, options_.make_recorder ? options_.make_recorder() : nullptr); }};
};

}  // namespace

std::optional<double> noise_of(const Film& film, const std::optional<SplatFilm>& splats, std::uint64_t photons) {
  if (!splats) return film.noise();
  if (photons == 0) return std::nullopt;
  Image image = film.to_image();
  splats->add_to(image, photons);
  return picture_noise(image);
}

Image RenderResult::to_image() const {
  Image image = film.to_image();
  if (samples) film.add_part_layers(image);
  if (splats) splats->add_to(image, photons);
  add_id_layers(aovs, names, film, image);
  if (samples) add_part_ids(aovs, names, film, image);
  return image;
}

RenderResult render(const Scene& scene, const RenderOptions& options) {
  SamplePlan plan = make_sample_plan(scene, options, scene.integrator());
  const std::vector<MemoryUse> memory = render_memory(scene, options, plan);
  const std::string task =
      "a picture of " + std::to_string(plan.crop.width()) + " x " + std::to_string(plan.crop.height()) + " pixels";
  check_memory(task, memory);
  try {
    return Renderer(scene, options, std::move(plan)).run();
  } catch (const std::bad_alloc&) { throw not_enough_memory(task, memory); }
}

}  // namespace sheaf
