#include "tools/preview/live_page.h"

#include "core/image/image_encoding.h"
#include "tools/console/progress.h"
#include "tools/preview/displayed_layer.h"
#include "tools/preview/preview_page.h"
#include "tools/preview/preview_script.h"
#include "tools/preview/preview_style.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <utility>

namespace sheaf {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCameraPath = "/camera";
constexpr const char* kDenoised = "denoised";
constexpr std::size_t kMaxMessages = 200, kMaxMessageBytes = 4000;
/// Time after its last request for which a browser counts as connected, s. The page sends a request every second.
constexpr double kClientTimeout = 4;
/// Extra time for pages in other windows to send another request, s.
constexpr double kPollSlack = 1.3;
/// PNG compression level: fast, because each image is sent once.
constexpr int kPngLevel = 1;

std::string new_run() {
  static std::atomic<int> count{0};
  return fmt::format("{}-{}-{}", std::time(nullptr), getpid(), ++count);
}

std::shared_ptr<const std::string> shared_text(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

/// The page with its style and its script.
std::string preview_page() {
  std::string page = kPreviewPage;
  for (const auto& [mark, text] : {std::pair("/* style */", kPreviewStyle), std::pair("/* script */", kPreviewScript)})
    page.replace(page.find(mark), std::strlen(mark), text);
  return page;
}

HttpResponse json_response(const Json& json) {
  return {200, "application/json", shared_text(json.dump(-1, ' ', false, Json::error_handler_t::replace))};
}

Json optional_json(const std::optional<double>& number) { return number ? Json(*number) : Json(); }

Json to_json(const std::optional<CameraState>& camera) {
  if (!camera) return {};
  return {
      {"moved", camera->is_moved}, {"number", camera->number}, {"mitsuba", camera->mitsuba}, {"pbrt", camera->pbrt}};
}

/// The display that a browser requests: "exposure tone_map", each of which may be empty. A tone map replaces a view of
/// OpenColorIO. Returns nothing for malformed text.
std::optional<DisplayTransform> display_for(std::string_view text, const DisplayTransform& display) {
  constexpr double kMaxStops = 100;
  DisplaySettings settings = display.settings();
  const std::string_view exposure = text.substr(0, text.find(' ')), tone_map = text.substr(exposure.size() + 1);
  if (!exposure.empty()) {
    double stops = 0;
    const auto [end, error] = std::from_chars(exposure.data(), exposure.data() + exposure.size(), stops);
    if (error != std::errc() || end != exposure.data() + exposure.size() || !(std::abs(stops) <= kMaxStops))
      return std::nullopt;
    settings.exposure = stops;
  }
  if (!tone_map.empty()) {
    const ToneMap* const named = kToneMaps.find(tone_map);
    if (named == nullptr) return std::nullopt;
    settings.tone_map = *named;
    settings.display_view = nullptr;
  }
  return DisplayTransform(std::move(settings));
}

}  // namespace

LivePage::LivePage(const Endpoint& endpoint, std::string scene, DisplayTransform display, bool repeats,
                   CameraControl* camera)
    : scene_(std::move(scene)),
      repeats_(repeats),
      camera_(camera),
      display_(std::move(display)),
      run_(new_run()),
      denoiser_([this](int number, const Image& image) {
        const std::lock_guard lock(mutex_);
        denoised_ = std::make_shared<const Image>(image);
        denoised_number_ = number;
        image_denoised_ = number == image_number_;
      }),
      server_(
          endpoint, [this](const HttpRequest& request) { return answer(request); },
          camera != nullptr ? HttpServer::Posts{kCameraPath, kMaxCameraRequest} : HttpServer::Posts{}) {}

void LivePage::begin_scene() {
  const std::lock_guard lock(mutex_);
  run_ = new_run();
  set_progress({});
  start_ = end_ = 0;
  state_ = "reading";
  report_ = "null";
  errors_.clear();
  messages_.clear();
}

void LivePage::begin_move() {
  const std::lock_guard lock(mutex_);
  set_progress({});
  start_ = end_ = 0;
  state_ = "moving";
}

void LivePage::begin_render() {
  const std::lock_guard lock(mutex_);
  start_ = Progress::steady_seconds();
  state_ = "rendering";
}

void LivePage::set_display(const DisplayTransform& display) {
  const std::lock_guard lock(mutex_);
  display_ = display;
}

void LivePage::update(const RenderProgress& progress) {
  const std::lock_guard lock(progress_mutex_);
  if (progress.done > progress_.done) progress_ = progress;  // workers may report in any order
}

RenderProgress LivePage::progress() const {
  const std::lock_guard lock(progress_mutex_);
  return progress_;
}

void LivePage::set_progress(const RenderProgress& progress) {
  const std::lock_guard lock(progress_mutex_);
  progress_ = progress;
}

void LivePage::set_state(const std::string& state) {
  const std::lock_guard lock(mutex_);
  if (end_ == 0) end_ = Progress::steady_seconds();
  state_ = state;
  state_seen_ = false;
}

void LivePage::fail(const std::string& errors) {
  set_state("failed");
  const std::lock_guard lock(mutex_);
  errors_ = errors;
}

void LivePage::set_report(const std::string& json) {
  const std::lock_guard lock(mutex_);
  report_ = json;
}

void LivePage::set_image(std::shared_ptr<const Image> image, std::shared_ptr<const Image> layers) {
  const std::lock_guard lock(mutex_);
  image_ = std::move(image);
  ++image_number_;
  if (layers) {
    layers_ = std::move(layers);
    layers_number_ = image_number_;
  }
  image_seen_ = image_denoised_ = false;
}

void LivePage::denoise(std::shared_ptr<const Image> image, bool has_variances) {
  int number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = image_number_;
  }
  denoiser_.submit(number, std::move(image), has_variances);
}

