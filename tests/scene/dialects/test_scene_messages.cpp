// Errors of well-formed scenes with invalid contents: file and line in every dialect.
#include "core/image/exr.h"
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_scene_messages {

using namespace test;

namespace {

/// The error of reading and compiling a scene in this folder without folder names; empty without an error.
std::string compile_error(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
  try {
    compile_scene(read_scene(write_below(folder, name, text)));
  } catch (const SceneError& error) {
    std::string message = error.what();
    const std::string before = folder.path().string() + "/";
    for (std::size_t at = message.find(before); at != std::string::npos; at = message.find(before))
      message.erase(at, before.size());
    return message;
  }
  return {};
}

/// A grid of 2 x 2 x 2 voxels in Mitsuba's format with the given box.
std::string vol_bytes(const std::array<float, 6>& box = {0, 0, 0, 1, 1, 1}) {
  const auto word = [](auto value) { return std::string(reinterpret_cast<const char*>(&value), 4); };
  std::string bytes = "VOL\x03";
  for (const int number : {1, 2, 2, 2, 1}) bytes += word(number);
  for (const float corner : box) bytes += word(corner);
  for (int i = 0; i < 8; ++i) bytes += word(0.5f);
  return bytes;
}

/// An image whose pixel 0 has red 3 and pixel 1 green -0.5. The others of 4 x 3 are 1.
Image beyond_one() {
  Image image(4, 3, {"R", "G", "B"});
  std::fill(image.data.begin(), image.data.end(), 1.0f);
  image.data[0] = 3;
  image.data[4] = -0.5f;
  return image;
}

std::vector<std::string> warnings_of(const TemporaryFolder& folder, const std::string& text) {
  std::vector<std::string> warnings = compile_scene(read_scene(write_below(folder, "scene.xml", text)))->warnings();
  std::erase_if(warnings, [](const std::string& warning) { return warning.find("clamped") == std::string::npos; });
  return warnings;
}

std::string bitmap(const char* name, const char* file, const char* id = "") {
  return "\n<texture type='bitmap'" + (*name == 0 ? "" : " name='" + std::string(name) + "'") +
         (*id == 0 ? "" : " id='" + std::string(id) + "'") + "><string name='filename' value='" + file +
         "'/><boolean name='raw' value='true'/></texture>";
}

std::string sphere_of(const std::string& bsdf) { return "<shape type='sphere'>" + bsdf + "</shape>"; }

}  // namespace

TEST_CASE("messages: filters of excessive size are errors with their line") {
  const TemporaryFolder folder;
  const auto mitsuba = [](const std::string& version, const std::string& filter) {
    return "<scene version='" + version + "'>\n<sensor type='perspective'><film type='hdrfilm'>\n<rfilter " + filter +
           "</rfilter></film></sensor></scene>";
  };
  const auto nori = [](const std::string& filter) {
    return "<scene><integrator type='path'/>\n<camera type='perspective'>\n<rfilter " + filter +
           "</rfilter></camera><mesh type='sphere'/></scene>";
  };
  const auto pbrt = [](const std::string& filter) {
    return "Film \"rgb\" \"integer xresolution\" 8\nCamera \"perspective\"\nPixelFilter " + filter + "\nWorldBegin\n";
  };
  const std::string wide = "scene.xml:3: the reconstruction filter has a radius of ";
  const std::string most = " pixels, expected one above 0 and at most 64";
  for (const char* version : {"3.0.0", "0.6.0"}) {
    const auto error = [&](const std::string& filter) {
      return compile_error(folder, "scene.xml", mitsuba(version, filter));
    };
    CHECK(error("type='box'><float name='radius' value='1e30'/>") == wide + "1e+30" + most);
    CHECK(error("type='tent'><float name='radius' value='64.5'/>") == wide + "64.5" + most);
    CHECK(error("type='gaussian'><float name='stddev' value='3e38'/>") == wide + "inf" + most);
    CHECK(contains(error("type='box'><float name='radius' value='nan'/>"), "scene.xml:3: property 'radius' is 'nan'"));
    CHECK(contains(error("type='lanczos'><integer name='lobes' value='65'/>"), "scene.xml:3: property 'lobes'"));
    CHECK(error("type='tent'><float name='radius' value='64'/>").empty());
  }
  CHECK(compile_error(folder, "scene.xml", nori("type='gaussian'>\n<float name='stddev' value='1e30'/>")) ==
        wide + "4e+30" + most);
  CHECK(compile_error(folder, "scene.pbrt", pbrt("\"box\" \"float xradius\" 1e30 \"float yradius\" 1e30")) ==
        "scene.pbrt:3: the reconstruction filter has a radius of 1e+30" + most);
  CHECK(compile_error(folder, "scene.pbrt", pbrt("\"gaussian\" \"float sigma\" 17")) ==
        "scene.pbrt:3: the reconstruction filter has a radius of 68" + most);
}

TEST_CASE("messages: grids with singular transforms are errors with their line") {
  const TemporaryFolder folder;
  write_below(folder, "grid.vol", vol_bytes());
  write_below(folder, "thin.vol", vol_bytes({0, 0, 0, 1e-44f, 1, 1}));
  write_below(folder, "flat.vol", vol_bytes({0, 0, 0, 0, 1, 1}));
  const auto grid = [](const char* file, const std::string& rest) {
    return "type='gridvolume'><string name='filename' value='" + std::string(file) + "'/>" + rest + "</volume>";
  };
  const auto medium = [&](const std::string& volume) {
    return mitsuba_scene("<medium id='m' type='heterogeneous'><volume name='sigma_t' " + volume +
                         "</medium><shape type='cube'><ref name='interior' id='m'/><bsdf type='null'/></shape>");
  };
  const auto texture = [&](const std::string& volume) {
    return mitsuba_scene(
        "<shape type='cube'><bsdf type='diffuse'>\n<texture name='reflectance' type='volume'>"
        "<volume name='volume' " +
        volume + "</texture></bsdf></shape>");
  };
  const auto matrix = [](const char* first) {
    return "<transform name='to_world'><matrix value='" + std::string(first) +
           " 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'/></transform>";
  };
  const std::string own_box = "<boolean name='use_grid_bbox' value='true'/>";
  const std::string is_not = "the transform of a volume is not invertible";
  const auto error = [&](const std::string& text) { return compile_error(folder, "scene.xml", text); };
  CHECK(error(medium(grid("grid.vol", matrix("0")))) == "scene.xml:4: transform is not invertible");
  CHECK(error(texture(grid("grid.vol", matrix("0")))) == "scene.xml:5: transform is not invertible");
  CHECK(error(medium(grid("grid.vol", matrix("1e-40")))) == "scene.xml:4: grid.vol: " + is_not);
  CHECK(error(texture(grid("grid.vol", matrix("1e-40")))) == "scene.xml:5: grid.vol: " + is_not);
  CHECK(error(medium(grid("thin.vol", own_box))) == "scene.xml:4: thin.vol: " + is_not);
  CHECK(contains(error(medium(grid("flat.vol", own_box))), "scene.xml:4: flat.vol: the file's bounding box is empty"));
  CHECK(error(medium(grid("grid.vol", matrix("1")))).empty());
  const auto pbrt = [](const std::string& transform) {
    return "Film \"rgb\" \"integer xresolution\" 8\nCamera \"perspective\"\nWorldBegin\n" + transform +
           "\nMakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1 "
           "\"float density\" [1 1]\nMediumInterface \"m\" \"\"\nShape \"sphere\"\n";
  };
  CHECK(compile_error(folder, "scene.pbrt", pbrt("Scale 1 0 1")) == "scene.pbrt:4: transform is not invertible");
  CHECK(compile_error(folder, "scene.pbrt", pbrt("Scale 1 1e-40 1")) == "scene.pbrt:5: " + is_not);
}

TEST_CASE("messages: unreadable environment maps are errors with line and file name") {
  const TemporaryFolder folder;
  write_below(folder, "empty.exr", "");
  write_below(folder, "empty.hdr", "");
  write_below(folder, "broken.exr", "v/1\x01 and so on");
  write_below(folder, "text.png", "no image");
  Image depth(2, 2, {"Q", "P"});
  write_exr(folder / "channels.exr", depth);
  std::filesystem::create_directory(folder / "folder.exr");
  for (const char* file :
       {"empty.exr", "empty.hdr", "broken.exr", "text.png", "channels.exr", "missing.exr", "folder.exr"}) {
    CAPTURE(std::string(file));
    const std::string name = "<string name='filename' value='" + std::string(file) + "'/>";
    const std::string camera = "Camera \"perspective\"\nWorldBegin\n";
    for (const auto& [scene, text] :
         {std::pair<std::string, std::string>{"scene.xml",
                                              mitsuba_scene("<emitter type='envmap'>" + name + "</emitter>")},
          {"scene.xml", mitsuba_scene("<emitter type='envmap'>" + name + "</emitter>", "<sensor type='perspective'/>",
                                      "<integrator type='path'/>", "0.6.0")},
          {"scene.xml",
           "<scene><integrator type='path'/>\n<camera type='perspective'/>\n<mesh type='sphere'/>\n"
           "<emitter type='envmap'>" +
               name + "</emitter></scene>"},
          {"scene.pbrt", camera + "\nLightSource \"infinite\" \"string filename\" \"" + file + "\"\n"}}) {
      const std::string error = compile_error(folder, scene, text);
      CAPTURE(error);
      CHECK(error.starts_with(scene + ":4: "));
      CHECK(contains(error, file));
    }
  }
}

TEST_CASE("messages: a missing file is an error that names the script which generates it") {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& file) {
    return compile_error(folder, "scene.xml",
                         mitsuba_scene("<shape type='ply'><string name='filename' value='" + file + "'/></shape>"));
  };
  const std::string missing = "scene.xml:4: file 'made/deep/knot.ply' not found in '" + folder.path().string() + "'";
  CHECK(error("made/deep/knot.ply") == missing);
  write_below(folder, "made.txt", "make_knot.py makes these\nand more\n");
  CHECK(error("made/deep/knot.ply") == missing + " (made.txt: make_knot.py makes these)");
  write_below(folder, "made/deep.txt", "the nearest counts");
  CHECK(error("made/deep/knot.ply") == missing + " (made/deep.txt: the nearest counts)");
  CHECK(contains(
      compile_error(folder, "scene.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"made/deep/knot.ply\"\n"),
      "scene.pbrt:2: file 'made/deep/knot.ply' not found in '"));
  CHECK(contains(
      compile_error(folder, "scene.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"made/knot.ply\"\n"),
      " (made.txt: make_knot.py makes these)"));
  // Names outside the folder, and texts that are empty or long.
  for (const char* name : {"knot.ply", "/made/knot.ply", "../made/knot.ply", "made//", "..", "/"})
    CHECK_FALSE(contains(error(name), "make_knot"));
  write_below(folder, "many.txt", std::string(100000, 'x'));
  CHECK(error("many/knot.ply").ends_with("many.txt: " + std::string(200, 'x') + ")"));
  write_below(folder, "none.txt", "");
  CHECK(error("none/knot.ply").ends_with("'"));
  std::filesystem::create_directory(folder / "folder.txt");
  CHECK(error("folder/knot.ply").ends_with("'"));
}

