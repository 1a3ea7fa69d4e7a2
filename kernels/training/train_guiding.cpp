// Runs the training passes of path guiding.
#include "kernels/training/train_guiding.h"

#include "core/sampling/rng.h"
#include "core/simd/flush_denormals.h"
#include "kernels/film/film_layout.h"
#include "kernels/passes/passes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf {

namespace {

/// Camera samples per task.
constexpr int kTrainingTaskSamples = 1024;
/// Cells with more records than this times the square root of the pass's sample count over that of the first are split.
constexpr double kSplitRecords = 1400;

/// Number of samples of a pass over that of another.
double size_ratio(const TrainingPass& pass, const TrainingPass& other) {
  const auto per_pixel = [](const TrainingPass& p) {
    return static_cast<double>(p.samples()) / (p.column_stride * p.row_stride);
  };
  return per_pixel(pass) / per_pixel(other);
}

/// The pixels of a pass in the order of rows, divided into tasks.
std::vector<std::vector<std::uint32_t>> pixels_of_tasks(const SampledFrame& frame, int height,
                                                        const TrainingPass& pass) {
  // Each pass uses other pixels than the one before.
  const auto column_stride = static_cast<std::uint32_t>(pass.column_stride);
  const auto row_stride = static_cast<std::uint32_t>(pass.row_stride);
  std::uint32_t x = pass.first_pair, y = row_stride, z = 0, w = 0;
  hash4(x, y, z, w);
  const int side = static_cast<int>(std::sqrt(kTrainingTaskSamples / pass.set_samples));
  const int columns = pass.columns(frame.width), rows = pass.rows(height);
  std::vector<std::vector<std::uint32_t>> tasks;
  for (int y0 = 0; y0 < rows; y0 += side)
    for (int x0 = 0; x0 < columns; x0 += side) {
      std::vector<std::uint32_t>& task = tasks.emplace_back();
      for (int row = y0; row < std::min(y0 + side, rows); ++row)
        for (int column = x0; column < std::min(x0 + side, columns); ++column) {
          const int px = std::min(column * pass.column_stride + static_cast<int>(x % column_stride), frame.width - 1);
          const int py = std::min(row * pass.row_stride + static_cast<int>(y % row_stride), height - 1);
          task.push_back(frame.pixel(px, py));
        }
    }
  return tasks;
}

/// A sampler that shares no random numbers with samples of the image.
SamplerView training_sampler(const SamplerView& image_sampler) {
  std::uint32_t x = image_sampler.seed, y = 0x6775u, z = 0x6964u, w = 0x65u;
  hash4(x, y, z, w);
  return make_sampler(SamplerKind::kSobol, x, kComparedSamples);
}

/// Number of rays that the workers have traced.
std::uint64_t traced_rays(const Workers& workers) {
  std::uint64_t rays = 0;
  for (const Worker& worker : workers) rays += worker.wave.stats.rays.total();
  return rays;
}

/// Runs a pass. Returns the records of each set of each task in order. `compared`: output.
std::vector<std::vector<GuideRecord>> run_pass(const StageContext& context, Workers& workers, int width, int height,
                                               const TrainingPass& pass, std::span<const float> means,
                                               const GuideTraining& training, ComparedPass& compared) {
  const SampledFrame frame{width};
  const std::vector<std::vector<std::uint32_t>> pixels = pixels_of_tasks(frame, height, pass);
  // The first pair of sets of all pixels, then the next; the two sets of a task are taken one by one
  compared.tasks.resize(pass.pairs * pixels.size());
  const std::size_t sets = 2 * compared.tasks.size();
  std::vector<std::vector<GuideRecord>> records(sets);
  std::vector<TrainingSamples::Vertices> vertices(sets);
  const std::uint64_t rays_before = traced_rays(workers);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, sets, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end() && !training.stopped(); ++i) {
          const FlushDenormals flush;
          Worker& worker = workers.local();
          ComparedTask& task = compared.tasks[i / 2];
          const std::size_t set = i % 2, pair = pass.first_pair + i / 2 / pixels.size();
          const auto replicate = static_cast<std::uint32_t>(2 * pair + set);
          std::vector<PixelSamples> samples;
          for (const std::uint32_t pixel : pixels[i / 2 % pixels.size()])
            samples.push_back({pixel, replicate * kComparedSamples, pass.set_samples});
          worker.camera.begin(samples, frame, kBeautyChannels);
          worker.guide.begin(worker.camera.total());
          StageContext of_task = context;
          of_task.set_camera_task(worker.camera);
          of_task.record_in(worker.guide);
          of_task.sampler = sampler_of_replicate(context.sampler, replicate, kComparedSamples);
          run_pass<Wide>(of_task, worker.wave);
          records[i] = worker.guide.records(context.guide(), means);
          task.radiance[set] = worker.guide.radiance();
          task.squared_radiance[set] = worker.guide.squared_radiance();
          vertices[i] = worker.guide.vertices();
          training.on_samples(static_cast<std::uint64_t>(worker.camera.total()));
        }
      },
      tbb::simple_partitioner());
  compared.rays = traced_rays(workers) - rays_before;
  for (const TrainingSamples::Vertices& of_task : vertices) {
    compared.light_vertices += of_task.sampled;
    for (std::size_t i = 0; i < compared.shadow_rays.size(); ++i) compared.shadow_rays[i] += of_task.shadow_rays[i];
  }
  return records;
}

}  // namespace

