// Renders that are paused, saved, loaded and resumed have the same bits as uninterrupted ones.
#include "core/io/error.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <cstring>

namespace sheaf::test_resume {

namespace {

const RecordedSettings kSettings{{"--spp", "8"}, {"scene.xml", "1 bytes"}};

/// A lit box with a sphere, with a filter that is wider than a pixel.
Description small_box(int samples, int width = 70, int height = 50) {
  Description d = empty_scene(width, height);
  look_at(d, {0, 0.3f, -3}, {0, 0, 0}, {0, 1, 0}, 50);
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  d.sampler.kind = SamplerKind::kSobol;
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  const MaterialId white = add_diffuse(d, 0.7f);
  add_rectangle(d, Transform::translate({0, -1, 0}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}),
                white);
  add_rectangle(d, Transform::translate({0, 0, 1}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({2, 2, 1}),
                white);
  add_sphere(d, {0.2f, -0.6f, 0}, 0.4f, add_glass(d));
  emit(add_rectangle(d, Transform::translate({0, 1.5f, 0}) * Transform::rotate({1, 0, 0}, 90), add_diffuse(d, 0)), 4);
  return d;
}

/// A kind of render with its settings.
struct Case {
  const char* name;
  Description scene;
  RenderOptions options;
  ColorMode color = ColorMode::kRgb;
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  const auto add = [&](const char* name, int samples = 8) -> Case& {
    return cases.emplace_back(Case{name, samples > 256 ? small_box(samples, 24, 16) : small_box(samples), {}});
  };
  Case& layers = add("replicates and layers");
  layers.options.replicates = 2;
  layers.options.aovs = {aov_named("albedo"), aov_named("depth"), aov_named("cryptomatte_object"),
                         aov_named("variance"), aov_named("half")};
  add("more than one pass", 300);
  add("independent").scene.sampler.kind = SamplerKind::kIndependent;
  Case& importance = add("importance");
  importance.scene.film.filter_mode = FilterMode::kImportance;
  Case& spectral = add("spectral bins");
  spectral.color = ColorMode::kSpectral;
  spectral.options.spectral_bins = 5;
  add("guiding", 32).options.guiding = GuidingMode::kOn;
  Case& light = add("light tracing");
  light.scene.integrator.kind = IntegratorKind::kLightTracer;
  light.options.aovs = {aov_named("variance")};
  for (const bool progressive : {false, true}) {
    Case& photons = add(progressive ? "progressive photon mapping" : "photon mapping");
    photons.scene.integrator.kind = IntegratorKind::kPhotonMapper;
    photons.scene.integrator.photons.progressive = progressive;
    photons.scene.integrator.photons.global.count = 2000;
    if (!progressive) photons.color = ColorMode::kSpectral;
  }
  return cases;
}

bool same_images(const Image& a, const Image& b) {
  return a.channels == b.channels && a.data.size() == b.data.size() &&
         std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0;
}

/// Renders until `tasks` tasks have started, and writes a checkpoint. Returns whether the render was interrupted.
bool render_part(const Scene& scene, RenderOptions options, int tasks, const std::filesystem::path& file) {
  std::atomic<int> asked{0};
  std::atomic<bool> stop{false};
  options.stop = &stop;
  options.wants_pause = [&] {
    if (asked.fetch_add(1) < tasks) return false;
    stop = true;
    return true;
  };
  options.on_pause = [&](const RenderState& state) { write_checkpoint(file, kSettings, state); };
  return render(scene, options).interrupted;
}

}  // namespace

TEST_CASE("a resumed render has the same bytes as an uninterrupted one") {
  const TemporaryFolder folder;
  const auto file = folder / "render.checkpoint";
  for (const Case& c : all_cases()) {
    CAPTURE(std::string(c.name));
    const auto scene = compile_scene(c.scene, {false, c.color});
    RenderOptions options = c.options;
    options.threads = 2;
    const Image whole = render(*scene, options).to_image();
    int parts = 0;
    for (int tasks = 3; parts < 3; tasks += 4) {
      options.threads = 1 + parts % 2;
      options.wave_size = 256 + 64 * parts;
      std::optional<RenderState> state;
      if (parts > 0) state = read_checkpoint(file, kSettings);
      options.resume = state ? &*state : nullptr;
      const bool interrupted = render_part(*scene, options, tasks, file);
      if (parts == 0) CHECK(interrupted);
      ++parts;
    }
    for (const bool again : {false, true}) {  // once to the end, once from that checkpoint
      CAPTURE(again);
      RenderState state = read_checkpoint(file, kSettings);
      options.resume = &state;
      options.on_pause = [&](const RenderState& end) { write_checkpoint(file, kSettings, end); };
      const RenderResult result = render(*scene, options);
      CHECK_FALSE(result.interrupted);
      CHECK(same_images(result.to_image(), whole));
    }
  }
}

TEST_CASE("an interrupted render reports its sample count and its noise where it is known") {
  for (const bool traces_light : {false, true})
    for (const bool adapts : {false, true}) {
      if (traces_light && adapts) continue;
      CAPTURE(traces_light);
      CAPTURE(adapts);
      Description d = small_box(64);
      if (traces_light) d.integrator.kind = IntegratorKind::kLightTracer;
      const auto scene = compile_scene(d);
      RenderOptions options;
      options.threads = 1;
      options.replicates = 4;
      if (adapts) options.noise_target = 1e-4;
      const RenderResult whole = render(*scene, options);
      CHECK_FALSE(whole.report.interrupted);
      CHECK(whole.report.mean_samples == near(64));
      CHECK(whole.report.noise.has_value());
      // Interrupted in the first of four replicates, then in the last. Light tracing counts whole rounds of photons, of
      // which there is one.
      double taken = 0;
      for (const double fraction : {0.2, 0.9}) {
        std::atomic<bool> stop{false};
        options.stop = &stop;
        options.on_progress = [&](const RenderProgress& progress) {
          if (progress.fraction() >= fraction) stop = true;
        };
        const RenderResult part = render(*scene, options);
        CHECK(part.interrupted);
        CHECK(part.report.interrupted);
        CHECK((part.report.mean_samples > taken || traces_light));
        CHECK(part.report.mean_samples < 64);
        taken = part.report.mean_samples;
        if (!traces_light) CHECK(part.report.mean_samples == near(part.film.mean_samples(), 0.3));
        if (!traces_light && !adapts) CHECK(part.report.noise.has_value() == (fraction > 0.5));
        if (part.report.noise) {
          CHECK(*part.report.noise > 0);
          CHECK(*part.report.noise > 0.8 * *whole.report.noise);
        }
      }
    }
}

TEST_CASE("pauses do not change the image") {
  const auto scene = compile_scene(small_box(16));
  RenderOptions options;
  const Image whole = render(*scene, options).to_image();
  std::atomic<int> asked{0};
  int pauses = 0;
  options.wants_pause = [&] { return asked.fetch_add(1) % 3 == 2; };
  options.on_pause = [&](const RenderState& state) {
    ++pauses;
    CHECK(state.film.width() == 70);
  };
  CHECK(same_images(render(*scene, options).to_image(), whole));
  CHECK(pauses > 2);
}

TEST_CASE("a checkpoint keeps the counters of a render") {
  const TemporaryFolder folder;
  const auto file = folder / "render.checkpoint";
  const auto scene = compile_scene(small_box(64));
  RenderState counted;
  counted.division = {8, 8, 0, 256, {0, 8}};
  counted.film = Film(2, 1, {0, 0, 2, 1});
  counted.photons = 7;
  counted.dropped = {3, 5};
  write_checkpoint(file, kSettings, counted);
  const RenderState back = read_checkpoint(file, kSettings);
  CHECK(back.photons == 7);
  CHECK(back.dropped.rays == 3);
  CHECK(back.dropped.samples == 5);

  RenderOptions options;
  options.noise_target = 0.01;
  options.samples_per_pixel = 64;
  std::atomic<int> asked{0};
  options.wants_pause = [&] { return asked.fetch_add(1) % 3 == 2; };
  int with_image = 0, without = 0;
  options.on_pause = [&](const RenderState& state) {
    REQUIRE(state.adaptive.has_value());
    write_checkpoint(file, kSettings, state);
    const RenderState again = read_checkpoint(file, kSettings);
    REQUIRE(again.adaptive.has_value());
    CHECK(again.adaptive->has_image() == state.adaptive->has_image());
    ++(state.adaptive->has_image() ? with_image : without);
    for (const std::size_t tile : {0u, 1u})
      CHECK(again.adaptive->expected_samples(tile) == state.adaptive->expected_samples(tile));
  };
  render(*scene, options);
  CHECK(with_image > 0);
  CHECK(without > 0);
}

TEST_CASE("foreign and damaged checkpoints are rejected with exit code 5") {
  const TemporaryFolder folder;
  const auto file = folder / "render.checkpoint";
  const auto scene = compile_scene(small_box(8));
  REQUIRE(render_part(*scene, {}, 2, file));
  const auto message_of = [&](const RecordedSettings& settings) {
    try {
      read_checkpoint(file, settings);
    } catch (const Error& error) {
      CHECK(error.exit_code() == ExitCode::kCheckpoint);
      return std::string(error.what());
    }
    return std::string();
  };
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  CHECK(message_of(kSettings).empty());
  CHECK(message_of({{"--spp", "9"}, {"scene.xml", "1 bytes"}}).empty());  // judged by continue_from()
  CHECK(contains(message_of({{"--spp", "8"}, {"scene.xml", "2 bytes"}}),
                 "scene.xml has changed ('1 bytes' in the checkpoint, '2 bytes' now)"));
  CHECK(contains(message_of({{"--spp", "8"}}), "scene.xml in the checkpoint is not part of the scene now"));
  CHECK(contains(message_of({{"--spp", "8"}, {"scene.xml", "1 bytes"}, {"--seed", "2"}}),
                 "--seed 2 now, not in the checkpoint"));

  const std::string good = read_bytes(file);
  for (std::size_t size = 0; size < good.size(); size += good.size() / 50 + 1) {
    write_bytes(file, good.substr(0, size));
    CHECK_FALSE(message_of(kSettings).empty());
    std::string bytes = good;
    bytes[size] = static_cast<char>(bytes[size] ^ 4);
    write_bytes(file, bytes);
    CHECK_FALSE(message_of(kSettings).empty());
  }
  write_bytes(file, good);
  // A checkpoint for another frame with the same settings.
  const auto other = compile_scene(small_box(4));
  Description wide = small_box(8);
  wide.film.width = 71;
  const auto wider = compile_scene(wide);
  for (const Scene* each : {other.get(), wider.get()}) {
    RenderState state = read_checkpoint(file, kSettings);
    state.first_sample = each == other.get() ? 5 : state.first_sample;
    RenderOptions options;
    options.resume = &state;
    CHECK_THROWS_AS(render(*each, options), Error);
  }
}

}  // namespace sheaf::test_resume
