#include "tools/preview/preview.h"

#include "kernels/denoise/denoise.h"
#include "kernels/render/render.h"
#include "tools/console/messages.h"
#include "tools/console/progress.h"
#include "tools/preview/displayed_layer.h"
#include "tools/preview/live_page.h"
#include "tools/preview/tev.h"
#include "tools/report/report_text.h"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

namespace sheaf {

namespace {

/// Minimum interval between previews, s, and as a multiple of the cost of the last preview.
constexpr double kMinInterval = 1, kCostFactor = 20;
/// Samples of a render per sample of show_first_passes(), and the largest number of samples of these. Renders that are
/// repeated are looked at while they are young.
struct FirstPasses {
  std::uint32_t fraction, max;
};
constexpr FirstPasses kFirstPasses{32, 4}, kRepeatedPasses{8, 16};
constexpr double kTevSeconds = 5, kPageSeconds = 3;

/// The channels R, G, B and A of an image.
std::shared_ptr<const Image> beauty_of(const Image& image) {
  const auto beauty = std::make_shared<Image>(image.width, image.height, std::vector<std::string>{});
  std::vector<std::size_t> sources;
  for (const char* name : {"R", "G", "B", "A"}) {
    const int channel = image.find_channel(name);
    if (channel < 0) continue;
    beauty->channels.emplace_back(name);
    sources.push_back(static_cast<std::size_t>(channel));
  }
  beauty->x0 = image.x0;
  beauty->y0 = image.y0;
  beauty->frame_width = image.frame_width;
  beauty->frame_height = image.frame_height;
  beauty->data.reserve(image.pixel_count() * sources.size());
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    for (const std::size_t source : sources) beauty->data.push_back(image.data[i * image.channels.size() + source]);
  return beauty;
}

/// Copies R, G, B and A of `other`, an image of the same pixels, to the pixels of `image` where they are zero.
void fill_gaps(Image& image, const Image& other) {
  if (image.pixel_count() != other.pixel_count()) return;
  std::vector<std::pair<std::size_t, std::size_t>> channels;  // in both images
  for (const char* name : {"R", "G", "B", "A"}) {
    const int to = image.find_channel(name), from = other.find_channel(name);
    if (to >= 0 && from >= 0) channels.emplace_back(static_cast<std::size_t>(to), static_cast<std::size_t>(from));
  }
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    float* const to = image.data.data() + i * image.channels.size();
    const float* const from = other.data.data() + i * other.channels.size();
    const bool is_zero = std::all_of(channels.begin(), channels.end(), [&](auto& c) { return to[c.first] == 0.0f; });
    if (!is_zero) continue;
    for (const auto& [target, source] : channels) to[target] = from[source];
  }
}

/// The settings of a render of the same pixels with few samples. `with_layers`: with those that pages show.
RenderSettings first_pass(const RenderSettings& settings, std::uint32_t samples, bool with_layers) {
  RenderRequest request;
  request.samples_per_pixel = samples;
  request.replicates = 1;
  request.crop = settings.crop;
  if (with_layers) request.aovs = page_layers(settings.integrator);
  return resolve_settings(settings, settings.color, request);
}

}  // namespace

void add_preview_options(Command& command, PreviewArguments& arguments) {
  command
      .add_option("--tev", arguments.tev,
                  "Show the image in the viewer tev at HOST:PORT, usually 127.0.0.1:14158, during rendering. The "
                  "viewer may start later or restart")
      .placeholder("HOST:PORT")
      .only_for_run();
  command
      .add_option("--serve", arguments.serve,
                  "Serve a web page with the image, progress, stage times and messages at PORT on this machine, or at "
                  "ADDRESS:PORT (0.0.0.0: all network interfaces, without a password). Port 0: any free port. The page "
                  "closes with the program, after connected browsers have received the final image. See "
                  "docs/preview.md")
      .placeholder("[ADDRESS:]PORT")
      .only_for_run();
}

Preview::Preview(const PreviewArguments& arguments, const std::string& scene, const std::string& name,
                 DisplayTransform display, bool repeats, CameraControl* camera)
    : repeats_(repeats), display_(std::move(display)) {
  if (!arguments.tev.empty())
    tev_ = std::make_unique<TevViewer>(parse_endpoint("--tev", arguments.tev, "", 1), name,
                                       [](const std::string& text) { print_note(text); });
  if (arguments.serve.empty()) return;
  page_ = std::make_unique<LivePage>(parse_endpoint("--serve", arguments.serve, "127.0.0.1", 0), scene, display_,
                                     repeats, camera);
  print_note("preview page: " + page_->url());
  listen_to_messages([this](std::string_view message) { page_->add_message(message); });
}

Preview::~Preview() { listen_to_messages(nullptr); }

void Preview::set_display(DisplayTransform display) {
  if (page_) page_->set_display(display);
  display_ = std::move(display);
}

