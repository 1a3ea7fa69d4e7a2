// Detects changes of files by polling their modification times, which also works on network file systems.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sheaf {

/// Watches files on a thread of its own. All functions are thread-safe.
class FileWatcher {
 public:
  /// `on_change` is called on the watcher's thread, again and again while has_changed().
  explicit FileWatcher(std::function<void()> on_change);
  ~FileWatcher();
  FileWatcher(const FileWatcher&) = delete;
  FileWatcher& operator=(const FileWatcher&) = delete;

  /// Forgets all changes so far, and watches the same files.
  void begin();
  /// Watches these files instead. Those that were written after the last begin() have changed.
  void watch(const std::vector<std::filesystem::path>& files);
  /// Whether a file was written, replaced, removed or created since begin().
  bool has_changed() const { return has_changed_; }
  /// Waits until a file has changed, and then until the files remain the same for 0.3 s.
  void wait();

 private:
  /// The state of a file that every change alters.
  struct Stamp {
    std::filesystem::file_time_type time{};
    std::uintmax_t size = 0;
    bool exists = false;

    bool operator==(const Stamp&) const = default;
  };
  struct File {
    std::filesystem::path path;
    Stamp stamp;
  };

  static Stamp stamp_of(const std::filesystem::path& file);
  /// Takes the stamps of all files. Returns whether any differs.
  bool update();
  void run();

  const std::function<void()> on_change_;
  std::atomic<bool> has_changed_{false};
  std::mutex mutex_;  ///< guards the members below
  std::condition_variable changed_;
  std::vector<File> files_;
  std::filesystem::file_time_type begin_{};
  std::chrono::steady_clock::time_point last_change_{};
  bool stop_ = false;
  std::thread thread_;  ///< last member: it uses the others
};

}  // namespace sheaf
