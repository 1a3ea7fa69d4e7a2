// Shapes and textures that refer to files or other shapes: curves, hair, height fields, merged shapes.
#include "scene/compile/compile.h"
#include "tests/support/files/image_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_shape_reading {

using namespace test;

namespace {

/// A folder with the files that these scenes refer to.
struct Files {
  TemporaryFolder folder;

  Files() {
    write_below(folder, "curves.txt", "0 0 0 1\n0 0 1 1\n0 0 2 1\n0 0 3 1\n0 0 4 1\n");
    write_below(folder, "wig.hair", "0 0 0\n0 0 1\n1 0 1\n");
    write_below(folder, "mesh.ply", "");
    // Heights 0, 1/4, 1/2; 1, 3/4, 0 in 8 bits.
    write_pnm(folder / "hills.pgm", 3, 2, 1, 255, {0, 64, 128, 255, 191, 0});
    write_pnm(folder / "point.pgm", 1, 1, 1, 255, {0});
  }
  Description read(const std::string& inside, const std::string& version = "3.0.0") const {
    return read_scene(write_below(folder, "scene.xml", scene(inside, version)));
  }
  std::string error(const std::string& inside) const {
    return error_of(write_below(folder, "scene.xml", scene(inside, "3.0.0")));
  }
  static std::string scene(const std::string& inside, const std::string& version) {
    return mitsuba_scene(inside, "<sensor type='perspective'/>", "<integrator type='path'/>", version);
  }
};

std::string shape(const std::string& type, const std::string& file, const std::string& more = "") {
  return "<shape type='" + type + "'><string name='filename' value='" + file + "'/>" + more + "</shape>";
}

}  // namespace

TEST_CASE("Mitsuba: curves and hair are read") {
  const Files files;
  const Description d = files.read(shape("bsplinecurve", "curves.txt") + shape("linearcurve", "curves.txt") +
                                   shape("hair", "wig.hair",
                                         "<float name='radius' value='0.5'/><float name='angleThreshold' value='2'/>"
                                         "<transform name='toWorld'><scale value='3'/></transform>"));
  REQUIRE(d.shapes.size() == 3);
  CHECK(std::get<Curves>(d.shapes[0].geometry).basis == Curves::Basis::kBspline);
  CHECK(std::get<Curves>(d.shapes[1].geometry).basis == Curves::Basis::kLinear);
  CHECK(std::get<Curves>(d.shapes[1].geometry).points.size() == 5);
  CHECK(std::get<Curves>(d.shapes[2].geometry).points.at(2).position == Vec3f{1, 0, 1});
  CHECK(std::get<Curves>(d.shapes[2].geometry).points.at(2).radius == near(1.5f));
  CHECK(d.shapes[2].to_world.point({1, 0, 0}) == Vec3f{3, 0, 0});
  CHECK(contains(files.error(shape("hair", "wig.hair", "<float name='reduction' value='1'/>")), "is 1, expected less"));
  CHECK(contains(files.error(shape("hair", "curves.txt")), "curves.txt:1: expected 3 finite numbers"));
  CHECK(contains(files.error(shape("bsplinecurve", "none.txt")), "none.txt"));
  CHECK(contains(files.error(shape("bsplinecurve", "curves.txt", "<float name='radius' value='1'/>")), "radius"));
}

