// Checkpoints. The first line and the checksum are corrected for every input, because almost none would be read
// otherwise.
#include "core/io/inflate.h"
#include "kernels/render/render_state.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/temporary_folder.h"

namespace sheaf::fuzz {

namespace {

const RecordedSettings kSettings = {{"spp", "16"}};

/// The first line of all checkpoints of this version.
std::string first_line() {
  const std::filesystem::path file = folder() / "first.checkpoint";
  write_checkpoint(file, kSettings, {});
  const std::string bytes = read_bytes(file);
  return bytes.substr(0, bytes.find('\n') + 1);
}

}  // namespace

void try_input(std::string_view input) {
  static const std::string line = first_line();
  std::string bytes = line + std::string(input);
  const std::uint32_t sum = check_sum(bytes);
  bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  const auto file = make_file("render.checkpoint", bytes);
  reads([&] {
    const RenderState state = read_checkpoint(file, kSettings);
    Film film = state.film;
    film.add(state.borders);
    (void)film.to_image();
    if (state.adaptive) {
      AdaptiveFilm adaptive = *state.adaptive;
      adaptive.begin_round();
      adaptive.assemble(film);
    }
  });
}

}  // namespace sheaf::fuzz
