// Unsupported, empty and malformed files for every command that reads a file.
#include "core/image/exr.h"
#include "core/image/image.h"
#include "core/io/version.h"
#include "scene/formats/model_formats.h"
#include "scene/formats/model_import.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <vector>

namespace sheaf::test_cli_formats {

namespace {

using namespace std::string_literals;

/// A command that reads a scene or an image, with FILE as placeholder, and the expected files in its message.
struct Reader {
  const char* arguments;
  const char* expected;
};
constexpr Reader kSceneReaders[] = {
    {"render FILE --quiet -o out.exr",
     "expected a scene of Mitsuba or Nori (.xml) or of pbrt (.pbrt, .pbrt.gz), or a model"},
    {"render FILE --lenient --quiet -o out.exr", "expected a scene of Mitsuba or Nori"},
    {"info FILE", "expected a scene of Mitsuba or Nori"},
    {"farm FILE --parts 2 --quiet", "expected a scene of Mitsuba or Nori"}};
constexpr Reader kImageReaders[] = {{"denoise FILE --quiet -o out.exr", "expected an OpenEXR image"},
                                    {"merge FILE --quiet -o out.exr", "expected an OpenEXR image"},
                                    {"compare FILE FILE", "expected an image"},
                                    {"compare image.exr FILE", "expected an image"},
                                    {"compare image.exr image.exr --variance-a FILE", "expected an image"}};

std::string with_file(const Reader& reader, const std::string& file) {
  std::string arguments = reader.arguments;
  for (std::size_t at = arguments.find("FILE"); at != arguments.npos; at = arguments.find("FILE", at))
    arguments.replace(at, 4, file);
  return arguments;
}

/// Files of other programs: their first bytes, and the name in messages.
struct Foreign {
  const char* name;
  std::string bytes;
  const char* told;
  const char* remedy;
};
const std::vector<Foreign>& foreign_files() {
  static const std::vector<Foreign> files = {{"a.usd", "PXR-USDC\0\x08"s, "a USD scene", "Blender"},
                                             {"a.usda", "#usda 1.0\n", "a USD scene", "Blender"},
                                             {"a.usdc", "PXR-USDC\0\x08"s, "a USD scene", "Blender"},
                                             {"a.usdz", "PK\x03\x04\0"s, "a USD scene", "Blender"},
                                             {"a.ma", "//Maya ASCII 2024 scene", "a Maya scene", "Blender"},
                                             {"a.x3d", "<?xml version='1.0'?><X3D/>", "an X3D scene", "Blender"},
                                             {"a.blend", "BLENDER-v404", "a Blender file", "Blender"},
                                             {"a.abc", "Ogawa\xff\0"s, "an Alembic file", "Blender"},
                                             {"a.vdb", " BDV\0\0\0\0\xe0"s, "an OpenVDB file", "use it in a scene"},
                                             {"a.nvdb", "NanoVDB2", "a NanoVDB file", "use it in a scene"},
                                             {"a.mtl", "newmtl x\n", "a material library", "use it in a scene"},
                                             {"a.zip", "PK\x03\x04\0"s, "a ZIP archive", "unpack"}};
  return files;
}

struct Workplace {
  Workplace() {
    write_bytes(folder / "scene.xml", test::kScene);
    write_exr(folder / "image.exr", Image(4, 4, {"R", "G", "B"}));
    write_png(folder / "image.png", Image(4, 4, {"R", "G", "B"}));
  }
  /// Checks for a message in one line that begins with the names of the program and of the file.
  void check_refused(const std::string& arguments, const std::string& file, const std::string& expected) const {
    CAPTURE(arguments);
    const Outcome outcome = run(folder, arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.code == 3);
    CHECK(outcome.err.starts_with("sheaf: " + file));
    CHECK(contains(outcome.err, expected));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    CHECK_FALSE(std::filesystem::exists(folder / "out.exr"));
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("formats: foreign files are errors that name the format and how to convert it") {
  const Workplace workplace;
  for (const Foreign& foreign : foreign_files()) {
    const std::string file = foreign.name, told = std::string(": is ") + foreign.told + ", ";
    write_bytes(workplace.folder / file, foreign.bytes);
    workplace.check_refused(with_file(kSceneReaders[0], file), file, told);
    workplace.check_refused(with_file(kSceneReaders[0], file), file, foreign.remedy);
  }
  // Every command with one file of each kind, also under another name, and damaged.
  write_bytes(workplace.folder / "model.xml", foreign_files()[0].bytes);
  write_bytes(workplace.folder / "broken.ma", "nothing of the kind");
  for (const char* const file : {"a.ma", "a.vdb", "a.nvdb", "a.zip", "model.xml", "broken.ma"}) {
    for (const Reader& reader : kSceneReaders) workplace.check_refused(with_file(reader, file), file, reader.expected);
    for (const Reader& reader : kImageReaders) workplace.check_refused(with_file(reader, file), file, reader.expected);
  }
}

TEST_CASE("formats: images are rejected as scenes and images without layers are not denoised or merged") {
  const Workplace workplace;
  for (const char* const file : {"image.png", "image.exr"})
    for (const Reader& reader : kSceneReaders)
      if (!std::string(reader.arguments).starts_with("info") || std::string(file) == "image.png")
        workplace.check_refused(with_file(reader, file), file, "image, expected a scene of Mitsuba or Nori");
  for (const Reader& reader : {kImageReaders[0], kImageReaders[1]})
    workplace.check_refused(
        with_file(reader, "image.png"), "image.png",
        "is a PNG image, expected an OpenEXR image, as written by 'sheaf render -o NAME.exr'; other "
        "formats lack the required layers");
  // Scenes are not images.
  for (const Reader& reader : {kImageReaders[0], kImageReaders[1]})
    workplace.check_refused(with_file(reader, "scene.xml"), "scene.xml",
                            "has an unknown format, expected an OpenEXR image");
}

TEST_CASE("formats: empty and malformed files are errors") {
  const Workplace workplace;
  for (const char* const file : {"e.xml", "e.pbrt", "e.obj", "e.ply", "e.serialized", "e.exr", "e.png", "e.ma", "e"}) {
    CAPTURE(std::string(file));
    write_bytes(workplace.folder / file, "");
    for (const Reader& reader : kSceneReaders) {
      const bool is_image = std::string(reader.arguments).starts_with("info") && std::string(file) == "e.exr";
      // Where the extension names a format, the reader of that format reports the error.
      const bool is_named = std::set<std::string>{"e.xml", "e.pbrt", "e.obj", "e.ply", "e.serialized"}.count(file) > 0;
      workplace.check_refused(with_file(reader, file), file, is_named ? "" : "is empty, expected ");
      if (is_image) workplace.check_refused(with_file(reader, file), file, "expected an OpenEXR image");
    }
    for (const Reader& reader : kImageReaders)
      workplace.check_refused(with_file(reader, file), file, "is empty, expected ");
  }
  write_bytes(workplace.folder / "b.exr", "nothing of the kind");
  workplace.check_refused("info b.exr", "b.exr", "does not start like an OpenEXR file");
  for (const Reader& reader : kImageReaders)
    workplace.check_refused(with_file(reader, "b.exr"), "b.exr", "does not start like an OpenEXR file");
  // Truncated at any length.
  const std::string whole = read_bytes(workplace.folder / "image.exr");
  for (std::size_t size = 4; size < whole.size(); size += whole.size() / 7) {
    CAPTURE(size);
    write_bytes(workplace.folder / "c.exr", whole.substr(0, size));
    const Outcome info = run(workplace.folder, "info c.exr");
    CHECK((info.code == 3 || info.code == 0));  // the header may be complete
    if (info.code == 3) CHECK(info.err.starts_with("sheaf: c.exr: "));
    for (const Reader& reader : kImageReaders) {
      const Outcome outcome = run(workplace.folder, with_file(reader, "c.exr"));
      CHECK(outcome.code == 3);
      CHECK(outcome.err.starts_with("sheaf: c.exr: "));
    }
  }
  const std::string png = read_bytes(workplace.folder / "image.png");
  write_bytes(workplace.folder / "c.png", png.substr(0, png.size() / 2));
  workplace.check_refused("compare c.png c.png", "c.png", "cannot read the image");
}

TEST_CASE("formats: info lists all formats that the program reads and writes") {
  const Workplace workplace;
  const std::string text = run(workplace.folder, "info --formats").out;
  const nlohmann::json json = nlohmann::json::parse(run(workplace.folder, "info --formats --json").out);
  CHECK(json["version"] == kSheafVersion);
  CHECK(std::count(text.begin(), text.end(), '\n') == static_cast<std::ptrdiff_t>(json["formats"].size()));
  for (const char* const line :
       {"scene       Mitsuba (.xml)\n", "scene       pbrt (.pbrt, .pbrt.gz)\n", "model       glTF model (.gltf)\n",
        "model       STL model (.stl)\n", "image       OpenEXR (.exr), also written, by OpenEXR\n",
        "image       JPEG (.jpg, .jpeg), also written, by libjpeg-turbo\n", "image       TGA (.tga)\n",
        "image       WebP (.webp), by libwebp\n", "asset       NanoVDB file (.nvdb)\n",
        "asset       OpenVDB file (.vdb)\n", "asset       Mitsuba volume (.vol)\n", "asset       spectrum (.spd)\n"})
    CHECK_MESSAGE(contains(text, line), line);
  for (const ModelFormat& model : model_formats()) CHECK(contains(text, model.known.extensions[0]));
  // The documentation lists the formats of images
  const std::string page = read_bytes(SHEAF_SOURCE_DIR "/docs/scene-format/textures.md");
  const std::string listed = page.substr(page.find("Supported image formats: "), 200);
  // Images are written in exactly these formats
  for (const nlohmann::json& format : json["formats"]) {
    const std::string kind = format["kind"], name = format["name"], reader = format["reader"];
    if (kind == "image") CHECK_MESSAGE(contains(listed, name), name);
    for (const std::string extension : format["extensions"]) {
      CAPTURE(extension);
      const Outcome written = run(workplace.folder, "convert image.exr -q -o out" + extension);
      CHECK(written.code == (format["written"] ? 0 : 2));
    }
    CHECK(format["available"] == (reader != kModelImporter || can_import_models()));
    CHECK((kind == "image" || !format["written"]));
  }
  // A program alone, without the importer
  std::filesystem::copy_file(SHEAF_EXECUTABLE, workplace.folder / "alone");
  REQUIRE(std::system(("cd '" + workplace.folder.path().string() + "' && ./alone info --formats >alone.txt").c_str()) ==
          0);
  CHECK(contains(read_bytes(workplace.folder / "alone.txt"), "FBX model (.fbx), by sheaf_import_model (missing)\n"));
  // A scene or --formats
  for (const auto& [arguments, message] : {std::pair{"info", "scene is required"},
                                           {"info --json", "scene is required"},
                                           {"info --formats image.exr", "--formats takes no scene"}}) {
    const Outcome outcome = run(workplace.folder, arguments);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, message));
  }
}

}  // namespace sheaf::test_cli_formats
