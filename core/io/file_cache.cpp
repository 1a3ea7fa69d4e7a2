#include "core/io/file_cache.h"

#include <system_error>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

FileCache* active_cache = nullptr;

}  // namespace

FileCache::FileCache() { active_cache = this; }

FileCache::~FileCache() { active_cache = nullptr; }

FileCache* FileCache::active() { return active_cache; }

bool FileCache::version_of(const fs::path& file, Version& version) {
  std::error_code size_error, time_error;
  version.size = fs::file_size(file, size_error);
  version.time = fs::last_write_time(file, time_error);
  return !size_error && !time_error;
}

std::shared_ptr<const void> FileCache::find(const fs::path& file, const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find({file, key});
  if (found == entries_.end()) return nullptr;
  Version version;
  if (!version_of(file, version) || version != found->second.version) {
    entries_.erase(found);
    return nullptr;
  }
  found->second.used = true;
  return found->second.value;
}

void FileCache::keep(const fs::path& file, const std::string& key, std::shared_ptr<const void> value) {
  Version version;
  if (!version_of(file, version)) return;
  const std::lock_guard lock(mutex_);
  entries_[{file, key}] = {version, std::move(value), true};
}

void FileCache::drop_unused() {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return !entry.second.used; });
  for (auto& [key, entry] : entries_) entry.used = false;
}

}  // namespace sheaf
