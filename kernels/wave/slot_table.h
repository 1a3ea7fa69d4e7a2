// Records that are accessed by slot: one aligned row of 32 or 64 bytes per path, transposed to and from registers.
//
// After sorting, the paths of a tile lie anywhere in the wave. Gathering eight columns would touch eight cache lines
// per path. A row touches one, and its transpose to registers costs a few shuffles (bench/bench_core.cpp).
#pragma once

#include "core/simd/simd_rows.h"
#include "core/soa/record_table.h"
#include "kernels/wave/slot_list.h"

namespace sheaf {

/// Rows of `Record`, which must have 8 or 16 leaves.
template <template <class> class Record> class SlotTable {
 public:
  using Row = Record<Scalar>;
  static constexpr int kWords = kLeafCount<Record>;
  static_assert(kWords == 8 || kWords == 16, "a row must fill half a cache line or a whole one");
  static_assert(record_table_detail::kIsRow<Record>);

  static std::size_t bytes(int capacity) { return static_cast<std::size_t>(capacity) * sizeof(Row) + kSimdAlignment; }

  void bind(Arena& arena, int capacity) { rows_ = arena.take<Row>(static_cast<std::size_t>(capacity)); }

  /// Gathers the rows of slots[0 .. L::width). All slots must be valid (see SlotList::pad).
  template <class L> SHEAF_INLINE Record<L> gather(const Slot* slots) const {
    const float* rows[L::width];
    for (int lane = 0; lane < L::width; ++lane) rows[lane] = reinterpret_cast<const float*>(rows_ + slots[lane]);
    typename L::Float words[kWords];
    for (int quad = 0; quad < kWords; quad += 4) {
      load_rows4(rows, words + quad);
      for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
    }
    return record_of_words<L, Record>(words);
  }

  /// Stores the first `count` lanes to the rows of slots[0 .. count).
  template <class L> SHEAF_INLINE void scatter(const Slot* slots, int count, const Record<L>& in) {
    typename L::Float words[kWords];
    words_of_record<L, Record>(in, words);
    float* rows[L::width];
    for (int lane = 0; lane < L::width; ++lane)
      rows[lane] = reinterpret_cast<float*>(rows_ + slots[lane < count ? lane : 0]);
    for (int quad = 0; quad < kWords; quad += 4) {
      store_rows4(rows, words + quad, count);
      for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
    }
  }

  /// Stores the lanes set in `lanes`. All slots must be valid.
  template <class L> SHEAF_INLINE void scatter_lanes(const Slot* slots, std::uint32_t lanes, const Record<L>& in) {
    typename L::Float words[kWords];
    words_of_record<L, Record>(in, words);
    float discarded[kWords];
    float* rows[L::width];
    for (int lane = 0; lane < L::width; ++lane)
      rows[lane] = (lanes >> lane & 1u) != 0 ? reinterpret_cast<float*>(rows_ + slots[lane]) : discarded;
    for (int quad = 0; quad < kWords; quad += 4) {
      store_rows4(rows, words + quad, L::width);
      for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
    }
  }

  /// A reference to one row, for scalar code that reads or writes some of its members.
  SHEAF_INLINE Row& row(Slot slot) { return rows_[slot]; }
  SHEAF_INLINE const Row& row(Slot slot) const { return rows_[slot]; }
  /// Copies a whole row, and replaces it.
  Row get(Slot slot) const { return gather<Scalar>(&slot); }
  void set(Slot slot, const Row& in) { scatter<Scalar>(&slot, 1, in); }

 private:
  Row* rows_ = nullptr;
};

}  // namespace sheaf
