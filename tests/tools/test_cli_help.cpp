// Help: groups, width, the command `help`, and the description as JSON.
#include "tests/support/capture.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>
#include <sstream>
#include <vector>

namespace sheaf::test_cli_help {

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  for (const std::string& line : lines_of(text)) longest = std::max(longest, line.size());
  return longest;
}

nlohmann::json description(const TemporaryFolder& folder) {
  return nlohmann::json::parse(run(folder, "help --json").out);
}

}  // namespace

TEST_CASE("help: the options of render are in groups, in the order of use") {
  const TemporaryFolder folder;
  const std::vector<std::string> lines = lines_of(run(folder, "render --help").out);
  std::vector<std::string> titles;
  for (const std::string& line : lines)
    if (line.ends_with(':') && !line.starts_with(' ')) titles.push_back(line);
  CHECK(titles == std::vector<std::string>{"Arguments:", "Scene:", "Image:", "Sampling:", "Light transport:", "Output:",
                                           "Preview:", "Resources:", "Advanced:", "Help:"});
  const auto line_of = [&](const std::string& begin) {
    const auto found = std::find_if(lines.begin(), lines.end(), [&](auto& line) { return line.starts_with(begin); });
    REQUIRE(found != lines.end());
    return found - lines.begin();
  };
  for (const auto& [option, title] : {std::pair{"      --spp N", "Sampling:"},
                                      {"      --color rgb|spectral", "Image:"},
                                      {"  -o, --output FILE", "Output:"},
                                      {"      --max-depth N", "Light transport:"},
                                      {"      --serve [ADDRESS:]PORT", "Preview:"},
                                      {"      --threads N", "Resources:"},
                                      {"      --wave-size N", "Advanced:"}}) {
    CAPTURE_BINDING(option);
    const auto at = std::find(titles.begin(), titles.end(), title);
    CHECK(line_of(option) > line_of(*at));
    CHECK(line_of(option) < line_of(*(at + 1)));
  }
}

TEST_CASE("help: lines fit the width") {
  const TemporaryFolder folder;
  for (const char* const command : {"help", "help render", "help farm", "help compare"}) {
    CAPTURE(std::string(command));
    CHECK(longest_line(run(folder, command).out) <= 80);
    CHECK(longest_line(run(folder, command).out) > 70);
    const std::size_t narrow = longest_line(run(folder, command, "COLUMNS=50 ").out);
    CHECK(narrow <= 60);  // single words may be longer than the column
    CHECK(longest_line(run(folder, command, "COLUMNS=100 ").out) > 90);
    CHECK(longest_line(run(folder, command, "COLUMNS=1000 ").out) <= 120);
    CHECK(run(folder, command, "COLUMNS=wide ").out == run(folder, command).out);
  }
}

TEST_CASE("help: the command prints the same as the option, and --version works everywhere") {
  const TemporaryFolder folder;
  CHECK(run(folder, "help").out == run(folder, "--help").out);
  CHECK(run(folder, "help").out == run(folder, "-h").out);
  std::size_t count = 0;
  const nlohmann::json program = description(folder);
  for (const nlohmann::json& command : program["commands"]) {
    const std::string name = command["name"];
    CAPTURE(name);
    const Outcome help = run(folder, "help " + name);
    CHECK(help.code == 0);
    CHECK(help.out == run(folder, name + " --help").out);
    CHECK(contains(help.out, "\nUsage: sheaf " + name + " [OPTIONS]"));
    CHECK(run(folder, name + " --version").out == run(folder, "--version").out);
    ++count;
  }
  CHECK(count >= 8);
  const Outcome unknown = run(folder, "help paint");
  CHECK(unknown.code == 2);
  CHECK(contains(unknown.err, "paint not in {render,"));
}

TEST_CASE("help: watch lists what it takes, and the gestures of its page") {
  const TemporaryFolder folder;
  const std::string help = run(folder, "help watch").out;
  for (const char* const absent : {"--frames", "--skip-existing", "--checkpoint", "--resume", "--format", "--fps"}) {
    CAPTURE(std::string(absent));
    CHECK_FALSE(contains(help, absent));
  }
  for (const char* const present : {"--spp", "--serve", "--denoise", "orbit", "pan", "wheel", "Alt", "R returns"}) {
    CAPTURE(std::string(present));
    CHECK(contains(help, present));
  }
  CHECK(contains(run(folder, "watch scene.xml --frames 1:2").err, "--frames and --skip-existing are not supported"));
}

TEST_CASE("help: JSON describes the values of options") {
  const TemporaryFolder folder;
  const nlohmann::json program = description(folder);
  CHECK(program["version"].get<std::string>() + "\n" == run(folder, "--version").out);
  nlohmann::json options;
  for (const nlohmann::json& command : program["commands"])
    if (command["name"] == "render")
      for (const nlohmann::json& option : command["options"])
        options[option["names"].back().get<std::string>()] = option;
  CHECK(options["--color"]["words"] == nlohmann::json{"rgb", "spectral"});
  CHECK(options["--color"]["only_words"] == true);
  CHECK(options["--integrator"]["only_words"] == false);
  CHECK(options["--spp"]["kind"] == "integer");
  CHECK(options["--spp"]["min"] == 1);
  CHECK(options["--spp"]["max"] == 16777216);
  CHECK(options["--time-limit"]["kind"] == "time");
  CHECK(options["--time-limit"]["positive"] == true);
  CHECK(options["--output"]["kind"] == "file");
  CHECK(options["--output"]["repeats"] == true);
  CHECK(options["--crop"]["count"] == 4);
  CHECK(options["--light-groups"]["kind"] == "none");
  CHECK(options["--guiding"]["kind"] == "text");
  CHECK(options["scene"]["argument"] == true);
  CHECK(options["scene"]["required"] == true);
}

}  // namespace sheaf::test_cli_help
