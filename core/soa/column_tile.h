// A small structure-of-arrays buffer of a record, without an arena: scratch memory of a kernel, on the stack.
#pragma once

#include "core/soa/soa.h"

namespace sheaf {

/// `kRows` rows, a multiple of kWidth. Columns are an odd number of cache lines apart, as in Soa.
template <template <class> class Record, int kRows> class ColumnTile {
 public:
  /// Loads the rows [i, i + L::width). `i` must be a multiple of L::width.
  template <class L> SHEAF_INLINE Record<L> load(int i) const {
    Record<L> out;
    for_each_leaf(out, [&](auto& leaf, int k) SHEAF_LAMBDA_INLINE {
      using Word =
          std::conditional_t<std::is_same_v<std::remove_cvref_t<decltype(leaf)>, Uint<L>>, std::uint32_t, float>;
      sheaf::load(reinterpret_cast<const Word*>(words_[k]) + i, leaf);
    });
    return out;
  }

  /// Stores to the rows [i, i + L::width). `i` must be a multiple of L::width.
  template <class L> SHEAF_INLINE void store(int i, const Record<L>& in) {
    for_each_leaf(in, [&](const auto& leaf, int k) SHEAF_LAMBDA_INLINE {
      using Word =
          std::conditional_t<std::is_same_v<std::remove_cvref_t<decltype(leaf)>, Uint<L>>, std::uint32_t, float>;
      sheaf::store(reinterpret_cast<Word*>(words_[k]) + i, leaf);
    });
  }

 private:
  static_assert(kRows % kWidth == 0);
  static constexpr int kStride = ((kRows * 4 / 64) | 1) * 16;

  template <class R, class F> static SHEAF_INLINE void for_each_leaf(R& record, F&& f) {
    auto all = leaves(record);
    [&]<std::size_t... I>(std::index_sequence<I...>) SHEAF_LAMBDA_INLINE {
      (f(std::get<I>(all), static_cast<int>(I)), ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(all)>>{});
  }

  alignas(64) float words_[kLeafCount<Record>][kStride];
};

}  // namespace sheaf
