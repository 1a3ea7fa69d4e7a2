// Models that Assimp imports: COLLADA, FBX and 3D Studio.
#include "scene/formats/model_import.h"
#include "tests/support/files/model_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_model_import {

using namespace test;

namespace {

/// Whether the importer was built. Prints a message otherwise.
bool has_importer() {
  if (!can_import_models()) MESSAGE("not tested: built without Assimp");
  return can_import_models();
}

Description read_as(const std::string& name, const std::string& bytes, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  write_below(folder, "cube.mtl", cube_mtl());
  return read_scene(write_below(folder, name, bytes), options);
}
std::string error_as(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  return error_of(write_below(folder, name, bytes));
}

/// The diffuse color of a material, below its two sides.
Vec3f color_of(const Description& d, MaterialId id) {
  const MaterialModel& model = d.materials[static_cast<std::size_t>(id)].model;
  if (const auto* both = std::get_if<TwoSidedDescription>(&model)) return color_of(d, both->front);
  const auto* diffuse = std::get_if<DiffuseDescription>(&model);
  const auto* metallic = std::get_if<MetallicRoughnessDescription>(&model);
  REQUIRE((diffuse != nullptr || metallic != nullptr));
  if (metallic != nullptr) {
    CHECK(metallic->metallic == ScalarInput(0.0f));
    CHECK(metallic->specular == ScalarInput(0.0f));
  }
  const SpectrumInput& color = diffuse != nullptr ? diffuse->reflectance : metallic->base_color;
  return std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(color).value).value;
}

/// Triangles in world space with their color, in the order of their numbers; without the studio, which is gray.
using ColoredTriangle = std::array<float, 12>;
std::vector<ColoredTriangle> triangles_of(const Description& d) {
  std::vector<ColoredTriangle> out;
  for (const ShapeDescription& shape : d.shapes) {
    const auto* mesh = std::get_if<Mesh>(&shape.geometry);
    if (mesh == nullptr) continue;
    const Vec3f color = color_of(d, *shape.material);
    if (color.x == color.y) continue;
    for (const auto& t : mesh->triangles) {
      std::array<std::array<float, 3>, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f p = shape.to_world.point(mesh->positions[t[k]]);
        corners[k] = {std::round(p.x * 1e4f) / 1e4f + 0.0f, std::round(p.y * 1e4f) / 1e4f + 0.0f,
                      std::round(p.z * 1e4f) / 1e4f + 0.0f};
      }
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      ColoredTriangle all{};
      for (std::size_t k = 0; k < 9; ++k) all[k] = corners[k / 3][k % 3];
      all[9] = color.x, all[10] = color.y, all[11] = color.z;
      out.push_back(all);
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// Applies x' = s x, y' = s z, z' = -s y: z upwards becomes y upwards.
std::vector<ColoredTriangle> rotated(std::vector<ColoredTriangle> triangles, float scale) {
  for (ColoredTriangle& t : triangles) {
    std::array<std::array<float, 3>, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = {std::round(scale * t[3 * k] * 1e4f) / 1e4f + 0.0f,
                    std::round(scale * t[3 * k + 2] * 1e4f) / 1e4f + 0.0f,
                    std::round(-scale * t[3 * k + 1] * 1e4f) / 1e4f + 0.0f};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    for (std::size_t k = 0; k < 9; ++k) t[k] = corners[k / 3][k % 3];
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

struct NamedBytes {
  std::string name, bytes;
};

Vec3f camera_of(const Description& d) { return d.camera.to_world.point({0, 0, 0}); }

}  // namespace

TEST_CASE("model import: a colored cube equals that of an OBJ file") {
  if (!has_importer()) return;
  const Description obj = read_as("cube.obj", cube_obj());
  const std::vector<ColoredTriangle> expected = triangles_of(obj);
  REQUIRE(expected.size() == 12);
  CHECK(expected.front()[9] == kCubeColors[1][0]);
  for (const NamedBytes& file : {NamedBytes{"cube.dae", cube_dae()}, {"cube.FBX", cube_fbx()}}) {
    CAPTURE(file.name);
    const Description d = read_as(file.name, file.bytes);
    CHECK(triangles_of(d) == expected);
    CHECK(d.notes.empty());
    CHECK(length(camera_of(d) - camera_of(obj)) < 1e-4f);
    CHECK(d.lights.size() == obj.lights.size());
  }
}

TEST_CASE("model import: up axes and units become y upwards and meters") {
  if (!has_importer()) return;
  const std::vector<ColoredTriangle> obj = triangles_of(read_as("cube.obj", cube_obj()));
  CHECK(triangles_of(read_as("cube.3ds", cube_3ds())) == rotated(obj, 1));
  ColladaParts parts;
  parts.up = "Z_UP";
  parts.meter = "0.5";
  CHECK(triangles_of(read_as("a.dae", cube_dae(parts))) == rotated(obj, 0.5f));
  CHECK(triangles_of(read_as("a.fbx", cube_fbx({2, 1, -1, "25"}))) == rotated(obj, 0.25f));
}

TEST_CASE("model import: faces without normals are flat where they meet at a right angle") {
  if (!has_importer()) return;
  for (const NamedBytes& file :
       {NamedBytes{"cube.dae", cube_dae()}, {"cube.fbx", cube_fbx()}, {"cube.3ds", cube_3ds()}}) {
    CAPTURE(file.name);
    const Description d = read_as(file.name, file.bytes);
    const Mesh& mesh = std::get<Mesh>(d.shapes.front().geometry);
    REQUIRE(mesh.normals.size() == 12);  // three faces of four corners
    for (const Vec3f n : mesh.normals) CHECK(std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)}) == near(1));
  }
}