TEST_CASE("messages: texels outside the range of reflectance are counted once for each texture") {
  const TemporaryFolder folder;
  write_exr(folder / "beyond.exr", beyond_one());
  Image gray(5, 5, {"Y"});
  std::fill(gray.data.begin(), gray.data.end(), 1.5f);
  write_exr(folder / "grey.exr", gray);
  Image fine(5, 5, {"Y"});
  std::fill(fine.data.begin(), fine.data.end(), 1.0f);
  write_exr(folder / "fine.exr", fine);
  const auto warnings = [&](const std::string& inside) { return warnings_of(folder, mitsuba_scene(inside)); };
  const std::string clamped = ": as reflectances they are clamped to [0, 1]";

  const auto one = warnings(sphere_of("<bsdf type='diffuse'>" + bitmap("reflectance", "beyond.exr") + "</bsdf>"));
  REQUIRE(one.size() == 1);
  CHECK(one[0] == (folder / "scene.xml").string() + ":5: texture: " + (folder / "beyond.exr").string() +
                      ": 2 of 12 texels (16.7 %) are above 1 or below 0, from -0.5 to 3" + clamped);
  // A texture that several materials share, and two of one file.
  const std::string shared = bitmap("", "grey.exr", "wood") + bitmap("", "grey.exr", "bark");
  const std::string two = sphere_of("<bsdf type='diffuse'><ref name='reflectance' id='wood'/></bsdf>") +
                          sphere_of("<bsdf type='plastic'><ref name='diffuse_reflectance' id='wood'/></bsdf>") +
                          sphere_of("<bsdf type='principled'><ref name='base_color' id='bark'/></bsdf>");
  const auto both = warnings(shared + two);
  REQUIRE(both.size() == 2);
  CHECK(contains(both[0], ":5: texture 'wood': "));
  CHECK(contains(both[0], "grey.exr: 25 of 25 texels (100 %) are above 1 or below 0, from 0 to 1.5" + clamped));
  CHECK(contains(both[1], ":6: texture 'bark': "));
  // Inside checkerboards and coats, and on both sides.
  const std::string board =
      "<texture type='checkerboard' name='reflectance'>" + bitmap("color0", "beyond.exr") + "</texture>";
  CHECK(warnings(sphere_of("<bsdf type='twosided'><bsdf type='diffuse'>" + board + "</bsdf></bsdf>")).size() == 1);

  // Colors of checkerboards, and of materials that no dialect rejects.
  const auto color =
      warnings(sphere_of("<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'>"
                         "<rgb name='color0' value='0.2 1.5 0'/></texture></bsdf>"));
  REQUIRE(color.size() == 1);
  CHECK(contains(color[0], ":4: texture: a reflectance of 1.5 is clamped to 1"));
  write_below(folder, "model.mtl", "newmtl a\nKd 1.75 0 0\n");
  write_below(folder, "model.obj", "mtllib model.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto model = compile_scene(read_scene(folder / "model.obj"))->warnings();
  REQUIRE(model.size() == 1);
  CHECK(contains(model[0], "a reflectance of 1.75 is clamped to 1"));
  CHECK(contains(model[0], "model."));

  // Textures that are not reflectances may have any value, and valid reflectances give no warning.
  CHECK(warnings(sphere_of("<bsdf type='diffuse'>" + bitmap("reflectance", "fine.exr") + "</bsdf>")).empty());
  CHECK(warnings(sphere_of("<emitter type='area'>" + bitmap("radiance", "beyond.exr") + "</emitter>")).empty());
  CHECK(warnings(sphere_of("<bsdf type='roughconductor'>" + bitmap("alpha", "grey.exr") + bitmap("eta", "beyond.exr") +
                           bitmap("k", "beyond.exr") + "</bsdf>"))
            .empty());
  CHECK(warnings(sphere_of("<bsdf type='roughconductor'>" + bitmap("specular_reflectance", "grey.exr") + "</bsdf>"))
            .size() == 1);
  CHECK(warnings(bitmap("", "beyond.exr", "unused") + sphere_of("")).empty());
}

}  // namespace sheaf::test_scene_messages
