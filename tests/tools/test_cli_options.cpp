// Notation of options: units, percentages, values out of range, unknown names; and the streams of messages.
#include "core/image/exr.h"
#include "tests/support/capture.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <cctype>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

namespace sheaf::test_cli_options {

using test::kScene;

namespace {

/// A folder with the scene, and properties of its renders.
struct Workplace {
  Workplace() { write_bytes(folder / "scene.xml", kScene); }
  Outcome render(const std::string& options, const std::string& before = "") const {
    return run(folder, "render scene.xml --no-timestamps --spp 1 -o out.exr " + options, before);
  }
  std::string attribute(const std::string& name, const std::string& file = "out.exr") const {
    for (const ExrMetadata::Attribute& each : read_exr_attributes(folder / file))
      if (each.name == name) {
        std::ostringstream text;
        std::visit([&](const auto& value) { text << value; }, each.value);
        return text.str();
      }
    return "";
  }
  TemporaryFolder folder;
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

TEST_CASE("options: integers may be written as floats of integral value") {
  const Workplace workplace;
  for (const char* const spp : {"16", "16.0", "1.6e1", "016"}) {
    CAPTURE(std::string(spp));
    REQUIRE(run(workplace.folder, "render scene.xml --quiet -o out.exr --spp " + std::string(spp)).code == 0);
    CHECK(workplace.attribute("sheaf/samplesPerPixel") == "16");
  }
  for (const auto& [options, message] : {std::pair{"--spp 16.5", "--spp: '16.5' is not an integer"},
                                         {"--spp many", "--spp: 'many' is not a number"},
                                         {"--spp 0x10", "'0x10' is not a number"},
                                         {"--spp 1e400", "'1e400' is not a number"},
                                         {"--spp 16s", "'16s' is not a number"},
                                         {"--spp 1e12", "not in range 1 to 16777216"},
                                         {"--threads 1e30", "'1e30' is too large"},
                                         {"--seed 4294967296", "not in range 0 to 4294967295"},
                                         {"--crop 0,0,99999999999,4", "--crop"},
                                         {"--crop 0,0,4.5,4", "'4.5' is not an integer"},
                                         {"--noise-target 2x", "'2x' is not a number"},
                                         {"--size 99999999999x4", "--size 99999999999x4: expected WxH"}}) {
    CAPTURE_BINDING(options);
    const Outcome outcome = workplace.render(options);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, message));
    CHECK(lines_of(outcome.err).size() == 1);
  }
}

TEST_CASE("options: times have units and shares may be percentages") {
  const Workplace workplace;
  REQUIRE(run(workplace.folder, "render scene.xml --quiet -o out.exr --noise-target 40%").code == 0);
  CHECK(workplace.attribute("sheaf/noiseTarget") == "0.4");
  REQUIRE(run(workplace.folder, "render scene.xml --quiet -o out.exr --noise-target 0.4").code == 0);
  CHECK(workplace.attribute("sheaf/noiseTarget") == "0.4");
  REQUIRE(workplace.render("--quiet --scale 50%").code == 0);
  CHECK(read_exr(workplace.folder / "out.exr").width == 12);
  // With wrong units, these would take long or end before they begin.
  for (const char* const limit : {"100ms", "0.1s", "0.001m", "1e-3min", "0.00003h", "0.000001d", "0h0.1s", "0.1"}) {
    CAPTURE(std::string(limit));
    const Outcome outcome =
        run(workplace.folder, "render scene.xml --quiet -o out.exr --time-limit " + std::string(limit), "timeout 20 ");
    CHECK(outcome.code == 0);
  }
  for (const char* const limit : {"5x", "m", "5m5", "5 m", "1h-3m", "-5m", "0s", "nan"}) {
    CAPTURE(std::string(limit));
    const Outcome outcome =
        run(workplace.folder, "render scene.xml -o out.exr --time-limit '" + std::string(limit) + "'");
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "--time-limit"));
  }
}

