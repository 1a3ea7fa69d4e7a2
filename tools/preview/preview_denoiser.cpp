#include "tools/preview/preview_denoiser.h"

#include "core/io/error.h"
#include "kernels/denoise/denoise.h"

#include <sys/resource.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sheaf {

namespace {

/// Lower priority of the denoiser's thread.
constexpr int kNice = 10;

bool has_oidn() {
  try {
    check_denoiser(Denoiser::kOidn);
    return true;
  } catch (const Error&) { return false; }
}

/// The image without the named channels, and with other channels appended, which are zero.
Image with_other_channels(const Image& image, const std::array<std::string, 6>& removed,
                          const std::array<std::string, 3>& added) {
  std::vector<std::string> names;
  std::vector<std::size_t> sources;
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    if (std::find(removed.begin(), removed.end(), image.channels[c]) != removed.end()) continue;
    names.push_back(image.channels[c]);
    sources.push_back(c);
  }
  names.insert(names.end(), added.begin(), added.end());
  Image out(image.width, image.height, std::move(names));
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    for (std::size_t k = 0; k < sources.size(); ++k)
      out.data[i * out.channels.size() + k] = image.data[i * image.channels.size() + sources[k]];
  return out;
}

}  // namespace

Image with_estimated_variances(const Image& image) {
  // Radius of the mean of squared differences, and distance at which the noise of pixels with a wide filter is
  // independent, pixels
  constexpr int kRadius = 4, kDistance = 4;
  const std::array<std::string, 3> colors{"R", "G", "B"}, variances{"variance.R", "variance.G", "variance.B"},
      halves{"half.R", "half.G", "half.B"};
  std::array<std::string, 6> removed;
  std::copy(variances.begin(), variances.end(), removed.begin());
  std::copy(halves.begin(), halves.end(), removed.begin() + 3);
  Image out = with_other_channels(image, removed, variances);
  const int width = out.width, height = out.height;
  std::vector<float> squares(out.pixel_count());
  for (std::size_t c = 0; c < 3; ++c) {
    const int color = out.find_channel(colors[c]), variance = out.find_channel(variances[c]);
    if (color < 0) continue;
    const auto at = [&](int x, int y) {
      return out.at(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1), color);
    };
    // The second difference of independent pixels has 1.5 times the variance of a pixel. The smaller one of two
    // directions ignores most edges; the mean of its square is 0.363 times as large.
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        const float along_x = at(x, y) - 0.5f * (at(x - kDistance, y) + at(x + kDistance, y));
        const float along_y = at(x, y) - 0.5f * (at(x, y - kDistance) + at(x, y + kDistance));
        const float difference = std::min(std::abs(along_x), std::abs(along_y));
        squares[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
            difference * difference / (1.5f * 0.363f);
      }
    });
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        float sum = 0, count = 0;
        for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, height - 1); ++v)
          for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, width - 1); ++u) {
            sum += squares[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
            ++count;
          }
        out.at(x, y, variance) = sum / count;
      }
    });
  }
  return out;
}

PreviewDenoiser::PreviewDenoiser(Done done) : done_(std::move(done)), thread_([this] { run(); }) {}

PreviewDenoiser::~PreviewDenoiser() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    group_.cancel();
  }
  changed_.notify_all();
  thread_.join();
}

void PreviewDenoiser::submit(int number, std::shared_ptr<const Image> image, bool has_variances) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(image);
    number_ = number;
    has_variances_ = has_variances;
  }
  changed_.notify_all();
}

void PreviewDenoiser::run() {
  [[maybe_unused]] const bool is_low = setpriority(PRIO_PROCESS, 0, kNice) == 0;  // on Linux, of this thread only
  tbb::task_arena arena(static_cast<int>(std::max(1u, std::thread::hardware_concurrency() / 2)));
  const Denoiser denoiser = has_oidn() ? Denoiser::kOidn : Denoiser::kNlMeans;
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return waiting_ || stop_; });
    if (stop_) return;
    const std::shared_ptr<const Image> image = std::exchange(waiting_, nullptr);
    const int number = number_;
    const bool estimates = !has_variances_ && denoiser == Denoiser::kNlMeans;
    lock.unlock();
    // Errors, such as images that are too large, leave the preview without a denoised image.
    try {
      Image denoised;
      const auto work = [&] {
        denoised = denoised_only(denoise(estimates ? with_estimated_variances(*image) : *image, denoiser).image);
      };
      const tbb::task_group_status status = arena.execute([&] { return group_.run_and_wait(work); });
      if (status != tbb::canceled) done_(number, denoised);
    } catch (const std::exception&) {}
    lock.lock();
  }
}

}  // namespace sheaf
