#include "kernels/photons/photon_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace sheaf {

namespace {

/// Maximum number of bits per digit of the radix sort. The counters of a chunk stay in the first-level cache.
constexpr int kDigitBits = 11;
/// Keys per chunk of the radix sort.
constexpr std::size_t kChunk = 1 << 15;
/// Maximum number of bits of a cell along each axis.
constexpr int kMaxAxisBits = 21;

/// Inserts two zeros between each of the low 21 bits.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

struct Bounds {
  Vec3f low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};

  void add(const Bounds& other) {
    low = {min(low.x, other.low.x), min(low.y, other.low.y), min(low.z, other.low.z)};
    high = {max(high.x, other.high.x), max(high.y, other.high.y), max(high.z, other.high.z)};
  }
};

using TaskRange = tbb::blocked_range<std::size_t>;

Bounds bounds_of(const std::vector<std::vector<Photon>>& tasks) {
  return tbb::parallel_reduce(
      TaskRange(0, tasks.size()), Bounds(),
      [&](const TaskRange& range, Bounds bounds) {
        for (std::size_t t = range.begin(); t < range.end(); ++t)
          for (const Photon& photon : tasks[t]) bounds.add({photon.p, photon.p});
        return bounds;
      },
      [](Bounds a, const Bounds& b) {
        a.add(b);
        return a;
      });
}

/// One pass of the radix sort: sorts `from` by the digit at `shift` into `to`.
void sort_by_digit(const std::uint64_t* from, std::uint64_t* to, std::size_t count, int shift, int bits) {
  const std::size_t digits = std::size_t{1} << bits, chunks = (count + kChunk - 1) / kChunk;
  const std::uint64_t mask = digits - 1;
  const auto for_chunks = [&](auto&& f) {
    tbb::parallel_for(TaskRange(0, chunks, 1), [&](const TaskRange& range) {
      for (std::size_t c = range.begin(); c < range.end(); ++c) f(c, c * kChunk, std::min(count, (c + 1) * kChunk));
    });
  };
  // Count the digits of each chunk
  std::vector<std::size_t> places(chunks * digits);
  for_chunks([&](std::size_t chunk, std::size_t begin, std::size_t end) {
    std::size_t* counts = &places[chunk * digits];
    for (std::size_t i = begin; i < end; ++i) ++counts[from[i] >> shift & mask];
  });
  // Turn the counts into the first place of each chunk for each digit
  std::size_t total = 0;
  for (std::size_t d = 0; d < digits; ++d)
    for (std::size_t c = 0; c < chunks; ++c) {
      const std::size_t here = places[c * digits + d];
      places[c * digits + d] = total;
      total += here;
    }
  // Move the keys
  for_chunks([&](std::size_t chunk, std::size_t begin, std::size_t end) {
    std::size_t* next = &places[chunk * digits];
    for (std::size_t i = begin; i < end; ++i) to[next[from[i] >> shift & mask]++] = from[i];
  });
}

}  // namespace

void radix_sort(std::unique_ptr<std::uint64_t[]>& keys, std::size_t count, int first, int end) {
  if (count < 2 || first >= end) return;
  const int passes = (end - first + kDigitBits - 1) / kDigitBits;
  const int bits = (end - first + passes - 1) / passes;
  auto sorted = std::make_unique_for_overwrite<std::uint64_t[]>(count);
  for (int shift = first; shift < end; shift += bits) {
    sort_by_digit(keys.get(), sorted.get(), count, shift, std::min(bits, end - shift));
    keys.swap(sorted);
  }
}

PhotonOrder::PhotonOrder(const std::vector<std::vector<Photon>>& tasks, float cell) : tasks_(tasks) {
  std::size_t longest = 0;
  for (const std::vector<Photon>& task : tasks) {
    size_ += task.size();
    longest = std::max(longest, task.size());
  }
  if (size_ == 0) return;
  photon_bits_ = std::bit_width(longest - 1);
  index_bits_ = photon_bits_ + std::bit_width(tasks.size() - 1);
  assert(index_bits_ <= 61);
  const int bits = make_keys(cell);
  radix_sort(keys_, size_, index_bits_, index_bits_ + bits);
}

int PhotonOrder::make_keys(float cell) {
  // Choose the size of the cells
  const Bounds bounds = bounds_of(tasks_);
  const Vec3f extent = bounds.high - bounds.low;
  const double widest = static_cast<double>(max_component(extent)), cells = widest / static_cast<double>(cell);
  const int most = std::min(kMaxAxisBits, (64 - index_bits_) / 3);
  const int axis_bits = static_cast<int>(std::clamp(std::ceil(std::log2(cells + 1.0)), 1.0, static_cast<double>(most)));
  const double highest = std::ldexp(1.0, axis_bits) - 1.0;
  const double scale = widest > 0.0 ? std::min(1.0 / static_cast<double>(cell), highest / widest) : 0.0;
  const auto cell_of = [&](float x, float low) {
    const double place = (static_cast<double>(x) - static_cast<double>(low)) * scale;
    return spread_bits(static_cast<std::uint64_t>(std::clamp(place, 0.0, highest)));
  };
  // Compute the keys of each task
  std::vector<std::size_t> first(tasks_.size());
  for (std::size_t t = 1; t < tasks_.size(); ++t) first[t] = first[t - 1] + tasks_[t - 1].size();
  keys_ = std::make_unique_for_overwrite<std::uint64_t[]>(size_);
  tbb::parallel_for(TaskRange(0, tasks_.size()), [&](const TaskRange& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t)
      for (std::size_t i = 0; i < tasks_[t].size(); ++i) {
        const Vec3f p = tasks_[t][i].p;
        const std::uint64_t code =
            cell_of(p.x, bounds.low.x) | cell_of(p.y, bounds.low.y) << 1 | cell_of(p.z, bounds.low.z) << 2;
        keys_[first[t] + i] = code << index_bits_ | static_cast<std::uint64_t>(t) << photon_bits_ | i;
      }
  });
  return 3 * axis_bits;
}

}  // namespace sheaf
