// Reads and writes checkpoints in the binary format of kernels/film/film_file.h.
#include "kernels/render/render_state.h"

#include "kernels/film/film_file.h"

#include <array>
#include <cstring>
#include <fstream>

namespace sheaf {

namespace {

constexpr std::string_view kFirstWords = "sheaf checkpoint ", kFirstLine = "sheaf checkpoint 3\n";
/// Maximum number of settings: far beyond any command line.
constexpr std::uint32_t kMaxSettings = 100'000;
/// Maximum number of differences that a message lists.
constexpr std::size_t kMaxReported = 5;

RecordedSettings get_settings(BinaryInput& in) {
  const auto count = in.get<std::uint32_t>();
  if (count > kMaxSettings) in.fail(fmt::format("is damaged (it lists {} settings)", count));
  RecordedSettings settings;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string name = in.get_text();
    settings.push_back({std::move(name), in.get_text()});
  }
  return settings;
}

const std::string* find(const RecordedSettings& settings, const std::string& name) {
  for (const RecordedSetting& setting : settings)
    if (setting.name == name) return &setting.value;
  return nullptr;
}

/// A difference of a setting. `here`, `there`: its value in the render and in the checkpoint; null: it is not set.
std::string difference(const std::string& name, const std::string* here, const std::string* there) {
  if (!name.starts_with("--")) {
    if (there == nullptr) return fmt::format("{} is not in the checkpoint", name);
    if (here == nullptr) return fmt::format("{} in the checkpoint is not part of the scene now", name);
    return fmt::format("{} has changed ('{}' in the checkpoint, '{}' now)", name, *there, *here);
  }
  // Options without a value have the value "true"
  const auto given = [&](const std::string& value) { return value == "true" ? name : name + " " + value; };
  if (there == nullptr) return given(*here) + " now, not in the checkpoint";
  return given(*there) + " in the checkpoint, " + (here == nullptr ? "not" : *here) + " now";
}

/// One line for each difference, at most kMaxReported.
std::vector<std::string> differences(const RecordedSettings& here, const RecordedSettings& there) {
  std::vector<std::string> found;
  // Another number of samples continues the render, perhaps with another number of sets
  const std::string *spp = find(here, "--spp"), *spp_there = find(there, "--spp");
  const bool continues = (spp == nullptr) != (spp_there == nullptr) || (spp != nullptr && *spp != *spp_there);
  const auto may_differ = [&](const std::string& name) {
    return continues && (name == "--spp" || name == "--replicates");
  };
  for (const auto& [name, value, kind] : here) {
    if (may_differ(name)) continue;
    const std::string* other = find(there, name);
    if (other == nullptr || *other != value) found.push_back(difference(name, &value, other));
  }
  for (const auto& [name, value, kind] : there)
    if (!may_differ(name) && find(here, name) == nullptr) found.push_back(difference(name, nullptr, &value));
  if (found.size() <= kMaxReported) return found;
  const std::string more = fmt::format("and {} more", found.size() - kMaxReported);
  found.resize(kMaxReported);
  found.push_back(more);
  return found;
}

void check_settings(const BinaryInput& in, const RecordedSettings& here, const RecordedSettings& there) {
  std::string text;
  for (const std::string& difference : differences(here, there)) text += (text.empty() ? "" : "; ") + difference;
  if (!text.empty()) in.fail("is a checkpoint of another render: " + text);
}

/// The version of Sheaf that wrote a checkpoint, which may have another layout; empty for other files.
std::string writer_of(const std::filesystem::path& file) {
  std::array<char, 256> bytes{};
  std::ifstream(file, std::ios::binary).read(bytes.data(), bytes.size());
  const std::string_view text(bytes.data(), bytes.size()), name = kVersionSetting;
  // The first line, the number of settings, and the first of them: both its texts follow their lengths
  const std::size_t length_at = text.find(name) + name.size();
  std::uint32_t length = 0;
  if (!text.starts_with(kFirstWords) || length_at < name.size() || length_at > text.size() / 2) return "";
  std::memcpy(&length, &text[length_at], sizeof length);
  return std::string(text.substr(length_at + sizeof length, std::min<std::uint32_t>(length, 32)));
}

/// Rejects checkpoints of other versions of Sheaf.
void check_version(const std::filesystem::path& file, const RecordedSettings& here) {
  const std::string *const version = find(here, kVersionSetting), writer = writer_of(file);
  if (version == nullptr || writer.empty() || writer == *version) return;
  throw Error(
      ExitCode::kCheckpoint, {file.string(), 0},
      fmt::format("was written by Sheaf {0}, but this is Sheaf {1}: finish the render with Sheaf {0}, or delete "
                  "the file to begin again",
                  writer, *version));
}

/// The numbers of a division in the order of the file.
std::array<std::uint32_t, 6> numbers_of(const SampleDivision& d) {
  return {d.spp, d.replicate_samples, d.half_samples, d.max_pass_samples, d.range.first, d.range.count};
}

SampleDivision get_division(BinaryInput& in) {
  std::array<std::uint32_t, 6> numbers{};
  for (std::uint32_t& number : numbers) number = in.get<std::uint32_t>();
  const auto [spp, replicate, half, pass, first, count] = numbers;
  if (spp == 0 || replicate == 0 || pass == 0 || first > spp || count > spp - first || half > spp)
    in.fail("is damaged (its samples are divided in an impossible way)");
  return {spp, replicate, half, pass, {first, count}};
}

}  // namespace

void write_checkpoint(const std::filesystem::path& file, const RecordedSettings& settings, const RenderState& state) {
  BinaryOutput out(file, kFirstLine);
  out.put(static_cast<std::uint32_t>(settings.size()));
  for (const auto& [name, value, kind] : settings) {
    out.put(std::string_view(name));
    out.put(std::string_view(value));
  }
  for (const std::uint32_t number : numbers_of(state.division)) out.put(number);
  put_film(out, state.film);
  out.put(state.first_sample);
  out.put(static_cast<std::uint64_t>(state.tiles.size()));
  out.put(state.tiles);
  put_borders(out, state.borders);
  out.put(static_cast<std::uint8_t>(state.adaptive.has_value()));
  if (state.adaptive) put_adaptive(out, *state.adaptive);
  out.put(static_cast<std::uint8_t>(state.splats.has_value()));
  if (state.splats) put_splats(out, *state.splats);
  out.put(state.photons);
  out.put(state.dropped.rays);
  out.put(state.dropped.samples);
  out.commit();
}

RenderState read_checkpoint(const std::filesystem::path& file, const RecordedSettings& settings) {
  check_version(file, settings);
  BinaryInput in(file, kFirstLine);
  check_settings(in, settings, get_settings(in));
  RenderState state;
  state.division = get_division(in);
  state.film = get_film(in);
  state.first_sample = in.get<std::uint32_t>();
  state.tiles = in.get_vector<std::uint8_t>(in.get<std::uint64_t>());
  state.borders = get_borders(in, state.film);
  if (in.get<std::uint8_t>() != 0) state.adaptive = get_adaptive(in, state.film);
  if (in.get<std::uint8_t>() != 0) {
    state.splats.emplace(state.film.crop());
    get_splats(in, *state.splats);
  }
  state.photons = in.get<std::uint64_t>();
  state.dropped.rays = in.get<std::uint64_t>();
  state.dropped.samples = in.get<std::uint64_t>();
  if (in.left() > 0) in.fail("is damaged (data after the end)");
  return state;
}

}  // namespace sheaf
