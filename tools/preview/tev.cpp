#include "tools/preview/tev.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdint>

namespace sheaf {

namespace {

/// Packet types of tev's protocol.
enum class PacketType : std::uint8_t { kCreateImage = 4, kUpdateImage = 6 };  // third version of updates

constexpr double kConnectSeconds = 2, kSendSeconds = 10;
constexpr auto kTryEvery = std::chrono::seconds(2);
/// Approximate size of the pieces that images are sent in, so that the viewer shows parts early.
constexpr std::size_t kPieceBytes = std::size_t{4} << 20;

/// Builder for packets.
class Packet {
 public:
  explicit Packet(PacketType type) : bytes_(4, '\0') { put_integer(static_cast<std::uint8_t>(type)); }

  template <class T> void put_integer(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes_ += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff);
  }
  void put_text(const std::string& text) { bytes_.append(text.c_str(), text.size() + 1); }
  void put_floats(const float* values, std::size_t count) {
    bytes_.reserve(bytes_.size() + count * sizeof(float));
    if constexpr (std::endian::native == std::endian::little)
      bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(float));
    else
      for (std::size_t i = 0; i < count; ++i) put_integer(std::bit_cast<std::uint32_t>(values[i]));
  }
  /// Returns the packet, with its length filled in.
  std::string finish() {
    for (std::size_t i = 0; i < 4; ++i) bytes_[i] = static_cast<char>(bytes_.size() >> (8 * i) & 0xff);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

}  // namespace

std::string tev_create_packet(const std::string& name, const Image& image) {
  Packet packet(PacketType::kCreateImage);
  packet.put_integer(std::uint8_t{1});  // bring the image to the front
  packet.put_text(name);
  packet.put_integer(static_cast<std::int32_t>(image.frame_width));
  packet.put_integer(static_cast<std::int32_t>(image.frame_height));
  packet.put_integer(static_cast<std::int32_t>(image.channels.size()));
  for (const std::string& channel : image.channels) packet.put_text(channel);
  return packet.finish();
}

std::string tev_update_packet(const std::string& name, const Image& image, int first, int last) {
  const std::size_t channels = image.channels.size();
  const std::size_t row = static_cast<std::size_t>(image.width) * channels;
  Packet packet(PacketType::kUpdateImage);
  packet.put_integer(std::uint8_t{0});  // do not bring it to the front
  packet.put_text(name);
  packet.put_integer(static_cast<std::int32_t>(channels));
  for (const std::string& channel : image.channels) packet.put_text(channel);
  for (const int number : {image.x0, image.y0 + first, image.width, last - first})
    packet.put_integer(static_cast<std::int32_t>(number));
  // Offsets of the channels, then their strides.
  for (std::size_t c = 0; c < channels; ++c) packet.put_integer(static_cast<std::int64_t>(c));
  for (std::size_t c = 0; c < channels; ++c) packet.put_integer(static_cast<std::int64_t>(channels));
  packet.put_floats(image.data.data() + static_cast<std::size_t>(first) * row,
                    static_cast<std::size_t>(last - first) * row);
  return packet.finish();
}

TevViewer::TevViewer(const Endpoint& endpoint, std::string name, LogFunction log)
    : name_(std::move(name)),
      location_(endpoint.text()),
      addresses_(resolve(endpoint, false)),
      log_(std::move(log)),
      thread_([this] { run(); }) {}

TevViewer::~TevViewer() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void TevViewer::show(std::shared_ptr<const Image> image) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(image);
    ready_ = false;
  }
  changed_.notify_all();
}

void TevViewer::finish(double seconds) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(seconds),
                    [this] { return tried_ && (!waiting_ || !socket_.is_open()) && !sending_; });
}

void TevViewer::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    if (!socket_.is_open()) {
      // Try to connect.
      sending_ = true;
      lock.unlock();
      connect();
      lock.lock();
      sending_ = false;
      tried_ = true;
      ready_ = socket_.is_open() && !waiting_;
      changed_.notify_all();
      if (!socket_.is_open()) changed_.wait_for(lock, kTryEvery, [this] { return stop_.load(); });
    } else if (waiting_) {
      // Send the next image.
      const std::shared_ptr<const Image> image = std::exchange(waiting_, nullptr);
      sending_ = true;
      lock.unlock();
      const bool sent = send(*image);
      if (!sent && !stop_)
        log_(fmt::format("the tev viewer at {} has disconnected or stopped accepting images", location_));
      lock.lock();
      sending_ = false;
      if (!sent) socket_ = Socket();
      tried_ = sent;  // the viewer may have restarted: finish() waits for another attempt
      if (!sent && !waiting_) waiting_ = image;
      ready_ = sent && !waiting_;
      changed_.notify_all();
    } else {
      changed_.wait(lock, [this] { return waiting_ || stop_; });
    }
  }
}

void TevViewer::connect() {
  std::string why;
  Socket socket = connect_to(addresses_, kConnectSeconds, stop_, why);
  if (!socket.is_open() && !stop_ && why != reported_)
    log_(fmt::format("no tev viewer at {} yet: {}; retrying during the render", location_, why));
  reported_ = why;
  created_ = false;
  const std::lock_guard lock(mutex_);
  socket_ = std::move(socket);
}

bool TevViewer::send(const Image& image) {
  if (is_hung_up(socket_)) return false;
  if (!created_ && !send_all(socket_, tev_create_packet(name_, image), kSendSeconds, stop_)) return false;
  created_ = true;
  const std::size_t row = static_cast<std::size_t>(image.width) * image.channels.size() * sizeof(float);
  const int rows = static_cast<int>(std::max(kPieceBytes / row, std::size_t{1}));
  for (int y = 0; y < image.height; y += rows)
    if (!send_all(socket_, tev_update_packet(name_, image, y, std::min(y + rows, image.height)), kSendSeconds, stop_))
      return false;
  return true;
}

}  // namespace sheaf
