// A headless Chromium that a test drives through the DevTools protocol over pipes: JSON messages that end in zero
// bytes.
#pragma once

#include "tests/support/temporary_folder.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace sheaf::test_preview {

inline bool has_browser() { return std::system("command -v chromium >/dev/null") == 0; }

/// One page in a browser of its own. All functions throw std::runtime_error if the browser does not answer.
class Browser {
 public:
  using Json = nlohmann::json;

  Browser(int width, int height, bool has_touch = false) {
    int to[2], from[2];
    if (pipe(to) != 0 || pipe(from) != 0) throw std::runtime_error("no pipe");
    process_ = fork();
    if (process_ == 0) run(to[0], from[1]);
    close(to[0]);
    close(from[1]);
    to_ = to[1];
    from_ = from[0];
    fcntl(to_, F_SETFD, FD_CLOEXEC);
    fcntl(from_, F_SETFD, FD_CLOEXEC);
    try {
      attach(width, height, has_touch);
    } catch (...) {
      end();
      throw;
    }
  }
  ~Browser() { end(); }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void open(int port) { call("Page.navigate", {{"url", "http://127.0.0.1:" + std::to_string(port) + "/"}}); }
  /// The value of an expression in the page.
  Json value(const std::string& expression) {
    return call("Runtime.evaluate",
                {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}})["result"]["value"];
  }
  /// Waits until an expression is true, at most 30 s.
  bool wait_for(const std::string& expression) {
    for (int i = 0; i < 300; ++i) {
      if (value("!!(" + expression + ")") == true) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }
  void mouse(const std::string& type, double x, double y, const Json& more = Json::object()) {
    Json event{{"type", type}, {"x", x}, {"y", y}, {"button", "left"}};
    event.update(more);
    call("Input.dispatchMouseEvent", event);
  }
  /// Drags with the left button. `modifiers`: 1 Alt, 8 Shift.
  void drag(double x, double y, double dx, double dy, int modifiers = 0) {
    mouse("mousePressed", x, y, {{"clickCount", 1}, {"buttons", 1}, {"modifiers", modifiers}});
    for (int i = 1; i <= 5; ++i)
      mouse("mouseMoved", x + dx * i / 5, y + dy * i / 5, {{"buttons", 1}, {"modifiers", modifiers}});
    mouse("mouseReleased", x + dx, y + dy, {{"clickCount", 1}, {"modifiers", modifiers}});
  }
  void click(double x, double y, int modifiers = 0) {
    mouse("mousePressed", x, y, {{"clickCount", 1}, {"buttons", 1}, {"modifiers", modifiers}});
    mouse("mouseReleased", x, y, {{"clickCount", 1}, {"modifiers", modifiers}});
  }
  void wheel(double x, double y, double by) { mouse("mouseWheel", x, y, {{"deltaX", 0}, {"deltaY", by}}); }
  void key(const std::string& name) {
    call("Input.dispatchKeyEvent", {{"type", "keyDown"}, {"key", name}, {"text", name}});
    call("Input.dispatchKeyEvent", {{"type", "keyUp"}, {"key", name}});
  }
  /// `type`: touchStart, touchMove or touchEnd. `points`: all fingers that touch the screen.
  void touch(const std::string& type, const std::vector<std::pair<double, double>>& points) {
    Json list = Json::array();
    for (std::size_t i = 0; i < points.size(); ++i)
      list.push_back({{"x", points[i].first}, {"y", points[i].second}, {"id", i}});
    call("Input.dispatchTouchEvent", {{"type", type}, {"touchPoints", list}});
  }

 private:
  void attach(int width, int height, bool has_touch) {
    const Json targets = call("Target.getTargets");
    for (const Json& target : targets["targetInfos"])
      if (target["type"] == "page") page_ = target["targetId"];
    session_ = call("Target.attachToTarget", {{"targetId", page_}, {"flatten", true}})["sessionId"];
    call("Emulation.setDeviceMetricsOverride",
         {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", has_touch}});
    if (has_touch) call("Emulation.setTouchEmulationEnabled", {{"enabled", true}, {"maxTouchPoints", 5}});
  }
  void end() const {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    close(to_);
    close(from_);
  }
  [[noreturn]] void run(int in, int out) const {
    const int null = open_null();
    // 3 and 4 may be among the pipes' descriptors
    const int safe_in = fcntl(in, F_DUPFD, 10), safe_out = fcntl(out, F_DUPFD, 10);
    dup2(safe_in, 3);
    dup2(safe_out, 4);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    const std::string folder = "--user-data-dir=" + (folder_ / "profile").string();
    execlp("chromium", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe",
           folder.c_str(), "about:blank", static_cast<char*>(nullptr));
    _exit(127);
  }
  static int open_null() { return ::open("/dev/null", O_WRONLY); }

  Json call(const std::string& method, const Json& parameters = Json::object()) {
    Json request{{"id", ++count_}, {"method", method}, {"params", parameters}};
    if (!session_.empty()) request["sessionId"] = session_;
    const std::string text = request.dump() + '\0';
    if (write(to_, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
      throw std::runtime_error("the browser has ended");
    for (;;) {
      const Json answer = Json::parse(next_message(), nullptr, false);
      if (!answer.is_object() || answer.value("id", 0) != count_) continue;  // an event
      if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
      return answer["result"];
    }
  }

  std::string next_message() {
    constexpr int kPatience = 60'000;  // ms
    std::size_t end = 0;
    while ((end = received_.find('\0')) == std::string::npos) {
      pollfd waiting{from_, POLLIN, 0};
      char piece[65536];
      const ssize_t got = poll(&waiting, 1, kPatience) == 1 ? read(from_, piece, sizeof piece) : 0;
      if (got <= 0) throw std::runtime_error("the browser does not answer");
      received_.append(piece, static_cast<std::size_t>(got));
    }
    std::string message = received_.substr(0, end);
    received_.erase(0, end + 1);
    return message;
  }

  TemporaryFolder folder_;
  pid_t process_ = 0;
  int to_ = -1, from_ = -1, count_ = 0;
  std::string page_, session_, received_;
};

}  // namespace sheaf::test_preview