TEST_CASE("options: candidates are a number or chosen, and a scene's number stays unless auto is given") {
  const Workplace workplace;
  const auto candidates = [&](const std::string& words) {
    REQUIRE(run(workplace.folder, "render scene.xml --size 128x128 --spp 16 -o a.exr --stats a.json " + words).code ==
            0);
    return nlohmann::json::parse(read_bytes(workplace.folder / "a.json"))["candidates"];
  };
  for (const std::string words : {"", "--candidates auto", "--integrator path_ris --candidates auto"}) {
    CAPTURE(words);
    CHECK(candidates(words)["gains"].size() == 4);
  }
  CHECK(candidates("--candidates 3")["count"] == 3);
  CHECK(candidates("--candidates 3")["gains"].empty());
  CHECK(candidates("--integrator path_ris")["count"] == 8);
  CHECK(candidates("--guiding off")["gains"].empty());
  for (const std::string bad : {"0", "1025", "many", "2x"}) {
    CAPTURE(bad);
    const Outcome outcome = run(workplace.folder, "render scene.xml -o a.exr --candidates " + bad);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "expected auto or a number from 1 to 1024"));
  }
}

TEST_CASE("options: guiding has a value, or none and means on") {
  const Workplace workplace;
  const auto mode = [&](const std::string& words) {
    const Outcome outcome = run(workplace.folder, "render --spp 16 --quiet --stats a.json " + words);
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    return nlohmann::json::parse(read_bytes(workplace.folder / "a.json"))["guiding"];
  };
  for (const std::string words : {"--guiding on scene.xml -o out.exr", "--guiding scene.xml -o out.exr",
                                  "scene.xml --guiding -o out.exr", "scene.xml -o out.exr --guiding=on"}) {
    CAPTURE(words);
    const nlohmann::json guiding = mode(words);
    CHECK(guiding["used"] == true);
    CHECK(guiding["gain"].is_null());
  }
  CHECK(mode("scene.xml --size 128x128 -o out.exr --guiding auto")["gain"].is_number());
  CHECK(mode("scene.xml --size 128x128 -o out.exr --guiding off")["passes"] == 0);
  const Outcome unknown = run(workplace.folder, "render scene.xml --guiding=maybe -o out.exr");
  CHECK(unknown.code == 2);
  CHECK(contains(unknown.err, "maybe"));
}

TEST_CASE("options: caustics are found by BSDF sampling or by manifold next-event estimation") {
  const Workplace workplace;
  const auto attempts = [&](const std::string& words) {
    const Outcome outcome = run(workplace.folder, "render scene.xml -o out.exr --quiet --stats a.json " + words);
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    return nlohmann::json::parse(read_bytes(workplace.folder / "a.json"))["caustics"]["attempts"].get<int>();
  };
  // Nothing in the scene casts caustics.
  for (const char* words : {"", "--caustics none", "--caustics mnee"}) CHECK(attempts(words) == 0);
  const Outcome unknown = run(workplace.folder, "render scene.xml --caustics photons -o out.exr");
  CHECK(unknown.code == 2);
  CHECK(contains(unknown.err, "photons"));
  const Outcome without_lights =
      run(workplace.folder, "render scene.xml --caustics mnee --integrator path_mats -o out.exr");
  CHECK(without_lights.code == 2);
  CHECK(contains(without_lights.err, "samples lights"));
}

