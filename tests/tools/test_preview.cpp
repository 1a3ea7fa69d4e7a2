// Previews of a running render: --serve as browsers and other clients use it, --tev as the viewer does.
#include "core/image/exr.h"
#include "tests/tools/preview_testing.h"
#include "tools/console/progress.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <thread>

namespace sheaf::test_preview {

TEST_CASE("invalid addresses are usage errors and an occupied port ends the program before it reads the scene") {
  for (const char* arguments :
       {"--serve 65536", "--serve -1", "--serve x", "--serve 127.0.0.1:", "--serve :80", "--serve ::1:80",
        "--serve [1.2.3.4]:80", "--tev 14158", "--tev localhost", "--tev localhost:0", "--tev localhost:1x"}) {
    CAPTURE(std::string(arguments));
    Render render(arguments);
    CHECK(render.end() == 2);
    CHECK(contains(render.log(), "PORT"));
  }
  const LoopbackSocket taken = LoopbackSocket::listen();
  Render render("--serve " + std::to_string(taken.port()));
  CHECK(render.end() == 1);
  CHECK(contains(render.log(), "cannot listen at 127.0.0.1:" + std::to_string(taken.port())));
  CHECK_FALSE(std::filesystem::exists(render.file("out.exr")));
}

TEST_CASE("the page and the status and the image of a render are served and nothing else") {
  Render render("--serve 0" + std::string(kEndless));
  const int port = render.port();
  REQUIRE(port > 0);
  const std::string page = get(port, "/");
  CHECK(status_of(page) == 200);
  CHECK(contains(page, "Content-Type: text/html"));
  CHECK(contains(page, "</html>"));
  for (const char* elsewhere : {"http://", "https://", "<link rel=\"stylesheet", "<script src"})
    CHECK_FALSE(contains(body_of(page), elsewhere));

  // The first three images have 1, 2 and 4 samples per pixel and are not part of the progress.
  const nlohmann::json first = wait_for_image(port, 4), second = wait_for_image(port, 5);
  REQUIRE(second.is_object());
  CHECK(second["state"] == "rendering");
  CHECK(second["scene"] == "scene.xml");
  CHECK(second["done"] > first["done"]);
  CHECK(second["fraction"] < 1);
  CHECK(second["left_seconds"] > 0);
  CHECK(contains(second["messages"][0].get<std::string>(), "rendered with 'sobol'"));
  CHECK(second["report"]["stages"][0]["name"] == "camera_rays");
  CHECK(second["report"]["stages"][0]["items"] > first["report"]["stages"][0]["items"]);
  const std::string image = get(port, "/image.png");
  CHECK(contains(image, "Content-Type: image/png"));
  write_bytes(render.file("seen.png"), body_of(image));
  const Image seen = read_image(render.file("seen.png"));
  CHECK(seen.width == 48);
  CHECK(seen.height == 32);

  CHECK(status_of(get(port, "/image.exr")) == 404);
  CHECK(status_of(get(port, "/../scene.xml")) == 404);
  CHECK(status_of(get(port, "/status.json?a=b")) == 200);
  CHECK(status_of(get(port, "/", "localhost:" + std::to_string(port))) == 200);
  CHECK(status_of(get(port, "/status.json", "pages.example")) == 403);
  for (const char* method : {"POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PAINT"}) {
    const std::string answer =
        ask(port, std::string(method) + " / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\n\r\nabcd");
    CHECK(status_of(answer) == 405);
    CHECK(contains(answer, "Allow: GET"));
  }
  CHECK(render.end(SIGINT) == 130);
  CHECK_FALSE(LoopbackSocket::connect_to(port).is_open());
}

TEST_CASE("slow and silent and malformed clients block neither the render nor other clients") {
  Render render("--serve 0" + std::string(kEndless));
  const int port = render.port();
  REQUIRE(port > 0);
  std::vector<LoopbackSocket> slow;
  for (const char* beginning : {"", "G", "GET / HTTP/1.1\r\n", "GET / HTTP/1.1\r\nHost: localhost\r\nX: ",
                                "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n"})
    for (int i = 0; i < 3; ++i) {
      slow.push_back(LoopbackSocket::connect_to(port));
      REQUIRE(slow.back().is_open());
      slow.back().send(beginning);
    }
  slow.back().send(std::string("\0\xff nonsense\r\n\r\n", 14));
  CHECK(status_of(ask(port, "GET /%00%ff%zz HTTP/1.1\r\nHost: [\r\n\r\n")) > 0);
  // Invalid requests and requests that are too long are rejected.
  const std::string endless(std::size_t{4} << 20, 'x');
  for (const std::string& nonsense :
       {"GET /" + endless, "GET / HTTP/1.1\r\nX: " + endless, std::string("GET / HTTP/9.9\r\n\r\n")})
    CHECK(status_of(ask(port, nonsense)) >= 400);
  const nlohmann::json before = wait_for_image(port, 4), after = wait_for_image(port, 5);
  REQUIRE(after.is_object());
  CHECK(after["done"] > before["done"]);
  const double start = Progress::steady_seconds();
  CHECK(render.end(SIGTERM) == 143);
  CHECK(Progress::steady_seconds() - start < 8);
}

TEST_CASE("viewers get the finished image and do not change its bytes") {
  const std::string arguments = " --spp 5000 --threads 1 --no-timestamps";
  Render alone(arguments);
  REQUIRE(alone.end() == 0);
  Render render("--serve 0" + arguments);
  const int port = render.port();
  REQUIRE(port > 0);
  nlohmann::json last;
  std::string image;
  int images = 0;
  for (int i = 0; i < 6000; ++i, pause_for(0.02)) {
    const nlohmann::json now = status(port);
    if (now.is_discarded() || !now.is_object()) break;
    if (now["image"] != (last.is_object() ? last["image"] : nlohmann::json(0))) {
      image = body_of(get(port, "/image.png"));
      ++images;
    }
    last = now;
  }
  CHECK(render.end() == 0);
  CHECK(last["state"] == "done");
  CHECK(last["fraction"] == 1.0);
  CHECK(last["report"]["samples"] == 48 * 32 * 5000);
  CHECK(images >= 2);
  write_bytes(render.file("seen.png"), image);
  CHECK(read_image(render.file("seen.png")).data == read_image(render.file("out.png")).data);
  CHECK(read_bytes(render.file("out.exr")) == read_bytes(alone.file("out.exr")));
  CHECK(read_bytes(render.file("out.png")) == read_bytes(alone.file("out.png")));
}

namespace {

/// kScene with a wall in front of the camera that fills a frame of 256 x 256 pixels.
std::string wall_scene() {
  std::string scene = kScene;
  for (const auto& [before, after] : {std::pair<std::string, std::string>{"value=\"48\"", "value=\"256\""},
                                      {"value=\"32\"", "value=\"256\""},
                                      {"<shape type=\"sphere\">",
                                       "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"9\"/>"
                                       "</transform>"}})
    scene.replace(scene.find(before), before.size(), after);
  return scene;
}

/// Mean difference between horizontal neighbors.
double roughness(const Image& image) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 1; x < image.width; ++x) sum += std::abs(double{image.at(x, y, 0)} - double{image.at(x - 1, y, 0)});
  return sum / (image.height * (image.width - 1));
}

}  // namespace

