#include "tools/preview/file_watcher.h"

#include <algorithm>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::milliseconds kInterval{200}, kStable{300};

}  // namespace

FileWatcher::FileWatcher(std::function<void()> on_change)
    : on_change_(std::move(on_change)), begin_(fs::file_time_type::clock::now()), thread_([this] { run(); }) {}

FileWatcher::~FileWatcher() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

FileWatcher::Stamp FileWatcher::stamp_of(const fs::path& file) {
  std::error_code error;
  Stamp stamp;
  stamp.time = fs::last_write_time(file, error);
  if (error) return {};
  stamp.size = fs::file_size(file, error);
  stamp.exists = !error;
  return stamp;
}

void FileWatcher::begin() {
  const std::lock_guard lock(mutex_);
  update();
  begin_ = fs::file_time_type::clock::now();
  has_changed_ = false;
}

void FileWatcher::watch(const std::vector<fs::path>& files) {
  const std::lock_guard lock(mutex_);
  const fs::file_time_type now = fs::file_time_type::clock::now();
  std::vector<File> watched;
  for (const fs::path& file : files) {
    const auto known = std::find_if(files_.begin(), files_.end(), [&](const File& each) { return each.path == file; });
    const Stamp stamp = stamp_of(file);
    // Times in the future come from other clocks
    if (known == files_.end() && stamp.time > begin_ && stamp.time <= now) has_changed_ = true;
    watched.push_back(known != files_.end() ? *known : File{file, stamp});
  }
  files_ = std::move(watched);
}

bool FileWatcher::update() {
  bool differs = false;
  for (File& file : files_) {
    const Stamp stamp = stamp_of(file.path);
    differs = differs || stamp != file.stamp;
    file.stamp = stamp;
  }
  return differs;
}

void FileWatcher::wait() {
  std::unique_lock lock(mutex_);
  while (!has_changed_ || std::chrono::steady_clock::now() - last_change_ < kStable) changed_.wait_for(lock, kInterval);
}

void FileWatcher::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    if (update()) {
      last_change_ = std::chrono::steady_clock::now();
      has_changed_ = true;
      changed_.notify_all();
    }
    if (has_changed_) on_change_();
    changed_.wait_for(lock, kInterval);
  }
}

}  // namespace sheaf