TEST_CASE("options: frames beyond the limits are rejected") {
  const Workplace workplace;
  for (const auto& [options, message] :
       {std::pair{"--scale 119304648", "--scale 1.19305e+08 gives a frame of 2.86331e+09 x 1.90887e+09 pixels"},
        {"--scale 1e30", "expected at most 1000000000 per side"},
        {"--size 1000000x1000000 --scale 2148", "expected at most 1000000000"},
        {"--scale 2e7", "too large (expected at most 2^31 pixels"},
        {"--size 1000000x1000000", "too large (expected at most 2^31 pixels"},
        {"--size 1000001x1", "each from 1 to 1000000"},
        {"--crop -2147483648,0,2147483647,16", "reaches beyond the frame"},
        {"--crop 0,0,2147483647,2147483647", "reaches beyond the frame"},
        {"--samples 4294967295:4294967295", "4294967295:4294967295"},
        {"--view nan,10", "--view"}}) {
    CAPTURE_BINDING(options);
    const Outcome outcome = workplace.render(options);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, message));
  }
  CHECK(workplace.folder.entry_count() == 1);
  // A scene with the largest possible frame.
  std::string scene = kScene;
  scene.replace(scene.find("value=\"16\""), 10, "value=\"1\"");
  write_bytes(workplace.folder / "scene.xml", scene);
  const Outcome wide = run(workplace.folder, "farm scene.xml --parts 1000 --tiles -- -D size=1000000000");
  CHECK(wide.code == 2);
  CHECK(contains(wide.err, "1 pixel rows cannot be split into 1000 parts"));
  scene = kScene;
  scene.replace(scene.find("value=\"16\""), 10, "value=\"$size\"");
  scene.replace(scene.find("value=\"$size\""), 13, "value=\"1\"");
  write_bytes(workplace.folder / "scene.xml", scene);
  REQUIRE(run(workplace.folder, "farm scene.xml --parts 1000 --tiles --quiet -- -D size=1000000000").code == 0);
  const std::string script = read_bytes(workplace.folder / "scene_farm/render.sh");
  CHECK(contains(script, "0,999000000,1,1000000000"));
  CHECK_FALSE(contains(script, ",-"));
}

TEST_CASE("options: every message is one line that begins with the program name") {
  const Workplace workplace;
  for (const char* const arguments :
       {"", "paint", "--quiet", "--quiet render", "render", "render scene.xml --no-such-option",
        "render scene.xml --spp 0", "render scene.xml --color cmyk", "render scene.xml --crop 1,2,3",
        "render scene.xml other.xml", "compare a.exr", "merge", "info", "denoise", "farm scene.xml",
        "render nowhere.xml", "render scene.xml --env 1"}) {
    CAPTURE(std::string(arguments));
    const Outcome outcome = run(workplace.folder, arguments);
    CHECK((outcome.code == 2 || outcome.code == 3));
    const std::vector<std::string> lines = lines_of(outcome.err);
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].starts_with("sheaf: "));
  }
}

TEST_CASE("options: misplaced options name their command and only similar names are suggested") {
  const Workplace workplace;
  for (const char* const arguments : {"--quiet render scene.xml", "--quiet", "--quiet=1 render"}) {
    CAPTURE(std::string(arguments));
    CHECK(contains(run(workplace.folder, arguments).err, "' must follow its command: sheaf "));
  }
  CHECK(contains(run(workplace.folder, "--quiet render scene.xml").err,
                 "option '--quiet' must follow its command: sheaf render --quiet"));
  CHECK(contains(run(workplace.folder, "--qiet render scene.xml").err, "unknown option '--qiet'"));
  for (const char* const option : {"--zap", "--fast", "--gpu", "--bounces", "--frobnicate"}) {
    CAPTURE(std::string(option));
    const Outcome outcome = workplace.render(option);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "unknown option '" + std::string(option) + "'"));
    CHECK_FALSE(contains(outcome.err, "did you mean"));
  }
  CHECK(contains(workplace.render("--noise 1").err, "did you mean '--noise-target'?"));
  CHECK(contains(workplace.render("--sedd 1").err, "did you mean '--seed'?"));
}

TEST_CASE("options: replaced integrators and samplers are noted") {
  const Workplace workplace;
  for (const auto& [options, note] :
       {std::pair{"--integrator vpl", "integrator 'vpl' is rendered with 'path', which has the same expectation"},
        {"--integrator randomwalk", "integrator 'randomwalk' is rendered with 'path'"},
        {"--integrator direct_projective", "integrator 'direct_projective' is rendered with 'direct'"},
        {"--sampler halton", "sampler 'halton' is rendered with 'sobol'"},
        {"--sampler pmj02bn", "sampler 'pmj02bn' is rendered with 'sobol'"},
        {"--sampler ldsampler", "sampler 'ldsampler' is rendered with 'sobol'"}}) {
    CAPTURE_BINDING(options);
    const Outcome outcome = workplace.render(options);
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.err, note));
  }
  CHECK_FALSE(contains(workplace.render("--integrator path_mats --sampler sobol").err, "is rendered with"));
}

