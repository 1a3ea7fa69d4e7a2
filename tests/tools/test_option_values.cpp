// Options that a program sets without a command line: the variables, the checks, and what counts as given.
#include "core/io/error.h"
#include "tests/support/contains.h"
#include "tools/options/options.h"

#include <doctest/doctest.h>

#include <limits>
#include <tuple>

namespace sheaf::test_option_values {

using test::contains;

namespace {

/// A command with options of all kinds.
struct Options {
  Options() : program("test", ""), command(program.add_command("run", "")) {
    command.add_option("-n,--count", count, "").in_range(1u, 4294967295u);
    command.add_option("--share", fraction, "").fraction().positive();
    command.add_option("--time", time, "").seconds().only_for_run();
    command.add_option("--crop", crop, "").list(',', 4);
    command.add_option("--color", color, "").one_of({"rgb", "spectral"});
    command.add_option("--guiding", guiding, "").one_of({"on", "off"}).implies("on");
    command.add_option("-D,--define", definitions, "");
    command.add_flag("--float", floats, "");
  }

  std::string error(const std::string& name, const OptionValue& value) {
    try {
      command.set({{name, value}});
    } catch (const Error& error) {
      CHECK(error.exit_code() == ExitCode::kUsage);
      return error.what();
    }
    return "";
  }

  Program program;
  Command command;
  std::optional<unsigned> count;
  std::optional<float> fraction;
  double time = 0;
  std::vector<int> crop;
  std::string color, guiding;
  std::vector<std::string> definitions;
  bool floats = false;
};

OptionValue text(const char* value) { return std::string(value); }

}  // namespace

TEST_CASE("option values: variables are set, and given options are listed in the order of their declaration") {
  Options options;
  const auto given = options.command.set({{"float", true},
                                          {"color", text("rgb")},
                                          {"count", 4294967295.0},
                                          {"crop", std::vector<double>{0, -1, 8, 9}},
                                          {"define", std::vector<std::string>{"a=1", "b=2"}},
                                          {"guiding", true},
                                          {"share", 0.25},
                                          {"time", 90.0}});
  CHECK(options.count == 4294967295u);
  CHECK(options.fraction == 0.25f);
  CHECK(options.time == 90);
  CHECK(options.crop == std::vector<int>{0, -1, 8, 9});
  CHECK(options.color == "rgb");
  CHECK(options.guiding == "on");
  CHECK(options.definitions == std::vector<std::string>{"a=1", "b=2"});
  CHECK(options.floats);
  std::string list;
  for (const GivenOption& option : given)
    list += option.name + "=" + option.values + (option.affects_image ? " " : "! ");
  CHECK(list == "count=4294967295 share=0.25 time=90! crop=0,-1,8,9 color=rgb guiding=on define=a=1,b=2 float=true ");
}

TEST_CASE("option values: numbers may be given as on the command line") {
  Options options;
  const auto given = options.command.set(
      {{"share", text("2%")}, {"time", text("1m30s")}, {"count", text("1e3")}, {"crop", text("1,2,3,4")}});
  CHECK(options.fraction == 0.02f);
  CHECK(options.time == 90);
  CHECK(options.count == 1000u);
  CHECK(options.crop == std::vector<int>{1, 2, 3, 4});
  CHECK(given.front().values == "1000");
}

TEST_CASE("option values: errors are those of the command line") {
  Options options;
  const std::vector<std::tuple<const char*, OptionValue, const char*>> cases{
      {"count", 0.0, "--count: Value 0 not in range 1 to 4294967295"},
      {"count", 1.5, "--count: '1.5' is not an integer"},
      {"count", text("many"), "--count: 'many' is not a number"},
      {"count", true, "--count: expected a number"},
      {"count", std::vector<double>{1, 2}, "--count: expected a number"},
      {"share", -1.0, "--share: '-1' is not a positive number"},
      {"share", std::numeric_limits<double>::infinity(), "--share: 'inf' is not a finite number"},
      {"crop", std::vector<double>{1, 2, 3}, "--crop: expected 4 numbers"},
      {"crop", std::vector<double>{1, 2, 3, 1e12}, "is too large"},
      {"color", text("cmyk"), "--color: cmyk not in {rgb,spectral}"},
      {"color", true, "--color: expected a text"},
      {"define", text("a=1"), "--define: expected several texts"},
      {"float", 1.0, "--float: expected true or false"},
      {"cuont", 1.0, "unknown option 'cuont', did you mean 'count'?"}};
  for (const auto& [name, value, message] : cases) {
    const std::string found = options.error(name, value);
    CHECK_MESSAGE(contains(found, message), found);
  }
  CHECK_FALSE(options.count);
}

}  // namespace sheaf::test_option_values
