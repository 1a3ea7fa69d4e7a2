// Decoding of glTF accessors.
#include "scene/formats/gltf.h"
#include "scene/formats/little_endian.h"

#include <algorithm>
#include <bit>

namespace sheaf {

namespace {

/// Bytes of an integer or float, and its conversion.
template <class T> struct PackedNumber {
  static constexpr std::size_t kBytes = sizeof(T);

  static T load(const std::uint8_t* bytes) {
    using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t,
                                    std::conditional_t<sizeof(T) == 2, std::uint16_t, std::uint32_t>>;
    return std::bit_cast<T>(little_endian<Bits>(reinterpret_cast<const char*>(bytes)));
  }
};

/// Calls f(T{}) with the type of a component.
template <class F> auto with_type(GltfComponent type, F&& f) {
  switch (type) {
    case GltfComponent::kByte:
      return f(std::int8_t{});
    case GltfComponent::kUnsignedByte:
      return f(std::uint8_t{});
    case GltfComponent::kShort:
      return f(std::int16_t{});
    case GltfComponent::kUnsignedShort:
      return f(std::uint16_t{});
    case GltfComponent::kUnsignedInt:
      return f(std::uint32_t{});
    case GltfComponent::kFloat:
      break;
  }
  return f(float{});
}

template <class Out, class T> Out convert(T value, bool normalized) {
  if constexpr (std::is_same_v<Out, float> && std::is_integral_v<T>) {
    if (normalized)
      return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
  }
  return static_cast<Out>(value);
}

/// Elements of `components` numbers each in a view.
struct ElementSource {
  const std::uint8_t* first;
  std::size_t stride;
};

ElementSource source(const GltfFile& file, int view_index, std::size_t offset, std::size_t element) {
  const GltfView& view = file.views[static_cast<std::size_t>(view_index)];
  const auto& buffer = file.buffers[static_cast<std::size_t>(view.buffer)];
  return {buffer.data() + view.offset + offset, std::max(view.stride, element)};
}

/// Layout of an element.
struct Layout {
  std::size_t columns, rows;
  std::size_t stride;  ///< bytes from one column to the next

  Layout(int components, std::size_t bytes)
      : columns(components == 16  ? 4
                : components == 9 ? 3
                                  : 1),
        rows(static_cast<std::size_t>(components) / columns),
        stride(columns > 1 ? (rows * bytes + 3) / 4 * 4 : rows * bytes) {}
};

template <class T, class Out> void copy_element(const std::uint8_t* from, const GltfAccessor& accessor, Out* to) {
  const Layout layout(accessor.components, sizeof(T));
  for (std::size_t column = 0; column < layout.columns; ++column)
    for (std::size_t row = 0; row < layout.rows; ++row)
      *to++ = convert<Out>(PackedNumber<T>::load(from + column * layout.stride + row * sizeof(T)), accessor.normalized);
}

/// All elements of an accessor.
template <class Out> std::vector<Out> read_elements(const GltfFile& file, const GltfAccessor& accessor) {
  const auto components = static_cast<std::size_t>(accessor.components);
  std::vector<Out> out(accessor.count * components);
  with_type(accessor.type, [&]<class T>(T) {
    const std::size_t element = element_bytes(accessor.type, accessor.components);
    if (accessor.view != kNoIndex) {
      const ElementSource from = source(file, accessor.view, accessor.offset, element);
      for (std::size_t i = 0; i < accessor.count; ++i)
        copy_element<T>(from.first + i * from.stride, accessor, out.data() + i * components);
    }
    if (!accessor.sparse) return;
    const GltfAccessor::Sparse& sparse = *accessor.sparse;
    const ElementSource values = source(file, sparse.value_view, sparse.value_offset, element);
    with_type(sparse.index_type, [&]<class Index>(Index) {
      if constexpr (std::is_unsigned_v<Index>) {
        const ElementSource indices = source(file, sparse.index_view, sparse.index_offset, sizeof(Index));
        for (std::size_t i = 0; i < sparse.count; ++i) {
          const std::size_t target = PackedNumber<Index>::load(indices.first + i * indices.stride);
          if (target < accessor.count)
            copy_element<T>(values.first + i * values.stride, accessor, out.data() + target * components);
        }
      }
    });
  });
  return out;
}

const GltfAccessor& checked(const GltfFile& file, int index, int components) {
  const GltfAccessor& accessor = file.accessors[static_cast<std::size_t>(index)];
  if (accessor.components == components) return accessor;
  throw file.error(fmt::format("accessors[{}]", index),
                   fmt::format("has {} numbers per element, expected {}", accessor.components, components));
}

}  // namespace

std::size_t element_bytes(GltfComponent type, int components) {
  const Layout layout(components, with_type(type, []<class T>(T) { return sizeof(T); }));
  return layout.columns * layout.stride;
}

std::vector<float> read_floats(const GltfFile& file, int accessor, int components) {
  return read_elements<float>(file, checked(file, accessor, components));
}

std::vector<std::uint32_t> read_integers(const GltfFile& file, int accessor, int components) {
  const GltfAccessor& a = checked(file, accessor, components);
  const bool is_unsigned = a.type == GltfComponent::kUnsignedByte || a.type == GltfComponent::kUnsignedShort ||
                           a.type == GltfComponent::kUnsignedInt;
  if (!is_unsigned) throw file.error(fmt::format("accessors[{}]", accessor), "does not have unsigned integers");
  return read_elements<std::uint32_t>(file, a);
}

}  // namespace sheaf