void LivePage::add_message(std::string_view message) {
  const std::lock_guard lock(mutex_);
  messages_.emplace_back(message.substr(0, kMaxMessageBytes));
  if (messages_.size() > kMaxMessages) messages_.pop_front();
}

bool LivePage::is_watched() const { return Progress::steady_seconds() - looked_ < kClientTimeout; }

bool LivePage::wants_image() const {
  const bool is_denoised = image_denoised_.load(std::memory_order_relaxed) && wants_denoised();
  return (image_seen_.load(std::memory_order_relaxed) || is_denoised) && is_watched();
}

bool LivePage::wants_denoised() const {
  return Progress::steady_seconds() - denoised_looked_.load(std::memory_order_relaxed) < kClientTimeout;
}

void LivePage::wait_until_seen(double seconds) {
  if (!is_watched()) return;
  const double start = Progress::steady_seconds();
  std::unique_lock lock(mutex_);
  const bool seen = seen_.wait_for(lock, std::chrono::duration<double>(seconds),
                                   [this] { return state_seen_ && sent_number_ == image_number_; });
  const double left = std::min(kPollSlack, seconds) - (Progress::steady_seconds() - start);
  if (seen && left > 0) seen_.wait_for(lock, std::chrono::duration<double>(left), [] { return false; });
}

HttpResponse LivePage::answer(const HttpRequest& request) {
  const std::string_view path = request.path;
  if (path == kCameraPath && request.method == "POST") return move(request);
  if (path == "/") return {200, "text/html; charset=utf-8", shared_text(preview_page())};
  if (path == "/status.json") return status();
  if (path == "/image.png") return encoded_image(request, std::string(request.value("layer")));
  if (path == "/pick.json" && camera_ != nullptr) return picked(request);
  if (path == "/denoised/status.json") {
    denoised_looked_ = Progress::steady_seconds();
    return status();
  }
  if (path == "/denoised/image.png") return encoded_image(request, kDenoised);
  return {404, HttpResponse().type, nullptr};
}

HttpResponse LivePage::status() {
  const std::optional<CameraState> camera = camera_ != nullptr ? camera_->state() : std::nullopt;
  const double now = Progress::steady_seconds();
  looked_ = now;
  const std::lock_guard lock(mutex_);
  // Estimate the progress
  const RenderProgress progress = this->progress();
  const double fraction = state_ == "done" ? 1.0 : std::min(progress.fraction(), 0.9999);
  const double elapsed = start_ > 0 ? (end_ > 0 ? end_ : now) - start_ : 0.0;
  const double left = state_ == "rendering" ? progress.seconds_left(elapsed) : -1.0;
  // Build the response
  const Json json{{"run", run_},
                  {"scene", scene_},
                  {"state", state_},
                  {"done", progress.done},
                  {"total", progress.total},
                  {"total_is_bound", progress.is_bound},
                  {"fraction", fraction},
                  {"elapsed_seconds", elapsed},
                  {"left_seconds", left >= 0 ? Json(left) : Json()},
                  {"samples_per_second", progress.samples_per_second(elapsed)},
                  {"image", image_number_},
                  {"denoised_image", denoised_number_},
                  {"layers_image", layers_number_},
                  {"layers", layers_ ? shown_layers(*layers_) : std::vector<std::string_view>()},
                  {"exposure", optional_json(display_.settings().exposure)},
                  {"tone_map", kToneMaps.name_of(display_.settings().tone_map)},
                  {"camera", to_json(camera)},
                  {"errors", errors_},
                  {"repeats", repeats_},
                  {"messages", messages_},
                  {"report", Json::parse(report_)}};
  state_seen_ = true;
  seen_.notify_all();
  return json_response(json);
}

