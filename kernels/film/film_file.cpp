#include "kernels/film/film_file.h"

#include "core/error.h"
#include "core/inflate.h"
#include "core/output_file.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <iterator>
#include <type_traits>

namespace sheaf {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kFirstLine = "sheaf film 3\n";
/// Longest name of a channel, and most of them: far beyond any film, far below what would exhaust memory.
constexpr std::uint32_t kMaxName = 1024, kMaxChannels = 4096;

class Writer {
 public:
  template <class T> void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_ += text;
  }
  template <class T> void put(const std::vector<T>& values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(const std::filesystem::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ExitCode::kCheckpoint, {file_.string(), 0}, what);
  }
  template <class T> T get() {
    T value;
    std::memcpy(&value, take(sizeof(T)), sizeof(T));
    return value;
  }
  std::string get_text() {
    const auto size = get<std::uint32_t>();
    if (size > kMaxName) fail("names a channel by " + std::to_string(size) + " letters: damaged");
    return std::string(take(size), size);
  }
  template <class T> void get(std::vector<T>& values) {
    const char* bytes = take(values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(values.data(), bytes, values.size() * sizeof(T));
  }
  std::size_t left() const { return bytes_.size(); }

 private:
  const char* take(std::size_t size) {
    if (size > bytes_.size()) fail("ends too early: cut off");
    const char* at = bytes_.data();
    bytes_.remove_prefix(size);
    return at;
  }

  const std::filesystem::path& file_;
  std::string_view bytes_;
};

std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream || bytes.empty()) throw Error(ExitCode::kCheckpoint, {file.string(), 0}, "cannot be read");
  return bytes;
}

FilmLayout read_layout(Reader& in) {
  const auto count = in.get<std::uint32_t>();
  if (count > kMaxChannels) in.fail("has " + std::to_string(count) + " channels: damaged");
  std::vector<FilmChannel> channels;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string name = in.get_text();
    const bool has_variance = in.get<std::uint8_t>() != 0;
    channels.push_back({std::move(name), has_variance, in.get<std::uint8_t>() != 0});
  }
  return FilmLayout(std::move(channels));
}

void read_coverage(Reader& in, std::size_t pixels, std::vector<IdCoverage>& coverage) {
  coverage.resize(pixels);
  for (IdCoverage& pixel : coverage)
    for (auto left = in.get<std::uint32_t>(); left > 0; --left) {
      const auto shape = in.get<std::uint32_t>();
      pixel.add(shape, in.get<double>());
    }
}

}  // namespace

void write_film(const std::filesystem::path& file, const Film& film) {
  Writer out;
  for (const int value : {film.frame_width_, film.frame_height_, film.crop_.x0, film.crop_.y0, film.crop_.x1,
                          film.crop_.y1, film.spectral_bins(), static_cast<int>(film.unit_)})
    out.put(static_cast<std::int32_t>(value));
  out.put(static_cast<std::uint32_t>(film.layout_.size()));
  for (const FilmChannel& channel : film.layout_.channels()) {
    out.put(std::string_view(channel.name));
    out.put(static_cast<std::uint8_t>(channel.has_variance));
    out.put(static_cast<std::uint8_t>(channel.has_half));
  }
  out.put(film.counts_);
  out.put(film.sums_);
  out.put(film.open_);
  out.put(film.half_);
  out.put(static_cast<std::uint8_t>(film.tells_surfaces()));
  for (const IdCoverage& pixel : film.coverage_) {
    out.put(static_cast<std::uint32_t>(pixel.entries().size()));
    for (const IdCoverage::Entry& entry : pixel.entries()) {
      out.put(entry.shape);
      out.put(entry.weight);
    }
  }
  const std::uint32_t check = check_sum(out.bytes());
  out.put(check);
  write_text_file(file, std::string(kFirstLine) + out.bytes());
}

Film read_film(const std::filesystem::path& file) {
  const std::string bytes = read_bytes(file);
  std::string_view body = bytes;
  Reader whole(file, body);
  if (!body.starts_with(kFirstLine)) whole.fail("is no film of this version of Sheaf");
  body.remove_prefix(kFirstLine.size());
  if (body.size() < sizeof(std::uint32_t)) whole.fail("ends too early: cut off");
  std::uint32_t check;
  std::memcpy(&check, body.data() + body.size() - sizeof check, sizeof check);
  body.remove_suffix(sizeof check);
  if (check != check_sum(body)) whole.fail("is damaged: its check sum is wrong");

  Reader in(file, body);
  std::int32_t numbers[8];
  for (std::int32_t& number : numbers) number = in.get<std::int32_t>();
  const auto [width, height, x0, y0, x1, y1, bins, unit] = numbers;
  if (x0 < 0 || y0 < 0 || x1 < x0 || y1 < y0 || x1 > width || y1 > height || bins < 0 || bins > kMaxSpectralBins ||
      unit < 0 || unit > static_cast<int>(VarianceUnit::kReplicate))
    in.fail("has a crop or bins that cannot be: damaged");
  FilmLayout layout = read_layout(in);
  const auto pixels = static_cast<std::size_t>(x1 - x0) * static_cast<std::size_t>(y1 - y0);
  const bool has_open = unit == static_cast<int>(VarianceUnit::kReplicate) && layout.variance_count() > 0;
  const std::size_t open_numbers = has_open ? 1 + static_cast<std::size_t>(layout.variance_count()) : 0;
  const auto halves = static_cast<std::size_t>(layout.half_count());
  const std::size_t half_numbers = halves > 0 ? 1 + halves : 0;
  const std::size_t numbers_per_pixel = 1 + FilmRow(layout, bins).film_size() + open_numbers + half_numbers;
  constexpr const char* kWrongSize = "has another size than its header claims";
  if (in.left() <= pixels * numbers_per_pixel * sizeof(double)) in.fail(kWrongSize);
  Film film(width, height, {x0, y0, x1, y1}, std::move(layout), bins, static_cast<VarianceUnit>(unit));
  in.get(film.counts_);
  in.get(film.sums_);
  in.get(film.open_);
  in.get(film.half_);
  if (in.get<std::uint8_t>() != 0) read_coverage(in, pixels, film.coverage_);
  if (in.left() > 0) in.fail(kWrongSize);
  return film;
}

}  // namespace sheaf
