// Contents of files kept in memory, for programs that read the same files repeatedly.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace sheaf {

/// While a FileCache exists, cached() keeps what it reads, until the file changes or is no longer used. At most one may
/// exist at a time. find() and keep() may be called from any thread.
class FileCache {
 public:
  FileCache();
  ~FileCache();
  FileCache(const FileCache&) = delete;
  FileCache& operator=(const FileCache&) = delete;

  /// The existing cache, or null.
  static FileCache* active();

  /// Returns what is kept under `key` for this file; null if there is nothing, or if the file's size or modification
  /// time has changed since.
  std::shared_ptr<const void> find(const std::filesystem::path& file, const std::string& key);
  /// Keeps a value, unless the file does not exist.
  void keep(const std::filesystem::path& file, const std::string& key, std::shared_ptr<const void> value);
  /// Drops everything that was neither kept nor found since the last call.
  void drop_unused();

 private:
  struct Version {
    std::uintmax_t size = 0;
    std::filesystem::file_time_type time{};
    bool operator==(const Version&) const = default;
  };
  struct Entry {
    Version version;
    std::shared_ptr<const void> value;
    bool used = true;
  };
  /// The current version of a file. Returns false if it cannot be determined.
  static bool version_of(const std::filesystem::path& file, Version& version);

  std::mutex mutex_;  ///< of the entries
  std::map<std::pair<std::filesystem::path, std::string>, Entry> entries_;
};

/// Returns read(), or a copy of its earlier result for the same file and `key` if a FileCache kept it. `key` names the
/// type of the result and all options of reading.
template <class Read> auto cached(const std::filesystem::path& file, const std::string& key, Read&& read) {
  using Value = decltype(read());
  FileCache* const cache = FileCache::active();
  if (cache == nullptr) return read();
  if (const std::shared_ptr<const void> kept = cache->find(file, key))
    return Value(*static_cast<const Value*>(kept.get()));
  auto value = std::make_shared<const Value>(read());
  cache->keep(file, key, value);
  return Value(*value);
}

}  // namespace sheaf
