// Tables for gathers: arrays of a record's Scalar form, of which every lane reads one row.
//
// A record is declared once, as for queues (core/soa/soa.h). `Record<Scalar>` is a row of the table. A kernel gathers
// the rows of its lanes as a `Record<L>`, or a named member of them.
#pragma once

#include "core/soa/lane_array.h"

#include <array>
#include <type_traits>

namespace sheaf {

/// The type of a member: an enumeration in a table, its number in registers.
template <class L, class Enum> using EnumIn = std::conditional_t<std::is_same_v<L, Scalar>, Enum, typename L::Uint>;

/// The alignment of a record, for alignas: `bytes` in a table, its natural alignment in registers.
template <class L> constexpr std::size_t row_alignment(std::size_t bytes) {
  return std::is_same_v<L, Scalar> ? bytes : alignof(typename L::Float);
}

/// Sets a leaf of a record to the value that a word stores: numbers and integers keep their bits.
template <class L> SHEAF_INLINE void set_leaf(Float<L>& leaf, Float<L> word) { leaf = word; }
template <class L> SHEAF_INLINE void set_leaf(Uint<L>& leaf, Float<L> word) { leaf = float_bits(word); }
template <class L, class Enum>
requires std::is_enum_v<Enum> SHEAF_INLINE void set_leaf(Enum& leaf, float word) {
  static_assert(sizeof(Enum) == sizeof(std::uint32_t));
  leaf = static_cast<Enum>(float_bits(word));
}
/// The word that stores a leaf; the inverse of set_leaf().
SHEAF_INLINE WideFloat word_of_leaf(WideFloat leaf) { return leaf; }
SHEAF_INLINE WideFloat word_of_leaf(WideUint leaf) { return bits_float(leaf); }
SHEAF_INLINE float word_of_leaf(float leaf) { return leaf; }
SHEAF_INLINE float word_of_leaf(std::uint32_t leaf) { return bits_float(leaf); }

namespace record_table_detail {

/// The words of a record in registers, in leaf order.
template <class L, template <class> class Record> SHEAF_INLINE void to_words(const Record<L>& in, Float<L>* words) {
  std::apply(
      [words](const auto&... leaf) SHEAF_LAMBDA_INLINE {
        int k = 0;
        ((words[k++] = word_of_leaf(leaf)), ...);
      },
      leaves(in));
}

template <class L, class Row> SHEAF_INLINE Uint<L> first_words(Uint<L> index) {
  static_assert(sizeof(Row) % sizeof(float) == 0);
  return index * Uint<L>(static_cast<std::uint32_t>(sizeof(Row) / sizeof(float)));
}

/// Whether the Scalar form of a record consists of its leaves only, one word each, in declaration order.
template <template <class> class Record>
inline constexpr bool kIsRow = std::is_trivially_copyable_v<Record<Scalar>> &&
                               sizeof(Record<Scalar>) == sizeof(float) * std::size_t{kLeafCount<Record>};

}  // namespace record_table_detail

/// The record with the leaves `words`, in declaration order.
template <class L, template <class> class Record> SHEAF_INLINE Record<L> record_of_words(const Float<L>* words) {
  Record<L> out;
  std::apply(
      [words](auto&... leaf) SHEAF_LAMBDA_INLINE {
        int k = 0;
        (set_leaf<L>(leaf, words[k++]), ...);
      },
      leaves(out));
  return out;
}

/// Writes the leaves of a record to `words`, in declaration order; the inverse of record_of_words().
template <class L, template <class> class Record>
SHEAF_INLINE void words_of_record(const Record<L>& in, Float<L>* words) {
  record_table_detail::to_words<L, Record>(in, words);
}

/// Gathers the rows table[index], one for each lane. The size of a row must be a multiple of four words.
template <class L, template <class> class Record>
SHEAF_INLINE Record<L> gather_rows(const Record<Scalar>* table, Uint<L> index) {
  static_assert(record_table_detail::kIsRow<Record> && kLeafCount<Record> % 4 == 0);
  constexpr int kWords = kLeafCount<Record>;
  const auto* base = reinterpret_cast<const float*>(table);
  const Uint<L> row = record_table_detail::first_words<L, Record<Scalar>>(index);
  Float<L> words[kWords];
  for (int k = 0; k < kWords; k += 4) gather_row4<L>(base + k, row, words + k);
  return record_of_words<L, Record>(words);
}

/// Broadcasts one row to all lanes.
template <class L, template <class> class Record> SHEAF_INLINE Record<L> spread_row(const Record<Scalar>& row) {
  static_assert(record_table_detail::kIsRow<Record>);
  const auto* const first = reinterpret_cast<const float*>(&row);
  Float<L> words[kLeafCount<Record>];
  for (int k = 0; k < kLeafCount<Record>; ++k) words[k] = Float<L>(first[k]);
  return record_of_words<L, Record>(words);
}

/// Gathers table[index].*member, one for each lane: a number, the number of an enumeration, or a record such as Vec3.
template <class L, class Row, class T>
requires(!HasFields<T>) SHEAF_INLINE auto gather_member(const Row* table, T Row::*member, Uint<L> index) {
  static_assert(sizeof(T) == sizeof(float));
  using Word = std::conditional_t<std::is_enum_v<T>, std::uint32_t, T>;
  return gather(reinterpret_cast<const Word*>(&(table->*member)), record_table_detail::first_words<L, Row>(index));
}
template <class L, class Row, template <class> class Record>
SHEAF_INLINE Record<L> gather_member(const Row* table, Record<Scalar> Row::*member, Uint<L> index) {
  static_assert(record_table_detail::kIsRow<Record>);
  const auto* first = reinterpret_cast<const float*>(&(table->*member));
  const Uint<L> row = record_table_detail::first_words<L, Row>(index);
  Float<L> words[kLeafCount<Record>];
  for (int k = 0; k < kLeafCount<Record>; ++k) words[k] = gather(first + k, row);
  return record_of_words<L, Record>(words);
}

/// Gathers element `k` of the array table[index].*member, one for each lane.
template <class L, class Row, class T, std::size_t N>
SHEAF_INLINE auto gather_element(const Row* table, T (Row::*member)[N], int k, Uint<L> index) {
  static_assert(sizeof(T) == sizeof(float));
  return gather(table->*member + k, record_table_detail::first_words<L, Row>(index));
}
/// Gathers elements [k, k + 4) of the array table[index].*member.
template <class L, class Row, std::size_t N>
SHEAF_INLINE void gather_four(const Row* table, float (Row::*member)[N], int k, Uint<L> index, Float<L>* out) {
  gather_row4<L>(table->*member + k, record_table_detail::first_words<L, Row>(index), out);
}

/// Gathers table[3 index], table[3 index + 1] and table[3 index + 2] for each lane. The table must be readable one
/// number beyond its end.
template <class L> SHEAF_INLINE std::array<Uint<L>, 3> gather_triple(const std::uint32_t* table, Uint<L> index) {
  Float<L> words[4];
  gather_row4<L>(reinterpret_cast<const float*>(table), index * Uint<L>(3u), words);
  return {float_bits(words[0]), float_bits(words[1]), float_bits(words[2])};
}

}  // namespace sheaf
