// Client of the image viewer tev (https://github.com/Tom94/tev): sends the image during rendering by its TCP protocol.
#pragma once

#include "core/image/image.h"
#include "tools/preview/sockets.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace sheaf {

/// Packet that opens an empty image with the frame and the channels of `image`, replacing one of the same name. A
/// packet begins with its length in bytes, including these four. Integers are little-endian, and strings end with a
/// zero byte.
std::string tev_create_packet(const std::string& name, const Image& image);

/// Packet with rows [first, last) of `image` at their position in the frame, channels interleaved.
std::string tev_update_packet(const std::string& name, const Image& image, int first, int last);

/// Sends images to a viewer on a thread of its own. If there is no viewer, or it disappears, the thread tries to
/// connect every 2 s.
class TevViewer {
 public:
  /// Receives messages about connection and failure. Called on the thread.
  using LogFunction = std::function<void(const std::string&)>;

  /// `name`: of the image. Throws Error (exit code 1) for an unknown host.
  TevViewer(const Endpoint& endpoint, std::string name, LogFunction log);
  /// Discards images that are not sent yet.
  ~TevViewer();
  TevViewer(const TevViewer&) = delete;
  TevViewer& operator=(const TevViewer&) = delete;

  /// Whether the viewer is connected and has received all images.
  bool is_ready() const { return ready_.load(std::memory_order_relaxed); }
  /// Queues an image; replaces one that is not sent yet. Does not block.
  void show(std::shared_ptr<const Image> image);
  /// Waits until everything is sent, at most `seconds`. Does not wait if the viewer is not connected.
  void finish(double seconds);

 private:
  void run();
  void connect();
  bool send(const Image& image);

  const std::string name_, location_;
  const std::vector<Address> addresses_;
  const LogFunction log_;
  std::atomic<bool> stop_{false}, ready_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const Image> waiting_;  ///< to be sent next; guarded by mutex_
  bool sending_ = false;                  ///< guarded by mutex_
  bool tried_ = false;                    ///< tried to connect at least once; guarded by mutex_
  Socket socket_;                         ///< used by the thread only
  bool created_ = false;                  ///< the viewer has opened the image; used by the thread only
  std::string reported_;                  ///< the last connection error that was reported; used by the thread only
  std::thread thread_;                    ///< last member: it uses the others
};

}  // namespace sheaf
