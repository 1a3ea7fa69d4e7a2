#include "tools/preview/live_page.h"

#include "core/image/image_encoding.h"
#include "tools/console/progress.h"
#include "tools/preview/preview_page.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <ctime>

namespace sheaf {

namespace {

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

}  // namespace

LivePage::LivePage(const Endpoint& endpoint, std::string scene, const DisplayTransform& display, bool repeats)
    : scene_(std::move(scene)),
      repeats_(repeats),
      run_(new_run()),
      denoiser_([this, display](int number, const Image& image) {
        const IntegerEncoding encoding{IntegerFormat::kPng, kPngLevel, 0, {}};
        const std::vector<unsigned char> png =
            encode_image(display.is_identity() ? image : display.apply(image), encoding);
        const std::lock_guard lock(mutex_);
        denoised_ = std::make_shared<const std::string>(png.begin(), png.end());
        denoised_number_ = number;
        image_denoised_ = number == image_number_;
      }),
      server_(endpoint, [this](std::string_view path) { return answer(path); }) {}

void LivePage::begin_scene() {
  const std::lock_guard lock(mutex_);
  run_ = new_run();
  done_ = total_ = 0;
  start_ = end_ = 0;
  state_ = "reading";
  report_ = "null";
  messages_.clear();
}

void LivePage::begin_render() {
  const std::lock_guard lock(mutex_);
  start_ = Progress::steady_seconds();
  state_ = "rendering";
}

void LivePage::update(std::uint64_t done, std::uint64_t total) {
  total_.store(total, std::memory_order_relaxed);
  std::uint64_t seen = done_.load(std::memory_order_relaxed);
  while (seen < done && !done_.compare_exchange_weak(seen, done, std::memory_order_relaxed)) {}
}

void LivePage::set_state(const std::string& state) {
  const std::lock_guard lock(mutex_);
  if (end_ == 0) end_ = Progress::steady_seconds();
  state_ = state;
  state_seen_ = false;
}

void LivePage::set_report(const std::string& json) {
  const std::lock_guard lock(mutex_);
  report_ = json;
}

void LivePage::set_image(std::shared_ptr<const Image> image) {
  const std::lock_guard lock(mutex_);
  image_ = std::move(image);
  encoded_ = nullptr;
  ++image_number_;
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

HttpResponse LivePage::answer(std::string_view path) {
  if (path == "/") return {200, "text/html; charset=utf-8", shared_text(kPreviewPage)};
  if (path == "/status.json") return status();
  if (path == "/image.png") return encoded_image();
  if (path == "/denoised/status.json") {
    denoised_looked_ = Progress::steady_seconds();
    return status();
  }
  if (path == "/denoised/image.png") return denoised_image();
  return {404, HttpResponse().type, nullptr};
}

HttpResponse LivePage::status() {
  using Json = nlohmann::ordered_json;
  const double now = Progress::steady_seconds();
  looked_ = now;
  const std::lock_guard lock(mutex_);
  // Estimate the progress
  const auto done = static_cast<double>(done_.load()), total = static_cast<double>(total_.load());
  const double fraction = state_ == "done" ? 1.0 : total > 0 ? std::min(done / total, 0.9999) : 0.0;
  const double elapsed = start_ > 0 ? (end_ > 0 ? end_ : now) - start_ : 0.0;
  const bool can_tell = state_ == "rendering" && fraction > 0;
  // Build the response
  const Json json{{"run", run_},
                  {"scene", scene_},
                  {"state", state_},
                  {"done", done_.load()},
                  {"total", total_.load()},
                  {"fraction", fraction},
                  {"elapsed_seconds", elapsed},
                  {"left_seconds", can_tell ? Json(elapsed * (1 - fraction) / fraction) : Json()},
                  {"image", image_number_},
                  {"denoised_image", denoised_number_},
                  {"repeats", repeats_},
                  {"messages", messages_},
                  {"report", Json::parse(report_)}};
  state_seen_ = true;
  seen_.notify_all();
  return {200, "application/json", shared_text(json.dump(-1, ' ', false, Json::error_handler_t::replace))};
}

HttpResponse LivePage::denoised_image() {
  const std::lock_guard lock(mutex_);
  if (!denoised_) return {404, HttpResponse().type, nullptr};
  return {200, "image/png", denoised_};
}

HttpResponse LivePage::encoded_image() {
  std::unique_lock lock(mutex_);
  if (!image_) return {404, HttpResponse().type, nullptr};
  const int number = image_number_;
  std::shared_ptr<const std::string> encoded = encoded_;
  if (!encoded) {  // only the server's thread encodes
    const std::shared_ptr<const Image> image = image_;
    lock.unlock();
    const double start = Progress::steady_seconds();
    const std::vector<unsigned char> png = encode_image(*image, {IntegerFormat::kPng, kPngLevel, 0, {}});
    encoded = std::make_shared<const std::string>(png.begin(), png.end());
    encoding_seconds_ = Progress::steady_seconds() - start;
    lock.lock();
    if (number == image_number_) encoded_ = encoded;
  }
  if (number == image_number_) image_seen_ = true;
  // The server releases the body once it is sent.
  const auto sent = [this, encoded, number](const std::string*) {
    const std::lock_guard guard(mutex_);
    sent_number_ = std::max(sent_number_, number);
    seen_.notify_all();
  };
  return {200, "image/png", std::shared_ptr<const std::string>(encoded.get(), sent)};
}

}  // namespace sheaf
