// Materials for kernels: the rows of the material table.
#pragma once

#include "core/color/spectrum.h"
#include "core/soa/record_table.h"

namespace sheaf {

/// Kinds of closures, by which vertices are sorted and dispatched, once per bucket. Their values follow from the list
/// of closures in scene/materials/list.h.
enum class ClosureKind : std::uint32_t {};
/// Maximum number of kinds, for the sizes of tables.
inline constexpr int kMaxClosureKinds = 48;

/// Maximum number of 32-bit parameter words of a closure; a multiple of four.
inline constexpr int kMaxClosureWords = 56;

/// Maximum number of spectra among the parameters of a closure.
inline constexpr int kMaxClosureSpectra = 5;

/// Positions of the spectra among a closure's parameters: the first of their four words, in order.
struct ClosureSpectra {
  int count = 0;
  int word[kMaxClosureSpectra] = {};
};

/// Derived from the types in fields().
template <template <class> class Parameters> constexpr ClosureSpectra closure_spectra() {
  ClosureSpectra found;
  int word = 0;
  const auto visit = [&]<class Field>(const Field*) {
    using Element = std::remove_all_extents_t<Field>;
    constexpr std::size_t kBytes = sizeof(Field);
    const int end = word + static_cast<int>(kBytes / sizeof(float));
    if (std::is_same_v<Element, Spectrum4>)
      for (int at = word; at < end; at += 4) found.word[found.count++] = at;
    word = end;
  };
  using Fields = decltype(Parameters<Scalar>::fields(std::declval<Parameters<Scalar>&>()));
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (visit(static_cast<const std::remove_reference_t<std::tuple_element_t<I, Fields>>*>(nullptr)), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<Fields>>{});
  return found;
}

/// Bits of MaterialRow::flags.
enum MaterialFlags : std::uint32_t {
  kTwoSided = 1,   ///< the shading frame is flipped towards the viewer
  kNeedsUv = 2,    ///< needs uv coordinates: for textures, maps or a tangent
  kMapped = 4,     ///< the shading normal comes from a map
  kComposite = 8,  ///< a choice between other rows, see MaterialRow::choice; never shaded
  kPart = 16,      ///< one of the rows that a composite material chooses from
};

/// The bits from here on: 0, or 1 + the word of a closure's angle from the tangent towards the bitangent.
inline constexpr int kRotationWordShift = 8;

/// One material after flattening of composites. 64 words.
struct alignas(64) MaterialRow {
  ClosureKind kind{};
  std::uint32_t back = 0;              ///< row for the back side of the surface; the row itself for one-sided materials
  std::uint32_t flags = 0;             ///< MaterialFlags and kRotationWordShift
  std::uint16_t bucket = 0;            ///< sorting key; ordered by kind, then material
  std::uint16_t binding_count = 0;     ///< number of its texture bindings
  std::uint32_t first_binding = 0;     ///< into MaterialView::bindings
  std::uint32_t map = 0;               ///< kMapped: into MaterialView::normal_maps
  std::uint32_t choice[2] = {};        ///< kComposite: the two rows; kNothing: light passes unchanged
  float words[kMaxClosureWords] = {};  ///< parameters' leaves in declaration order; the bits of integers
  static constexpr std::uint32_t kNothing = 0xffffffffu;
  /// kComposite: probability of the second choice, in [0, 1], unless a texture gives it. The only parameter of such
  /// rows.
  float second_weight() const { return words[0]; }
};
static_assert(sizeof(MaterialRow) == 256);

/// A normal or bump map.
struct NormalMapRow {
  std::uint32_t texture = 0;  ///< into TextureView::rows
  std::uint32_t flags = 0;
  float scale = 1;  ///< kBump: factor of the texture's gradient; otherwise of the normal's x and y
  /// Bits of `flags`.
  enum : std::uint32_t {
    kBump = 1,        ///< the texture is a height field, not a normal map
    kFlipGreen = 2,   ///< green points down
    kFixInvalid = 4,  ///< normals that face away from the viewer are mirrored at the unmapped normal
    kSoften = 8,      ///< soften the shadow terminator
    kFollowsUv = 16,  ///< the y axis of the normal map follows the direction of increasing v
  };
};

/// Writes parameters into a row.
template <template <class> class Parameters>
void set_parameters(MaterialRow& row, ClosureKind kind, const Parameters<Scalar>& parameters) {
  static_assert(kLeafCount<Parameters> <= kMaxClosureWords);
  row.kind = kind;
  int i = 0;
  std::apply([&](const auto&... leaf) { ((row.words[i++] = word_of_leaf(leaf)), ...); }, leaves(parameters));
}

}  // namespace sheaf