TEST_CASE("the first image shows every pixel, and images follow every second") {
  Render render("--serve 0" + std::string(kEndless), wall_scene());
  const int port = render.port();
  REQUIRE(port > 0);
  const nlohmann::json first = wait_for_image(port, 1);
  REQUIRE(first.is_object());
  // A pass of the render would take longer than this image
  CHECK(first["done"] < 256 * 256 * 256);
  write_bytes(render.file("seen.png"), body_of(get(port, "/image.png")));
  const Image seen = read_image(render.file("seen.png"));
  const int alpha = seen.find_channel("A");
  std::size_t missing = 0;
  if (alpha >= 0)
    for (int y = 0; y < seen.height; ++y)
      for (int x = 0; x < seen.width; ++x) missing += seen.at(x, y, alpha) < 1.0f ? 1u : 0u;
  CHECK(missing == 0);
  const double start = Progress::steady_seconds();
  REQUIRE(wait_for_image(port, 4).is_object());
  CHECK(Progress::steady_seconds() - start < 10);
  CHECK(render.end(SIGINT) == 130);
}

TEST_CASE("images are denoised while a client asks for it") {
  Render render("--serve 0 --integrator path_ems" + std::string(kEndless), wall_scene());
  const int port = render.port();
  REQUIRE(port > 0);
  REQUIRE(wait_for_image(port, 1).is_object());
  CHECK(status_of(get(port, "/denoised/image.png")) == 404);
  nlohmann::json now;
  for (int i = 0; i < 600; ++i, pause_for(0.05)) {
    now = nlohmann::json::parse(body_of(get(port, "/denoised/status.json")), nullptr, false);
    get(port, "/image.png");
    if (now.is_discarded() || now["denoised_image"] > 0) break;
  }
  REQUIRE(now.is_object());
  REQUIRE(now["denoised_image"] > 0);
  write_bytes(render.file("noisy.png"), body_of(get(port, "/image.png")));
  write_bytes(render.file("smooth.png"), body_of(get(port, "/denoised/image.png")));
  const Image noisy = read_image(render.file("noisy.png")), smooth = read_image(render.file("smooth.png"));
  CHECK(smooth.width == noisy.width);
  CHECK(roughness(smooth) < 0.5 * roughness(noisy));
  const double start = Progress::steady_seconds();
  CHECK(render.end(SIGINT) == 130);
  CHECK(Progress::steady_seconds() - start < 8);  // denoising does not delay the end
}

