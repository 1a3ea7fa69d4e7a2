#include "kernels/film/film_file.h"

#include <fmt/format.h>

namespace sheaf {

namespace {

/// Maximum number of channels: far more than any film has, far fewer than would exhaust memory.
constexpr std::uint32_t kMaxChannels = 4096;

/// Maximum distance of tiles and filter support from the frame, pixels: far larger than any filter.
constexpr int kMaxReach = 4096;

/// Maximum side of a frame, pixels: the limit for the pixels of a whole frame.
constexpr int kMaxFrameSide = 1'000'000'000;

void put_rect(BinaryOutput& out, const PixelRect& rect) {
  for (const int value : {rect.x0, rect.y0, rect.x1, rect.y1}) out.put(static_cast<std::int32_t>(value));
}

/// Reads a rectangle and checks that it lies inside `outer`.
PixelRect get_rect(BinaryInput& in, const PixelRect& outer) {
  PixelRect rect;
  for (int* const value : {&rect.x0, &rect.y0, &rect.x1, &rect.y1}) *value = in.get<std::int32_t>();
  if (rect.x0 < outer.x0 || rect.y0 < outer.y0 || rect.x1 > outer.x1 || rect.y1 > outer.y1 || rect.x1 < rect.x0 ||
      rect.y1 < rect.y0)
    in.fail("is damaged (invalid rectangle)");
  return rect;
}

void put_layout(BinaryOutput& out, const FilmLayout& layout) {
  out.put(static_cast<std::uint32_t>(layout.size()));
  for (const FilmChannel& channel : layout.channels()) {
    out.put(std::string_view(channel.name));
    out.put(static_cast<std::uint8_t>(channel.has_variance));
    out.put(static_cast<std::uint8_t>(channel.has_half));
  }
}

FilmLayout get_layout(BinaryInput& in) {
  const auto count = in.get<std::uint32_t>();
  if (count > kMaxChannels) in.fail(fmt::format("has {} channels: damaged", count));
  std::vector<FilmChannel> channels;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string name = in.get_text();
    const bool has_variance = in.get<std::uint8_t>() != 0;
    channels.push_back({std::move(name), has_variance, in.get<std::uint8_t>() != 0});
  }
  return FilmLayout(std::move(channels));
}

void put_coverage(BinaryOutput& out, const std::vector<IdCoverage>& coverage) {
  for (const IdCoverage& pixel : coverage) {
    out.put(static_cast<std::uint32_t>(pixel.entries().size()));
    for (const IdCoverage::Entry& entry : pixel.entries()) {
      out.put(entry.shape);
      out.put(entry.weight);
    }
  }
}

void get_coverage(BinaryInput& in, std::vector<IdCoverage>& coverage) {
  for (IdCoverage& pixel : coverage)
    for (auto left = in.get<std::uint32_t>(); left > 0; --left) {
      const auto shape = in.get<std::uint32_t>();
      pixel.append({shape, in.get<double>()});
    }
}

}  // namespace

void put_film(BinaryOutput& out, const Film& film) {
  out.put(static_cast<std::int32_t>(film.frame_width_));
  out.put(static_cast<std::int32_t>(film.frame_height_));
  put_rect(out, film.crop_);
  out.put(static_cast<std::int32_t>(film.spectral_bins()));
  out.put(static_cast<std::uint8_t>(film.unit_));
  out.put(static_cast<std::uint8_t>(film.has_surface_ids()));
  put_layout(out, film.layout_);
  out.put(film.counts_);
  out.put(film.sums_);
  out.put(film.open_);
  out.put(film.half_);
  put_coverage(out, film.coverage_);
}

Film get_film(BinaryInput& in) {
  const auto width = in.get<std::int32_t>(), height = in.get<std::int32_t>();
  if (width > kMaxFrameSide || height > kMaxFrameSide) in.fail("is damaged (invalid frame size)");
  const PixelRect crop = get_rect(in, {0, 0, width, height});
  const auto bins = in.get<std::int32_t>();
  const auto unit = in.get<std::uint8_t>();
  const bool has_surface_ids = in.get<std::uint8_t>() != 0;
  if (bins < 0 || bins > kMaxSpectralBins || unit > static_cast<std::uint8_t>(VarianceUnit::kReplicate))
    in.fail("is damaged (invalid spectral bins or variance unit)");
  FilmLayout layout = get_layout(in);
  // Each pixel has at least its count and its row. Check this before allocating memory for pixels that the file cannot
  // hold.
  const std::uint64_t min_bytes = (1 + FilmRow(layout, bins, false).film_size()) * sizeof(double);
  if (crop.area() > in.left() / min_bytes) in.fail("is truncated");
  Film film(width, height, crop, std::move(layout), bins, static_cast<VarianceUnit>(unit), has_surface_ids);
  in.get(film.counts_);
  in.get(film.sums_);
  in.get(film.open_);
  in.get(film.half_);
  get_coverage(in, film.coverage_);
  return film;
}

void put_borders(BinaryOutput& out, const std::vector<FilmBorder>& borders) {
  out.put(static_cast<std::uint64_t>(borders.size()));
  for (const FilmBorder& border : borders) {
    out.put(static_cast<std::uint32_t>(border.strips.size()));
    for (const FilmBorder::Strip& strip : border.strips) {
      put_rect(out, strip.pixels);
      out.put(static_cast<std::uint64_t>(strip.sums.size()));
      out.put(strip.sums);
      out.put(static_cast<std::uint8_t>(!strip.coverage.empty()));
      put_coverage(out, strip.coverage);
    }
  }
}