TEST_CASE("model import: cameras and lights belong to their nodes") {
  if (!has_importer()) return;
  ColladaParts parts;
  parts.libraries =
      "<library_cameras><camera id='c' "
      "name='lens'><optics><technique_common><perspective><xfov>60</xfov><aspect_ratio>1.5"
      "</aspect_ratio><znear>1</znear><zfar>2</zfar></perspective></technique_common></optics></camera>"
      "</library_cameras><library_lights><light id='l'><technique_common><point><color>1 0.5 0</color></point>"
      "</technique_common></light></library_lights>\n";
  parts.nodes =
      "<node id='view'><translate>0 0 9</translate><instance_camera url='#c'/></node>"
      "<node id='bulb'><translate>0 2 3</translate><instance_light url='#l'/></node>";
  const Description d = read_as("a.dae", cube_dae(parts));
  CHECK(camera_of(d).z == near(9));
  CHECK(d.camera.to_world.vector({0, 0, 1}).z == near(-1));
  CHECK(d.film.width == 900);
  CHECK(2 * std::atan(1.5 * std::tan(d.camera.fov / 2 * M_PI / 180)) * 180 / M_PI == near(60));
  CHECK(d.camera.far_clip > 100);
  REQUIRE(d.lights.size() == 1);
  const auto& light = std::get<PointLightDescription>(d.lights[0].model);
  CHECK(light.position.y == 2);
  // At the center of the cube, at a distance of 2, the irradiance is pi.
  const Vec3f intensity = std::get<SpectrumDescription::Rgb>(light.intensity.value).value;
  CHECK(intensity.x == near(4 * M_PI));
  CHECK(intensity.y == near(2 * M_PI));
  CHECK(d.shapes.size() == 2);  // no floor
  ReadOptions missing;
  missing.camera = "other";
  CHECK_THROWS_WITH_AS(read_as("a.dae", cube_dae(parts), missing), doctest::Contains("has no camera 'other'"),
                       SceneError);
}

TEST_CASE("model import: animations move nodes") {
  if (!has_importer()) return;
  const auto source = [](const std::string& id, const std::string& array, const std::string& accessor) {
    return "<source id='" + id + "'>" + array + "<technique_common><accessor source='#" + id + "a' count='2' " +
           accessor + "</accessor></technique_common></source>";
  };
  ColladaParts parts;
  parts.libraries =
      "<library_animations><animation id='w'>" +
      source("t", "<float_array id='ta' count='2'>0 2</float_array>", "stride='1'><param name='TIME' type='float'/>") +
      source("o", "<float_array id='oa' count='6'>0 0 0 0 4 0</float_array>",
             "stride='3'><param name='X' type='float'/><param name='Y' type='float'/><param name='Z' type='float'/>") +
      source("i", "<Name_array id='ia' count='2'>LINEAR LINEAR</Name_array>",
             "stride='1'><param name='INTERPOLATION' type='name'/>") +
      "<sampler id='k'><input semantic='INPUT' source='#t'/><input semantic='OUTPUT' source='#o'/>"
      "<input semantic='INTERPOLATION' source='#i'/></sampler><channel source='#k' target='n/move'/></animation>"
      "</library_animations>\n";
  ReadOptions options;
  const auto lowest = [&](float time) {
    options.moment.time = time;
    const std::vector<ColoredTriangle> triangles = triangles_of(read_as("a.dae", cube_dae(parts), options));
    float y = 1e9f;
    for (const ColoredTriangle& t : triangles) y = std::min({y, t[1], t[4], t[7]});
    return y;
  };
  CHECK(lowest(0) == near(-1));
  CHECK(lowest(0.5f) == within(0, 1e-6));
  CHECK(lowest(9) == near(3));
}