TEST_CASE("Mitsuba: height fields are meshes with a vertex for each pixel") {
  const Files files;
  const std::string raw =
      "<texture type='bitmap'><string name='filename' value='hills.pgm'/>"
      "<boolean name='raw' value='true'/></texture>";
  const Description d =
      files.read("<shape type='heightfield'><float name='scale' value='2'/>" + raw + "</shape>" +
                 shape("heightfield", "hills.pgm",
                       "<boolean name='shadingNormals' value='false'/><integer name='width' value='9'/>"));
  const Mesh& mesh = std::get<Mesh>(d.shapes.at(0).geometry);
  REQUIRE(mesh.positions.size() == 6);
  CHECK(mesh.triangles.size() == 4);
  CHECK(mesh.positions[0] == Vec3f{-1, -1, 0});
  CHECK(mesh.positions[1].x == 0);
  CHECK(mesh.positions[1].z == near(2 * 64 / 255.0));
  CHECK(mesh.positions[3] == Vec3f{-1, 1, 2});
  CHECK(mesh.uvs[5].x == 1);
  CHECK(mesh.uvs[5].y == 1);
  for (const auto& t : mesh.triangles)
    CHECK(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]).z > 0);
  REQUIRE(mesh.normals.size() == 6);
  // The lower left corner has the slopes of its cell's edges: 128 / 255 along x, 1 along y.
  const float slope = 2 * 64 / 255.0f;
  CHECK(dot(mesh.normals[0], normalize(Vec3f{-slope, -1, 1})) == near(1, 1e-6));
  const Mesh& faceted = std::get<Mesh>(d.shapes.at(1).geometry);
  CHECK(faceted.normals.empty());
  CHECK(d.shapes.at(1).face_normals);
  // Bytes are sRGB-encoded unless the texture is raw.
  CHECK(faceted.positions[1].z == near(std::pow((64 / 255.0 + 0.055) / 1.055, 2.4), 1e-4));
  CHECK(contains(files.error(shape("heightfield", "point.pgm")), "1 x 1 pixels (expected at least 2 x 2"));
  CHECK(contains(files.error("<shape type='heightfield'/>"), "filename"));
  CHECK(contains(files.error(shape("heightfield", "hills.pgm", raw)), "is set together with a texture"));
  CHECK(contains(files.error(shape("heightfield", "wig.hair")), "wig.hair"));
}

TEST_CASE("Mitsuba: height fields of procedural textures are sampled at the given resolution") {
  const Files files;
  const auto field = [](const std::string& texture, const std::string& more = "") {
    return "<shape type='heightfield'><float name='scale' value='2'/><integer name='width' value='4'/>"
           "<integer name='height' value='6'/>" +
           more + texture + "</shape>";
  };
  const std::string board =
      "<texture type='checkerboard'><float name='color0' value='0.25'/><float name='color1' value='0.5'/></texture>";
  const Description d =
      files.read(field(board) + field("<texture type='scale'><float name='scale' value='3'/>" + board + "</texture>") +
                     field("<texture type='uniform'><float name='value' value='0.5'/></texture>") +
                     "<shape type='heightfield'>" + board + "</shape>",
                 "0.6.0");
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  REQUIRE(scene->info().shapes == 4);
  CHECK(scene->info().vertices == 3 * 24 + 256 * 256);
  // At the centers of pixels, an image has the values of its pixels.
  const auto hills = [](const std::string& name) {
    return "<texture " + name +
           " type='bitmap'><string name='filename' value='hills.pgm'/>"
           "<boolean name='raw' value='true'/></texture>";
  };
  const auto pixels = compile_scene(
      files.read("<shape type='heightfield'><integer name='width' value='3'/><integer name='height' value='2'/>"
                 "<texture type='checkerboard'>" +
                 hills("name='color0'") + hills("name='color1'") + "</texture></shape><shape type='heightfield'>" +
                 hills("") + "</shape>"));
  for (int i = 0; i < 6; ++i)
    CHECK(pixels->view().geometry.vertices[i].position.z == near(pixels->view().geometry.vertices[6 + i].position.z));
  for (std::uint32_t y = 0; y < 6; ++y)
    for (std::uint32_t x = 0; x < 4; ++x) {
      const bool first = (x < 2) == (y < 3);
      const std::uint32_t i = 4 * y + x;
      CHECK(view.geometry.vertices[i].position.x == near(2 * static_cast<float>(x) / 3 - 1));
      CHECK(view.geometry.vertices[i].position.y == near(2 * static_cast<float>(y) / 5 - 1));
      CHECK(view.geometry.vertices[i].position.z == (first ? 0.5f : 1.0f));
      CHECK(view.geometry.vertices[24 + i].position.z == near(first ? 1.5 : 3.0));
      CHECK(view.geometry.vertices[48 + i].position.z == 1.0f);
    }
  const auto compile_error = [&](const std::string& inside) {
    const Description broken = files.read(inside, "0.6.0");
    try {
      compile_scene(broken);
    } catch (const SceneError& error) { return std::string(error.what()); }
    return std::string();
  };
  CHECK(contains(compile_error(field("<texture type='vertexcolors'/>")), "depends on meshes"));
  CHECK(
      contains(compile_error(field("<texture type='gridtexture'><texture name='color0' type='wireframe'/></texture>")),
               "depends on meshes"));
  CHECK(contains(files.error(field(board, "<integer name='width' value='1'/>")), "width"));
}

