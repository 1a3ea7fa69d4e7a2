// The library of less common image formats, which is loaded on demand: what works without it, and messages where it is
// missing.
#include "core/image/image.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_cli_images {

namespace {

constexpr const char* kScene =
    "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><film type='hdrfilm'>"
    "<integer name='width' value='8'/><integer name='height' value='6'/></film>"
    "<sampler type='independent'><integer name='sample_count' value='1'/></sampler></sensor>"
    "<emitter type='constant'/></scene>";

const std::string kModule = "sheaf_image_io.so";

/// A copy of the program as `name` in the folder, with the exit code and output for given arguments.
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

TEST_CASE("images: the program starts without the image format libraries") {
  const TemporaryFolder folder;
  // The dynamic linker lists what it would load instead of running the program.
  const Outcome listed = run(folder, "--version", "LD_TRACE_LOADED_OBJECTS=1 ");
  CHECK(contains(listed.out, "libtbb"));
  CHECK_FALSE(contains(listed.out, "OpenImageIO"));
}

TEST_CASE("images: OpenEXR, PNG and JPEG need no image library, and TIFF is rejected before rendering") {
  const TemporaryFolder folder;
  const Copied alone(folder, "alone/sheaf");
  write_bytes(folder / "scene.xml", kScene);
  CHECK(alone.run("render scene.xml --quiet -o out.exr -o out.png -o out.jpg").code == 0);
  for (const char* const name : {"out.exr", "out.png", "out.jpg"}) {
    CAPTURE(std::string(name));
    CHECK(std::filesystem::exists(folder / name));
    const std::string bitmap =
        std::string("<texture type='bitmap' name='reflectance'><string name='filename' value='") + name +
        "'/></texture>";
    std::string textured = kScene;
    textured.insert(textured.find("<emitter"),
                    "<shape type='sphere'><bsdf type='diffuse'>" + bitmap + "</bsdf></shape>");
    write_bytes(folder / "textured.xml", textured);
    CHECK(alone.run("render textured.xml --quiet -o textured.png").code == 0);
  }
  CHECK(alone.run("compare out.png out.jpg --max-mse 0.01").code == 0);
  CHECK(alone.run("convert out.exr -o converted.png").code == 0);
  const Outcome tiff = alone.run("render scene.xml --quiet -o out.tif -o second.exr");
  CHECK(tiff.code == 1);
  CHECK(contains(tiff.err, "cannot read or write image formats other than OpenEXR, PNG and JPEG"));
  CHECK(contains(tiff.err, kModule));
  CHECK_FALSE(std::filesystem::exists(folder / "out.tif"));
  CHECK_FALSE(std::filesystem::exists(folder / "second.exr"));
}

TEST_CASE("images: views of OpenColorIO need their own library alone") {
  const TemporaryFolder folder;
  const std::filesystem::path library = module_file().replace_filename("sheaf_color_io.so");
  write_bytes(folder / "scene.xml", kScene);
  const Copied alone(folder, "alone/sheaf");
  const std::string command = "render scene.xml --quiet --ocio-config raw -o out.png";
  const Outcome missing = alone.run(command);
  if (!std::filesystem::exists(library)) {
    CHECK(contains(missing.err, "lacks OpenColorIO"));
    return;
  }
  CHECK(missing.code == 1);
  CHECK(contains(missing.err, "cannot use OpenColorIO configurations: "));
  CHECK(contains(missing.err, "(expected sheaf_color_io.so next to the program or in ../lib/sheaf)"));
  std::filesystem::copy_file(library, folder / "alone/sheaf_color_io.so");
  CHECK(alone.run(command).code == 0);
}

TEST_CASE("images: the image library is found beside the program and in lib/sheaf of an installation") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  std::filesystem::create_directories(folder / "usr/lib/sheaf");
  const Copied installed(folder, "usr/bin/sheaf"), beside(folder, "here/sheaf");
  std::filesystem::copy_file(module_file(), folder / ("usr/lib/sheaf/" + kModule));
  std::filesystem::copy_file(module_file(), folder / ("here/" + kModule));
  CHECK(installed.run("render scene.xml --quiet -o installed.tif").code == 0);
  CHECK(beside.run("render scene.xml --quiet -o beside.tif").code == 0);
  const Image a = read_image(folder / "installed.tif"), b = read_image(folder / "beside.tif");
  CHECK(a.width == 8);
  CHECK(a.data == b.data);

  SUBCASE("a file that is not a library is an error with its name") {
    write_bytes(folder / ("here/" + kModule), "no library");
    const Outcome outcome = beside.run("render scene.xml --quiet -o third.tif");
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.err, "here/" + kModule));
  }
}

}  // namespace sheaf::test_cli_images