TEST_CASE("options: unsupported integrators are errors unless --lenient is given") {
  const Workplace workplace;
  for (const char* const name : {"bdpt", "mlt", "vcm"}) {
    CAPTURE(std::string(name));
    const std::string option = std::string("--integrator ") + name;
    const Outcome outcome = workplace.render(option);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "integrator '" + std::string(name) +
                                    "' is not supported; --caustics mnee or --integrator sppm render caustics with "
                                    "less noise; 'path' has the same expectation (--lenient uses it)"));
    const Outcome lenient = workplace.render(option + " --lenient --quiet");
    CHECK(lenient.code == 0);
    CHECK(contains(lenient.err, "warning: integrator '" + std::string(name) + "' is not supported: rendered with"));
  }
}

TEST_CASE("options: layers that no output can hold are rejected") {
  const Workplace workplace;
  for (const char* const options : {"--aov depth", "--light-groups", "--color spectral --spectral-bins 4"}) {
    CAPTURE(std::string(options));
    const Outcome outcome = run(workplace.folder, "render scene.xml --spp 1 -o out.png " + std::string(options));
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "layers, which only .exr files can store: add -o out.exr"));
    CHECK(
        run(workplace.folder, "render scene.xml --spp 1 --quiet -o out.png -o out.exr " + std::string(options)).code ==
        0);
    std::filesystem::remove(workplace.folder / "out.png");
  }
}

TEST_CASE("options: an unwritable standard output has exit code 4") {
  const Workplace workplace;
  REQUIRE(workplace.render("--quiet").code == 0);
  for (const char* const arguments :
       {"info scene.xml", "info scene.xml --json", "info out.exr", "info --formats --json", "compare out.exr out.exr",
        "--help", "help render", "--version", "--version -v", "completion bash", "render --help",
        "render scene.xml -q -o -"}) {
    CAPTURE(std::string(arguments));
    for (const char* const stream : {" >/dev/full", " >&-"}) {
      CAPTURE(std::string(stream));
      // A shell of its own, whose standard output is the one of run().
      const Outcome outcome = run(workplace.folder, "--version",
                                  SHEAF_EXECUTABLE " " + std::string(arguments) + stream + " 2>said.txt; exit $?; ");
      CHECK(outcome.code == 4);
      const std::vector<std::string> lines = lines_of(read_bytes(workplace.folder / "said.txt"));
      REQUIRE(lines.size() == 1);
      CHECK(contains(lines[0], "sheaf: cannot write "));
      CHECK(contains(lines[0], " to the standard output: "));
    }
  }
  // A command without output needs no standard output, and its messages go nowhere else.
  const Outcome silent = run(workplace.folder, "--version",
                             SHEAF_EXECUTABLE
                             " render scene.xml -o b.exr --no-timestamps --spp 1 >&- 2>&- <&-; "
                             "exit $?; ");
  CHECK(silent.code == 0);
  CHECK(read_bytes(workplace.folder / "b.exr") == read_bytes(workplace.folder / "out.exr"));
}

