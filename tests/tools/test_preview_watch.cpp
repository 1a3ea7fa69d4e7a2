// sheaf watch: the camera that clients of the page move, and who may move it.
#include "core/image/image.h"
#include "tests/support/near.h"
#include "tests/tools/preview_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <string>

namespace sheaf::test_preview_watch {

using namespace test_preview;

namespace {

std::string post(int port, const std::string& body, const std::string& headers = "Content-Type: application/json\r\n",
                 const std::string& path = "/camera", const std::string& host = "127.0.0.1") {
  return ask(port, "POST " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n" + headers +
                       "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
}

/// Polls the status until it satisfies a condition.
nlohmann::json wait_for(int port, const std::function<bool(const nlohmann::json&)>& condition) {
  for (int i = 0; i < 1200; ++i, pause_for(0.05)) {
    nlohmann::json now = status(port);
    if (now.is_object() && condition(now)) return now;
    get(port, "/image.png");
  }
  return {};
}

bool is_done(const nlohmann::json& now) { return now["state"] == "done"; }

Image image_at(const Render& render, int port, const std::string& path = "/image.png") {
  write_bytes(render.file("seen.png"), body_of(get(port, path)));
  return read_image(render.file("seen.png"));
}

/// kScene with a red wall beside the sphere, named for clicks.
std::string named_scene() {
  std::string scene = kScene;
  const std::string shape = "<shape type=\"sphere\">", bsdf = "<bsdf type=\"diffuse\">";
  scene.replace(scene.find(shape), shape.size(), "<shape type=\"sphere\" id=\"ball\">");
  scene.replace(scene.find(bsdf), bsdf.size(), "<bsdf type=\"diffuse\" id=\"chalk\">");
  return scene;
}

}  // namespace

TEST_CASE("the camera moves while the scene is watched, and returns") {
  Render render("--serve 0 --spp 8", named_scene(), "watch");
  const int port = render.port();
  REQUIRE(port > 0);
  const nlohmann::json first = wait_for(port, is_done);
  REQUIRE(first.is_object());
  CHECK(first["camera"]["moved"] == false);
  CHECK(contains(first["camera"]["mitsuba"].get<std::string>(), "origin=\"0, 0, 5\" target=\"0, 0, 1\""));
  const std::string home = body_of(get(port, "/image.png")), written = read_bytes(render.file("out.exr"));

  // Move away: the answer has the new camera, and an image of all samples follows
  const std::string answer = post(port, R"({"dolly": 1})");
  CHECK(status_of(answer) == 200);
  const auto moved = nlohmann::json::parse(body_of(answer));
  CHECK(moved["moved"] == true);
  CHECK(contains(moved["mitsuba"].get<std::string>(), "origin=\"0, 0, 9\" target=\"0, 0, 1\""));
  CHECK(contains(moved["pbrt"].get<std::string>(), "LookAt 0 0 9 0 0 1 0 1 0"));
  const nlohmann::json second =
      wait_for(port, [&](const auto& now) { return is_done(now) && now["image"] > first["image"]; });
  REQUIRE(second.is_object());
  CHECK(second["run"] == first["run"]);
  CHECK(image_at(render, port).width == 48);
  CHECK(body_of(get(port, "/image.png")) != home);
  CHECK(read_bytes(render.file("out.exr")) == written);

  // A pasted look_at gives the same image
  std::string scene = named_scene();
  const std::size_t begin = scene.find("<transform"), end = scene.find("</transform>") + 12;
  scene.replace(begin, end - begin, moved["mitsuba"].get<std::string>());
  const std::string far = body_of(get(port, "/image.png"));
  write_bytes(render.file("scene.xml"), scene);
  const nlohmann::json third =
      wait_for(port, [&](const auto& now) { return is_done(now) && now["run"] != second["run"]; });
  REQUIRE(third.is_object());
  CHECK(third["camera"]["moved"] == false);
  CHECK(body_of(get(port, "/image.png")) == far);

  // Another material keeps a moved camera
  CHECK(status_of(post(port, R"({"dolly": -1})")) == 200);
  scene.replace(scene.find("0.5\"/></bsdf>"), 3, "0.1");
  write_bytes(render.file("scene.xml"), scene);
  const nlohmann::json fourth =
      wait_for(port, [&](const auto& now) { return is_done(now) && now["run"] != third["run"]; });
  REQUIRE(fourth.is_object());
  CHECK(fourth["camera"]["moved"] == true);
  CHECK(status_of(post(port, R"({"reset": true})")) == 200);
  REQUIRE(wait_for(port, [&](const auto& now) { return is_done(now) && now["image"] > fourth["image"]; }).is_object());
  CHECK(status(port)["camera"]["moved"] == false);
  CHECK(render.end(SIGINT) == 130);
}

TEST_CASE("a click names what a pixel shows, and a target is the point under the pointer") {
  Render render("--serve 0 --spp 8", named_scene(), "watch");
  const int port = render.port();
  REQUIRE(port > 0);
  REQUIRE(wait_for(port, is_done).is_object());
  const auto picked = nlohmann::json::parse(body_of(get(port, "/pick.json?x=0.5&y=0.5")));
  CHECK(picked["object"] == "ball");
  CHECK(picked["material"] == "chalk");
  CHECK(picked["position"][2].get<double>() == near(1, 1e-4));
  CHECK(picked["distance"].get<double>() == near(4, 1e-4));
  CHECK(picked["pixel"] == nlohmann::json({24, 16}));
  CHECK(picked["radiance"][2].get<double>() > picked["radiance"][0].get<double>());
  const auto beside = nlohmann::json::parse(body_of(get(port, "/pick.json?x=0.01&y=0.01")));
  CHECK_FALSE(beside.contains("object"));
  CHECK(beside["radiance"].size() == 3);
  for (const char* query : {"", "?x=0.5", "?x=0.5&y=2", "?x=nan&y=0", "?x=0.5&y=../scene.xml"})
    CHECK(status_of(get(port, "/pick.json" + std::string(query))) == 400);
  const auto target = nlohmann::json::parse(body_of(post(port, R"({"target": [0.6, 0.5]})")));
  CHECK_FALSE(contains(target["mitsuba"].get<std::string>(), "target=\"0, 0, 1\""));
  CHECK(contains(target["mitsuba"].get<std::string>(), "origin=\"0, 0, 5\""));
  CHECK(render.end(SIGINT) == 130);
}

TEST_CASE("each client chooses a layer, an exposure and a tone map") {
  Render render("--serve 0 --spp 8", named_scene(), "watch");
  const int port = render.port();
  REQUIRE(port > 0);
  const nlohmann::json now = wait_for(port, is_done);
  REQUIRE(now.is_object());
  CHECK(now["layers"] == nlohmann::json({"albedo", "normal", "depth"}));
  const Image plain = image_at(render, port), dark = image_at(render, port, "/image.png?exposure=-2"),
              mapped = image_at(render, port, "/image.png?tone_map=agx");
  const auto middle = [](const Image& image, int c) { return double{image.at(24, 16, c)}; };
  CHECK(middle(dark, 2) < 0.7 * middle(plain, 2));
  CHECK(mapped.data != plain.data);
  const Image albedo = image_at(render, port, "/image.png?layer=albedo");
  CHECK(middle(albedo, 0) == near(188 / 255.0, 0.01));  // 0.5, as sRGB
  const Image normal = image_at(render, port, "/image.png?layer=normal");
  CHECK(middle(normal, 2) > 0.97);
  CHECK(middle(normal, 0) == near(0.5, 0.1));
  CHECK(normal.find_channel("A") >= 0);  // nothing lies in the corners
  const Image depth = image_at(render, port, "/image.png?layer=depth");
  CHECK(middle(depth, 0) > 0.9);
  for (const char* query : {"layer=position", "layer=../scene.xml"})
    CHECK(status_of(get(port, "/image.png?" + std::string(query))) == 404);
  for (const char* query : {"exposure=x", "exposure=1e9", "exposure=nan", "tone_map=none2"})
    CHECK(status_of(get(port, "/image.png?" + std::string(query))) == 400);
  const std::string number = now["image"].dump();
  CHECK(status_of(get(port, "/image.png?after=" + number)) == 204);
  CHECK(status_of(get(port, "/image.png?after=0")) == 200);
  CHECK(render.end(SIGINT) == 130);
}

TEST_CASE("only the page itself moves the camera") {
  Render render("--serve 0 --spp 8", kScene, "watch");
  const int port = render.port();
  REQUIRE(port > 0);
  REQUIRE(wait_for(port, is_done).is_object());
  const std::string json = "Content-Type: application/json\r\n", body = R"({"dolly": 1})";
  const std::string here = "127.0.0.1:" + std::to_string(port);
  CHECK(status_of(post(port, body, json + "Origin: http://pages.example\r\n")) == 403);
  CHECK(status_of(post(port, body, json + "Origin: null\r\n")) == 403);
  CHECK(status_of(post(port, body, json + "Origin: https://" + here + "\r\n", "/camera", here)) == 403);
  CHECK(status_of(post(port, body, json + "Origin: http://127.0.0.1:1\r\n", "/camera", here)) == 403);
  CHECK(status_of(post(port, body, json + "Sec-Fetch-Site: cross-site\r\n")) == 403);
  CHECK(status_of(post(port, body, json, "/camera", "pages.example")) == 403);
  for (const char* type : {"", "Content-Type: text/plain\r\n", "Content-Type: application/x-www-form-urlencoded\r\n"})
    CHECK(status_of(post(port, body, type)) == 415);
  for (const char* path : {"/", "/image.png", "/camera/", "/status.json"}) {
    const std::string answer = post(port, body, json, path);
    CHECK(status_of(answer) == 405);
  }
  CHECK(status_of(post(port, "{\"dolly\": \"1\"}")) == 400);
  CHECK(status_of(post(port, std::string(1 << 20, ' '))) == 413);
  const std::string begin = "POST /camera HTTP/1.1\r\nHost: localhost\r\n" + json;
  CHECK(status_of(ask(port, begin + "Transfer-Encoding: chunked\r\n\r\n5\r\nabcde\r\n0\r\n\r\n")) == 411);
  CHECK(status_of(ask(port, begin + "Content-Length: 999999999999999999999999\r\n\r\n")) >= 400);
  CHECK(status(port)["camera"]["number"] == 0);
  // The page's own requests
  CHECK(status_of(post(port, body, json + "Origin: http://" + here + "\r\nSec-Fetch-Site: same-origin\r\n", "/camera",
                       here)) == 200);
  CHECK(status(port)["camera"]["number"] == 1);
  CHECK(render.end(SIGINT) == 130);
}

TEST_CASE("sheaf render serves no camera") {
  Render render("--serve 0" + std::string(kEndless));
  const int port = render.port();
  REQUIRE(port > 0);
  CHECK(status_of(post(port, R"({"dolly": 1})")) == 405);
  CHECK(status_of(get(port, "/pick.json?x=0.5&y=0.5")) == 404);
  CHECK(status(port)["camera"].is_null());
  CHECK(render.end(SIGINT) == 130);
}

TEST_CASE("motions during a render do not wait for it") {
  Render render("--serve 0 " + std::string(kEndless), kScene, "watch");
  const int port = render.port();
  REQUIRE(port > 0);
  REQUIRE(wait_for_image(port, 1).is_object());
  int before = status(port)["image"];
  for (int i = 0; i < 5; ++i) {
    CHECK(status_of(post(port, R"({"orbit": [0.02, 0.01]})")) == 200);
    bool has_image = false;
    for (int k = 0; k < 400 && !has_image; ++k, pause_for(0.01))
      has_image = status_of(get(port, "/image.png?after=" + std::to_string(before))) == 200;
    CHECK(has_image);
    before = status(port)["image"];
  }
  CHECK(render.end(SIGINT) != 0);
}

}  // namespace sheaf::test_preview_watch
