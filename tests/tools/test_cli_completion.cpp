// Completion of command lines: the scripts run in the shells that are installed.
#include "tests/support/capture.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <utility>

namespace sheaf::test_cli_completion {

namespace {

bool has_program(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

/// The words that bash offers for a command line, whose last word is the one to complete.
std::string completed_in_bash(const TemporaryFolder& folder, const std::string& line) {
  write_bytes(folder / "complete.sh", "source ./sheaf.bash\nCOMP_WORDS=(" + line +
                                          ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_sheaf\n"
                                          "echo \"${COMPREPLY[*]}\" >completed.txt\n");
  REQUIRE(run(folder, "--version", "bash complete.sh; ").code == 0);
  std::string words = read_bytes(folder / "completed.txt");
  words.pop_back();
  return words;
}

}  // namespace

TEST_CASE("completion: bash completes commands, options and values") {
  const TemporaryFolder folder;
  write_bytes(folder / "sheaf.bash", run(folder, "completion bash").out);
  write_bytes(folder / "scene.xml", "");
  for (const auto& [line, words] : {std::pair{"sheaf re", "render"},
                                    {"sheaf --ver", "--version --verbose"},
                                    {"sheaf --vers", "--version"},
                                    {"sheaf render --den", "--denoise"},
                                    {"sheaf render --color ''", "rgb spectral"},
                                    {"sheaf render --color s", "spectral"},
                                    {"sheaf render --color = s", "spectral"},
                                    {"sheaf render --integrator path_m", "path_mats"},
                                    {"sheaf render --sampler z", "zsobol"},
                                    {"sheaf render --aov alb", "albedo"},
                                    {"sheaf render --aov depth,alb", "depth,albedo"},
                                    {"sheaf render sce", "scene.xml"},
                                    {"sheaf render -o sce", "scene.xml"},
                                    {"sheaf render --spp 1", ""},
                                    {"sheaf render --size 1", ""},
                                    {"sheaf help rend", "render"},
                                    {"sheaf completion z", "zsh"},
                                    {"sheaf denoise --method o", "oidn"}}) {
    CAPTURE_BINDING(line);
    CHECK(completed_in_bash(folder, line) == words);
  }
}

TEST_CASE("completion: every option is in every script, and the scripts have no errors") {
  const TemporaryFolder folder;
  const nlohmann::json program = nlohmann::json::parse(run(folder, "help --json").out);
  for (const auto& [shell, check] :
       {std::pair<std::string, std::string>{"bash", "bash -n"}, {"zsh", "zsh -n"}, {"fish", "fish --no-execute"}}) {
    CAPTURE_BINDING(shell);
    const Outcome script = run(folder, "completion " + shell);
    REQUIRE(script.code == 0);
    for (const nlohmann::json& command : program["commands"]) {
      CHECK(contains(script.out, command["name"].get<std::string>()));
      for (const nlohmann::json& option : command["options"]) {
        const std::string name = option["names"].back();
        if (option["argument"] == true) continue;
        CAPTURE(name);
        CHECK(contains(script.out, shell == "fish" ? "-l " + name.substr(2) : name));
      }
    }
    if (!has_program(shell)) continue;
    write_bytes(folder / "script", script.out);
    CHECK(run(folder, "--version", check + " ./script && ").code == 0);
  }
  CHECK(run(folder, "completion tcsh").code == 2);
  CHECK(run(folder, "completion").code == 2);
}

TEST_CASE("completion: fish completes commands, options and values") {
  if (!has_program("fish")) {
    MESSAGE("skipped: fish is missing (Debian package fish)");
    return;
  }
  const TemporaryFolder folder;
  write_bytes(folder / "sheaf.fish", run(folder, "completion fish").out);
  for (const auto& [line, word] : {std::pair{"sheaf re", "render\t"},
                                   {"sheaf render --den", "--denoise\t"},
                                   {"sheaf render --color s", "spectral"},
                                   {"sheaf render --aov depth,alb", "depth,albedo"},
                                   {"sheaf help rend", "render"}}) {
    CAPTURE_BINDING(line);
    const std::string command =
        "HOME=. fish -c 'source sheaf.fish; complete -C \"" + std::string(line) + "\"' >completed.txt; ";
    run(folder, "--version", command);
    CHECK(contains(read_bytes(folder / "completed.txt"), word));
  }
}

}  // namespace sheaf::test_cli_completion
