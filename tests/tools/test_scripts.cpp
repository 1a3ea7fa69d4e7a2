// The scripts of the repository can be run as documented.
#include <doctest/doctest.h>

#include "tests/support/temporary_folder.h"

#include <cstdlib>
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

TEST_CASE("the commit hook accepts subjects of at most 72 characters") {
  const TemporaryFolder folder;
  const auto accepts = [&](const std::string& message) {
    std::ofstream(folder / "message") << message;
    const std::string file = folder / "message";
    return std::system(("'" SHEAF_SOURCE_DIR "/.githooks/commit-msg' '" + file + "' 2>/dev/null").c_str()) == 0;
  };
  CHECK(accepts(std::string(72, 'x') + "\n"));
  CHECK_FALSE(accepts(std::string(73, 'x') + "\n"));
  CHECK(accepts("Short\n\n" + std::string(100, 'x') + "\n"));
  CHECK(accepts("Fl\u00e4che " + std::string(65, 'x')));
  CHECK(accepts("Merge " + std::string(100, 'x')));
}

}  // namespace sheaf::test_scripts