namespace {

/// Each option that changes the image, with a value that is not the standard.
const std::vector<std::pair<std::string, std::string>> kChanges = {{"seed", "7"},
                                                                   {"color", "spectral"},
                                                                   {"spectral-bins", "4"},
                                                                   {"integrator", "direct"},
                                                                   {"sampler", "stratified"},
                                                                   {"filter-mode", "importance"},
                                                                   {"replicates", "2"},
                                                                   {"light-sampler", "uniform"},
                                                                   {"candidates", "2"},
                                                                   {"guiding", "on"},
                                                                   {"caustics", "mnee"},
                                                                   {"clamp-indirect", "2"},
                                                                   {"medium-estimator", "delta"},
                                                                   {"step-size", "0.1"},
                                                                   {"max-depth", "3"},
                                                                   {"rr-depth", "3"},
                                                                   {"crop", "0,0,4,4"},
                                                                   {"samples", "0:2"},
                                                                   {"size", "8x8"},
                                                                   {"scale", "0.5"},
                                                                   {"define", "size=8"},
                                                                   {"aov", "depth"},
                                                                   {"light-groups", ""},
                                                                   {"denoise", "nlm"},
                                                                   {"watertight", ""},
                                                                   {"noise-target", "0.5"},
                                                                   {"shutter", "0:1"},
                                                                   {"lenient", ""},
                                                                   {"nori-camera", "upstream"},
                                                                   {"float", ""},
                                                                   {"spp", ""},
                                                                   {"view", ""},
                                                                   {"up", ""},
                                                                   {"fov", ""},
                                                                   {"env", ""},
                                                                   {"no-floor", ""},
                                                                   {"studio", ""},
                                                                   {"camera", ""},
                                                                   {"time", ""},
                                                                   {"animation", ""},
                                                                   {"frames", ""},
                                                                   {"fps", ""},
                                                                   {"skip-existing", ""}};

/// Options of the run, with which the same image comes out.
const std::vector<std::pair<std::string, std::string>> kRuns = {
    {"threads", "1"},    {"wave-size", "256"},   {"no-timestamps", ""},  {"stats", "s.json"}, {"checkpoint-every", "5"},
    {"output", "b.exr"}, {"time-limit", ""},     {"quiet", ""},          {"resume", ""},      {"checkpoint", ""},
    {"format", "exr"},   {"verbose", ""},        {"version", ""},        {"serve", ""},       {"tev", ""},
    {"help", ""},        {"exposure", "-1"},     {"tone-map", "agx"},    {"ocio-config", ""}, {"ocio-display", ""},
    {"ocio-view", ""},   {"compression", "piz"}, {"jpeg-quality", "90"}, {"bvh", "compact"}};

}  // namespace

TEST_CASE("options: --shutter takes two times and a ramp") {
  const Workplace workplace;
  for (const char* const shutter : {"0:0", "0:0.02", "1:2:0.5", "1e-3:2e-3:0"}) {
    CAPTURE(std::string(shutter));
    CHECK(workplace.render("--quiet --shutter " + std::string(shutter)).code == 0);
  }
  CHECK(workplace.render("--quiet --shutter=-1:1").code == 0);
  for (const auto& [shutter, message] : {std::pair{"1", "expected OPEN:CLOSE or OPEN:CLOSE:RAMP"},
                                         {"0:", "expected OPEN:CLOSE"},
                                         {"0:1:", "expected OPEN:CLOSE"},
                                         {"0:1:0.1:2", "expected OPEN:CLOSE"},
                                         {"0:inf", "expected OPEN:CLOSE"},
                                         {"0:1e39", "expected OPEN:CLOSE"},
                                         {"0:1s", "expected OPEN:CLOSE"},
                                         {"2:1", "expected a shutter that does not close before it opens"},
                                         {"0:1:0.6", "expected a ramp from 0 to 0.5"},
                                         {"0:1:nan", "expected OPEN:CLOSE"}}) {
    const Outcome outcome = workplace.render("--shutter '" + std::string(shutter) + "'");
    CAPTURE(outcome.err);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "--shutter '" + std::string(shutter) + "': " + message));
  }
  write_bytes(workplace.folder / "model.stl", "");
  CHECK(contains(run(workplace.folder, "render model.stl --shutter 0:1").err, "--shutter applies to scenes"));
}

