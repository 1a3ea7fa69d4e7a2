#include "kernels/photons/photon_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
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

/// Cells whose indices are computed together.
constexpr std::size_t kBatch = 16;
/// Coordinates of these cells, axis by axis.
using Cells = std::array<std::array<std::uint32_t, kBatch>, 3>;

/// The indices along the Hilbert curve of the cells with coordinates `x` of `bits` bits each. Skilling, "Programming
/// the Hilbert curve", AIP Conference Proceedings 707 (2004). The inner loops are vectorized.
std::array<std::uint64_t, kBatch> hilbert_indices(Cells x, int bits) {
  // Undo the reflections and exchanges of axes, from the largest cubes to the smallest
  for (int bit = bits - 1; bit > 0; --bit) {
    const std::uint32_t lower = (1u << bit) - 1;
    for (std::array<std::uint32_t, kBatch>& axis : x)
      for (std::size_t i = 0; i < kBatch; ++i) {
        const std::uint32_t reflects = 0u - (axis[i] >> bit & 1u);  // all bits, or none
        const std::uint32_t exchanged = (x[0][i] ^ axis[i]) & lower & ~reflects;
        x[0][i] ^= exchanged | (lower & reflects);
        axis[i] ^= exchanged;
      }
  }
  // Gray code
  std::array<std::uint64_t, kBatch> indices;
  for (std::size_t i = 0; i < kBatch; ++i) {
    const std::uint32_t y = x[1][i] ^ x[0][i], z = x[2][i] ^ y;
    std::uint32_t flips = z >> 1;  // each bit: the parity of the bits above it
    for (int shift = 1; shift < 32; shift *= 2) flips ^= flips >> shift;
    indices[i] = spread_bits(x[0][i] ^ flips) << 2 | spread_bits(y ^ flips) << 1 | spread_bits(z ^ flips);
  }
  return indices;
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
  std::vector<std::size_t> starts(chunks * digits);
  for_chunks([&](std::size_t chunk, std::size_t begin, std::size_t end) {
    std::size_t* counts = &starts[chunk * digits];
    for (std::size_t i = begin; i < end; ++i) ++counts[from[i] >> shift & mask];
  });
  // Convert the counts to the first index of each chunk for each digit
  std::size_t total = 0;
  for (std::size_t d = 0; d < digits; ++d)
    for (std::size_t c = 0; c < chunks; ++c) {
      const std::size_t here = starts[c * digits + d];
      starts[c * digits + d] = total;
      total += here;
    }
  // Move the keys
  for_chunks([&](std::size_t chunk, std::size_t begin, std::size_t end) {
    std::size_t* next = &starts[chunk * digits];
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
    const double scaled = (static_cast<double>(x) - static_cast<double>(low)) * scale;
    return static_cast<std::uint32_t>(std::clamp(scaled, 0.0, highest));
  };
  // Compute the keys of each task
  std::vector<std::size_t> first(tasks_.size());
  for (std::size_t t = 1; t < tasks_.size(); ++t) first[t] = first[t - 1] + tasks_[t - 1].size();
  keys_ = std::make_unique_for_overwrite<std::uint64_t[]>(size_);
  tbb::parallel_for(TaskRange(0, tasks_.size()), [&](const TaskRange& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t)
      for (std::size_t begin = 0; begin < tasks_[t].size(); begin += kBatch) {
        const std::size_t count = std::min(kBatch, tasks_[t].size() - begin);
        Cells cells = {};
        for (std::size_t i = 0; i < count; ++i) {
          const Vec3f p = tasks_[t][begin + i].p;
          cells[0][i] = cell_of(p.x, bounds.low.x);
          cells[1][i] = cell_of(p.y, bounds.low.y);
          cells[2][i] = cell_of(p.z, bounds.low.z);
        }
        const std::array<std::uint64_t, kBatch> indices = hilbert_indices(cells, axis_bits);
        for (std::size_t i = 0; i < count; ++i)
          keys_[first[t] + begin + i] =
              indices[i] << index_bits_ | static_cast<std::uint64_t>(t) << photon_bits_ | (begin + i);
      }
  });
  return 3 * axis_bits;
}

}  // namespace sheaf
