// Progress output: its text and its timing, with a simulated clock.
#include "tests/support/contains.h"
#include "tools/console/progress.h"

#include <doctest/doctest.h>

#include <atomic>
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

TEST_CASE("a progress bar shows percentage and times and speed at most ten times a second") {
  Recorder recorder;
  Progress progress(Progress::Mode::kBar, recorder.write(), recorder.clock());
  recorder.now += 2;
  progress.update({2'000'000, 8'000'000});
  REQUIRE(recorder.texts.size() == 1);
  const std::string& text = recorder.texts[0];
  CHECK(contains(text, " 25 %"));
  CHECK(contains(text, "  2.0 s elapsed"));
  CHECK(contains(text, ", 6.0 s left"));
  CHECK(contains(text, "1.00 Msamples/s"));
  CHECK(text.front() == '\r');
  CHECK(text.back() != '\n');
  recorder.now += 0.05;
  progress.update({2'100'000, 8'000'000});
  CHECK(recorder.texts.size() == 1);
  recorder.now += 0.06;
  progress.update({2'200'000, 8'000'000});
  CHECK(recorder.texts.size() == 2);
}

TEST_CASE("samples from before the render was resumed count for the percentage only") {
  Recorder recorder;
  Progress progress(Progress::Mode::kLines, recorder.write(), recorder.clock());
  recorder.now += 10;
  progress.update({5'000'000, 10'000'000, 4'000'000});
  REQUIRE(recorder.texts.size() == 1);
  CHECK(recorder.texts.front() == " 50 %  10 s elapsed, 50 s left, 0.10 Msamples/s\n");
}

TEST_CASE("the time left is called an upper bound if the number of samples is one") {
  Recorder recorder;
  Progress progress(Progress::Mode::kLines, recorder.write(), recorder.clock());
  recorder.now += 10;
  progress.update({1'000'000, 5'000'000, 0, true});
  REQUIRE(recorder.texts.size() == 1);
  CHECK(recorder.texts.front() == " 20 %  10 s elapsed, at most 40 s left, 0.10 Msamples/s\n");
}

TEST_CASE("a progress bar fits the width of the terminal and keeps the percentage longest") {
  for (int columns = 1; columns <= 120; ++columns) {
    CAPTURE(columns);
    Recorder recorder;
    Progress progress(Progress::Mode::kBar, recorder.write(), recorder.clock(), [&] { return columns; });
    recorder.now += 2;
    progress.update({2'000'000, 8'000'000, 0, true});
    REQUIRE(recorder.texts.size() == 1);
    std::string text = recorder.texts.front();
    text = text.substr(1, text.find('\x1b') - 1);
    CHECK(static_cast<int>(text.size()) < columns);
    CHECK((columns < 7 || contains(text, " %")));
    CHECK((columns < 90 || contains(text, "[")));
    CHECK((columns < 90 || contains(text, "Msamples/s")));
  }
}

TEST_CASE("100 % is never shown and the end erases the bar") {
  Recorder recorder;
  Progress progress(Progress::Mode::kBar, recorder.write(), recorder.clock());
  for (std::uint64_t done = 0; done <= 1000; ++done) {
    recorder.now += 1;
    progress.update({done, 1000});
  }
  CHECK(contains(recorder.texts.back(), " 99 %"));
  for (const std::string& text : recorder.texts) CHECK_FALSE(contains(text, "100 %"));
  progress.finish();
  CHECK(recorder.texts.back() == "\r\x1b[K");
  const std::size_t count = recorder.texts.size();
  recorder.now += 1;
  progress.update({1000, 1000});
  progress.finish();
  CHECK(recorder.texts.size() == count);
}

TEST_CASE("log lines are printed every ten seconds") {
  Recorder recorder;
  Progress progress(Progress::Mode::kLines, recorder.write(), recorder.clock());
  for (std::uint64_t second = 1; second <= 60; ++second) {
    recorder.now += 1;
    progress.update({second, 60});
  }
  progress.finish();
  CHECK(recorder.texts.size() == 6);
  for (const std::string& text : recorder.texts) CHECK(text.back() == '\n');
}

TEST_CASE("nothing is shown when quiet") {
  Recorder recorder;
  Progress progress(Progress::Mode::kQuiet, recorder.write(), recorder.clock());
  recorder.now += 100;
  progress.update({1, 2});
  progress.finish();
  CHECK(recorder.texts.empty());
}

TEST_CASE("an empty task does not divide by zero") {
  Recorder recorder;
  Progress progress(Progress::Mode::kBar, recorder.write(), recorder.clock());
  progress.update({0, 0});
  REQUIRE(recorder.texts.size() == 1);
  CHECK(contains(recorder.texts.front(), "  0 %  0 s elapsed, ? left, 0.00 Msamples/s"));
}

TEST_CASE("the largest of many unordered updates from threads counts") {
  Recorder recorder;
  std::atomic<double> now = 0;
  Progress progress(Progress::Mode::kBar, recorder.write(), [&now] { return now.load(); });
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < 4; ++t) {
    threads.emplace_back([&progress, t] {
      for (std::uint64_t i = 250; i-- > 0;) progress.update({i * 4 + t, 2000});
    });
  }
  for (std::thread& thread : threads) thread.join();
  now = 1;
  progress.update({1, 2000});
  CHECK(contains(recorder.texts.back(), " 49 %"));
}

}  // namespace sheaf::test_progress
