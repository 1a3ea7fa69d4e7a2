// The library of picture formats, which is loaded when a picture is met: what starts without it, and what is said where
// it is missing.
#include "core/image.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_cli_pictures {

namespace {

constexpr const char* kScene =
    "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><film type='hdrfilm'>"
    "<integer name='width' value='8'/><integer name='height' value='6'/></film>"
    "<sampler type='independent'><integer name='sample_count' value='1'/></sampler></sensor>"
    "<emitter type='constant'/></scene>";

const std::string kModule = "sheaf_image_io.so";

/// A copy of the program at `name` in the folder, and its exit code and words for these arguments.
class Copied {
 public:
  Copied(const TemporaryFolder& folder, const std::string& name) : folder_(folder), name_(name) {
    std::filesystem::create_directories((folder / name).parent_path());
    std::filesystem::copy_file(SHEAF_EXECUTABLE, folder / name);
  }
  Outcome run(const std::string& arguments) const {
    return sheaf::run(folder_, "", "copied() { './" + name_ + "' " + arguments + "; }; copied ");
  }

 private:
  const TemporaryFolder& folder_;
  std::string name_;
};

std::filesystem::path module_file() { return std::filesystem::path(SHEAF_EXECUTABLE).parent_path() / kModule; }

}  // namespace

TEST_CASE("pictures: the program starts without the libraries of picture formats") {
  const TemporaryFolder folder;
  // What the dynamic linker would load: it prints that in place of running the program.
  const Outcome listed = run(folder, "--version", "LD_TRACE_LOADED_OBJECTS=1 ");
  CHECK(contains(listed.out, "libtbb"));
  CHECK_FALSE(contains(listed.out, "OpenImageIO"));
}

TEST_CASE("pictures: without their library OpenEXR is written all the same, and PNG refused before rendering") {
  const TemporaryFolder folder;
  const Copied alone(folder, "alone/sheaf");
  write_bytes(folder / "scene.xml", kScene);
  CHECK(alone.run("render scene.xml --quiet -o out.exr").code == 0);
  CHECK(std::filesystem::exists(folder / "out.exr"));
  const Outcome png = alone.run("render scene.xml --quiet -o out.png -o second.exr");
  CHECK(png.code == 1);
  CHECK(contains(png.err, "cannot read or write image formats other than OpenEXR"));
  CHECK(contains(png.err, kModule));
  CHECK_FALSE(std::filesystem::exists(folder / "out.png"));
  CHECK_FALSE(std::filesystem::exists(folder / "second.exr"));
  CHECK(alone.run("denoise out.exr -o out.png").code == 1);
}

TEST_CASE("pictures: their library is found beside the program, and in lib/sheaf where it is installed") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  std::filesystem::create_directories(folder / "usr/lib/sheaf");
  const Copied installed(folder, "usr/bin/sheaf"), beside(folder, "here/sheaf");
  std::filesystem::copy_file(module_file(), folder / ("usr/lib/sheaf/" + kModule));
  std::filesystem::copy_file(module_file(), folder / ("here/" + kModule));
  CHECK(installed.run("render scene.xml --quiet -o installed.png").code == 0);
  CHECK(beside.run("render scene.xml --quiet -o beside.png").code == 0);
  const Image a = read_image(folder / "installed.png"), b = read_image(folder / "beside.png");
  CHECK(a.width == 8);
  CHECK(a.data == b.data);

  SUBCASE("what is no library is told, with its name") {
    write_bytes(folder / ("here/" + kModule), "no library");
    const Outcome outcome = beside.run("render scene.xml --quiet -o third.png");
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.err, "here/" + kModule));
  }
}

}  // namespace sheaf::test_cli_pictures
