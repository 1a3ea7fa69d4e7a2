// Copies of the state of a wave, for tests and benchmarks that run a stage repeatedly from the same state.
#pragma once

#include "kernels/wave/wave.h"

#include <array>
#include <vector>

namespace sheaf {

/// All queues of a wave, without its statistics.
class WaveSnapshot {
 public:
  explicit WaveSnapshot(const Wave& wave)
      : memory_(wave.arena.memory().begin(), wave.arena.memory().end()), shadow_count_(wave.shadow_count) {
    for (int i = 0; i < kSlotLists; ++i) sizes_[static_cast<std::size_t>(i)] = (wave.*PathPool::kLists[i]).size();
    std::copy(std::begin(wave.runs), std::end(wave.runs), runs_.begin());
  }

  /// Restores the copied state in a wave of the same capacity and needs.
  void restore(Wave& wave) const {
    assert(wave.arena.memory().size() == memory_.size());
    std::copy(memory_.begin(), memory_.end(), wave.arena.memory().begin());
    for (int i = 0; i < kSlotLists; ++i) (wave.*PathPool::kLists[i]).resize(sizes_[static_cast<std::size_t>(i)]);
    std::copy(runs_.begin(), runs_.end(), std::begin(wave.runs));
    wave.shadow_count = shadow_count_;
  }

 private:
  std::vector<unsigned char> memory_;
  std::array<int, kSlotLists> sizes_{};
  std::array<VertexRun, kClosureKinds> runs_;
  int shadow_count_;
};

}  // namespace sheaf
