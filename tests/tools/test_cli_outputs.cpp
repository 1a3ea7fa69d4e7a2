// All files that the program writes, to invalid destinations of every kind: no data are lost, and messages give the
// reason.
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <regex>
#include <vector>

namespace sheaf::test_cli_outputs {

namespace fs = std::filesystem;

namespace {

constexpr const char* kScene = R"(<scene version="3.0.0">
  <integrator type="path"/>
  <sensor type="perspective">
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
  </sensor>
  <shape type="sphere"/>
  <emitter type="constant"/>
</scene>)";

/// A kind of file that the program writes: its name, and the arguments that write it, with TO as placeholder.
struct Written {
  const char* what;
  const char* name;
  const char* arguments;
  bool is_whole_folder = false;  ///< TO stands for the folder of the file, which is created
};

/// All kinds of files.
const std::vector<Written> kWritten = {
    {"image.exr", "x.exr", "render scene.xml --quiet --spp 2 -o TO"},
    {"image.png", "x.png", "render scene.xml --quiet --spp 2 -o TO"},
    {"statistics", "x.json", "render scene.xml --quiet --spp 2 -o /tmp/sheaf_test_none.exr --stats TO"},
    {"checkpoint", "x.state", "render scene.xml --quiet --spp 2 -o /tmp/sheaf_test_none.exr --checkpoint TO --resume"},
    {"denoised.exr", "x.exr", "denoise noisy.exr --quiet -o TO"},
    {"denoised.png", "x.png", "denoise noisy.exr --quiet -o TO"},
    {"merged.exr", "x.exr", "merge left.exr right.exr --quiet -o TO"},
    {"image.jpg", "x.jpg", "render scene.xml --quiet --spp 2 -o TO"},
    {"image.tif", "x.tif", "render scene.xml --quiet --spp 2 -o TO"},
    {"converted.exr", "x.exr", "convert noisy.exr --quiet -o TO"},
    {"converted.jpg", "x.jpg", "convert noisy.exr --quiet -o TO"},
    {"merged.png", "x.png", "merge left.exr right.exr --quiet -o TO"},
    {"farm", "render.sh", "farm scene.xml --parts 2 --quiet --folder TO", true},
    {"farm", "merge.sh", "farm scene.xml --parts 2 --quiet --folder TO", true},
    {"farm", "submit.sh", "farm scene.xml --parts 2 --quiet --folder TO", true}};

/// A folder with the inputs of the commands, and "place", where they write.
class Workplace {
 public:
  Workplace() {
    write_bytes(folder / "scene.xml", kScene);
    const std::string render = "render scene.xml --quiet --spp 4 --no-timestamps ";
    REQUIRE(run(folder, render + "-o noisy.exr --aov albedo,normal,depth,variance,half").code == 0);
    REQUIRE(run(folder, render + "--crop 0,0,12,16 -o left.exr").code == 0);
    REQUIRE(run(folder, render + "--crop 12,0,24,16 -o right.exr").code == 0);
    REQUIRE(run(folder, "render scene.xml --quiet --spp 2 -o noisy2.exr --checkpoint saved.state").code == 0);
    fs::permissions(folder.path(), fs::perms::all);
    for (const auto& entry : fs::directory_iterator(folder.path())) inputs.push_back(entry.path().filename());
  }

  /// Empties "place" and, with `with_old`, puts the previous file there.
  fs::path prepare(const Written& written, bool with_old) {
    for (const char* name : {"place", "other"}) {
      std::error_code error;
      if (fs::exists(folder / name)) fs::permissions(folder / name, fs::perms::all);
      fs::remove_all(folder / name, error);
      fs::create_directory(folder / name);
      fs::permissions(folder / name, fs::perms::all);
    }
    fs::path file = folder / ("place/" + std::string(written.name));
    if (with_old) write_bytes(file, old_of(written));
    return file;
  }
  /// A previous checkpoint must be valid, because the render resumes from it.
  std::string old_of(const Written& written) const {
    return written.what == std::string("checkpoint") ? read_bytes(folder / "saved.state") : "old";
  }

  /// Runs the command with `to` as its destination. `before` may drop privileges.
  Outcome write(const Written& written, const std::string& to = "place", const std::string& before = "") const {
    std::string arguments = written.arguments;
    const std::string file = written.is_whole_folder ? to : to + "/" + written.name;
    arguments.replace(arguments.find("TO"), 2, file);
    const std::size_t other = arguments.find("/tmp/sheaf_test_none.exr");
    if (other != std::string::npos) arguments.replace(other, 24, "other/other.exr");
    return run(folder, arguments, before);
  }

  /// Names of temporary files anywhere.
  std::string left_over() const {
    std::string names;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
      if (entry.path().extension() == ".tmp") names += entry.path().string() + " ";
    return names;
  }

