// Search paths for the Open Image Denoise library.
#include "kernels/denoise/find_oidn.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>

namespace sheaf::test_find_oidn {

namespace fs = std::filesystem;

namespace {

/// Creates a file and its parent folders.
void touch(const fs::path& file) {
  fs::create_directories(file.parent_path());
  write_bytes(file, "x");
}

bool contains(const std::vector<fs::path>& folders, const fs::path& folder) {
  return std::find(folders.begin(), folders.end(), fs::canonical(folder)) != folders.end();
}

}  // namespace

TEST_CASE("oidn: library files of a folder are sorted with the highest version first") {
  const TemporaryFolder folder;
  for (const char* const name :
       {"libOpenImageDenoise.so", "libOpenImageDenoise.so.1.4.3", "libOpenImageDenoise.so.2.10.0",
        "libOpenImageDenoise.so.2.9.1", "libOpenImageDenoise.so.2", "libOpenImageDenoise_core.so.2.9.1",
        "libOpenImageDenoise.a"})
    touch(folder / name);
  std::vector<std::string> names;
  for (const fs::path& file : oidn_files(folder.path())) names.push_back(file.filename().string());
  CHECK(names == std::vector<std::string>{"libOpenImageDenoise.so.2.10.0", "libOpenImageDenoise.so.2.9.1",
                                          "libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1.4.3",
                                          "libOpenImageDenoise.so"});
  CHECK(oidn_files(folder / "gone").empty());
  const std::vector<std::string> linked = oidn_names();
  for (const char* const name : {"libOpenImageDenoise.so", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so.2"})
    CHECK(std::find(linked.begin(), linked.end(), name) != linked.end());
}

TEST_CASE("oidn: the library is found beside the program and in pip and Blender installations") {
  const TemporaryFolder folder;
  const std::string library = "libOpenImageDenoise.so.2";
  const std::string packages = "lib/python3.11/site-packages/";
  for (const std::string& file :
       {std::string("program/bin/sheaf"), "program/lib/sheaf/" + library,
        "venv/" + packages + "oidn/lib.linux.x64/" + library, "conda/" + packages + "pyoidn/oidn/lib/" + library,
        "conda/lib/" + library, "home/.local/" + packages + "bpy/lib/" + library, "blender-4.2/lib/" + library,
        std::string("blender-4.2/blender")})
    touch(folder / file);
  fs::create_directory(folder / "bin");
  fs::create_symlink(folder / "blender-4.2/blender", folder / "bin/blender");
  const std::map<std::string, std::string> variables{
      {"VIRTUAL_ENV", (folder / "venv").string()},
      {"CONDA_PREFIX", (folder / "conda").string()},
      {"HOME", (folder / "home").string()},
      {"PATH", "/nowhere:" + (folder / "bin").string()},
  };
  const auto environment = [&](const char* name) {
    const auto found = variables.find(name);
    return found != variables.end() ? found->second : std::string();
  };
  const OidnFolders folders = oidn_folders(folder / "program/bin/sheaf", environment);
  CHECK(contains(folders.before, folder / "program/bin"));
  CHECK(contains(folders.before, folder / "program/lib/sheaf"));
  for (const std::string& each :
       {"venv/" + packages + "oidn/lib.linux.x64", "conda/" + packages + "pyoidn/oidn/lib", std::string("conda/lib"),
        "home/.local/" + packages + "bpy/lib", std::string("blender-4.2/lib")}) {
    CAPTURE(each);
    CHECK(contains(folders.behind, folder / each));
  }
  // With no environment variables set, only system folders remain.
  const OidnFolders bare = oidn_folders("", [](const char*) { return std::string(); });
  CHECK(bare.before.empty());
  for (const fs::path& each : bare.behind) CHECK(each.string().starts_with("/usr"));
}

}  // namespace sheaf::test_find_oidn
