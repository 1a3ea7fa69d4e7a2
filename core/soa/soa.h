// Structures of arrays (SoA) of records that are declared once.
//
// A record is a template over the lane policy with one fields() function. `Record<Wide>` is a register tile,
// `Record<Scalar>` a row, and `Soa<Record>` the storage: one padded, aligned column per leaf. Leaves are found by
// walking fields(), so records can nest (Vec3, Spectrum) and there is no second list of members to maintain.
#pragma once

#include "core/simd/lanes.h"
#include "core/simd/simd_compress.h"
#include "core/soa/arena.h"

#include <tuple>
#include <type_traits>
#include <utility>

namespace sheaf {

template <class T>
concept HasFields = requires(T& t) {
  T::fields(t);
};

/// References to all leaves of a record, in declaration order, as one flat tuple. Arrays count as their elements.
template <class T> SHEAF_INLINE constexpr auto leaves(T& value) {
  if constexpr (std::is_array_v<T>) {
    return [&value]<std::size_t... I>(std::index_sequence<I...>) SHEAF_LAMBDA_INLINE {
      return std::tuple_cat(leaves(value[I])...);
    }
    (std::make_index_sequence<std::extent_v<T>>{});
  } else if constexpr (HasFields<std::remove_const_t<T>>) {
    return std::apply([](auto&... field) SHEAF_LAMBDA_INLINE { return std::tuple_cat(leaves(field)...); },
                      std::remove_const_t<T>::fields(value));
  } else {
    return std::tuple<T&>(value);
  }
}

/// Number of leaves, which is also the number of 32-bit words of one row.
template <template <class> class Record>
inline constexpr int kLeafCount =
    static_cast<int>(std::tuple_size_v<decltype(leaves(std::declval<Record<Scalar>&>()))>);

/// Calls f(leaf of a, leaf of b) for every pair of leaves.
template <class A, class B, class F> SHEAF_INLINE void zip_leaves(A& a, B& b, F&& f) {
  auto ta = leaves(a);
  auto tb = leaves(b);
  static_assert(std::tuple_size_v<decltype(ta)> == std::tuple_size_v<decltype(tb)>);
  [&]<std::size_t... I>(std::index_sequence<I...>) SHEAF_LAMBDA_INLINE { (f(std::get<I>(ta), std::get<I>(tb)), ...); }
  (std::make_index_sequence<std::tuple_size_v<decltype(ta)>>{});
}

/// Columns of a record in an arena. Capacity is rounded up to whole registers plus one, so that whole tiles can always
/// be read and written. Columns are an odd number of cache lines apart: an even stride, especially a power of two,
/// would use only some of the cache's sets.
template <template <class> class Record> class Soa {
 public:
  /// Bytes that bind() takes from the arena.
  static std::size_t bytes(int capacity, int columns = kLeafCount<Record>) {
    return static_cast<std::size_t>(columns) * stride(capacity) * sizeof(float) + kSimdAlignment;
  }

  /// Binds only the first `columns` columns. Loads and stores of whole rows need all.
  void bind(Arena& arena, int capacity, int columns = kLeafCount<Record>) {
    capacity_ = capacity;
    auto* next = arena.take<float>(static_cast<std::size_t>(columns) * stride(capacity));
    int left = columns;
    const auto assign = [&]<class T>(T*& column) {
      if (left-- <= 0) return;
      column = reinterpret_cast<T*>(next);
      next += stride(capacity);
    };
    std::apply([&](auto&... column) { (assign(column), ...); }, leaves(columns_));
  }

  /// Loads the rows [i, i + L::width). `i` must be a multiple of L::width.
  template <class L> SHEAF_INLINE Record<L> load(int i) const {
    Record<L> out;
    zip_leaves(columns_, out, [i](auto* column, auto& leaf) SHEAF_LAMBDA_INLINE { sheaf::load(column + i, leaf); });
    return out;
  }

  /// Stores to the rows [i, i + L::width). `i` must be a multiple of L::width.
  template <class L> SHEAF_INLINE void store(int i, const Record<L>& in) {
    zip_leaves(columns_, in,
               [i](auto* column, const auto& leaf) SHEAF_LAMBDA_INLINE { sheaf::store(column + i, leaf); });
  }

  /// Writes the lanes of `in` that `mask` selects to consecutive rows, beginning at `i`. Returns their number.
  template <class L> SHEAF_INLINE int compress(int i, const Record<L>& in, typename L::Mask mask) {
    const std::uint32_t bits = mask_bits(mask);
    zip_leaves(columns_, in, [i, bits](auto* column, const auto& leaf) SHEAF_LAMBDA_INLINE {
      compress_store(column + i, leaf, bits);
    });
    return std::popcount(bits);
  }

  /// The columns, for kernels that access only some of them.
  const Record<Columns>& columns() const { return columns_; }
  int capacity() const { return capacity_; }

 private:
  static std::size_t stride(int capacity) {
    const auto rounded = (static_cast<std::size_t>(capacity) / kWidth + 2) * kWidth;
    const std::size_t lines = (rounded * sizeof(float) + kSimdAlignment - 1) / kSimdAlignment;
    return (lines | 1u) * kSimdAlignment / sizeof(float);
  }

  Record<Columns> columns_{};
  int capacity_ = 0;
};

}  // namespace sheaf
