// The program with a preview, and a client of its page.
#pragma once

#include "tests/support/contains.h"
#include "tests/support/loopback.h"
#include "tests/support/temporary_folder.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

namespace sheaf::test_preview {

using test::contains;

inline constexpr const char* kScene = R"(<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="6"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="48"/><integer name="height" value="32"/><rfilter type="gaussian"/>
    </film>
    <sampler type="independent"/>
  </sensor>
  <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
  <emitter type="constant"><rgb name="radiance" value="0.2, 0.5, 1.5"/></emitter>
</scene>)";
/// So many samples that no test waits for them, on one thread beside other tests.
inline constexpr const char* kEndless = " --spp 16000000 --threads 1";

inline void pause_for(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

/// The program, rendering kScene or another scene in a folder of its own.
class Render {
 public:
  explicit Render(const std::string& arguments, const std::string& scene = kScene,
                  const std::string& command = "render") {
    write_bytes(folder_ / "scene.xml", scene);
    write_bytes(folder_ / "go.sh",
                "exec '" SHEAF_EXECUTABLE "' " + command + " scene.xml -o out.exr -o out.png " + arguments);
    process_ = fork();
    if (process_ != 0) return;
    const int log = open((folder_ / "log.txt").c_str(), O_WRONLY | O_CREAT, 0600);
    if (chdir(folder_.path().c_str()) == 0 && dup2(log, STDERR_FILENO) >= 0)
      execlp("bash", "bash", "go.sh", static_cast<char*>(nullptr));
    _exit(127);
  }
  ~Render() {
    if (process_ > 0) end(SIGKILL);
  }
  Render(const Render&) = delete;

  std::string log() const { return read_bytes(folder_ / "log.txt"); }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  /// The port of --serve 0; 0 if none is printed within 10 s.
  int port() const {
    for (int i = 0; i < 200; ++i, pause_for(0.05)) {
      const std::string text = log(), before = "http://127.0.0.1:";
      const std::size_t at = text.find(before);
      if (at != std::string::npos && text.find('\n', at) != std::string::npos)
        return std::atoi(text.c_str() + at + before.size());
    }
    return 0;
  }

  /// Sends an optional signal and waits for the end. Returns the exit code, or 128 plus the signal that ended it.
  int end(int signal = 0) {
    if (signal != 0) kill(process_, signal);
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  TemporaryFolder folder_;
  pid_t process_ = 0;
};

/// Everything that a server replies to these bytes until it closes the connection; empty if there is no server.
inline std::string ask(int port, const std::string& request) {
  const LoopbackSocket socket = LoopbackSocket::connect_to(port);
  if (!socket.is_open()) return {};
  socket.send(request);  // the server may reply before it has received everything
  return socket.receive();
}

inline std::string get(int port, const std::string& path, const std::string& host = "127.0.0.1") {
  return ask(port, "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
}

inline int status_of(const std::string& answer) {
  return answer.starts_with("HTTP/1.1 ") ? std::atoi(answer.c_str() + 9) : 0;
}

inline std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? std::string() : answer.substr(end + 4);
}

inline nlohmann::json status(int port) {
  return nlohmann::json::parse(body_of(get(port, "/status.json")), nullptr, false);
}

/// Polls as a browser does until an image with at least this number exists. Returns the status.
inline nlohmann::json wait_for_image(int port, int number) {
  nlohmann::json now;
  for (int i = 0; i < 600; ++i, pause_for(0.05)) {
    now = status(port);
    if (now.is_discarded() || now["image"] >= number) break;
    get(port, "/image.png");
  }
  return now;
}

}  // namespace sheaf::test_preview