TEST_CASE("watch renders again when the scene changes, and survives errors in it") {
  Render render("--serve 0 --spp 16", kScene, "watch");
  const int port = render.port();
  REQUIRE(port > 0);
  const auto wait_for_state = [&](const std::string& state, const std::string& other_than) {
    for (int i = 0; i < 600; ++i, pause_for(0.05)) {
      nlohmann::json now = status(port);
      if (now.is_object() && now["state"] == state && now["run"] != other_than) return now;
    }
    return nlohmann::json();
  };
  const nlohmann::json first = wait_for_state("done", "");
  REQUIRE(first.is_object());
  CHECK(first["repeats"] == true);
  const std::string before = body_of(get(port, "/image.png"));
  CHECK(std::filesystem::exists(render.file("out.png")));
  // Another light
  std::string scene = kScene;
  scene.replace(scene.find("0.2, 0.5, 1.5"), 13, "1.5, 0.5, 0.2");
  write_bytes(render.file("scene.xml"), scene);
  const nlohmann::json second = wait_for_state("done", first["run"]);
  REQUIRE(second.is_object());
  CHECK(body_of(get(port, "/image.png")) != before);
  // An error, and its correction
  write_bytes(render.file("scene.xml"), "<scene>");
  const nlohmann::json failed = wait_for_state("failed", second["run"]);
  REQUIRE(failed.is_object());
  CHECK(contains(failed["messages"].dump(), "scene.xml:1: not well-formed XML"));
  write_bytes(render.file("scene.xml"), kScene);
  REQUIRE(wait_for_state("done", failed["run"]).is_object());
  CHECK(body_of(get(port, "/image.png")) == before);
  CHECK(render.end(SIGINT) == 130);
}

namespace {

/// State of the viewer after some packets.
struct Viewer {
  std::string name;
  int width = 0, height = 0, updates = 0;
  std::vector<std::string> channels;
  std::vector<float> pixels;  ///< interleaved, of the whole frame
  bool is_sound = true;       ///< all packets follow the protocol

  /// Reads packets, each preceded by its length.
  void take(std::string_view bytes) {
    while (is_sound && !bytes.empty()) {
      const std::uint32_t size = bytes.size() >= 4 ? peek<std::uint32_t>(bytes) : 0;
      is_sound = size > 5 && size <= bytes.size();
      if (!is_sound) return;
      std::string_view packet = bytes.substr(4, size - 4);
      bytes.remove_prefix(size);
      take_packet(packet);
    }
  }

 private:
  template <class T> static T peek(std::string_view bytes) {
    T value{};
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  template <class T> static T pop(std::string_view& bytes) {
    const T value = peek<T>(bytes);
    bytes.remove_prefix(sizeof value);
    return value;
  }
  static std::string pop_text(std::string_view& bytes) {
    std::string text(bytes.data());
    bytes.remove_prefix(text.size() + 1);
    return text;
  }
  static std::vector<std::string> pop_names(std::string_view& bytes, int count) {
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) names.push_back(pop_text(bytes));
    return names;
  }

  void take_packet(std::string_view packet) {
    const int type = pop<std::uint8_t>(packet);
    pop<std::uint8_t>(packet);
    const std::string of = pop_text(packet);
    if (type == 4) {
      name = of;
      width = pop<std::int32_t>(packet);
      height = pop<std::int32_t>(packet);
      channels = pop_names(packet, pop<std::int32_t>(packet));
      pixels.assign(static_cast<std::size_t>(width * height) * channels.size(), 0.0f);
      is_sound = packet.empty();
      return;
    }
    const int count = pop<std::int32_t>(packet);
    is_sound = type == 6 && of == name && pop_names(packet, count) == channels;
    if (!is_sound) return;
    const int x0 = pop<std::int32_t>(packet), y0 = pop<std::int32_t>(packet);
    const int columns = pop<std::int32_t>(packet), rows = pop<std::int32_t>(packet);
    std::vector<std::int64_t> offsets, strides;
    for (int c = 0; c < count; ++c) offsets.push_back(pop<std::int64_t>(packet));
    for (int c = 0; c < count; ++c) strides.push_back(pop<std::int64_t>(packet));
    is_sound = x0 >= 0 && y0 >= 0 && x0 + columns <= width && y0 + rows <= height &&
               packet.size() == static_cast<std::size_t>(columns * rows * count) * sizeof(float);
    for (int i = 0; is_sound && i < columns * rows; ++i)
      for (int c = 0; c < count; ++c) {
        const auto from =
            static_cast<std::size_t>(offsets[static_cast<std::size_t>(c)] + i * strides[static_cast<std::size_t>(c)]);
        const int to = ((y0 + i / columns) * width + x0 + i % columns) * count + c;
        pixels[static_cast<std::size_t>(to)] = peek<float>(packet.substr(from * sizeof(float)));
      }
    ++updates;
  }
};

}  // namespace