TEST_CASE("options: a checkpoint of other settings is refused with the values of both") {
  const Workplace workplace;
  const auto resume = [&](const std::string& options) {
    const Outcome outcome =
        run(workplace.folder, "render scene.xml --quiet -o out.exr --checkpoint a.state --resume " + options);
    CHECK(outcome.code == 5);
    return outcome.err;
  };
  REQUIRE(run(workplace.folder,
              "render scene.xml --quiet --spp 64 --seed 2 -D size=9 --lenient -o out.exr --checkpoint a.state")
              .code == 0);
  const std::string same = "--lenient -D size=9 --seed 2 ";
  CHECK(contains(resume("--spp 64 --lenient --seed 3 -D size=10"),
                 "a.state: is a checkpoint of another render: --seed 2 in the checkpoint, 3 now; "
                 "--define size=9 in the checkpoint, size=10 now\n"));
  CHECK(contains(resume("--spp 64 -D size=9"),
                 "--seed 2 in the checkpoint, not now; --lenient in the checkpoint, not now\n"));
  CHECK(contains(resume(same + "--spp 32"), "a.state: cannot be continued: --spp 64 in the checkpoint, 32 now"));
  CHECK(contains(resume(same), "--spp 64 in the checkpoint, 16 now"));
  CHECK(contains(resume(same + "--spp 64 --time-limit 9"), "--time-limit now, not in the checkpoint"));
  write_bytes(workplace.folder / "scene.xml", read_bytes(workplace.folder / "scene.xml") + "\n");
  CHECK(contains(resume(same + "--spp 64"), "scene.xml has changed ('"));
  write_bytes(workplace.folder / "a.state", "P6 8 8 255\n");
  CHECK(contains(resume(same + "--spp 64"), "a.state: is not a sheaf checkpoint"));
}

TEST_CASE("options: a render resumes from its checkpoint only with its original options") {
  const Workplace workplace;
  write_bytes(workplace.folder / "other.exr", "");
  const std::string common = "render scene.xml --spp 4 --quiet ";
  REQUIRE(run(workplace.folder, common + "-o out.exr --checkpoint a.state").code == 0);
  const auto resume = [&](const std::string& options) {
    return run(workplace.folder, common + "--checkpoint a.state --resume " + options);
  };
  std::set<std::string> known;
  for (const auto& [name, value] : kChanges) {
    CAPTURE_BINDING(name);
    known.insert(name);
    // Options that need others or do not apply to scenes.
    const std::set<std::string> elsewhere = {"spp",    "view", "up",        "fov",    "env", "no-floor",     "studio",
                                             "camera", "time", "animation", "frames", "fps", "skip-existing"};
    if (elsewhere.contains(name)) continue;
    const std::string also = name == "spectral-bins" ? " --color spectral" : "";
    const Outcome outcome = resume("-o out.exr --" + name + " " + value + also);
    CHECK(outcome.code == 5);
    const std::string given = "--" + name + (value.empty() ? "" : " " + value);
    CAPTURE(outcome.err);
    CHECK(contains(outcome.err, given + " now, not in the checkpoint"));
  }
  CHECK(run(workplace.folder, "render scene.xml --spp 3 --quiet -o out.exr --checkpoint a.state --resume").code == 5);
  for (const auto& [name, value] : kRuns) {
    CAPTURE_BINDING(name);
    known.insert(name);
    if (value.empty() && name != "no-timestamps") continue;
    CHECK(resume((name == "output" ? "" : "-o out.exr ") + ("--" + name) + " " + value).code == 0);
  }
  // Every option is in one of the two lists.
  std::istringstream help(run(workplace.folder, "render --help").out);
  for (std::string word; help >> word;) {
    const std::size_t at = word.find("--");
    if (at == word.npos || (at > 0 && word[at - 1] != ',')) continue;
    std::string name = word.substr(at + 2);
    while (!name.empty() && std::isalnum(static_cast<unsigned char>(name.back())) == 0) name.pop_back();
    if (name.empty()) continue;
    CAPTURE_BINDING(name);
    CHECK(known.count(name) == 1);
  }
}

}  // namespace sheaf::test_cli_options
