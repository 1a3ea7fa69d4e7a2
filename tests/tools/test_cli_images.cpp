// Image formats of the program alone, and the library of OpenColorIO, which is loaded on demand.
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_cli_images {

namespace {

constexpr const char* kScene =
    "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><film type='hdrfilm'>"
    "<integer name='width' value='8'/><integer name='height' value='6'/></film>"
    "<sampler type='independent'><integer name='sample_count' value='1'/></sampler></sensor>"
    "<emitter type='constant'/></scene>";

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

std::filesystem::path color_library() {
  return std::filesystem::path(SHEAF_EXECUTABLE).replace_filename("sheaf_color_io.so");
}

}  // namespace

TEST_CASE("images: the program starts without OpenColorIO") {
  const TemporaryFolder folder;
  // The dynamic linker lists what it would load instead of running the program.
  const Outcome listed = run(folder, "--version", "LD_TRACE_LOADED_OBJECTS=1 ");
  CHECK(contains(listed.out, "libtbb"));
  CHECK_FALSE(contains(listed.out, "OpenColorIO"));
}

TEST_CASE("images: no output format needs another file of Sheaf") {
  const TemporaryFolder folder;
  const Copied alone(folder, "alone/sheaf");
  write_bytes(folder / "scene.xml", kScene);
  CHECK(alone.run("render scene.xml --spp 4 --replicates 2 --quiet -o out.exr -o out.png -o out.jpg -o out.tif").code ==
        0);
  for (const char* const name : {"out.exr", "out.png", "out.jpg", "out.tif"}) {
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
  CHECK(alone.run("compare out.png out.tif --max-mse 0.01").code == 0);
  CHECK(alone.run("denoise out.exr --quiet -o denoised.png").code == 0);
}

TEST_CASE("images: views of OpenColorIO need their own library alone") {
  const TemporaryFolder folder;
  const std::filesystem::path library = color_library();
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

TEST_CASE("images: the library of OpenColorIO is found in lib/sheaf of an installation, and must be a library") {
  const TemporaryFolder folder;
  const std::filesystem::path library = color_library();
  if (!std::filesystem::exists(library)) return;
  write_bytes(folder / "scene.xml", kScene);
  const std::string command = "render scene.xml --quiet --ocio-config raw -o out.png";
  std::filesystem::create_directories(folder / "usr/lib/sheaf");
  std::filesystem::copy_file(library, folder / "usr/lib/sheaf/sheaf_color_io.so");
  CHECK(Copied(folder, "usr/bin/sheaf").run(command).code == 0);
  const Copied beside(folder, "here/sheaf");
  write_bytes(folder / "here/sheaf_color_io.so", "no library");
  const Outcome outcome = beside.run(command);
  CHECK(outcome.code == 1);
  CHECK(contains(outcome.err, "here/sheaf_color_io.so"));
}

}  // namespace sheaf::test_cli_images
