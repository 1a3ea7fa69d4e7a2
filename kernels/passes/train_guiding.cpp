// Plans and runs the training passes of path guiding.
#include "kernels/passes/train_guiding.h"

#include "core/flush_denormals.h"
#include "core/rng.h"
#include "kernels/film/film_layout.h"
#include "kernels/passes/passes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Maximum share of training in the samples of a render, and the samples per pixel after which training has converged.
constexpr double kTrainingShare = 0.125;
constexpr std::uint32_t kMaxTraining = 16;
/// Camera samples of the longest pass. Their records stay in memory until the guide has learned from them.
constexpr std::uint64_t kTrainingPassSamples = 1 << 20;
/// Camera samples per task.
constexpr int kTrainingTaskSamples = 4096;
/// Cells with more records than this times the square root of the pass's sample count over that of the first are split.
constexpr double kSplitRecords = 1000;

int strided(int size, int stride) { return (size + stride - 1) / stride; }

/// The pixels of a pass in the order of rows, divided into tasks.
std::vector<std::vector<PixelSamples>> tasks_of(const SampledFrame& frame, int height, const TrainingPass& pass) {
  // Each pass uses other pixels than the one before.
  const auto stride = static_cast<std::uint32_t>(pass.stride);
  std::uint32_t x = pass.first_sample, y = stride, z = 0, w = 0;
  hash4(x, y, z, w);
  const int side =
      std::max(4, static_cast<int>(std::sqrt(kTrainingTaskSamples / static_cast<double>(pass.sample_count))));
  const int columns = strided(frame.width, pass.stride), rows = strided(height, pass.stride);
  std::vector<std::vector<PixelSamples>> tasks;
  for (int y0 = 0; y0 < rows; y0 += side)
    for (int x0 = 0; x0 < columns; x0 += side) {
      std::vector<PixelSamples>& task = tasks.emplace_back();
      for (int row = y0; row < std::min(y0 + side, rows); ++row)
        for (int column = x0; column < std::min(x0 + side, columns); ++column) {
          const int px = std::min(column * pass.stride + static_cast<int>(x % stride), frame.width - 1);
          const int py = std::min(row * pass.stride + static_cast<int>(y % stride), height - 1);
          task.push_back({frame.pixel(px, py), pass.first_sample, pass.sample_count});
        }
    }
  return tasks;
}

/// A sampler that shares no random numbers with samples of the image.
SamplerView training_sampler(const SamplerView& image_sampler) {
  std::uint32_t x = image_sampler.seed, y = 0x6775u, z = 0x6964u, w = 0x65u;
  hash4(x, y, z, w);
  return make_sampler(SamplerKind::kSobol, x, 1);
}

/// Runs a pass. Returns the records of each task in order.
std::vector<std::vector<GuideRecord>> run_pass(const StageContext& context, Workers& workers, int width, int height,
                                               const TrainingPass& pass, std::span<const float> means,
                                               const GuideTraining& training) {
  const SampledFrame frame{width};
  const std::vector<std::vector<PixelSamples>> tasks = tasks_of(frame, height, pass);
  std::vector<std::vector<GuideRecord>> records(tasks.size());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, tasks.size(), 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end() && !training.stopped(); ++i) {
          const FlushDenormals flush;
          Worker& worker = workers.local();
          worker.camera.begin(tasks[i], frame, kBeautyChannels);
          worker.guide.begin(worker.camera.total());
          StageContext of_task = context;
          of_task.set_camera_task(worker.camera);
          of_task.record_in(worker.guide);
          run_pass<Wide>(of_task, worker.wave);
          records[i] = worker.guide.records(context.guide(), means);
          training.on_samples(static_cast<std::uint64_t>(worker.camera.total()));
        }
      },
      tbb::simple_partitioner());
  return records;
}

}  // namespace

std::vector<TrainingPass> training_passes(int width, int height, std::uint32_t samples) {
  const double pixels = static_cast<double>(width) * height;
  const int stride =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / static_cast<double>(kTrainingPassSamples)))));
  // Camera samples of a pass with one sample per participating pixel.
  const double unit = static_cast<double>(strided(width, stride)) * strided(height, stride);
  const double budget = std::min(kTrainingShare * samples, static_cast<double>(kMaxTraining)) * pixels / unit;
  const auto longest = static_cast<std::uint32_t>(std::max(1.0, static_cast<double>(kTrainingPassSamples) / unit));
  std::vector<TrainingPass> passes;
  std::uint32_t first = 0, count = 1;
  while (first + count <= budget) {
    passes.push_back({first, count, stride});
    first += count;
    if (passes.size() > 1) count = std::min(2 * count, longest);
    // Extend this pass if the remainder would be too short for a pass of its own.
    if (first + 2 * count > budget && first + count <= budget && budget - first <= longest)
      count = static_cast<std::uint32_t>(budget - first);
  }
  return passes;
}

std::uint64_t training_samples(int width, int height, std::span<const TrainingPass> passes) {
  std::uint64_t sum = 0;
  for (const TrainingPass& pass : passes)
    sum += static_cast<std::uint64_t>(strided(width, pass.stride)) *
           static_cast<std::uint64_t>(strided(height, pass.stride)) * pass.sample_count;
  return sum;
}

GuideField train_guide(const StageContext& context, Workers& workers, int width, int height,
                       std::span<const TrainingPass> passes, GuideTraining& training) {
  GuideField field;
  StageContext of_passes = context;
  of_passes.sampler = training_sampler(context.sampler);
  for (const TrainingPass& pass : passes) {
    if (training.stopped()) break;
    std::uint64_t start = timestamp();
    of_passes.sample_from(field.view());
    const auto records = run_pass(of_passes, workers, width, height, pass, field.means(), training);
    training.report.trace_seconds += seconds_since(start);
    start = timestamp();
    for (const auto& task : records) training.report.records += task.size();
    field.train(records, static_cast<std::size_t>(kSplitRecords * std::sqrt(pass.sample_count)));
    training.report.fit_seconds += seconds_since(start);
    ++training.report.passes;
  }
  training.report.samples = training_samples(width, height, passes);
  training.report.cells = field.cells();
  // Statistics count only samples of the image.
  for (Worker& worker : workers) worker.wave.stats.samples = 0;
  return field;
}

}  // namespace sheaf
