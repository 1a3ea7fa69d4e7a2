// The scripts of the repository can be run as documented.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace sheaf::test_scripts {

namespace fs = std::filesystem;

TEST_CASE("exactly the scripts with an interpreter line are executable") {
  int scripts = 0;
  for (const char* const folder : {"bench", "core", "kernels", "scene", "scenes", "tests", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SHEAF_SOURCE_DIR) / folder)) {
      const fs::path extension = entry.path().extension();
      if (!entry.is_regular_file() || (extension != ".py" && extension != ".sh" && extension != ".cpp")) continue;
      std::string line;
      std::getline(std::ifstream(entry.path()), line);
      CAPTURE(entry.path().string());
      const bool names_interpreter = line.starts_with("#!");
      CHECK(((entry.status().permissions() & fs::perms::owner_exec) != fs::perms::none) == names_interpreter);
      scripts += names_interpreter ? 1 : 0;
    }
  }
  CHECK(scripts > 20);
}

}  // namespace sheaf::test_scripts