TEST_CASE("Mitsuba: signed distance grids and wireframes are read") {
  const Files files;
  const auto vol = [](std::int32_t channels) {
    std::string bytes = "VOL\3";
    const auto put = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), 4); };
    for (const std::int32_t word : {1, 2, 2, 3, channels}) put(word);
    for (const float side : {0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f}) put(side);
    for (int i = 0; i < 12 * channels; ++i) put(static_cast<float>(i) - 3.5f);
    return bytes;
  };
  write_below(files.folder, "ball.vol", vol(1));
  write_below(files.folder, "color.vol", vol(3));
  const Description d =
      files.read(shape("sdfgrid", "ball.vol") + shape("sdfgrid", "ball.vol",
                                                      "<string name='normals' value='analytic'/>"
                                                      "<transform name='to_world'><scale value='3'/></transform>"));
  const auto& grid = std::get<SdfGrid>(d.shapes.at(0).geometry);
  CHECK(grid.size == std::array<int, 3>{2, 2, 3});
  CHECK(grid.values.at(4) == 0.5f);
  CHECK(grid.smooth_normals);
  CHECK_FALSE(std::get<SdfGrid>(d.shapes.at(1).geometry).smooth_normals);
  CHECK(compile_scene(d)->info().sdf_cells == 2);
  CHECK(contains(files.error(shape("sdfgrid", "color.vol")), "one channel"));
  CHECK(contains(files.error(shape("sdfgrid", "ball.vol", "<string name='normals' value='round'/>")),
                 "smooth or analytic"));
  CHECK(contains(files.error(shape("sdfgrid", "none.vol")), "none.vol"));

  const Description wires = files.read(
      "<shape type='cube'><bsdf type='diffuse'><texture type='wireframe' name='reflectance'>"
      "<spectrum name='interiorColor' value='0.7'/><float name='lineWidth' value='0.1'/>"
      "<float name='stepWidth' value='0.25'/></texture></bsdf></shape>",
      "0.6.0");
  const auto& frame = std::get<WireframeDescription>(wires.textures.at(0).model);
  CHECK(frame.line_width == 0.1f);
  CHECK(frame.step_width == 0.25f);
  CHECK(std::get<SpectrumDescription::Constant>(std::get<SpectrumDescription>(frame.interior).value).value == 0.7f);
  CHECK(std::get<SpectrumDescription::Constant>(std::get<SpectrumDescription>(frame.edge).value).value == 0.1f);
}

TEST_CASE("Mitsuba: merged shapes are expanded even in groups") {
  const Files files;
  const std::string two = "<shape type='merge'><shape type='sphere'/><shape type='cube'/></shape>";
  const Description d = files.read("<shape type='disk'/>" + two);
  REQUIRE(d.shapes.size() == 3);
  CHECK(std::holds_alternative<CubeShape>(d.shapes[2].geometry));
  const Description group =
      files.read("<shape type='shapegroup' id='g'>" + two + "</shape><shape type='instance'><ref id='g'/></shape>");
  CHECK(group.shapes.empty());
  REQUIRE(group.groups.size() == 1);
  CHECK(group.groups[0].shapes.size() == 2);
  CHECK(contains(files.error("<shape type='merge'><float name='radius' value='1'/></shape>"), "radius"));
  ReadOptions lenient;
  lenient.lenient = true;
  const Description rest = read_scene(
      write_below(files.folder, "broken.xml",
                  Files::scene("<shape type='merge'><shape type='sphere'/><shape type='blob'/></shape>", "3.0.0")),
      lenient);
  CHECK(rest.shapes.size() == 1);
  CHECK(rest.substitutions.size() >= 1);
}