HttpResponse LivePage::move(const HttpRequest& request) const {
  const std::optional<CameraRequest> motion = parse_camera_request(request.body);
  if (!motion) return {400, HttpResponse().type, nullptr};
  if (!camera_->move(*motion)) return {409, HttpResponse().type, nullptr};  // no scene, or none with such a camera
  return json_response(to_json(camera_->state()));
}

HttpResponse LivePage::picked(const HttpRequest& request) const {
  const std::optional<ImagePosition> at = parse_image_position(request.value("x"), request.value("y"));
  if (!at) return {400, HttpResponse().type, nullptr};
  Json json = Json::object();
  if (const std::optional<PickedPoint> point = camera_->pick(*at))
    json = {{"object", point->object},
            {"material", point->material},
            {"position", {point->position.x, point->position.y, point->position.z}},
            {"distance", point->distance}};
  // Radiance of the pixel
  const std::lock_guard lock(mutex_);
  if (!image_ || image_->channels.size() < 3) return json_response(json);
  const int x = std::min(static_cast<int>(at->x * image_->width), image_->width - 1);
  const int y = std::min(static_cast<int>(at->y * image_->height), image_->height - 1);
  json["pixel"] = {image_->x0 + x, image_->y0 + y};
  json["radiance"] = {image_->at(x, y, 0), image_->at(x, y, 1), image_->at(x, y, 2)};
  return json_response(json);
}

std::shared_ptr<const Image> LivePage::source_image(const std::string& source, int& number) const {
  const std::lock_guard lock(mutex_);
  if (source == kDenoised) {
    number = denoised_number_;
    return denoised_;
  }
  number = source.empty() ? image_number_ : layers_number_;
  return source.empty() ? image_ : layers_;
}

HttpResponse LivePage::encoded_image(const HttpRequest& request, const std::string& source) {
  int number = 0;
  const std::shared_ptr<const Image> image = source_image(source, number);
  const auto names =
      image && source != kDenoised && !source.empty() ? shown_layers(*image) : std::vector<std::string_view>{source};
  if (!image || std::find(names.begin(), names.end(), source) == names.end())
    return {404, HttpResponse().type, nullptr};
  if (source.empty()) looked_ = Progress::steady_seconds();
  // Browsers that follow the camera ask again until there is another image
  if (!request.value("after").empty() && request.value("after") == std::to_string(number))
    return {204, HttpResponse().type, nullptr, number};
  const std::string display = fmt::format("{} {}", request.value("exposure"), request.value("tone_map"));
  std::shared_ptr<const std::string> png = encoded(image, {number, source, display, nullptr});
  if (!png) return {400, HttpResponse().type, nullptr};
  if (!source.empty()) return {200, "image/png", png, number};
  return {200, "image/png", sent_body(png, number), number};
}

std::shared_ptr<const std::string> LivePage::encoded(const std::shared_ptr<const Image>& image, EncodedView view) {
  constexpr std::size_t kMaxViews = 4;
  for (const EncodedView& each : encoded_)
    if (each.number == view.number && each.source == view.source && each.display == view.display) return each.png;
  const auto default_display = [this] {
    const std::lock_guard lock(mutex_);
    return display_;
  };
  const std::optional<DisplayTransform> display = display_for(view.display, default_display());
  if (!display) return nullptr;
  const double start = Progress::steady_seconds();
  const bool is_layer = !view.source.empty() && view.source != kDenoised;
  const IntegerEncoding format{IntegerFormat::kPng, kPngLevel, 0, {}};
  const std::vector<unsigned char> png =
      is_layer ? encode_image(displayed_layer(*image, view.source), format)
               : encode_image(display->is_identity() ? *image : display->apply(*image), format);
  view.png = std::make_shared<const std::string>(png.begin(), png.end());
  if (!is_layer) encoding_seconds_ = Progress::steady_seconds() - start;
  encoded_.push_front(view);
  if (encoded_.size() > kMaxViews) encoded_.pop_back();
  return view.png;
}

/// The body of a response with the image, whose release shows that it was sent.
std::shared_ptr<const std::string> LivePage::sent_body(const std::shared_ptr<const std::string>& png, int number) {
  const std::lock_guard lock(mutex_);
  if (number == image_number_) image_seen_ = true;
  const auto sent = [this, png, number](const std::string*) {
    const std::lock_guard guard(mutex_);
    sent_number_ = std::max(sent_number_, number);
    seen_.notify_all();
  };
  return {png.get(), sent};
}

}  // namespace sheaf
