// Camera task: the camera samples that one worker takes, the position of the next sample, and the buffer of finished
// samples.
#pragma once

#include "core/image/pixel_rect.h"
#include "kernels/film/aovs.h"
#include "kernels/film/sample_buffer.h"

#include <cassert>
#include <span>

namespace sheaf {

/// The sampled pixels: those of the frame and a border around it.
struct SampledFrame {
  int width = 1;   ///< of the frame
  int border = 0;  ///< pixels on each side

  int row_length() const { return width + 2 * border; }
  /// Linear index of a pixel of the frame or its border.
  std::uint32_t pixel(int x, int y) const {
    return static_cast<std::uint32_t>((y + border) * row_length() + x + border);
  }
  int x(std::uint32_t pixel) const { return static_cast<int>(pixel) % row_length() - border; }
  int y(std::uint32_t pixel) const { return static_cast<int>(pixel) / row_length() - border; }
};

/// The samples [first_sample, first_sample + sample_count) of one pixel.
struct PixelSamples {
  std::uint32_t pixel = 0;  ///< SampledFrame::pixel()
  std::uint32_t first_sample = 0, sample_count = 0;
};

/// The same sample range for every pixel of a rectangle, row by row.
inline std::vector<PixelSamples> samples_of(const PixelRect& pixels, const SampledFrame& frame,
                                            std::uint32_t first_sample, std::uint32_t sample_count) {
  std::vector<PixelSamples> list;
  for (int y = pixels.y0; y < pixels.y1; ++y)
    for (int x = pixels.x0; x < pixels.x1; ++x) list.push_back({frame.pixel(x, y), first_sample, sample_count});
  return list;
}

/// Camera samples that one worker takes in one go. The source is the camera_rays stage, the sink is the accumulate
/// stage.
class CameraTask {
 public:
  /// Position of the next sample. Samples are numbered through the whole list, from 0.
  struct Cursor {
    std::size_t entry = 0;     ///< in the list
    std::uint32_t sample = 0;  ///< relative to the entry's first sample
    int index = 0;             ///< among all samples
    int x = 0, y = 0;          ///< the entry's pixel in the frame
  };

  /// Begins a list of samples; the caller keeps the list alive until the task ends. `channels`: number of channels of a
  /// sample. `spectral_bins`: those of the film. `aovs`: channel indices of the AOVs of the first surface.
  void begin(std::span<const PixelSamples> pixels, SampledFrame frame, int channels, int spectral_bins = 0,
             const AovChannels& aovs = {}) {
    pixels_ = pixels;
    frame_ = frame;
    spectral_bins_ = spectral_bins;
    aovs_ = aovs;
    total_ = 0;
    for (const PixelSamples& p : pixels) total_ += static_cast<int>(p.sample_count);
    cursor = {};
    enter();
    samples.resize(total_, channels, spectral_bins > 0, aovs.has_surfaces());
    // Paths that hit no surface, or no light of a group, do not write these layers.
    if (channels > kBeautyChannels) samples.clear();
  }

  std::span<const PixelSamples> pixels() const { return pixels_; }
  const SampledFrame& frame() const { return frame_; }
  int spectral_bins() const { return spectral_bins_; }
  const AovChannels& aovs() const { return aovs_; }
  int total() const { return total_; }                ///< number of samples
  int left() const { return total_ - cursor.index; }  ///< samples not started yet

  /// Pixel and absolute sample index at the cursor. Requires left() > 0.
  std::uint32_t pixel() const { return pixels_[cursor.entry].pixel; }
  std::uint32_t sample() const { return pixels_[cursor.entry].first_sample + cursor.sample; }
  int x() const { return cursor.x; }
  int y() const { return cursor.y; }
  void advance() {
    assert(left() > 0);
    ++cursor.index;
    if (++cursor.sample < pixels_[cursor.entry].sample_count) return;
    cursor.sample = 0;
    ++cursor.entry;
    enter();
  }

  Cursor cursor;
  SampleBuffer samples;  ///< in the order of the list

 private:
  void enter() {
    while (cursor.entry < pixels_.size() && pixels_[cursor.entry].sample_count == 0) ++cursor.entry;
    if (cursor.entry == pixels_.size()) return;
    cursor.x = frame_.x(pixel());
    cursor.y = frame_.y(pixel());
  }

  std::span<const PixelSamples> pixels_;
  SampledFrame frame_;
  int spectral_bins_ = 0, total_ = 0;
  AovChannels aovs_;
};

}  // namespace sheaf
