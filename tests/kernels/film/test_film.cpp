// The film of named channels: means, variances and sample counts; and conversion to images.
#include "core/io/error.h"
#include "kernels/film/cryptomatte.h"
#include "kernels/film/film.h"
#include "kernels/film/film_file.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace sheaf::test_film {

namespace {

const FilmLayout kLayout({{"R", true}, {"depth", false}, {"albedo.G", true}});

/// Adds the samples of one pixel to a film with a box filter of one pixel.
void add_samples(Film& film, int x, int y, const SampleBuffer& samples, std::size_t count) {
  FilmTile tile;
  film.begin(tile, {x, y, x + 1, y + 1}, nullptr);
  tile.add(x, y, samples, 0, count);
  film.add(tile);
}

/// A film of 3 x 2 pixels inside a larger frame. Samples differ between pixels; one pixel has none.
Film some_film(int spectral_bins = 0, VarianceUnit unit = VarianceUnit::kSample) {
  Film film(7, 5, {2, 1, 5, 3}, kLayout, spectral_bins, unit);
  SampleBuffer samples;
  samples.resize(4, kLayout.size(), spectral_bins > 0);
  for (int y = 1; y < 3; ++y)
    for (int x = 2; x < 5; ++x) {
      if (x == 4 && y == 2) continue;
      for (std::size_t i = 0; i < 4; ++i) {
        const auto value = static_cast<float>(x + 10 * y) + 0.1f * static_cast<float>(i * i);
        samples[i][0] = value, samples[i][1] = -value, samples[i][2] = 1.0f / value;
        if (spectral_bins > 0) samples.spectrum(i) = {{0, 1, 1, 2}, {value, 1, 2, 3}};
      }
      add_samples(film, x, y, samples, 4);
    }
  return film;
}

/// A buffer with one sample.
SampleBuffer some_samples(int spectral_bins) {
  SampleBuffer samples;
  samples.resize(1, kLayout.size(), spectral_bins > 0);
  samples[0][0] = 0.1f, samples[0][1] = 0.7f, samples[0][2] = 1e-8f;
  return samples;
}

constexpr std::string_view kFirstLine = "a film\n";

void write_film(const std::filesystem::path& file, const Film& film) {
  BinaryOutput out(file, kFirstLine);
  put_film(out, film);
  out.commit();
}

Film read_film(const std::filesystem::path& file) {
  BinaryInput in(file, kFirstLine);
  Film film = get_film(in);
  CHECK(in.left() == 0);
  return film;
}

bool same_images(const Image& a, const Image& b) {
  return a.channels == b.channels && a.width == b.width && a.height == b.height && a.x0 == b.x0 && a.y0 == b.y0 &&
         a.frame_width == b.frame_width && a.data.size() == b.data.size() &&
         std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0;
}

}  // namespace

TEST_CASE("a film holds means and sample counts and optionally variances of the mean") {
  const Film film = some_film();
  CHECK(film.layout().find("depth") == 1);
  CHECK(film.layout().find("G") == -1);
  CHECK(film.count(2, 1) == 4);
  CHECK(film.count(4, 2) == 0);
  const Image image = film.to_image();
  CHECK(image.channels ==
        std::vector<std::string>{"R", "depth", "albedo.G", "variance.R", "variance.albedo.G", "sampleCount"});
  CHECK(image.x0 == 2);
  CHECK(image.frame_height == 5);
  // 12 + {0, 0.1, 0.4, 0.9}: the variance of the mean is the sum of squared differences over n (n - 1).
  CHECK(image.at(0, 0, 0) == near(12.35, 1e-6));
  CHECK(image.at(0, 0, 1) == near(-12.35, 1e-6));
  const double expected = (0.35 * 0.35 + 0.25 * 0.25 + 0.05 * 0.05 + 0.55 * 0.55) / 12;
  CHECK(image.at(0, 0, 3) == near(expected, 1e-4));
  CHECK(image.at(0, 0, 5) == 4);
  for (int c = 0; c < 6; ++c) CHECK(image.at(2, 1, c) == 0);
}

