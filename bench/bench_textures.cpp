// The cost of texture lookups per item: every format and filter, one path at a time and in registers. Positions are
// close together (paths that see the same part of a surface) or anywhere in the image. "per_item" is in seconds.
#include "core/sampling/rng.h"
#include "scene/textures/list.h"
#include "scene/textures/texture_lookup.h"

#include <benchmark/benchmark.h>

#include <cstring>
#include <vector>

namespace sheaf {

namespace {

constexpr int kItems = 1024;

float uniform(std::uint32_t i, std::uint32_t stream) { return random4<Scalar>(stream, i, 0, 0).x; }

/// A square image of noise as texture 0, and a checkerboard of it as texture 1.
struct NoiseImage {
  std::vector<TexelLine> tiles;
  TexelImage image;
  TextureRow rows[2];
  TextureView view;

  NoiseImage(TexelFormat format, TextureFilter filter, std::uint32_t size) {
    const std::uint32_t per_row = size >> tile_shift(format).x;
    tiles.resize(padded_lines(format, std::size_t{per_row} * per_row));
    for (std::size_t i = 0; i < tiles.size(); ++i)
      for (std::uint32_t word = 0; word < 16; ++word) {
        const float value = uniform(static_cast<std::uint32_t>(i) * 16 + word, 1);
        const std::uint32_t bits = holds_bytes(format) ? float_bits(value) * 2654435761u : float_bits(value);
        std::memcpy(tiles[i].bytes + 4 * word, &bits, sizeof(bits));
      }
    constexpr auto kRepeat = TextureWrap::kRepeat;
    rows[0].kind = kTextureKind<BitmapDescription>;
    rows[0].set_data(BitmapRow{0, per_row, size, size, kRepeat, kRepeat, filter, format});
    rows[1].kind = kTextureKind<CheckerboardDescription>;
    rows[1].input_count = 2;  // both are texture 0
    view.rows = rows;
    image.tiles = tiles.data();
    view.images = &image;
  }
};

/// Columns of texture coordinates and of results.
struct TextureCoordinates {
  alignas(kSimdAlignment) float u[kItems], v[kItems], out[4][kItems];

  /// All within `extent` of (0.3, 0.4).
  explicit TextureCoordinates(float extent) {
    for (std::uint32_t i = 0; i < kItems; ++i) {
      u[i] = 0.3f + extent * uniform(i, 2);
      v[i] = 0.4f + extent * uniform(i, 3);
    }
  }
};

/// Runs f(query, places, index of the first item) over all items.
template <class L, class F> void run(benchmark::State& state, float extent, F&& f) {
  TextureCoordinates positions(extent);
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      TextureQuery<L> query{};
      load(positions.u + i, query.uv.x);
      load(positions.v + i, query.uv.y);
      if constexpr (L::width == 1) benchmark::ClobberMemory();
      f(query, positions, i);
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kItems);
  state.counters["per_item"] =
      benchmark::Counter(kItems, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

struct Case {
  const char* name;
  TexelFormat format;
  TextureFilter filter;
};
constexpr Case kCases[] = {
    {"bytes:3/srgb/bilinear", TexelFormat::kSrgbByte3, TextureFilter::kBilinear},
    {"bytes:3/raw/bilinear", TexelFormat::kByte3, TextureFilter::kBilinear},
    {"bytes:3/srgb/nearest", TexelFormat::kSrgbByte3, TextureFilter::kNearest},
    {"bytes:1/srgb/bilinear", TexelFormat::kSrgbByte1, TextureFilter::kBilinear},
    {"bytes:1/raw/bilinear", TexelFormat::kByte1, TextureFilter::kBilinear},
    {"bytes:1/raw/nearest", TexelFormat::kByte1, TextureFilter::kNearest},
    {"floats:4/bilinear", TexelFormat::kFloat4, TextureFilter::kBilinear},
    {"floats:4/nearest", TexelFormat::kFloat4, TextureFilter::kNearest},
    {"floats:1/bilinear", TexelFormat::kFloat1, TextureFilter::kBilinear},
    {"floats:1/nearest", TexelFormat::kFloat1, TextureFilter::kNearest},
};

template <class L>
void color(benchmark::State& state, const Case& c, std::uint32_t size, float extent, std::uint32_t texture) {
  const NoiseImage image(c.format, c.filter, size);
  run<L>(state, extent, [&](const TextureQuery<L>& query, TextureCoordinates& positions, int i) {
    const Spectrum<L> s = lookup_texture<L>(image.view, texture, query);
    store(positions.out[0] + i, s.c0);
    store(positions.out[1] + i, s.c1);
    store(positions.out[2] + i, s.c2);
    store(positions.out[3] + i, s.c3);
  });
}

template <class L> void gradient(benchmark::State& state, const Case& c, std::uint32_t size, float extent) {
  const NoiseImage image(c.format, c.filter, size);
  run<L>(state, extent, [&](const TextureQuery<L>& query, TextureCoordinates& positions, int i) {
    const Vec2<L> g = lookup_scalar_gradient<L>(image.view, 0, query);
    store(positions.out[0] + i, g.x);
    store(positions.out[1] + i, g.y);
  });
}

template <class L> void register_lane(const std::string& suffix) {
  const auto add = [&](const std::string& name, auto&& f) {
    benchmark::RegisterBenchmark((name + suffix).c_str(), std::forward<decltype(f)>(f));
  };
  for (const Case& c : kCases) {
    const std::string name = std::string("texture/") + c.name;
    add(name + "/size:2048/close", [&c](benchmark::State& s) { color<L>(s, c, 2048, 0.01f, 0); });
    add(name + "/size:256/anywhere", [&c](benchmark::State& s) { color<L>(s, c, 256, 1, 0); });
    add(name + "/size:2048/anywhere", [&c](benchmark::State& s) { color<L>(s, c, 2048, 1, 0); });
  }
  add("texture/board/size:2048/close", [](benchmark::State& s) { color<L>(s, kCases[0], 2048, 0.01f, 1); });
  add("texture/gradient/bytes:1/size:2048/close", [](benchmark::State& s) { gradient<L>(s, kCases[4], 2048, 0.01f); });
  add("texture/gradient/bytes:3/size:2048/close", [](benchmark::State& s) { gradient<L>(s, kCases[1], 2048, 0.01f); });
}

[[maybe_unused]] const bool registered = [] {
  register_lane<Scalar>("/scalar");
  register_lane<Wide>("/wide");
  return true;
}();

}  // namespace

}  // namespace sheaf
