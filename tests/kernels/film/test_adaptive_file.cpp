// Adaptive films that are written and read in the middle of sampling continue as if they had stayed in memory.
#include "kernels/film/adaptive_film.h"
#include "kernels/film/aovs.h"
#include "kernels/film/film_file.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sheaf::test_adaptive_file {

namespace {

constexpr int kTiles = 3, kSide = 8;
constexpr PixelRect kFrame{0, 0, kTiles* kSide, kSide};
constexpr std::string_view kFirstLine = "adaptive film\n";

std::vector<PixelRect> squares() {
  std::vector<PixelRect> tiles;
  for (int i = 0; i < kTiles; ++i) tiles.push_back({i * kSide, 0, (i + 1) * kSide, kSide});
  return tiles;
}

/// Value of the samples of a unit. The two sets of a half differ at first and agree afterwards, so that more samples
/// reduce the noise. Half A of the first tile converges early, and its neighbor becomes noisy after that.
float value_of(const AdaptiveUnit& unit) {
  const float sign = unit.set % 2 == 0 ? 1.0f : -1.0f;
  const bool is_half_a = unit.set < 2, is_early = unit.first_sample < 8;
  switch (unit.tile) {
    case 0:
      return 1;
    case 1:
      return 1 + sign * (is_half_a ? (unit.first_sample == 24 ? 1.0f : 0.0f) : (is_early ? 0.5f : 0.0f));
    default:
      return is_early ? 1 + 0.9f * sign : 0.8f;
  }
}

/// Three tiles with samples that are made up.
struct Sampled {
  Film film{kFrame.width(), kFrame.height(), kFrame, film_layout({}, true), 0, VarianceUnit::kReplicate};
  AdaptiveFilm adaptive{film, squares(), 0, {0.1, 512}};

  /// Renders units until `count` of them are done or none is left. Returns the number that was rendered.
  int render(int count) {
    SampleBuffer samples;
    FilmTile tile;
    int rendered = 0;
    while (rendered < count && adaptive.begin_round())
      for (std::size_t i = 0; i < adaptive.units().size() && rendered < count; ++i) {
        const AdaptiveUnit unit = adaptive.units()[i];
        if (unit.done != 0) continue;
        samples.resize(static_cast<int>(unit.samples), film.layout().size(), false);
        for (std::size_t s = 0; s < unit.samples; ++s) std::fill_n(samples[s], film.layout().size(), value_of(unit));
        const PixelRect own = squares()[unit.tile];
        film.begin(tile, own, nullptr);
        for (int y = own.y0; y < own.y1; ++y)
          for (int x = own.x0; x < own.x1; ++x) tile.add(x, y, samples, 0, unit.samples);
        adaptive.add(i, tile);
        ++rendered;
      }
    return rendered;
  }

  void store_and_load(const std::filesystem::path& file) {
    BinaryOutput out(file, kFirstLine);
    put_adaptive(out, adaptive);
    out.commit();
    BinaryInput in(file, kFirstLine);
    adaptive = get_adaptive(in, film);
    CHECK(in.left() == 0);
  }

  std::vector<float> pixels() {
    adaptive.assemble(film);
    return film.to_image().data;
  }
};

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace

TEST_CASE("adaptive film: a film that is read from a file takes and uses the same samples, wherever it was written") {
  const TemporaryFolder folder;
  Sampled whole;
  int total = 0;
  while (whole.render(1) > 0) ++total;
  const AdaptiveSummary expected = whole.adaptive.summary();
  const std::vector<float> pixels = whole.pixels();
  // The first tile stops first, and the image uses more samples of one half than of the other.
  CHECK(expected.tiles == kTiles);
  CHECK(expected.reached == kTiles);
  CHECK(whole.adaptive.taken_samples(0) < whole.adaptive.taken_samples(1));
  std::uint64_t taken = 0;
  for (std::size_t tile = 0; tile < kTiles; ++tile) taken += whole.adaptive.taken_samples(tile);
  CHECK(expected.mean_samples < static_cast<double>(taken) / kTiles);
  for (int written = 0; written <= total; ++written) {
    CAPTURE(written);
    Sampled resumed;
    CHECK(resumed.render(written) == written);
    resumed.store_and_load(folder / "film");
    CHECK(resumed.render(100'000) == total - written);
    for (std::size_t tile = 0; tile < kTiles; ++tile) {
      CHECK(resumed.adaptive.taken_samples(tile) == whole.adaptive.taken_samples(tile));
      CHECK(resumed.adaptive.expected_samples(tile) == whole.adaptive.expected_samples(tile));
    }
    const AdaptiveSummary found = resumed.adaptive.summary();
    CHECK(found.mean_samples == expected.mean_samples);
    CHECK(found.reached == expected.reached);
    CHECK(same_bits(resumed.pixels(), pixels));
  }
}

}  // namespace sheaf::test_adaptive_file