void Preview::begin_scene() {
  if (page_) page_->begin_scene();
}

void Preview::begin_move() {
  if (page_) page_->begin_move();
}

void Preview::show_move(const RenderResult& result) {
  const auto image = std::make_shared<const Image>(result.film.to_image());
  if (page_) page_->set_image(beauty_of(*image), image);
  if (tev_ && tev_->is_ready()) tev_->show(displayed(*image));
}

void Preview::watch(RenderControl& control) {
  if (!page_ && !tev_) return;
  first_ = nullptr;
  next_ = pause_requested_ = 0;
  if (page_) page_->begin_render();
  control.on_progress = [this, before = std::move(control.on_progress)](const RenderProgress& progress) {
    if (before) before(progress);
    if (page_) page_->update(progress);
  };
  control.on_report = [this, before = std::move(control.on_report)](const RenderReport& report) {
    if (before) before(report);
    if (page_) page_->set_report(to_json(report));
  };
  control.wants_pause = [this, before = std::move(control.wants_pause)] { return (before && before()) || is_due(); };
  control.on_pause = [this, before = std::move(control.on_pause)](const RenderState& state) {
    if (before) before(state);
    if (pause_requested_ > 0) show(state);
  };
}

void Preview::show_first_passes(const Scene& scene, const RenderSettings& settings, const RenderControl& control) {
  const bool is_new = control.resume == nullptr && settings.integrator.traits().source == PathSource::kCamera;
  if ((!page_ && !tev_) || !is_new) return;
  RenderControl first;
  first.threads = control.threads;
  first.wave_size = control.wave_size;
  first.stop = control.stop;
  const FirstPasses passes = repeats_ ? kRepeatedPasses : kFirstPasses;
  const std::uint32_t samples = settings.camera_samples(), most = std::max(samples / passes.fraction, 1u);
  std::uint32_t taken = 0;
  for (std::uint32_t count = 1; samples > 1 && count <= passes.max && taken + count <= most; count *= 2) {
    const RenderResult result = render(scene, first_pass(settings, count, page_ && repeats_), first);
    if (result.interrupted) return;
    taken += count;
    first_ = std::make_shared<const Image>(result.film.beauty_image());
    if (page_) page_->set_image(first_, repeats_ ? std::make_shared<const Image>(result.film.to_image()) : nullptr);
    if (tev_ && tev_->is_ready()) tev_->show(displayed(*first_));
  }
}

bool Preview::is_due() {
  const double now = Progress::steady_seconds();
  if (now < next_.load(std::memory_order_relaxed)) return false;
  const bool looked_at = (page_ && page_->wants_image()) || (tev_ && tev_->is_ready());
  double never = 0;
  if (looked_at) pause_requested_.compare_exchange_strong(never, now, std::memory_order_relaxed);
  return looked_at;
}

void Preview::show(const RenderState& state) {
  // Only denoising needs all layers
  const bool all = page_ && page_->wants_denoised();
  Image image = all ? state.film.to_image() : state.film.beauty_image();
  if (state.splats && state.photons > 0) state.splats->add_to(image, state.photons);
  if (first_) fill_gaps(image, *first_);
  if (page_) page_->set_image(beauty_of(image));
  if (tev_ && tev_->is_ready()) tev_->show(displayed(image));
  // The variances are valid only after two replicates
  if (all) page_->denoise(std::make_shared<const Image>(std::move(image)), false);
  const double now = Progress::steady_seconds();
  double cost = now - pause_requested_;
  // The page encodes in parallel to the render, on one of its processors.
  if (page_) cost += page_->encoding_seconds() / std::max(1u, std::thread::hardware_concurrency());
  next_ = now + std::max(kMinInterval, kCostFactor * cost);
  pause_requested_ = 0;
}

/// The image as viewers show it.
std::shared_ptr<const Image> Preview::displayed(const Image& image) const {
  return display_.is_identity() ? beauty_of(image) : std::make_shared<Image>(display_.apply(image));
}

void Preview::begin_writing() {
  if (page_) page_->set_state("writing");
}

void Preview::fail(const std::string& errors) {
  if (page_) page_->fail(errors);
}

void Preview::finish(const std::string& state, const Image& image, const RenderReport& report) {
  if (!page_ && !tev_) return;
  if (tev_) tev_->show(displayed(image));
  if (page_) {
    page_->set_report(to_json(report));
    page_->set_image(beauty_of(image.find_channel("denoised.R") >= 0 ? denoised_only(image) : image));
    if (page_->wants_denoised()) page_->denoise(std::make_shared<const Image>(image), report.noise.has_value());
    page_->set_state(state);
  }
  if (repeats_) return;
  if (tev_) tev_->finish(kTevSeconds);
  if (page_) page_->wait_until_seen(kPageSeconds);
}

}  // namespace sheaf
