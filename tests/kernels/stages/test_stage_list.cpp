// The list of stages against the files of kernels/stages/.
#include "kernels/stages/stage_list.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace sheaf::test_stage_list {

namespace fs = std::filesystem;

namespace {

/// Whether the file of that path instantiates the stage `name`.
bool instantiates(const fs::path& path, const std::string& name) {
  std::ifstream stream(path);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return text.find("SHEAF_INSTANTIATE_STAGE(" + name + ");") != text.npos ||
         text.find("SHEAF_INSTANTIATE_CANDIDATE_STAGE(" + name + ");") != text.npos;
}

}  // namespace

TEST_CASE("each stage of the list is in a file of its name, and each file with a stage is in the list") {
  std::set<std::string> listed;
  for (const StageEntry& entry : kStages<Wide>) CHECK(listed.insert(std::string(entry.name)).second);
  const fs::path folder = SHEAF_SOURCE_DIR "/kernels/stages";
  for (const std::string& name : listed) {
    CAPTURE(name);
    CHECK(instantiates(folder / (name + ".cpp"), name));
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    CAPTURE(name);
    if (entry.path().extension() == ".cpp" && instantiates(entry.path(), name)) CHECK(listed.contains(name));
  }
}

TEST_CASE("the positions of stages follow the list") {
  static_assert(static_cast<std::size_t>(stage_named("camera_rays")) == 0);
  for (std::size_t i = 0; i < kStages<Wide>.size(); ++i) CHECK(kStages<Wide>[i].stage == static_cast<Stage>(i));
}

}  // namespace sheaf::test_stage_list
