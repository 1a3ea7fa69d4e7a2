#include "kernels/denoise/find_oidn.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kLibrary = "libOpenImageDenoise.so";

/// Library folders inside Python's package folders.
constexpr const char* kPackages[] = {"pyoidn/oidn/lib", "oidn/lib.linux.x64", "oidn/lib", "oidn", "bpy/lib"};

/// Version numbers after the library's name; empty for names without a version.
std::vector<int> version_of(std::string_view name) {
  name.remove_prefix(kLibrary.size());
  std::vector<int> version;
  while (name.starts_with('.')) {
    int number = 0;
    const auto end = std::from_chars(name.data() + 1, name.data() + name.size(), number);
    if (end.ec != std::errc()) break;
    version.push_back(number);
    name.remove_prefix(static_cast<std::size_t>(end.ptr - name.data()));
  }
  return version;
}

class Folders {
 public:
  void add(const fs::path& folder) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) return;
    const fs::path real = fs::canonical(folder, error);
    if (!error && std::find(found_.begin(), found_.end(), real) == found_.end()) found_.push_back(real);
  }
  /// Adds the package folders of a Python installation, e.g. `prefix`/lib/python3.11/site-packages.
  void add_python(const fs::path& prefix) {
    std::error_code error;
    std::vector<fs::path> versions;
    for (const auto& entry : fs::directory_iterator(prefix / "lib", error))
      if (entry.path().filename().string().starts_with("python")) versions.push_back(entry.path());
    std::sort(versions.rbegin(), versions.rend());
    for (const fs::path& version : versions)
      for (const char* const packages : {"site-packages", "dist-packages"})
        for (const char* const package : kPackages) add(version / packages / package);
  }
  std::vector<fs::path> take() { return std::move(found_); }

 private:
  std::vector<fs::path> found_;
};

/// Folder of a program found through PATH, with symbolic links resolved; empty if not found.
fs::path program_folder(std::string_view path, const char* program) {
  while (!path.empty()) {
    const std::size_t end = std::min(path.find(':'), path.size());
    std::error_code error;
    const fs::path file = fs::path(path.substr(0, end)) / program;
    if (end > 0 && fs::is_regular_file(file, error)) return fs::canonical(file, error).parent_path();
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return {};
}

}  // namespace

OidnFolders oidn_folders(const fs::path& program, const Environment& environment) {
  Folders before, folders;
  const fs::path beside = program.parent_path();
  if (!beside.empty())
    for (const char* const folder : {".", "lib", "..", "../lib", "../lib/sheaf"}) before.add(beside / folder);
  for (const char* const variable : {"VIRTUAL_ENV", "CONDA_PREFIX"})
    if (const fs::path prefix = environment(variable); !prefix.empty()) {
      folders.add_python(prefix);
      folders.add(prefix / "lib");
    }
  if (const fs::path home = environment("HOME"); !home.empty()) folders.add_python(home / ".local");
  for (const char* const prefix : {"/usr/local", "/usr"}) folders.add_python(prefix);
  if (const fs::path blender = program_folder(environment("PATH"), "blender"); !blender.empty())
    folders.add(blender / "lib");
  return {before.take(), folders.take()};
}

std::vector<fs::path> oidn_files(const fs::path& folder) {
  std::error_code error;
  std::vector<std::pair<std::vector<int>, fs::path>> found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name == kLibrary || name.starts_with(std::string(kLibrary) + "."))
      found.emplace_back(version_of(name), entry.path());
  }
  std::sort(found.rbegin(), found.rend());
  std::vector<fs::path> files;
  for (auto& [version, file] : found) files.push_back(std::move(file));
  return files;
}

std::vector<std::string> oidn_names() {
  std::vector<std::string> names;
  for (const char* const version : {".2", ".1", ".0", ""}) names.push_back(std::string(kLibrary) + version);
  return names;
}

}  // namespace sheaf
