// Passes of a render: their numbers of samples.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/render_testing.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_passes {

namespace {

/// The samples per pixel at the end of each pass, of a render that pauses after every task. Checks that all pixels then
/// have that many samples.
std::vector<std::uint32_t> pass_ends(int samples, int replicates) {
  Description d = empty_scene(30, 20);
  d.sampler.kind = SamplerKind::kSobol;
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  add_constant_light(d, 1);
  const auto scene = compile_scene(d);
  RenderOptions options;
  options.threads = 1;
  options.replicates = replicates;
  bool has_progress = false;
  std::vector<std::uint32_t> ends;
  options.on_progress = [&](const RenderProgress&) { has_progress = true; };
  options.wants_pause = [&] { return has_progress; };
  options.on_pause = [&](const RenderState& state) {
    has_progress = false;
    const bool is_between = std::all_of(state.tiles.begin(), state.tiles.end(), [](auto done) { return done == 0; });
    if (!is_between || state.first_sample == 0) return;
    if (ends.empty() || ends.back() != state.first_sample) ends.push_back(state.first_sample);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 30; ++x) REQUIRE(state.film.count(x, y) == state.first_sample);
  };
  render(*scene, options);
  return ends;
}

}  // namespace

TEST_CASE("each pass covers the frame, and ends where a set of samples ends") {
  using Ends = std::vector<std::uint32_t>;
  CHECK(pass_ends(1, 1) == Ends{1});
  CHECK(pass_ends(20, 2) == Ends{10, 20});
  CHECK(pass_ends(700, 1) == Ends{256, 512, 700});
}

}  // namespace sheaf::test_passes