GuideField train_guide(const StageContext& context, Workers& workers, int width, int height,
                       std::span<const TrainingPass> passes, GuidingMode mode, bool has_comparison,
                       GuideTraining& training) {
  GuideField field;
  StageContext of_passes = context;
  of_passes.sampler = training_sampler(context.sampler);
  RenderReport::Guiding& report = training.report;
  report.is_used = true;
  std::vector<ComparedPass> comparisons;
  const std::size_t compared_passes = std::min(kComparedPasses, passes.size());
  for (const TrainingPass& pass : passes) {
    if (training.stopped()) break;
    // Take the samples
    std::uint64_t start = timestamp();
    of_passes.sample_from(field.view());
    StageContext of_pass = of_passes;
    if (has_comparison && comparisons.size() < kComparedPasses) of_pass.start_candidate_comparison();
    const auto records =
        run_pass(of_pass, workers, width, height, pass, field.means(), training, comparisons.emplace_back());
    report.trace_seconds += seconds_since(start);
    report.samples += training_samples(width, height, {&pass, 1});
    // Train the guide
    start = timestamp();
    for (const auto& task : records) report.records += task.size();
    field.train(records, static_cast<std::size_t>(kSplitRecords * std::sqrt(size_ratio(pass, passes[0]))));
    report.fit_seconds += seconds_since(start);
    ++report.passes;
    if (comparisons.size() < 2 || comparisons.size() > compared_passes || training.stopped()) continue;
    // Decide about guiding and about the number of light candidates
    const bool is_last = comparisons.size() == compared_passes;
    if (mode == GuidingMode::kAuto) {
      const GuidingGain gain = guiding_gain(comparisons.front(), comparisons.back());
      report.gain = gain.ratio;
      report.is_used = is_last ? gain.is_significant() : gain.is_promising();
    }
    if (has_comparison && (is_last || !report.is_used)) {
      training.candidates =
          choose_candidates(report.is_used ? comparisons.back() : comparisons.front(), candidate_cost(context.scene));
      of_passes.candidates = training.candidates.count;
    }
    if (report.is_used) continue;
    training.on_samples(training_samples(width, height, passes) - report.samples);  // that are not taken
    break;
  }
  report.cells = field.cells();
  // Statistics count only samples of the image.
  for (Worker& worker : workers) worker.wave.stats.samples = 0;
  return field;
}

}  // namespace sheaf
