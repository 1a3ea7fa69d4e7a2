// The photons of a map along a Hilbert curve: photons that are close in space become close in memory.
#pragma once

#include "kernels/photons/photon.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sheaf {

/// Sorts 64-bit keys stably by their bits [first, end), by all threads. The result does not depend on their number.
void radix_sort(std::unique_ptr<std::uint64_t[]>& keys, std::size_t count, int first, int end);

/// The photons of several tasks, sorted. Photons in the same cell of the curve keep the order of the tasks.
class PhotonOrder {
 public:
  /// `tasks` must remain valid. `cell`: size of the cells of the curve in meters, positive; cells are larger if the
  /// keys do not have enough bits. Does not depend on the number of threads.
  PhotonOrder(const std::vector<std::vector<Photon>>& tasks, float cell);

  std::size_t size() const { return size_; }
  /// The photon at position i of the curve.
  const Photon& operator[](std::size_t i) const {
    const std::uint64_t index = keys_[i] & ((std::uint64_t{1} << index_bits_) - 1);
    return tasks_[index >> photon_bits_][index & ((std::uint64_t{1} << photon_bits_) - 1)];
  }

 private:
  /// Computes the keys. Returns the number of bits of the cells.
  int make_keys(float cell);

  const std::vector<std::vector<Photon>>& tasks_;
  std::size_t size_ = 0;
  /// Bits of a photon's index in its task, and of the index with the task above them.
  int photon_bits_ = 0, index_bits_ = 0;
  /// The cell in the high bits and the index in the low ones.
  std::unique_ptr<std::uint64_t[]> keys_;
};

}  // namespace sheaf
