// The preview page in a browser: gestures of mouse and fingers, two browsers at once, errors, and a program that starts
// again. Skipped without chromium.
#include "tests/tools/browser_testing.h"
#include "tests/tools/preview_testing.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <optional>
#include <string>

namespace sheaf::test_preview_browser {

using namespace test_preview;

namespace {

constexpr const char* kHasImage = "document.getElementById('image').dataset.number";
constexpr const char* kLookAt = "document.getElementById('look_at').value";
constexpr const char* kMoved = "document.body.dataset.moved === 'true'";

bool is_skipped() {
  if (has_browser()) return false;
  std::puts("skipped: chromium is missing (Debian package chromium)");
  return true;
}

/// A watched scene, and a browser with its image.
struct Watched {
  explicit Watched(int width = 1440, int height = 900, bool has_touch = false)
      : render("--serve 0 --spp 8", kScene, "watch"), browser(width, height, has_touch), port(render.port()) {
    browser.open(port);
    REQUIRE(browser.wait_for(std::string(kHasImage) + " && document.body.dataset.camera !== undefined"));
    x = 0.5 * width;
    y = 0.5 * height;
  }

  /// The text of the camera after a gesture that changes it from `before`, when all motions have been sent.
  std::string changed_from(const std::string& before) {
    REQUIRE(browser.wait_for(std::string(kLookAt) + " !== " + nlohmann::json(before).dump() +
                             " && !sending && Object.keys(motion).length === 0"));
    return browser.value(kLookAt);
  }