  TemporaryFolder folder;
  std::vector<fs::path> inputs;
};

/// Command prefix that drops privileges; none where that is impossible.
std::optional<std::string> as_nobody() {
  if (geteuid() != 0) return "";
  const std::string nobody = "setpriv --reuid=65534 --regid=65534 --clear-groups ";
  if (std::system((nobody + "true >/dev/null 2>&1").c_str()) == 0) return nobody;
  MESSAGE("skipped: setpriv is missing");
  return std::nullopt;
}

void check_refused(const Workplace& workplace, const Written& written, const Outcome& outcome,
                   const std::string& reason) {
  CAPTURE(outcome.err);
  CHECK(outcome.code == 4);
  CHECK(contains(outcome.err, reason));
  CHECK(contains(outcome.err, written.is_whole_folder ? "place" : written.name));
  CHECK(workplace.left_over().empty());
}

}  // namespace

TEST_CASE("outputs: only core/io/output_file opens files for writing") {
  const std::regex opens("std::ofstream|\\bfopen\\(|O_WRONLY|O_RDWR|O_CREAT|\\bcreat\\(");
  int files = 0;
  for (const char* layer : {"core", "scene", "kernels", "tools"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SHEAF_SOURCE_DIR) / layer)) {
      const std::string extension = entry.path().extension().string();
      if ((extension != ".cpp" && extension != ".h") || entry.path().stem() == "output_file") continue;
      ++files;
      CAPTURE(entry.path().string());
      CHECK_FALSE(std::regex_search(read_bytes(entry.path()), opens));
    }
  CHECK(files > 300);
}

TEST_CASE("outputs: a missing folder is an error") {
  Workplace workplace;
  for (const Written& written : kWritten) {
    CAPTURE(std::string(written.what));
    workplace.prepare(written, false);
    // The farm creates its folder unless a file is in the way.
    write_bytes(workplace.folder / "place/file", "");
    if (written.is_whole_folder)
      check_refused(workplace, written, workplace.write(written, "place/file/farm"), "Not a directory");
    else
      check_refused(workplace, written, workplace.write(written, "place/gone"), "there is no folder 'place/gone'");
  }
}

TEST_CASE("outputs: a read-only folder is an error") {
  const auto nobody = as_nobody();
  if (!nobody) return;
  Workplace workplace;
  for (const Written& written : kWritten) {
    CAPTURE(std::string(written.what));
    for (const bool with_old : {false, true}) {
      const fs::path file = workplace.prepare(written, with_old);
      if (with_old) fs::permissions(file, fs::perms(0666));
      fs::permissions(workplace.folder / "place", fs::perms(0555));
      check_refused(workplace, written, workplace.write(written, "place", *nobody), "Permission denied");
      CHECK(read_bytes(file) == (with_old ? workplace.old_of(written) : ""));
    }
  }
  workplace.prepare(kWritten[0], false);
}

TEST_CASE("outputs: a read-only file is an error even through a link") {
  const auto nobody = as_nobody();
  if (!nobody) return;
  Workplace workplace;
  for (const Written& written : kWritten) {
    CAPTURE(std::string(written.what));
    const fs::path file = workplace.prepare(written, true), real = workplace.folder / "place/real";
    fs::permissions(file, fs::perms(0444));
    check_refused(workplace, written, workplace.write(written, "place", *nobody), "Permission denied");
    CHECK(read_bytes(file) == workplace.old_of(written));
    fs::rename(file, real);
    fs::create_symlink("real", file);
    check_refused(workplace, written, workplace.write(written, "place", *nobody), "Permission denied");
    CHECK(read_bytes(real) == workplace.old_of(written));
    CHECK(fs::is_symlink(file));
    CHECK((fs::status(real).permissions() & fs::perms::all) == fs::perms(0444));
  }
}

TEST_CASE("outputs: links are followed") {
  Workplace workplace;
  const fs::path far = fs::path("/dev/shm") / ("sheaf_test_" + std::to_string(getpid()));
  const bool has_far = fs::is_directory("/dev/shm") && access("/dev/shm", W_OK) == 0;
  if (!has_far) MESSAGE("skipped: no second file system is writable");
  for (const Written& written : kWritten) {
    CAPTURE(std::string(written.what));
    for (const bool is_there : {true, false})
      for (const fs::path& target : {fs::path("real"), workplace.folder / "place/real", far}) {
        CAPTURE(target.string());
        if (target == far && !has_far) continue;
        const fs::path file = workplace.prepare(written, false);
        const fs::path real = target.is_absolute() ? target : workplace.folder / "place/real";
        fs::remove(real);
        if (is_there) write_bytes(real, workplace.old_of(written)), fs::permissions(real, fs::perms(0640));
        // A link to a link.
        fs::create_symlink(target, workplace.folder / "place/between");
        fs::create_symlink("between", file);
        const Outcome outcome = workplace.write(written);
        CAPTURE(outcome.err);
        CHECK(outcome.code == 0);
        CHECK(fs::is_symlink(file));
        CHECK(fs::is_regular_file(fs::symlink_status(real)));
        CHECK(read_bytes(real).size() > 10);
        CHECK(read_bytes(real) != "old");
        if (is_there) CHECK((fs::status(real).permissions() & fs::perms::all) == fs::perms(0640));
        CHECK(workplace.left_over().empty());
      }
    fs::remove(far);
    // Dangling links.
    const fs::path file = workplace.prepare(written, false);
    fs::create_symlink("gone/real", file);
    check_refused(workplace, written, workplace.write(written), "place/gone'");
    CHECK(fs::is_symlink(file));
    fs::remove(file);
    fs::create_symlink(written.name, file);
    check_refused(workplace, written, workplace.write(written), "Too many levels of symbolic links");
    CHECK(fs::is_symlink(file));
    // Devices are not replaced.
    fs::remove(file);
    fs::create_symlink("/dev/full", file);
    check_refused(workplace, written, workplace.write(written), "it is not a regular file");
    CHECK(fs::is_symlink(file));
    fs::remove(file);
    fs::create_directory(file);
    check_refused(workplace, written, workplace.write(written), "it is a folder");
  }
}

