// The picture in the viewer tev (https://github.com/Tom94/tev), sent by its TCP protocol while it is being rendered.
#pragma once

#include "core/image.h"
#include "tools/sockets.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace sheaf {

/// A packet that opens an empty picture of `image`'s frame with its channels, in place of one of the same name.
/// Packets begin with their length in bytes, these four included; integers are little-endian, texts end with a zero.
std::string tev_create_packet(const std::string& name, const Image& image);

/// A packet with the rows from `first` up to `last` of `image`, at its place in the frame, channels interleaved.
std::string tev_update_packet(const std::string& name, const Image& image, int first, int last);

/// Sends pictures to a viewer, on a thread of its own. A viewer that is not there is looked for every two seconds, also
/// when it was there and is gone.
class TevViewer {
 public:
  /// Told of what goes wrong, and when the viewer is found; by the thread.
  using Say = std::function<void(const std::string&)>;

  /// `name`: of the picture. Throws Error (exit code 1) for a host that is not known.
  TevViewer(const Endpoint& endpoint, std::string name, Say say);
  /// What is not sent yet, is not sent.
  ~TevViewer();
  TevViewer(const TevViewer&) = delete;
  TevViewer& operator=(const TevViewer&) = delete;

  /// Whether the viewer is there, and has taken what it was to show.
  bool is_ready() const { return ready_.load(std::memory_order_relaxed); }
  /// Shows a picture, the newest if there are several yet to be sent. Does not wait.
  void show(std::shared_ptr<const Image> picture);
  /// Waits until everything is sent, at most this long; not for a viewer that is not there.
  void finish(double seconds);

 private:
  void run();
  void connect();
  bool send(const Image& picture);

  const std::string name_, place_;
  const std::vector<Address> addresses_;
  const Say say_;
  std::atomic<bool> stop_{false}, ready_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const Image> waiting_;  ///< to be sent; guarded by mutex_
  bool sending_ = false;                  ///< guarded by mutex_
  bool tried_ = false;                    ///< it was looked for at least once; guarded by mutex_
  Socket socket_;                         ///< the thread's
  bool created_ = false;                  ///< the viewer knows of the picture; the thread's
  std::string told_;                      ///< the last that was said of a viewer that is not there; the thread's
  std::thread thread_;                    ///< the last member: what it uses is there
};

}  // namespace sheaf