  Render render;
  Browser browser;
  int port;
  double x, y;  ///< the middle of the page
};

}  // namespace

TEST_CASE("the mouse orbits, pans, dollies and sets the target, and R returns") {
  if (is_skipped()) return;
  Watched watched;
  Browser& browser = watched.browser;
  const std::string home = browser.value(kLookAt);
  CHECK(contains(home, "origin=\"0, 0, 5\""));
  // The image fills the page
  CHECK(browser.value("document.getElementById('image').getBoundingClientRect().height") > 700);
  const int number = std::stoi(browser.value(kHasImage).get<std::string>());
  browser.drag(watched.x, watched.y, 120, 40);
  std::string text = watched.changed_from(home);
  CHECK(contains(text, "target=\"0, 0, 1\""));
  CHECK(browser.wait_for("Number(" + std::string(kHasImage) + ") > " + std::to_string(number)));
  // The image of all samples follows when the hand rests
  CHECK(browser.wait_for(
      "document.body.dataset.state === 'done' && document.getElementById('image').naturalWidth === 48"));
  browser.key("r");
  CHECK(watched.changed_from(text) == home);
  CHECK(browser.wait_for("document.body.dataset.moved === 'false'"));
  browser.drag(watched.x, watched.y, 100, 0, 8);
  text = watched.changed_from(home);
  CHECK_FALSE(contains(text, "target=\"0, 0, 1\""));
  browser.key("r");
  REQUIRE(watched.changed_from(text) == home);
  browser.wheel(watched.x, watched.y, 500);
  text = watched.changed_from(home);
  CHECK(contains(text, "origin=\"0, 0, 9\" target=\"0, 0, 1\""));
  browser.key("r");
  REQUIRE(watched.changed_from(text) == home);
  // A click names the object, two set the target
  browser.click(watched.x, watched.y);
  CHECK(browser.wait_for("/^object +sphere/.test(document.getElementById('pick').textContent)"));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  browser.click(watched.x + 60, watched.y);
  browser.click(watched.x + 60, watched.y);
  text = watched.changed_from(home);
  CHECK(contains(text, "origin=\"0, 0, 5\""));
  CHECK_FALSE(contains(text, "target=\"0, 0, 1\""));
  // pbrt's text, and the copy
  browser.value("(d => { d.value = 'pbrt'; d.onchange(); })(document.getElementById('dialect'))");
  CHECK(contains(browser.value(kLookAt).get<std::string>(), "LookAt 0 0 5"));
  browser.value("document.getElementById('copy').click()");
  CHECK(browser.wait_for("document.getElementById('copy').textContent === 'copied'"));
  CHECK(watched.render.end(SIGINT) != 0);
}

TEST_CASE("on a phone, one finger orbits and two pinch and pan") {
  if (is_skipped()) return;
  Watched watched(390, 844, true);
  Browser& browser = watched.browser;
  const std::string home = browser.value(kLookAt);
  CHECK(browser.value("document.documentElement.scrollWidth") <= 390);
  CHECK(browser.value("document.getElementById('image').getBoundingClientRect().width") > 380);
  CHECK(browser.value("Math.min(...[...document.querySelectorAll('footer button:not([hidden]), footer select')]"
                      ".map(e => e.getBoundingClientRect().height))") >= 40);
  browser.touch("touchStart", {{195, 350}});
  for (int i = 1; i <= 4; ++i) browser.touch("touchMove", {{195.0 + 15 * i, 350}});
  browser.touch("touchEnd", {});
  std::string text = watched.changed_from(home);
  CHECK(contains(text, "target=\"0, 0, 1\""));
  CHECK(browser.wait_for(kMoved));
  // Apart: nearer
  browser.value("document.getElementById('reset').click()");
  REQUIRE(watched.changed_from(text) == home);
  browser.touch("touchStart", {{175, 350}});
  browser.touch("touchStart", {{175, 350}, {215, 350}});
  for (int i = 1; i <= 4; ++i) browser.touch("touchMove", {{175.0 - 5 * i, 350}, {215.0 + 5 * i, 350}});
  browser.touch("touchEnd", {});
  REQUIRE(browser.wait_for("(/origin=\"[^,]*, [^,]*, ([0-9.]*)\"/.exec(" + std::string(kLookAt) + ") || [])[1] < 3.2"));
  CHECK(watched.render.end(SIGINT) != 0);
}

TEST_CASE("two browsers move the same camera") {
  if (is_skipped()) return;
  Watched watched;
  Browser other(800, 600);
  other.open(watched.port);
  REQUIRE(other.wait_for(std::string(kHasImage) + " && document.body.dataset.camera !== undefined"));
  const std::string home = watched.browser.value(kLookAt);
  watched.browser.drag(watched.x, watched.y, 80, 0);
  const std::string first = watched.changed_from(home);
  REQUIRE(other.wait_for(kMoved));
  other.wheel(400, 300, -200);
  const std::string both = watched.changed_from(first);
  CHECK(other.wait_for(std::string(kLookAt) + " === " + nlohmann::json(both).dump()));
  for (Browser* browser : {&watched.browser, &other})
    CHECK(
        browser->wait_for("document.getElementById('image').naturalWidth === 48 && "
                          "document.body.dataset.state === 'done'"));
  CHECK(watched.render.end(SIGINT) != 0);
}

TEST_CASE("errors of the scene stand over the image, and a program that starts again is found") {
  if (is_skipped()) return;
  std::optional<Watched> watched(std::in_place);
  Browser& browser = watched->browser;
  const int port = watched->port;
  write_bytes(watched->render.file("scene.xml"), "<scene version='3.0.0'>\n<shape type='spere'/>\n</scene>");
  REQUIRE(browser.wait_for("!document.getElementById('errors').hidden"));
  const std::string text = browser.value("document.getElementById('errors').textContent");
  CHECK(contains(text, "scene.xml:2: "));
  CHECK(contains(text, "spere"));
  CHECK(browser.value("document.querySelector('#errors b').textContent") == "scene.xml:2: ");
  CHECK(browser.value("getComputedStyle(document.getElementById('errors')).color") == "rgb(255, 138, 128)");
  write_bytes(watched->render.file("scene.xml"), kScene);
  REQUIRE(browser.wait_for("document.getElementById('errors').hidden && document.body.dataset.state === 'done'"));
  // The program ends and starts again at the same port
  CHECK(watched->render.end(SIGINT) != 0);
  REQUIRE(browser.wait_for("/does not answer/.test(document.getElementById('note').textContent)"));
  const std::string run = browser.value("run");
  Render again("--spp 8 --serve " + std::to_string(port), kScene, "watch");
  REQUIRE(browser.wait_for("run !== " + nlohmann::json(run).dump()));
  CHECK(browser.wait_for("!/does not answer/.test(document.getElementById('note').textContent)"));
  const std::string home = browser.value(kLookAt);
  browser.drag(watched->x, watched->y, 80, 0);
  CHECK(watched->changed_from(home) != home);
  CHECK(browser.wait_for(
      "document.body.dataset.state === 'done' && document.getElementById('image').naturalWidth === 48"));
  CHECK(again.end(SIGINT) != 0);
}

}  // namespace sheaf::test_preview_browser
