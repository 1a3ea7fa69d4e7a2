// Lists of path slots, by which stages pass paths to each other.
#pragma once

#include "core/simd/lanes.h"
#include "core/simd/simd_compress.h"
#include "core/soa/arena.h"

#include <bit>
#include <span>

namespace sheaf {

/// Index of a path in its wave.
using Slot = std::uint16_t;

/// A list of slots with room for a whole wave and one more register.
class SlotList {
 public:
  static std::size_t bytes(int capacity) {
    return static_cast<std::size_t>(padded(capacity)) * sizeof(Slot) + kSimdAlignment;
  }

  void bind(Arena& arena, int capacity) {
    capacity_ = capacity;
    slots_ = arena.take<Slot>(static_cast<std::size_t>(padded(capacity)));
    size_ = 0;
  }

  SHEAF_INLINE void push(Slot slot) {
    assert(size_ < capacity_);
    slots_[size_++] = slot;
  }

  /// Pushes slots[lane] for every lane set in `bits`, in lane order. If lanes beyond the first may be set, kWidth slots
  /// must be readable.
  SHEAF_INLINE void push(const Slot* slots, std::uint32_t bits) {
    assert(size_ + std::popcount(bits) <= capacity_);
    if (bits <= 1) {
      slots_[size_] = slots[0];
      size_ += static_cast<int>(bits);
      return;
    }
    compress_copy(slots_ + size_, slots, bits);
    size_ += std::popcount(bits);
  }

  Slot pop() {
    assert(size_ > 0);
    return slots_[--size_];
  }

  /// Repeats the last slot behind the end, so that a partial last tile can be gathered as a whole.
  void pad() {
    if (size_ == 0) return;
    for (int i = size_; i < size_ + kWidth; ++i) slots_[i] = slots_[size_ - 1];
  }

  void clear() { size_ = 0; }
  int size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const Slot* data() const { return slots_; }
  Slot* data() { return slots_; }
  Slot operator[](int i) const { return slots_[i]; }
  std::span<const Slot> span() const { return {slots_, static_cast<std::size_t>(size_)}; }
  void swap(SlotList& other) noexcept { std::swap(*this, other); }

  /// Sets the size after slots were written through data().
  void resize(int size) {
    assert(size <= capacity_);
    size_ = size;
  }

 private:
  static int padded(int capacity) { return capacity + 2 * kWidth; }

  Slot* slots_ = nullptr;
  int size_ = 0, capacity_ = 0;
};

/// Calls f(begin, count) for tiles of L::width items, the last of which may be partial.
template <class L, class F> SHEAF_INLINE void for_tiles(int items, F&& f) {
  for (int i = 0; i < items; i += L::width) f(i, std::min(L::width, items - i));
}

}  // namespace sheaf