std::vector<FilmBorder> get_borders(BinaryInput& in, const Film& film) {
  const auto count = in.get<std::uint64_t>();
  if (count > in.left() / sizeof(std::uint32_t)) in.fail("is truncated");
  std::vector<FilmBorder> borders(static_cast<std::size_t>(count));
  for (FilmBorder& border : borders)
    for (auto strips = in.get<std::uint32_t>(); strips > 0; --strips) {
      FilmBorder::Strip& strip = border.strips.emplace_back();
      strip.pixels = get_rect(in, film.crop());
      const auto numbers = in.get<std::uint64_t>();
      if (numbers != strip.pixels.area() * film.tile_row_size()) in.fail("is damaged (border of the wrong size)");
      strip.sums = in.get_vector<double>(numbers);
      if ((in.get<std::uint8_t>() != 0) != film.has_surface_ids()) in.fail("is damaged (border of another film)");
      if (!film.has_surface_ids()) continue;
      strip.coverage.resize(strip.pixels.area());
      get_coverage(in, strip.coverage);
    }
  return borders;
}

void put_adaptive(BinaryOutput& out, const AdaptiveFilm& film) {
  // Write the goal and the rectangles of the tiles
  out.put(film.goal_.noise);
  out.put(film.goal_.max_samples);
  out.put(static_cast<std::int32_t>(film.reach_));
  out.put(static_cast<std::uint64_t>(film.tiles_.size()));
  for (const AdaptiveFilm::Tile& tile : film.tiles_) put_rect(out, tile.square);
  for (const AdaptiveFilm::Tile& tile : film.tiles_) {
    // Write the samples of the tile
    for (const bool converged : tile.converged) out.put(static_cast<std::uint8_t>(converged));
    for (const AdaptiveFilm::Set& set : tile.sets) {
      out.put(set.samples);
      out.put(set.used);
      out.put(set.sums);
      out.put(set.counts);
      put_coverage(out, set.coverage);
      out.put(set.luminance);
    }
  }
  // Write the units of work
  out.put(static_cast<std::uint64_t>(film.units_.size()));
  for (const AdaptiveUnit& unit : film.units_) {
    out.put(unit.tile);
    out.put(unit.first_sample);
    out.put(unit.samples);
    out.put(unit.set);
    out.put(unit.done);
  }
  out.put(film.rounds_);
  out.put(film.expected_);
}

AdaptiveFilm get_adaptive(BinaryInput& in, const Film& of) {
  const auto noise = in.get<double>();
  const AdaptiveGoal goal{noise, in.get<std::uint32_t>()};
  const auto reach = in.get<std::int32_t>();
  const auto count = in.get<std::uint64_t>();
  if (reach < 0 || reach > kMaxReach || count > in.left() / sizeof(PixelRect)) in.fail("is damaged (invalid tiles)");
  // Read the tiles' rectangles
  const PixelRect around = PixelRect{0, 0, of.width(), of.height()}.grown(kMaxReach);
  std::vector<PixelRect> squares;
  std::uint64_t pixels = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    squares.push_back(get_rect(in, around));
    pixels += squares.back().grown(reach).intersection(of.crop()).area();
  }
  if (pixels > in.left() / (AdaptiveFilm::kSets * sizeof(double) *
                            static_cast<std::uint64_t>(1 + of.layout().size() + of.spectral_bins())))
    in.fail("is truncated");
  // Read the samples of each tile
  AdaptiveFilm film(of, squares, reach, goal);
  for (AdaptiveFilm::Tile& tile : film.tiles_) {
    for (bool& converged : tile.converged) converged = in.get<std::uint8_t>() != 0;
    for (AdaptiveFilm::Set& set : tile.sets) {
      set.samples = in.get<std::uint32_t>();
      set.used = in.get<std::uint32_t>();
      in.get(set.sums);
      in.get(set.counts);
      get_coverage(in, set.coverage);
      in.get(set.luminance);
    }
  }
  // Read the units of work
  const auto units = in.get<std::uint64_t>();
  if (units > AdaptiveFilm::kSets * film.tiles_.size()) in.fail("is damaged (more units than tiles)");
  film.units_.resize(static_cast<std::size_t>(units));
  for (AdaptiveUnit& unit : film.units_) {
    unit.tile = in.get<std::uint32_t>();
    unit.first_sample = in.get<std::uint32_t>();
    unit.samples = in.get<std::uint32_t>();
    unit.set = in.get<std::uint8_t>();
    unit.done = in.get<std::uint8_t>();
    if (unit.tile >= film.tiles_.size() || unit.set >= AdaptiveFilm::kSets) in.fail("is damaged (unit without a tile)");
  }
  film.rounds_ = in.get<std::uint32_t>();
  in.get(film.expected_);
  return film;
}

void put_splats(BinaryOutput& out, const SplatFilm& film) {
  out.put(film.sums_);
  out.put(film.squares_);
}

void get_splats(BinaryInput& in, SplatFilm& film) {
  in.get(film.sums_);
  in.get(film.squares_);
}

}  // namespace sheaf
