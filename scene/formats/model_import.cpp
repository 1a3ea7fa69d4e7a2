#include "scene/formats/model_import.h"

#include "core/io/error.h"
#include "core/io/file_cache.h"
#include "core/io/memory.h"
#include "core/io/module.h"
#include "scene/formats/model_formats.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <vector>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// A process whose standard output is read. The destructor ends it.
class Process {
 public:
  Process(const fs::path& program, const std::vector<std::string>& arguments) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw Error(ExitCode::kRuntime, "cannot create a pipe: " + message(errno));
    output_ = ends[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, STDIN_FILENO, STDERR_FILENO);  // so writing to it fails
    std::string name = program.string();
    std::vector<std::string> texts = arguments;
    std::vector<char*> pointers = {name.data()};
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    const int failure = posix_spawn(&id_, name.c_str(), &actions, nullptr, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (failure == 0) return;
    close(output_);
    throw Error(ExitCode::kRuntime, fmt::format("cannot start '{}': {}", name, message(failure)));
  }
  ~Process() {
    close(output_);
    if (id_ <= 0) return;
    kill(id_, SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Reads the whole output. Returns false if it has more than `max` bytes.
  bool read_all(std::string& out, std::size_t max) const {
    std::vector<char> piece(std::size_t{1} << 20);
    for (;;) {
      const ssize_t count = read(output_, piece.data(), piece.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return true;
      if (out.size() + static_cast<std::size_t>(count) > max) return false;
      out.append(piece.data(), static_cast<std::size_t>(count));
    }
  }

  /// Waits for the end and returns the status of waitpid().
  int wait() {
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {}
    id_ = 0;
    return status;
  }

 private:
  static std::string message(int code) { return std::strerror(code); }

  pid_t id_ = 0;
  int output_ = -1;
};

/// Limits of the process, by the size of the file.
struct Limits {
  std::uint64_t memory, seconds;
};

Limits limits_for(std::uintmax_t file_size) {
  constexpr double kMinMemory = double{1 << 30}, kMemoryPerByte = 256;
  constexpr std::uint64_t kMinSeconds = 10, kBytesPerSecond = 20'000;
  const auto size = static_cast<double>(file_size);
  const double memory = std::min(kMinMemory + kMemoryPerByte * size, std::max(available_memory(), kMinMemory));
  return {static_cast<std::uint64_t>(memory), kMinSeconds + file_size / kBytesPerSecond};
}

/// Throws the error of a process that did not succeed.
[[noreturn]] void reject(const fs::path& file, int status, const std::string& output) {
  constexpr int kFailed = 3;
  constexpr std::size_t kLongest = 500;
  const SourceLocation where{file.string(), 0};
  if (WIFEXITED(status) && WEXITSTATUS(status) == kFailed && !output.empty()) {
    std::string message = output.substr(0, std::min(output.find('\n'), kLongest));
    for (char& c : message)
      if (std::iscntrl(static_cast<unsigned char>(c))) c = ' ';
    throw SceneError(where, message);
  }
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL))
    throw SceneError(where, "takes too long to read; convert it to glTF, for example with Blender");
  throw SceneError(where,
                   "Assimp cannot read it: the file is damaged, or it has features that Assimp does not support");
}

std::string run_importer(const fs::path& file) {
  const SourceLocation where{file.string(), 0};
  const fs::path program = shipped_file(kModelImporter);
  if (program.empty())
    throw SceneError(
        where,
        fmt::format("this build of Sheaf cannot read {} files: it was built without Assimp (package libassimp-dev), or "
                    "{} is missing next to the program; convert the file to glTF, for example with Blender",
                    file.extension().string(), kModelImporter));
  std::error_code failure;
  const std::uintmax_t size = fs::file_size(file, failure);
  constexpr std::uintmax_t kMaxSize = std::uintmax_t{1} << 30;
  if (failure) throw SceneError(where, "cannot be read: " + failure.message());
  if (size == 0) throw SceneError(where, "is empty");
  if (size > kMaxSize) throw SceneError(where, "is larger than 1 GiB");
  const Limits limits = limits_for(size);
  Process process(program, {file.string(), std::to_string(limits.memory), std::to_string(limits.seconds)});
  std::string output;
  const auto max = static_cast<std::size_t>(std::min(double{1ull << 32}, available_memory() / 2));
  if (!process.read_all(output, max))
    throw SceneError(where, "is too large: its data take more than " + format_bytes(static_cast<double>(max)));
  const int status = process.wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) reject(file, status, output);
  return output;
}

}  // namespace

bool is_imported_model(const fs::path& file) {
  const ModelFormat* const format = find_model_format(file);
  return format != nullptr && format->is_imported;
}

bool can_import_models() { return !shipped_file(kModelImporter).empty(); }

std::string import_model(const fs::path& file) {
  std::error_code failure;
  const fs::file_status status = fs::status(file, failure);
  if (!fs::exists(status)) throw SceneError(SourceLocation{file.string(), 0}, "model not found");
  if (!fs::is_regular_file(status)) throw SceneError(SourceLocation{file.string(), 0}, "model is not a regular file");
  return cached(file, "import", [&] { return run_importer(file); });
}

fs::path find_model_image(const std::string& name, const fs::path& folder) {
  std::string path = name.starts_with("file://") ? name.substr(7) : name;
  std::replace(path.begin(), path.end(), '\\', '/');
  fs::path whole = path, file = whole.filename();
  const bool has_drive = path.size() > 1 && path[1] == ':';
  std::error_code failure;
  const auto exists = [&](const fs::path& candidate) { return fs::is_regular_file(folder / candidate, failure); };
  if (whole.is_relative() && !has_drive && exists(whole)) return whole;
  for (const char* below : {"", "textures", "Textures", "images", "Images"})
    if (exists(fs::path(below) / file)) return fs::path(below) / file;
  return file;
}

}  // namespace sheaf