TEST_CASE("outputs: a full disk is an error") {
  Workplace workplace;
  // One page, which the old file occupies.
  write_bytes(workplace.folder / "full.sh", R"sh(set -e
mount -t tmpfs -o size=4k none place
cp old "place/$1" && shift
rc=0; "$@" || rc=$?
ls -A place >place.txt
cp place/* kept
exit $rc
)sh");
  const std::string tried =
      "cd '" + workplace.folder.path().string() + "' && mkdir -p place && unshare -m mount -t tmpfs none place";
  if (std::system((tried + " >/dev/null 2>&1").c_str()) != 0) {
    MESSAGE("skipped: file systems cannot be mounted");
    return;
  }
  for (const Written& written : kWritten) {
    CAPTURE(std::string(written.what));
    workplace.prepare(written, false);
    const std::string old = workplace.old_of(written).substr(0, 4096);
    if (written.what == std::string("checkpoint")) continue;  // takes more than a page, see below
    write_bytes(workplace.folder / "old", old);
    const Outcome outcome =
        workplace.write(written, "place", "unshare -m sh ./full.sh " + std::string(written.name) + " ");
    check_refused(workplace, written, outcome, "No space left on device");
    CHECK(read_bytes(workplace.folder / "kept") == old);
    CHECK(read_bytes(workplace.folder / "place.txt") == std::string(written.name) + "\n");
  }
  // Files are limited to 1 kB.
  for (const Written& written : kWritten) {
    CAPTURE(std::string(written.what));
    const std::string extension = fs::path(written.name).extension();
    const bool is_exr_or_text = extension == ".exr" || extension == ".json" || extension == ".state";
    if (written.is_whole_folder || !is_exr_or_text) continue;  // shorter
    const fs::path file = workplace.prepare(written, true);
    const Outcome outcome = workplace.write(written, "place", "ulimit -f 2 && ");
    check_refused(workplace, written, outcome, "cannot write 'place/" + std::string(written.name) + "'");
    CHECK(read_bytes(file) == workplace.old_of(written));
  }
}

TEST_CASE("outputs: other outputs are written after a failure and previews report it") {
  Workplace workplace;
  workplace.prepare(kWritten[0], false);
  const std::string small = "ulimit -f 2 && ";
  for (const char* command : {"denoise noisy.exr", "merge left.exr right.exr"}) {
    const Outcome outcome = run(workplace.folder, std::string(command) + " -o place/a.exr -o place/b.png", small);
    CAPTURE(outcome.err);
    CHECK(outcome.code == 4);
    CHECK(contains(outcome.err, "cannot write 'place/a.exr'"));
    CHECK(contains(outcome.err, "wrote place/b.png"));
    CHECK(fs::exists(workplace.folder / "place/b.png"));
    CHECK(workplace.left_over().empty());
    workplace.prepare(kWritten[0], false);
  }
  // The folder disappears during the render: the preview reports it, and the render continues.
  write_bytes(workplace.folder / "go.sh", R"sh("$@" 2>log.txt & pid=$!
sleep 1; rm -rf place; kill -USR1 $pid
for i in $(seq 100); do grep -q 'cannot write' log.txt && break; sleep 0.1; done
mkdir place; kill -TERM $pid; wait $pid
)sh");
  const Outcome outcome =
      run(workplace.folder, "render scene.xml --spp 16000000 --size 96x64 -o place/a.exr", "sh ./go.sh ");
  const std::string log = read_bytes(workplace.folder / "log.txt");
  CAPTURE(log);
  CHECK(contains(log, "cannot write 'place/a.exr': there is no folder 'place'"));
  CHECK(outcome.code == 143);
  CHECK(fs::exists(workplace.folder / "place/a.exr"));
}

}  // namespace sheaf::test_cli_outputs
