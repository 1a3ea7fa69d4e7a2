// Storage that is reached by slot: one aligned row of 32 or 64 bytes per path, transposed on the way to registers.
//
// After sorting, the paths of a tile lie anywhere in the wave. Eight gathers from eight columns would touch eight cache
// lines per path; a row touches one, and turning rows into registers costs a few shuffles (bench/bench_core.cpp).
#pragma once

#include "core/slot_list.h"
#include "core/soa.h"

namespace sheaf {

/// Rows of `Record`, which must have 8 or 16 leaves.
template <template <class> class Record> class Groups {
 public:
  static constexpr int kWords = kLeafCount<Record>;
  static_assert(kWords == 8 || kWords == 16, "a row must fill half a cache line or a whole one");

  static std::size_t bytes(int capacity) {
    return static_cast<std::size_t>(capacity) * kWords * sizeof(float) + kSimdAlignment;
  }

  void bind(Arena& arena, int capacity) { rows_ = arena.take<float>(static_cast<std::size_t>(capacity) * kWords); }

  /// The rows of slots[0 .. L::width). All of them must be valid (see SlotList::pad).
  template <class L> SHEAF_INLINE Record<L> gather(const Slot* slots) const {
    const float* rows[L::width];
    for (int lane = 0; lane < L::width; ++lane) rows[lane] = rows_ + slots[lane] * kWords;
    typename L::Float words[kWords];
    for (int quad = 0; quad < kWords; quad += 4) {
      load_rows4(rows, words + quad);
      for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
    }
    Record<L> out;
    unpack(out, words);
    return out;
  }

  /// Stores the first `count` lanes to the rows of slots[0 .. count).
  template <class L> SHEAF_INLINE void scatter(const Slot* slots, int count, const Record<L>& in) {
    typename L::Float words[kWords];
    pack(in, words);
    float* rows[L::width];
    for (int lane = 0; lane < L::width; ++lane) rows[lane] = rows_ + slots[lane < count ? lane : 0] * kWords;
    for (int quad = 0; quad < kWords; quad += 4) {
      store_rows4(rows, words + quad, count);
      for (int lane = 0; lane < L::width; ++lane) rows[lane] += 4;
    }
  }

  /// One row, for tests, scalar code and single words: 8 or 16 words in leaf order.
  float* row(Slot slot) { return rows_ + slot * kWords; }
  const float* row(Slot slot) const { return rows_ + slot * kWords; }
  Record<Scalar> get(Slot slot) const { return gather<Scalar>(&slot); }
  void set(Slot slot, const Record<Scalar>& in) { scatter<Scalar>(&slot, 1, in); }

 private:
  template <class L> static SHEAF_INLINE void unpack(Record<L>& out, const typename L::Float* words) {
    std::apply(
        [words](auto&... leaf) SHEAF_LAMBDA_INLINE {
          int i = 0;
          (from_word(words[i++], leaf), ...);
        },
        leaves(out));
  }
  template <class L> static SHEAF_INLINE void pack(const Record<L>& in, typename L::Float* words) {
    std::apply(
        [words](const auto&... leaf) SHEAF_LAMBDA_INLINE {
          int i = 0;
          ((words[i++] = to_word(leaf)), ...);
        },
        leaves(in));
  }
  static SHEAF_INLINE void from_word(WideFloat w, WideFloat& leaf) { leaf = w; }
  static SHEAF_INLINE void from_word(WideFloat w, WideUint& leaf) { leaf = float_bits(w); }
  static SHEAF_INLINE void from_word(float w, float& leaf) { leaf = w; }
  static SHEAF_INLINE void from_word(float w, std::uint32_t& leaf) { leaf = float_bits(w); }
  static SHEAF_INLINE WideFloat to_word(WideFloat leaf) { return leaf; }
  static SHEAF_INLINE WideFloat to_word(WideUint leaf) { return bits_float(leaf); }
  static SHEAF_INLINE float to_word(float leaf) { return leaf; }
  static SHEAF_INLINE float to_word(std::uint32_t leaf) { return bits_float(leaf); }

  float* rows_ = nullptr;
};

}  // namespace sheaf