TEST_CASE("tev receives the image during the render and finally the pixels of the file") {
  for (const char* crop : {"", " --crop 3,5,40,31"}) {
    const LoopbackSocket server = LoopbackSocket::listen();
    Render render("--tev 127.0.0.1:" + std::to_string(server.port()) + " --spp 6000 --threads 1 --float" + crop);
    const LoopbackSocket connection = server.accept();
    REQUIRE(connection.is_open());
    Viewer viewer;
    viewer.take(connection.receive());
    CHECK(render.end() == 0);
    CHECK(viewer.is_sound);
    CHECK(viewer.updates >= 2);
    CHECK(viewer.name == "out.exr");
    CHECK(viewer.channels == std::vector<std::string>{"R", "G", "B", "A"});
    const Image image = read_exr(render.file("out.exr"));
    REQUIRE(viewer.width == image.frame_width);
    REQUIRE(viewer.height == image.frame_height);
    std::size_t different = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 4; ++c) {
          const int at = ((image.y0 + y) * viewer.width + image.x0 + x) * 4 + c;
          const int channel = image.find_channel(viewer.channels[static_cast<std::size_t>(c)]);
          different += viewer.pixels[static_cast<std::size_t>(at)] != image.at(x, y, channel) ? 1u : 0u;
        }
    CHECK(different == 0);
  }
}

TEST_CASE("a missing or late or closed or blocked tev does not stop the render") {
  {
    int port = 0;
    {
      const LoopbackSocket nobody = LoopbackSocket::listen();
      port = nobody.port();
    }
    Render render("--spp 16 --tev 127.0.0.1:" + std::to_string(port));
    CHECK(render.end() == 0);
    CHECK(contains(render.log(), "no tev viewer at 127.0.0.1"));
  }
  {
    const LoopbackSocket server = LoopbackSocket::listen();
    Render render("--tev 127.0.0.1:" + std::to_string(server.port()) + std::string(kEndless));
    { const LoopbackSocket first = server.accept(); }  // disconnects at once
    const LoopbackSocket second = server.accept();
    REQUIRE(second.is_open());
    pause_for(2);
    CHECK(render.end(SIGINT) == 130);
    Viewer viewer;
    viewer.take(second.receive());
    CHECK(viewer.is_sound);
    CHECK(viewer.updates >= 1);
  }
  {
    const LoopbackSocket server = LoopbackSocket::listen();  // never accepts, never reads
    Render render("--tev 127.0.0.1:" + std::to_string(server.port()) + " --size 1024x1024 --spp 4");
    const double start = Progress::steady_seconds();
    CHECK(render.end() == 0);
    CHECK(Progress::steady_seconds() - start < 60);
    CHECK(std::filesystem::exists(render.file("out.exr")));
  }
}

TEST_CASE("a browser shows the render") {
  if (std::system("command -v chromium >/dev/null") != 0) {
    MESSAGE("skipped: chromium is missing (Debian package chromium)");
    return;
  }
  Render render("--serve 0" + std::string(kEndless));
  const int port = render.port();
  REQUIRE(port > 0);
  const std::string command = "timeout -s KILL 60 chromium --headless --no-sandbox --disable-gpu --user-data-dir='" +
                              render.file("browser").string() +
                              "' --virtual-time-budget=4000 --dump-dom http://127.0.0.1:" + std::to_string(port) +
                              "/ >'" + render.file("page.html").string() + "' 2>/dev/null";
  std::string page;
  const auto is_complete = [&] { return contains(page, "data-number=") && contains(page, "<td>camera_rays</td>"); };
  for (int i = 0; i < 10 && !is_complete(); ++i, pause_for(1)) {
    REQUIRE(std::system(command.c_str()) == 0);
    page = read_bytes(render.file("page.html"));
  }
  CHECK(contains(page, "data-state=\"rendering\""));
  CHECK(contains(page, "<span id=\"scene\">scene.xml</span>"));
  CHECK(contains(page, "data-number="));  // an image has loaded
  CHECK(contains(page, "<td>camera_rays</td>"));
  CHECK(render.end(SIGINT) == 130);
}

}  // namespace sheaf::test_preview