TEST_CASE("model import: skins deform meshes by their bones") {
  if (!has_importer()) return;
  const std::string identity = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  ColladaParts parts;
  parts.libraries =
      "<library_controllers><controller id='k'><skin source='#g'><bind_shape_matrix>" + identity +
      "</bind_shape_matrix><source id='j'><Name_array id='ja' count='1'>bone</Name_array><technique_common><accessor "
      "source='#ja' count='1' stride='1'><param name='JOINT' type='name'/></accessor></technique_common></source>"
      "<source id='b'><float_array id='ba' count='16'>" +
      identity +
      "</float_array><technique_common><accessor source='#ba' count='1' stride='16'><param name='TRANSFORM' "
      "type='float4x4'/></accessor></technique_common></source><source id='w'><float_array id='wa' count='1'>1"
      "</float_array><technique_common><accessor source='#wa' count='1' stride='1'><param name='WEIGHT' type='float'/>"
      "</accessor></technique_common></source><joints><input semantic='JOINT' source='#j'/><input "
      "semantic='INV_BIND_MATRIX' source='#b'/></joints><vertex_weights count='8'><input semantic='JOINT' source='#j' "
      "offset='0'/><input semantic='WEIGHT' source='#w' offset='1'/><vcount>1 1 1 1 1 1 1 1</vcount><v>0 0 0 0 0 0 0 0 "
      "0 0 0 0 0 0 0 0</v></vertex_weights></skin></controller></library_controllers>\n";
  parts.nodes = "<node id='bone' sid='bone' type='JOINT'><translate>0 5 0</translate></node>";
  std::string dae = cube_dae(parts);
  const auto replace = [&](const std::string& from, const std::string& to) {
    dae.replace(dae.find(from), from.size(), to);
  };
  replace("<instance_geometry url='#g'>", "<instance_controller url='#k'><skeleton>#bone</skeleton>");
  replace("</instance_geometry>", "</instance_controller>");
  const std::vector<ColoredTriangle> triangles = triangles_of(read_as("a.dae", dae));
  std::vector<ColoredTriangle> moved = triangles_of(read_as("a.dae", cube_dae()));
  for (ColoredTriangle& t : moved) t[1] += 5, t[4] += 5, t[7] += 5;
  CHECK(triangles == moved);
}

TEST_CASE("model import: Phong's materials get a roughness, a reflectance and an opacity") {
  if (!has_importer()) return;
  ColladaParts parts;
  parts.shading =
      "<phong>$<specular><color>0.5 0.25 0 1</color></specular><shininess><float>30</float></shininess>"
      "<transparent opaque='A_ONE'><color>1 1 1 1</color></transparent><transparency><float>0.25</float></transparency>"
      "</phong>";
  const Description d = read_as("a.dae", cube_dae(parts));
  const auto metallic = std::find_if(d.materials.begin(), d.materials.end(), [](const MaterialDescription& m) {
    return std::holds_alternative<MetallicRoughnessDescription>(m.model);
  });
  REQUIRE(metallic != d.materials.end());
  const auto& model = std::get<MetallicRoughnessDescription>(metallic->model);
  CHECK(std::get<float>(model.roughness) == near(0.5));
  CHECK(std::get<float>(model.specular) == near(0.5));
  const auto mask = std::find_if(d.materials.begin(), d.materials.end(), [](const MaterialDescription& m) {
    return std::holds_alternative<MaskDescription>(m.model);
  });
  REQUIRE(mask != d.materials.end());
  CHECK(std::get<float>(std::get<MaskDescription>(mask->model).opacity) == near(0.25));
}

