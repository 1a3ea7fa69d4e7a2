// Atomic output files, on full disks and with unusual names.
#include "core/io/output_file.h"

#include "core/image/exr.h"
#include "core/image/image.h"
#include "core/io/error.h"
#include "core/sampling/rng.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>

namespace sheaf::test_output_file {

namespace {

/// Limits the size of files of this process during its lifetime, to simulate a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit limited{bytes, old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limited);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

Image noise_image(int side) {
  Image image(side, side, {"R", "G", "B"});
  for (std::size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = random4<Scalar>(7, static_cast<std::uint32_t>(i), 0, 0).x;
  return image;
}

/// The message of the error with exit code 4 when writing under a file size limit; empty if writing succeeds.
std::string error_when_full(rlim_t bytes, const std::function<void()>& write) {
  const FileSizeLimit limit(bytes);
  try {
    write();
  } catch (const Error& error) { return error.exit_code() == ExitCode::kOutput ? error.what() : "another exit code"; }
  return {};
}

}  // namespace

TEST_CASE("output file: a full disk is an error and the previous file is kept") {
  const TemporaryFolder folder;
  // Files that fit into the library's buffers, and files that overflow them.
  for (const int side : {16, 24, 100}) {
    CAPTURE(side);
    const Image image = noise_image(side);
    const std::pair<const char*, std::function<void(const std::filesystem::path&)>> kinds[] = {
        {"a.exr", [&](const auto& path) { write_exr(path, image); }},
        {"a.png", [&](const auto& path) { write_png(path, image); }},
        {"a.txt", [&](const auto& path) { write_text_file(path, std::string(10000, 'x')); }}};
    for (const auto& kind : kinds) {
      const std::string name = kind.first;
      const auto& write = kind.second;
      CAPTURE(name);
      write(folder / name);
      const std::size_t whole = read_bytes(folder / name).size();
      REQUIRE(whole > 700);
      for (const rlim_t room : {rlim_t{0}, rlim_t{512}, static_cast<rlim_t>(whole - 1)}) {
        write_bytes(folder / name, "old");
        const std::string error = error_when_full(room, [&] { write(folder / name); });
        CHECK(error.find("cannot write '" + (folder / name).string()) != error.npos);
        CHECK(read_bytes(folder / name) == "old");
      }
      CHECK(error_when_full(whole, [&] { write(folder / name); }).empty());
      CHECK(read_bytes(folder / name).size() == whole);
    }
  }
  CHECK(folder.entry_count() == 3);
}

TEST_CASE("output file: different names of the same file are recognized") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "real");
  std::filesystem::create_directory_symlink(folder / "real", folder / "alias");
  write_bytes(folder / "real/there", "x");
  std::filesystem::create_symlink(folder / "real/there", folder / "link");
  std::filesystem::create_hard_link(folder / "real/there", folder / "hard");
  for (const char* other : {"real/there", "real/../real/./there", "alias/there", "link", "hard", "alias/../link"}) {
    CAPTURE(std::string(other));
    CHECK(is_same_file(folder / "real/there", folder / other));
    CHECK(is_same_file(folder / other, folder / "real/there"));
    CHECK_FALSE(is_same_file(folder / other, folder / "real/not_there"));
  }
  CHECK(is_same_file(folder / "real/not_there", folder / "alias/./not_there"));
  CHECK(is_same_file("not_there_at_all", "./not_there_at_all"));
  CHECK(is_same_file("not_there_at_all", std::filesystem::current_path() / "not_there_at_all"));
  CHECK_FALSE(is_same_file(folder / "real/not_there", folder / "not_there"));
  CHECK_FALSE(is_same_file(folder / "real", folder / "real/there"));
}

TEST_CASE("output file: leftovers of killed writers are removed and other files are not") {
  const TemporaryFolder folder;
  const std::filesystem::path target = folder / "out.exr";
  const auto aged = [&](const std::string& name, int seconds) {
    write_bytes(folder / name, "half");
    std::filesystem::last_write_time(folder / name,
                                     std::filesystem::file_time_type::clock::now() - std::chrono::seconds(seconds));
  };
  // The id of a terminated process: this one's child.
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  const std::string gone = std::to_string(child), own = std::to_string(getpid());
  const std::string left = ".out.exr." + gone + ".0.tmp";
  const std::vector<std::string> kept = {".out.exr." + gone + ".1.tmp",  // locked, see below
                                         ".out.exr." + gone + ".2.tmp",  // recent
                                         ".out.exr." + own + ".77.tmp",  // its process is running
                                         ".out.png." + gone + ".0.tmp",  // of another output file
                                         ".out.exr." + gone + ".tmp",   ".out.exr." + gone + ".x.tmp",
                                         ".out.exr.-1.0.tmp",           ".out.exr.0.0.tmp",
                                         "out.exr." + gone + ".0.tmp",  ".out.exr." + gone + ".0.tmp.bak"};
  aged(left, 60);
  for (const std::string& name : kept) aged(name, name == kept[1] ? 0 : 60);
  std::filesystem::create_directory(folder / (".out.exr." + gone + ".3.tmp"));
  std::filesystem::create_symlink("no", folder / (".out.exr." + gone + ".4.tmp"));
  const int lock = open((folder / kept[0]).c_str(), O_RDONLY | O_CLOEXEC);
  REQUIRE(flock(lock, LOCK_EX | LOCK_NB) == 0);
  check_writable(target);
  CHECK_FALSE(std::filesystem::exists(folder / left));
  for (const std::string& name : kept) {
    CAPTURE(name);
    CHECK(std::filesystem::exists(folder / name));
  }
  CHECK(folder.entry_count() == kept.size() + 2);
  close(lock);
  check_writable(target);
  CHECK_FALSE(std::filesystem::exists(folder / kept[0]));
}

TEST_CASE("output file: a file is locked while it is written") {
  const TemporaryFolder folder;
  const auto is_locked = [](const std::filesystem::path& path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const bool locked = flock(file, LOCK_EX | LOCK_NB) != 0;
    close(file);
    return locked;
  };
  {
    OutputFile file(folder / "out.txt");
    CHECK(is_locked(std::filesystem::directory_iterator(folder.path())->path()));
    file.commit();
  }
  CHECK_FALSE(is_locked(folder / "out.txt"));
}

}  // namespace sheaf::test_output_file