TEST_CASE("Mitsuba: ellipsoids are transformed spheres") {
  const Files files;
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float opacity\nproperty float scale_0\nproperty float scale_1\n"
      "property float scale_2\nproperty float rot_0\nproperty float rot_1\nproperty float rot_2\n"
      "property float rot_3\nend_header\n";
  // Half axes 1, e and at least 1e-6. The second is rotated by a quarter turn around z, by a quaternion that is not
  // normalized.
  const std::string second = "4 5 6 0 0 0 1 0 2 0 0 2\n";
  write_below(files.folder, "cloud.ply", header + "1 2 3 0 0 0 1 -99 1 0 0 0\n" + second);
  write_below(files.folder, "short.ply", header + second);
  write_below(files.folder, "zero.ply", header + second + "4 5 6 0 0 0 1 0 0 0 0 0\n");
  write_below(files.folder, "nan.ply", header + second + "4 nan 6 0 0 0 1 0 1 0 0 0\n");
  write_below(files.folder, "lists.ply",
              "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int x\nend_header\n0\n");
  const Description d =
      files.read(shape("ellipsoids", "cloud.ply",
                       "<float name='extent' value='2'/><float name='scale_factor' value='0.5'/><bsdf type='diffuse'/>"
                       "<transform name='to_world'><translate x='10'/></transform>"));
  REQUIRE(d.shapes.size() == 2);
  const auto distance = [](Vec3f a, Vec3f b) { return length(a - b); };
  const float e = std::exp(1.0f);
  CHECK(std::holds_alternative<SphereShape>(d.shapes[1].geometry));
  CHECK(d.shapes[0].material == d.shapes[1].material);
  CHECK(distance(d.shapes[0].to_world.point({1, 0, 0}), {12, 2, 3}) < 1e-5f);
  CHECK(distance(d.shapes[0].to_world.point({0, 1, 0}), {11, 2 + e, 3}) < 1e-5f);
  CHECK(d.shapes[0].to_world.vector({0, 0, 1}).z == near(1e-6f));
  CHECK(distance(d.shapes[1].to_world.point({1, 0, 0}), {14, 6, 6}) < 1e-5f);
  CHECK(distance(d.shapes[1].to_world.point({0, 1, 0}), {14 - e, 5, 6}) < 1e-5f);
  CHECK(files.read(shape("ellipsoidsmesh", "cloud.ply")).shapes[0].to_world.vector({1, 0, 0}).x == near(3));
  CHECK(contains(files.error(shape("ellipsoids", "short.ply")), "short.ply"));
  CHECK(contains(files.error(shape("ellipsoids", "zero.ply")), "row 1 of element 'vertex' (2 rows): an ellipsoid"));
  CHECK(contains(files.error(shape("ellipsoids", "nan.ply")), "row 1"));
  CHECK(contains(files.error(shape("ellipsoids", "lists.ply")), "has no property 'x'"));
  CHECK(contains(files.error(shape("ellipsoids", "wig.hair")), "wig.hair"));
  CHECK(contains(files.error("<shape type='ellipsoids'/>"), "filename"));
}

TEST_CASE("Mitsuba: textures of version 0.6 are read") {
  const Files files;
  const Description d = files.read(
      "<bsdf type='diffuse' id='a'><texture name='reflectance' type='gridtexture'><rgb name='color1' value='1 0 0'/>"
      "<float name='lineWidth' value='0.1'/><float name='uscale' value='4'/></texture></bsdf>"
      "<bsdf type='diffuse' id='b'><texture name='reflectance' type='vertexcolors'/></bsdf>"
      "<bsdf type='diffuse' id='c'><texture name='reflectance' type='scale'><float name='scale' value='0.5'/>"
      "<texture type='gridtexture'><rgb name='color0' value='0.2 0.4 0.6'/></texture></texture></bsdf>"
      "<shape type='sphere'><ref id='a'/></shape><shape type='sphere'><ref id='b'/></shape>"
      "<shape type='sphere'><ref id='c'/></shape>",
      "0.6.0");
  const auto texture_of = [&](std::size_t i) -> const TextureDescription& {
    const auto& diffuse = std::get<DiffuseDescription>(d.materials.at(i).model);
    return d.textures.at(static_cast<std::size_t>(std::get<TextureId>(diffuse.reflectance)));
  };
  const auto& grid = std::get<GridTextureDescription>(texture_of(0).model);
  CHECK(grid.line_width == 0.1f);
  CHECK(texture_of(0).to_uv[0] == 4);
  CHECK(std::get<MeshAttributeDescription>(texture_of(1).model).name == "vertex_color");
  const auto& scaled = std::get<GridTextureDescription>(texture_of(2).model);
  CHECK(std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(scaled.color0).value).value.y == near(0.2f));
  CHECK(std::get<SpectrumDescription::Constant>(std::get<SpectrumDescription>(scaled.color1).value).value ==
        near(0.2f));
  CHECK(contains(files.error("<bsdf type='diffuse'><texture name='reflectance' type='scale'/></bsdf>"),
                 "needs a nested <texture>"));
}

}  // namespace sheaf::test_shape_reading