TEST_CASE("model import: images are found by the name of their file") {
  const TemporaryFolder folder;
  write_below(folder, "textures/wood 50%.png", "");
  write_below(folder, "deep/stone.png", "");
  const auto found = [&](const char* name) { return find_model_image(name, folder.path()).string(); };
  CHECK(found("C:\\Users\\me\\wood 50%.png") == "textures/wood 50%.png");
  CHECK(found("/home/me/wood 50%.png") == "textures/wood 50%.png");
  CHECK(found("file:///home/me/wood 50%.png") == "textures/wood 50%.png");
  CHECK(found("deep\\stone.png") == "deep/stone.png");
  CHECK(found("/etc/passwd") == "passwd");
  CHECK(found("..\\gone.png") == "gone.png");
}

TEST_CASE("model import: textures of a model are bitmaps, and missing ones are errors") {
  if (!has_importer()) return;
  ColladaParts parts;
  parts.libraries =
      "<library_images><image id='i'><init_from>C:\\art\\wood%2050%25.png</init_from></image>"
      "</library_images>\n";
  parts.shading =
      "<newparam sid='f'><surface type='2D'><init_from>i</init_from></surface></newparam><newparam "
      "sid='q'><sampler2D><source>f</source></sampler2D></newparam><!--$--><lambert><diffuse><texture "
      "texture='i' texcoord='UV'/></diffuse></lambert>";
  const TemporaryFolder folder;
  const auto file = write_below(folder, "a.dae", cube_dae(parts));
  write_below(folder, "wood 50%.png", "not read here");
  const Description d = read_scene(file);
  const auto bitmap = std::find_if(d.textures.begin(), d.textures.end(), [](const TextureDescription& t) {
    return std::holds_alternative<BitmapDescription>(t.model);
  });
  REQUIRE(bitmap != d.textures.end());
  CHECK(std::get<BitmapDescription>(bitmap->model).file == folder / "wood 50%.png");
  CHECK(std::find(d.files.begin(), d.files.end(), folder / "wood 50%.png") != d.files.end());
}

TEST_CASE("model import: damaged files are errors that name the file") {
  if (!has_importer()) return;
  const std::string dae = cube_dae(), fbx = cube_fbx(), studio = cube_3ds();
  struct Case {
    const char* name;
    std::string bytes;
    const char* expected;
  };
  std::string infinite = dae;
  infinite.replace(infinite.find("0 0 0</translate>"), 1, "1e99");
  for (const Case& c : std::vector<Case>{{"a.dae", "", "is empty"},
                                         {"a.dae", "<x/>", "cannot be read"},
                                         {"a.dae", dae.substr(0, dae.size() / 2), "cannot be read"},
                                         {"a.dae", infinite, "not finite"},
                                         {"a.fbx", "; FBX 7.3.0 project file\n", "cannot be read"},
                                         {"a.fbx", fbx.substr(0, fbx.size() / 2), "cannot be read"},
                                         {"a.3ds", studio.substr(0, 40), "a.3ds"},
                                         {"a.3ds", fbx, "cannot be read"}}) {
    const std::string message = error_as(c.name, c.bytes);
    CAPTURE(c.name);
    CHECK_MESSAGE(message.starts_with(std::string(c.name) + ": "), message);
    CHECK_MESSAGE(contains(message, c.expected), message);
  }
  const TemporaryFolder folder;
  CHECK(error_of(folder / "gone.fbx") == "gone.fbx: model not found");
  std::filesystem::create_directory(folder / "folder.dae");
  CHECK(error_of(folder / "folder.dae") == "folder.dae: model is not a regular file");
}

TEST_CASE("model import: counts that the file is too small for are errors") {
  if (!has_importer()) return;
  std::string studio = cube_3ds();
  const std::size_t count = studio.find(bytes_of<std::uint16_t>(0x4110)) + 6;
  studio.replace(count, 2, "\xff\xff");
  error_as("a.3ds", studio);  // an error or a partial mesh, but no crash
  std::string fbx = cube_fbx();
  fbx.replace(fbx.find("*24"), 3, "*4000000000");
  error_as("a.fbx", fbx);
  std::string dae = cube_dae();
  dae.replace(dae.find("count='24'"), 10, "count='4000000000'");
  const std::string message = error_as("a.dae", dae);
  CHECK_MESSAGE((message.empty() || message.starts_with("a.dae: ")), message);
}

}  // namespace sheaf::test_model_import
