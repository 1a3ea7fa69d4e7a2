// Denoises previews beside a running render.
#pragma once

#include "core/image/image.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <tbb/task_group.h>

namespace sheaf {

/// Denoises images on a thread of its own and at most half of the processors: with Open Image Denoise if it is
/// installed, otherwise with non-local means.
class PreviewDenoiser {
 public:
  /// Receives the number of the image, and R, G, B and A. Called on the denoiser's thread.
  using Done = std::function<void(int number, const Image& image)>;

  explicit PreviewDenoiser(Done done);
  /// Cancels denoising.
  ~PreviewDenoiser();
  PreviewDenoiser(const PreviewDenoiser&) = delete;
  PreviewDenoiser& operator=(const PreviewDenoiser&) = delete;

  /// Denoises the image next. Replaces an image that is still waiting. `has_variances`: the image has valid layers
  /// variance.R/G/B.
  void submit(int number, std::shared_ptr<const Image> image, bool has_variances);

 private:
  void run();

  const Done done_;
  std::mutex mutex_;  ///< guards the members below
  std::condition_variable changed_;
  std::shared_ptr<const Image> waiting_;  ///< null: none
  int number_ = 0;
  bool has_variances_ = false, stop_ = false;
  tbb::task_group group_;  ///< of the current image; thread-safe
  std::thread thread_;     ///< last member: it uses the others
};

/// Replaces the layers variance.R/G/B by estimates from the differences between nearby pixels, for images without valid
/// variances. Textures count as noise. Removes the layers half.R/G/B, which may be incomplete.
Image with_estimated_variances(const Image& image);

}  // namespace sheaf
