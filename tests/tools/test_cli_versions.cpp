// Files that another version of Sheaf wrote: checkpoints and parts of images.
#include "core/image/exr.h"
#include "core/io/inflate.h"
#include "core/io/version.h"
#include "tests/support/capture.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

namespace sheaf::test_cli_versions {

namespace {

using namespace std::string_literals;

struct Workplace {
  Workplace() { write_bytes(folder / "scene.xml", test::kScene); }
  Outcome render(const std::string& options) const { return run(folder, "render scene.xml --quiet " + options); }
  /// Checks for an exit code and a message in one line.
  static void check_refused(const Outcome& outcome, int code, const std::string& message) {
    CHECK(outcome.code == code);
    CHECK(outcome.err == "sheaf: " + message + "\n");
  }
  TemporaryFolder folder;
};

/// Replaces the first line and the version of a checkpoint, whose checksum becomes valid.
std::string changed_checkpoint(std::string bytes, const std::string& line, const std::string& version) {
  bytes.resize(bytes.size() - 4);
  bytes.replace(0, bytes.find('\n') + 1, line + "\n");
  const std::size_t at = bytes.find("Sheaf's version") + 15;
  std::uint32_t length = 0;
  std::memcpy(&length, &bytes[at], sizeof length);
  bytes.replace(at + 4, length, version);
  length = static_cast<std::uint32_t>(version.size());
  std::memcpy(&bytes[at], &length, sizeof length);
  const std::uint32_t sum = check_sum({bytes.data(), bytes.size()}, 0);
  return bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
}

}  // namespace

TEST_CASE("versions: a checkpoint of another version is refused in one line") {
  const Workplace workplace;
  const std::string options = "--checkpoint a.state -o a.exr";
  REQUIRE(workplace.render(options).code == 0);
  const std::string saved = read_bytes(workplace.folder / "a.state"), line = saved.substr(0, saved.find('\n'));
  const auto resume = [&](const std::string& bytes) {
    write_bytes(workplace.folder / "a.state", bytes);
    const Outcome outcome = workplace.render(options + " --resume --spp 32 --max-depth 3");
    CHECK(read_bytes(workplace.folder / "a.state") == bytes);
    return outcome;
  };
  const auto expected = [](const std::string& version) {
    return "a.state: was written by Sheaf " + version + ", but this is Sheaf " + kSheafVersion +
           ": finish the render with Sheaf " + version + ", or delete the file to begin again";
  };
  // Only the version is reported, though the options differ as well
  const std::string old = changed_checkpoint(saved, line, "0.2.0");
  workplace.check_refused(resume(old), 5, expected("0.2.0"));
  workplace.check_refused(resume(changed_checkpoint(saved, line, "0.10.3")), 5, expected("0.10.3"));
  // Other layouts: version 0.1.0 wrote layout 2
  workplace.check_refused(resume(changed_checkpoint(saved, "sheaf checkpoint 2", "0.1.0")), 5, expected("0.1.0"));
  workplace.check_refused(resume(changed_checkpoint(saved, "sheaf checkpoint 12", "1.0")), 5, expected("1.0"));
  workplace.check_refused(resume(old.substr(0, 100)), 5, expected("0.2.0"));
  // Another layout of the same version, as between releases
  workplace.check_refused(resume(changed_checkpoint(saved, "sheaf checkpoint 2", kSheafVersion)), 5,
                          "a.state: was written by another version of Sheaf");
  CHECK(contains(resume(changed_checkpoint(saved, line, kSheafVersion)).err, "--max-depth"));
}

TEST_CASE("versions: files that are no checkpoints are reported as such") {
  const Workplace workplace;
  for (const std::string& bytes : {""s, "sheaf"s, "v/1\x01 Sheaf's version"s, std::string(1000, 'x')}) {
    CAPTURE(bytes);
    write_bytes(workplace.folder / "a.state", bytes);
    workplace.check_refused(workplace.render("--checkpoint a.state -o a.exr --resume"), 5,
                            "a.state: is not a sheaf checkpoint");
  }
  write_bytes(workplace.folder / "a.state", "sheaf checkpoint 3\n");
  workplace.check_refused(workplace.render("--checkpoint a.state -o a.exr --resume"), 5, "a.state: is truncated");
}

TEST_CASE("versions: parts of another version are refused in one line, alone and among others") {
  const Workplace workplace;
  REQUIRE(workplace.render("--samples 0:8 -o a.exr").code == 0);
  REQUIRE(workplace.render("--samples 8:8 -o b.exr").code == 0);
  REQUIRE(workplace.render("--crop 0,0,12,16 -o c.exr").code == 0);
  for (const std::string& name : {"a"s, "b"s, "c"s}) {
    ExrMetadata metadata = read_exr_metadata(workplace.folder / (name + ".exr"));
    for (ExrMetadata::Attribute& attribute : metadata.attributes)
      if (attribute.name == "sheaf/version") attribute.value = "0.2.0"s;
    write_exr(workplace.folder / (name + "_old.exr"), read_exr(workplace.folder / (name + ".exr")), metadata);
  }
  for (const auto& [parts, old] : {std::pair{"a_old.exr b_old.exr", "a_old.exr"},
                                   {"a.exr b_old.exr", "b_old.exr"},
                                   {"b_old.exr a.exr", "b_old.exr"},
                                   {"c_old.exr --incomplete", "c_old.exr"}}) {
    CAPTURE_BINDING(parts);
    const Outcome outcome = run(workplace.folder, "merge "s + parts + " --quiet -o whole.exr");
    workplace.check_refused(outcome, 3,
                            std::string(old) + ": was rendered by Sheaf 0.2.0, but this is Sheaf " + kSheafVersion +
                                ": merge the parts with Sheaf 0.2.0, or render them again");
    CHECK_FALSE(std::filesystem::exists(workplace.folder / "whole.exr"));
  }
  CHECK(run(workplace.folder, "merge a.exr b.exr --quiet -o whole.exr").code == 0);
  // They remain images
  CHECK(run(workplace.folder, "convert a_old.exr -q -o a.png").err.empty());
  CHECK(contains(run(workplace.folder, "info a_old.exr").out, "sheaf/version = 0.2.0\n"));
}

}  // namespace sheaf::test_cli_versions