TEST_CASE("a film's noise is unknown if more than 0.1 % of its pixels have fewer than two variance units") {
  const FilmLayout layout = FilmLayout::beauty();
  SampleBuffer samples;
  samples.resize(2, layout.size(), false);
  // A film of 2000 pixels, of which `single` have one sample and `empty` have none.
  const auto noise_of_film = [&](int single, int empty, VarianceUnit unit) {
    Film film(100, 20, {0, 0, 100, 20}, layout, 0, unit);
    for (int set = 0; set < 2; ++set) {
      for (int i = 0; i < 2000; ++i) {
        if (i < empty || (set == 1 && i < empty + single)) continue;
        for (std::size_t c = 0; c < 3; ++c) samples[0][c] = set == 0 ? 1.0f : 1.2f;
        add_samples(film, i % 100, i / 100, samples, 1);
      }
      film.end_replicate();
    }
    return film.noise();
  };
  for (const VarianceUnit unit : {VarianceUnit::kSample, VarianceUnit::kReplicate}) {
    // The standard error of the mean of 1 and 1.2 is 0.1. Relative errors of dark pixels use a tenth of the image mean.
    const double expected = 0.1 / std::sqrt(1.1 * 1.1 + 0.11 * 0.11);
    CHECK(noise_of_film(0, 0, unit).value_or(-1) == near(expected, 1e-4));
    CHECK(noise_of_film(1, 1, unit).value_or(-1) == near(expected, 0.01));
    CHECK_FALSE(noise_of_film(3, 0, unit).has_value());
    CHECK_FALSE(noise_of_film(0, 3, unit).has_value());
    CHECK_FALSE(noise_of_film(2000, 0, unit).has_value());
  }
  Film film(2, 1, {0, 0, 2, 1}, layout);
  CHECK(film.mean_samples() == 0);
  add_samples(film, 0, 0, samples, 2);
  CHECK(film.mean_samples() == 1);
  add_samples(film, 1, 0, samples, 1);
  CHECK(film.mean_samples() == 1.5);
}

TEST_CASE("dropped samples are not counted") {
  Film film(1, 1, {0, 0, 1, 1}, kLayout);
  SampleBuffer samples;
  samples.resize(3, kLayout.size(), false);
  for (std::size_t i = 0; i < 3; ++i) samples[i][0] = samples[i][1] = samples[i][2] = 2;
  samples.drop(1);
  CHECK(samples.is_dropped(1));
  CHECK_FALSE(samples.is_dropped(2));
  add_samples(film, 0, 0, samples, 3);
  CHECK(film.count(0, 0) == 2);
  CHECK(film.to_image().at(0, 0, 0) == 2);
}

TEST_CASE("a film restored from a file continues to the same result") {
  const TemporaryFolder folder;
  for (const auto& [bins, unit] : {std::pair{0, VarianceUnit::kSample},
                                   {5, VarianceUnit::kSample},
                                   {0, VarianceUnit::kReplicate},
                                   {5, VarianceUnit::kReplicate}}) {
    Film film = some_film(bins, unit);
    film.end_replicate();
    add_samples(film, 2, 1, some_samples(bins), 1);
    write_film(folder / "a.film", film);
    Film read = read_film(folder / "a.film");
    CHECK(read.width() == 7);
    CHECK(read.crop().x1 == 5);
    CHECK(read.spectral_bins() == bins);
    CHECK(same_images(film.to_image(), read.to_image()));
    for (Film* each : {&film, &read}) {
      add_samples(*each, 3, 2, some_samples(bins), 1);
      each->end_replicate();
    }
    CHECK(same_images(film.to_image(), read.to_image()));
    write_film(folder / "b.film", read);
    write_film(folder / "c.film", film);
    CHECK(read_bytes(folder / "b.film") == read_bytes(folder / "c.film"));
  }
}

