// The lanes of registers in memory, for code that processes one lane at a time, and the addresses of table rows.
#pragma once

#include "core/simd/lanes.h"
#include "core/simd/simd_rows.h"
#include "core/soa/column_tile.h"

namespace sheaf {

/// Calls f(lane) for each lane set in `lanes` (see mask_bits()), in ascending order.
template <class F> SHEAF_INLINE void for_each_lane(std::uint32_t lanes, F&& f) {
  for (; lanes != 0; lanes &= lanes - 1) f(std::countr_zero(lanes));
}

/// The values of a register: L::Float or L::Uint.
template <class V> class LaneArray {
 public:
  using Word =
      std::conditional_t<std::is_same_v<V, WideUint> || std::is_same_v<V, std::uint32_t>, std::uint32_t, float>;
  static constexpr int kLanes = std::is_same_v<V, Word> ? 1 : kWidth;

  /// Values are not initialized.
  SHEAF_INLINE LaneArray() {}
  explicit SHEAF_INLINE LaneArray(V values) { store(words_, values); }

  SHEAF_INLINE Word& operator[](int lane) { return words_[lane]; }
  SHEAF_INLINE Word operator[](int lane) const { return words_[lane]; }
  SHEAF_INLINE const Word* begin() const { return words_; }
  SHEAF_INLINE const Word* end() const { return words_ + kLanes; }

  SHEAF_INLINE V load() const {
    V values;
    sheaf::load(words_, values);
    return values;
  }

 private:
  alignas(kSimdAlignment) Word words_[kLanes];
};

/// The register with the value f(lane) in each lane. V: L::Float or L::Uint.
template <class V, class F> SHEAF_INLINE V make_lanes(F&& f) {
  LaneArray<V> values;
  for (int lane = 0; lane < LaneArray<V>::kLanes; ++lane) values[lane] = f(lane);
  return values.load();
}

/// The lanes of a record in registers, one row per lane.
template <class L, template <class> class Record> class LaneRows {
 public:
  /// Rows are not initialized.
  SHEAF_INLINE LaneRows() {}
  explicit SHEAF_INLINE LaneRows(const Record<L>& record) { rows_.template store<L>(0, record); }

  SHEAF_INLINE Record<Scalar> operator[](int lane) const { return rows_.template load<Scalar>(lane); }
  SHEAF_INLINE void set(int lane, const Record<Scalar>& row) { rows_.template store<Scalar>(lane, row); }
  SHEAF_INLINE Record<L> load() const { return rows_.template load<L>(0); }

 private:
  ColumnTile<Record, kWidth> rows_;
};

/// The addresses of table[index], one for each lane, to read rows of words of which each lane needs all.
template <class L> class RowPointers {
 public:
  template <class Row> SHEAF_INLINE RowPointers(const Row* table, Uint<L> index) {
    const LaneArray<Uint<L>> rows(index);
    for (int lane = 0; lane < L::width; ++lane) rows_[lane] = reinterpret_cast<const float*>(table + rows[lane]);
  }

  /// Reads the next four words of each row: out[k] is the k-th of them.
  SHEAF_INLINE void read_four(Float<L>* out) {
    load_rows4(rows_, out);
    for (const float*& row : rows_) row += 4;
  }

 private:
  const float* rows_[L::width];
};

/// Reads four words per lane from base + index[lane]. The table must be readable three words beyond its last row.
template <class L> SHEAF_INLINE void gather_row4(const float* base, typename L::Uint index, typename L::Float* out) {
  RowPointers<L>(base, index).read_four(out);
}

}  // namespace sheaf
