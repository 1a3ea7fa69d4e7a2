// Progress output: its text and its timing, with a simulated clock.
#include "core/progress.h"
#include "tests/support/contains.h"

#include <doctest/doctest.h>

#include <limits>
#include <thread>
#include <vector>

namespace sheaf::test_progress {

using test::contains;

namespace {

struct Recorder {
  double now = 100;
  std::vector<std::string> texts;
  Progress::Write write() {
    return [this](std::string_view text) { texts.emplace_back(text); };
  }
  Progress::Clock clock() {
    return [this] { return now; };
  }
};

}  // namespace

TEST_CASE("durations are printed in readable units") {
  CHECK(format_duration(0) == "0:00");
  CHECK(format_duration(59.6) == "1:00");
  CHECK(format_duration(3725) == "1:02:05");
  CHECK(format_duration(-1) == "?:??");
  CHECK(format_duration(std::numeric_limits<double>::quiet_NaN()) == "?:??");
  CHECK(format_duration(1e300) == "?:??");
}

TEST_CASE("a progress bar shows percentage and times and speed at most ten times a second") {
  Recorder recorder;
  Progress progress(Progress::Mode::kBar, 8'000'000, recorder.write(), recorder.clock());
  recorder.now += 2;
  progress.update(25, 100);
  REQUIRE(recorder.texts.size() == 1);
  const std::string& text = recorder.texts[0];
  CHECK(contains(text, " 25 %"));
  CHECK(contains(text, "0:02 elapsed"));
  CHECK(contains(text, "0:06 left"));
  CHECK(contains(text, "1.00 Msamples/s"));
  CHECK(text.front() == '\r');
  CHECK(text.back() != '\n');
  recorder.now += 0.05;
  progress.update(26, 100);
  CHECK(recorder.texts.size() == 1);
  recorder.now += 0.06;
  progress.update(27, 100);
  CHECK(recorder.texts.size() == 2);
}

TEST_CASE("a progress bar fits the width of the terminal and keeps the percentage longest") {
  for (int columns = 1; columns <= 120; ++columns)
    for (const bool complete : {false, true}) {
      CAPTURE(columns);
      Recorder recorder;
      Progress progress(Progress::Mode::kBar, 8'000'000, recorder.write(), recorder.clock(), [&] { return columns; });
      recorder.now += 2;
      progress.update(25, 100);
      progress.finish(complete);
      REQUIRE(recorder.texts.size() == 2);
      for (std::string text : recorder.texts) {
        text = text.substr(1, text.find('\x1b') - 1);
        CHECK(static_cast<int>(text.size()) < columns);
        CHECK((columns < 7 || contains(text, " %")));
        CHECK((columns < 90 || contains(text, "[")));
        CHECK((columns < 90 || contains(text, "Msamples/s")));
      }
    }
}

TEST_CASE("100 % is not shown before the end") {
  Recorder recorder;
  Progress progress(Progress::Mode::kBar, 1000, recorder.write(), recorder.clock());
  for (std::uint64_t done = 0; done <= 1000; ++done) {
    recorder.now += 1;
    progress.update(done, 1000);
  }
  for (const std::string& text : recorder.texts) CHECK_FALSE(contains(text, "100 %"));
  progress.finish(true);
  CHECK(contains(recorder.texts.back(), "100 %"));
  CHECK(recorder.texts.back().back() == '\n');
  CHECK_FALSE(contains(recorder.texts.back(), "left"));
}

TEST_CASE("an interrupted computation is reported and keeps its percentage") {
  Recorder recorder;
  Progress progress(Progress::Mode::kLines, 1000, recorder.write(), recorder.clock());
  recorder.now += 1;
  progress.update(40, 100);
  progress.finish(false);
  REQUIRE(recorder.texts.size() == 1);
  CHECK(contains(recorder.texts[0], " 40 %"));
  CHECK(contains(recorder.texts[0], "interrupted"));
  progress.finish(true);
  progress.update(100, 100);
  CHECK(recorder.texts.size() == 1);
}

TEST_CASE("log lines are printed every ten seconds") {
  Recorder recorder;
  Progress progress(Progress::Mode::kLines, 1000, recorder.write(), recorder.clock());
  for (std::uint64_t second = 1; second <= 60; ++second) {
    recorder.now += 1;
    progress.update(second, 60);
  }
  CHECK(recorder.texts.size() == 6);
  for (const std::string& text : recorder.texts) CHECK(text.back() == '\n');
}

TEST_CASE("nothing is shown when quiet") {
  Recorder recorder;
  Progress progress(Progress::Mode::kQuiet, 1000, recorder.write(), recorder.clock());
  recorder.now += 100;
  progress.update(1, 2);
  progress.finish(true);
  CHECK(recorder.texts.empty());
}

TEST_CASE("an empty task does not divide by zero") {
  Recorder recorder;
  Progress progress(Progress::Mode::kBar, 0, recorder.write(), recorder.clock());
  progress.update(0, 0);
  progress.finish(true);
  CHECK(contains(recorder.texts.front(), "  0 %"));
  CHECK(contains(recorder.texts.back(), "100 %"));
}

TEST_CASE("the largest of many unordered updates from threads counts") {
  Recorder recorder;
  Progress progress(Progress::Mode::kBar, 1000, recorder.write(), [] { return 0.0; });
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < 4; ++t) {
    threads.emplace_back([&progress, t] {
      for (std::uint64_t i = 250; i-- > 0;) progress.update(i * 4 + t, 2000);
    });
  }
  for (std::thread& thread : threads) thread.join();
  progress.finish(false);
  CHECK(contains(recorder.texts.back(), " 49 %"));
}

}  // namespace sheaf::test_progress