TEST_CASE("Cryptomatte coverage follows sample weights and survives a round trip with the half buffers") {
  const TemporaryFolder folder;
  PixelFilter gaussian;
  gaussian.kind = PixelFilter::Kind::kGaussian;
  const FilterWeights weights(gaussian);
  const AovSet aovs{aov_named("half"), aov_named("object_id"), aov_named("cryptomatte_object")};
  Film film(16, 8, {0, 0, 16, 8}, film_layout(aovs, false), 0, VarianceUnit::kReplicate, true);
  SampleBuffer samples;
  samples.resize(1, film.layout().size(), false, true);
  std::vector<FilmBorder> borders;
  // One sample in the center of each pixel: surface 0 on the left, 1 on the right, nothing at the far right.
  for (const int x0 : {0, 8}) {
    FilmTile tile;
    film.begin(tile, {x0, 0, x0 + 8, 8}, &weights);
    for (int y = 0; y < 8; ++y)
      for (int x = x0; x < x0 + 8; ++x) {
        std::fill_n(samples[0], 4, static_cast<float>(x));
        samples.surface(0) = {x < 8 ? 0u : x < 14 ? 1u : IdCoverage::kNothing, 1};
        tile.add(x, y, samples, 0, 1);
      }
    film.add(tile);
    borders.push_back(tile.border());
  }
  film.add(borders);
  film.end_first_half();
  write_film(folder / "a.film", film);
  const Film read = read_film(folder / "a.film");
  SceneNames names;
  names.objects = {"left", "right"};
  names.object_of_shape = {0, 1};
  Image image = film.to_image(), again = read.to_image();
  add_id_layers(aovs, names, film, image);
  add_id_layers(aovs, names, read, again);
  CHECK(same_images(image, again));
  CHECK(image.at(5, 4, image.find_channel("half.G")) == image.at(5, 4, kGreen));
  const int id = image.find_channel("CryptoObject00.r"), number = image.find_channel("objectId");
  REQUIRE(id == number + 1);
  CHECK(image.at(3, 4, number) == 1);
  CHECK(image.at(12, 4, number) == 2);
  CHECK(image.at(15, 4, number) == 0);
  CHECK(image.at(3, 4, id + 1) == near(1));
  CHECK(image.at(3, 4, id) == bits_float(cryptomatte_id("left")));
  // On both sides of the edge, the neighbor has the same coverage.
  CHECK(image.at(7, 4, id) == bits_float(cryptomatte_id("left")));
  CHECK(image.at(8, 4, id) == bits_float(cryptomatte_id("right")));
  CHECK(image.at(7, 4, id + 2) == bits_float(cryptomatte_id("right")));
  CHECK(image.at(7, 4, id + 1) + image.at(7, 4, id + 3) == near(1));
  CHECK(image.at(7, 4, id + 3) == near(double{image.at(8, 4, id + 3)}));
  CHECK(image.at(7, 4, id + 3) > 0.05f);
  CHECK(image.at(13, 4, id + 1) < 0.95f);
  CHECK(image.at(13, 4, id + 3) == 0);
}

TEST_CASE("truncated and damaged and foreign film files are rejected with exit code 5") {
  const TemporaryFolder folder;
  const auto file = folder / "a.film";
  write_film(file, some_film(3));
  const std::string good = read_bytes(file);
  const auto refused = [&](const std::string& bytes) {
    write_bytes(file, bytes);
    try {
      read_film(file);
    } catch (const Error& error) {
      CHECK(error.exit_code() == ExitCode::kCheckpoint);
      return std::string(error.what()).find("a.film") != std::string::npos;
    }
    return false;
  };
  for (std::size_t size = 0; size < good.size(); size += 7) CHECK(refused(good.substr(0, size)));
  for (std::size_t at = 0; at < good.size(); at += 11) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    CHECK(refused(bytes));
  }
  CHECK(refused(good + "x"));
  CHECK(refused("v/1\x01 no film at all"));
  CHECK_THROWS_AS(read_film(folder / "absent.film"), Error);
}

TEST_CASE("films without channels keep their adaptive tile sums and impossible frames are rejected") {
  const TemporaryFolder folder;
  const auto file = folder / "a.film";
  constexpr std::string_view kLine = "a film and its tiles\n";
  const auto write = [&](const Film& film) {
    BinaryOutput out(file, kLine);
    put_film(out, film);
    put_adaptive(out, AdaptiveFilm(film, {{0, 0, 4, 4}, {4, 0, 7, 4}}, 1, {0.5, 16}));
    out.commit();
  };
  write(Film(7, 5, {2, 1, 5, 3}, FilmLayout()));
  BinaryInput in(file, kLine);
  const Film film = get_film(in);
  CHECK(film.layout().size() == 0);
  CHECK(get_adaptive(in, film).taken_samples(1) == 0);
  CHECK(in.left() == 0);

  write(Film(std::numeric_limits<int>::max(), 5, {2, 1, 5, 3}, kLayout));
  BinaryInput wide(file, kLine);
  CHECK_THROWS_WITH_AS(get_film(wide), doctest::Contains("is damaged (invalid frame size)"), Error);
}

}  // namespace sheaf::test_film
