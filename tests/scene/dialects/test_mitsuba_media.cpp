// Participating media of Mitsuba: defaults, parameters, grids, and errors.
#include "scene/description/voxels.h"
#include "tests/scene/dialects/medium_files.h"
#include "tests/support/near.h"
#include "tests/support/scene_errors.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <fstream>
#include <numbers>
#include <utility>

namespace sheaf::test_mitsuba_media {

using namespace test;
using namespace medium_files;

namespace {

/// Writes a grid of one voxel of value 1 with a box.
void write_voxel(const std::filesystem::path& path, Vec3f low, Vec3f high) {
  std::ofstream out(path, std::ios::binary);
  const auto put = [&](auto v) { out.write(reinterpret_cast<const char*>(&v), sizeof(v)); };
  out.write("VOL\x03", 4);
  for (const std::int32_t v : {1, 1, 1, 1, 1}) put(v);
  for (const float v : {low.x, low.y, low.z, high.x, high.y, high.z, 1.0f}) put(v);
}

}  // namespace

TEST_CASE("media: homogeneous media of Mitsuba have the documented defaults and parameters") {
  const Description plain = read_volumes(mitsuba_scene(medium("homogeneous", "")));
  CHECK(text_of(coefficients<Pair>(only_medium(plain)).sigma_t) == constant(1));
  CHECK(text_of(coefficients<Pair>(only_medium(plain)).albedo) == constant(0.75f));
  CHECK(only_medium(plain).scale == 1);
  CHECK_FALSE(only_medium(plain).phase);
  CHECK_FALSE(only_medium(plain).emission);

  const Description full = read_volumes(mitsuba_scene(
      medium("homogeneous", "<rgb name='sigma_t' value='1, 20, 3'/>" +
                                volume("albedo", "constvolume", "<rgb name='value' value='0.9, 0.5, 1'/>") +
                                "<float name='scale' value='0'/><rgb name='emission' value='0, 5, 0'/>"
                                "<phase type='hg'><float name='g' value='-0.5'/></phase>"
                                "<boolean name='has_spectral_extinction' value='true'/>")));
  const MediumDescription& m = only_medium(full);
  CHECK(text_of(coefficients<Pair>(m).sigma_t) == rgb(1, 20, 3));
  CHECK(text_of(coefficients<Pair>(m).albedo) == rgb(0.9f, 0.5f, 1));
  CHECK(m.scale == 0);
  CHECK(text_of(*m.emission) == rgb(0, 5, 0));
  CHECK(m.where.line == 4);
  REQUIRE(full.phases.size() == 1);
  CHECK(std::get<HenyeyGreensteinDescription>(full.phases[0].model).g == -0.5f);
}

TEST_CASE("media: heterogeneous media have grids with transforms and filters") {
  const std::string grid = file("a.vol") +
                           "<transform name='to_world'><translate x='2'/></transform><boolean name='raw' value='true'/>"
                           "<string name='filter_type' value='nearest'/><string name='wrap_mode' value='mirror'/>"
                           "<boolean name='use_grid_bbox' value='true'/><boolean name='accel' value='false'/>";
  const Description d = read_volumes(
      mitsuba_scene(medium("heterogeneous", volume("sigma_t", "gridvolume", grid) + "<rgb name='albedo' value='0.5'/>" +
                                                volume("emission", "gridvolume",
                                                       file("a.nvdb") + "<string name='grid_name' value='flame'/>") +
                                                "<integer name='majorant_resolution_factor' value='8'/>")));
  const auto& sigma_t = std::get<Grid>(coefficients<Pair>(only_medium(d)).sigma_t);
  CHECK(sigma_t.format == Grid::Format::kVol);
  CHECK(sigma_t.file.filename() == "a.vol");
  CHECK(sigma_t.to_world.matrix().m[0][3] == 2);
  CHECK((sigma_t.raw && sigma_t.use_grid_bbox && !sigma_t.fit_to_shape));
  CHECK(sigma_t.filter == GridFilter::kNearest);
  CHECK(sigma_t.wrap == Grid::Wrap::kMirror);
  const auto& emission = std::get<Grid>(*only_medium(d).emission);
  CHECK(emission.format == Grid::Format::kSparse);
  CHECK(emission.grid == "flame");
  CHECK((!emission.raw && !emission.use_grid_bbox));
  CHECK(emission.filter == GridFilter::kTrilinear);
  CHECK(emission.wrap == Grid::Wrap::kClamp);
}

TEST_CASE("media: heterogeneous media of Mitsuba end at the axis-aligned box of their extinction volume") {
  const auto box_of = [](const Description& d) {
    REQUIRE(only_medium(d).density);
    const Grid& grid = *only_medium(d).density;
    REQUIRE(grid.made);
    CHECK(grid.made->values == std::vector<float>{1});
    CHECK(grid.wrap == Grid::Wrap::kClamp);
    const Transform& t = grid.made->grid_to_local;
    return std::pair{t.point({-0.5f, -0.5f, -0.5f}), t.point({0.5f, 0.5f, 0.5f})};
  };
  const auto check_box = [](std::pair<Vec3f, Vec3f> box, Vec3f low, Vec3f high) {
    CHECK(length(box.first - low) == within(0, 1e-6));
    CHECK(length(box.second - high) == within(0, 1e-6));
  };
  const auto constant_at = [&](const std::string& steps) {
    const std::string position = "<transform name='to_world'>" + steps + "</transform>";
    return read_volumes(mitsuba_scene(
        medium("heterogeneous", volume("sigma_t", "constvolume", "<float name='value' value='2'/>" + position))));
  };
  check_box(box_of(read_volumes(mitsuba_scene(medium("heterogeneous", "")))), {0, 0, 0}, {1, 1, 1});
  check_box(box_of(read_volumes(mitsuba_scene(medium("heterogeneous", "<float name='sigma_t' value='2'/>")))),
            {0, 0, 0}, {1, 1, 1});
  check_box(box_of(constant_at("<scale value='2, 3, -4'/><translate value='5, 0, 0'/>")), {5, 0, -4}, {7, 3, 0});
  const float half = 0.5f * std::numbers::sqrt2_v<float>;
  check_box(box_of(constant_at("<translate value='-0.5, -0.5, 0'/><rotate z='1' angle='45'/>")), {-half, -half, 0},
            {half, half, 1});
  check_box(box_of(read_volumes(mitsuba_scene(medium(
                "heterogeneous", volume("sigma_t", "volcache",
                                        "<volume type='constvolume'><float name='value' value='2'/>"
                                        "<transform name='to_world'><translate x='3'/></transform></volume>"))))),
            {3, 0, 0}, {4, 1, 1});
  // Axis-aligned grids have their own bounds. Others extend to their box.
  const auto grid_at = [&](const std::string& steps, const std::string& more) {
    const TemporaryFolder folder;
    write_voxel(folder / "box.vol", {-1, 0, 0}, {1, 1, 2});
    return read_scene(
        write_below(folder, "scene.xml",
                    mitsuba_scene(medium("heterogeneous", volume("sigma_t", "gridvolume",
                                                                 file("box.vol") + "<transform name='to_world'>" +
                                                                     steps + "</transform>" + more)))));
  };
  CHECK_FALSE(only_medium(grid_at("<rotate y='1' angle='-90'/><scale value='2'/>", "")).density);
  const std::string rotated = "<translate value='-0.5, -0.5, 0'/><rotate z='1' angle='45'/>";
  check_box(box_of(grid_at(rotated, "")), {-half, -half, 0}, {half, half, 1});
  check_box(box_of(grid_at("<rotate z='1' angle='45'/>", "<boolean name='use_grid_bbox' value='true'/>")),
            {-half - half, -half, 0}, {half, half + half, 2});
  // This does not apply to homogeneous media, to Nori, or to versions before 2.
  CHECK_FALSE(only_medium(read_volumes(mitsuba_scene(medium(
                              "homogeneous", volume("sigma_t", "constvolume", "<float name='value' value='2'/>")))))
                  .density);
  CHECK_FALSE(only_medium(read_volumes(mitsuba06_scene(medium(
                              "heterogeneous", volume("density", "constvolume", "<float name='value' value='2'/>")))))
                  .density);
}

TEST_CASE("media: the grid format follows from the file name or the first bytes") {
  const auto format = [](const std::string& name) {
    const Description d =
        read_volumes(mitsuba_scene(medium("heterogeneous", volume("sigma_t", "gridvolume", file(name)))));
    return std::get<Grid>(coefficients<Pair>(only_medium(d)).sigma_t).format;
  };
  CHECK(format("a.VOL") == Grid::Format::kVol);
  CHECK(format("vol.dat") == Grid::Format::kVol);
  CHECK(format("nanovdb.dat") == Grid::Format::kSparse);
  CHECK(format("openvdb.dat") == Grid::Format::kSparse);
  CHECK(format("a.vdb") == Grid::Format::kSparse);
}

TEST_CASE("media: grids may be textures of surfaces and may be scaled") {
  const std::string grid = "<texture type='volume' name='",
                    of = "'>" + volume("volume", "gridvolume", file("a.vol")) + "</texture>";
  const Description d = read_volumes(
      mitsuba_scene("<shape type='sphere'><bsdf type='diffuse'>" + grid + "reflectance" + of +
                    "</bsdf></shape><shape type='sphere'>" +
                    "<bsdf type='diffuse'><texture type='scale' name='reflectance'><float name='scale' value='0.5'/>" +
                    grid + "a" + of + "</texture></bsdf></shape>"));
  REQUIRE(d.textures.size() == 3);
  const auto& plain = std::get<VolumeTextureDescription>(d.textures[0].model);
  CHECK(plain.grid.file.filename() == "a.vol");
  CHECK(plain.scale == 1);
  CHECK(std::get<VolumeTextureDescription>(d.textures[2].model).scale == 0.5f);
}

TEST_CASE("media: shapes and sensors of Mitsuba refer to media and each medium is read once") {
  const Description d = read_volumes(mitsuba_scene(
      "<shape type='sphere'><ref id='fog' name='interior'/></shape>"
      "<medium type='homogeneous' id='fog'/>"
      "<shape type='sphere'><ref id='fog' name='exterior'/>"
      "<medium name='interior' type='homogeneous'><float name='scale' value='3'/></medium><bsdf type='null'/></shape>"
      "<shape type='sphere'/><emitter type='point'><ref id='fog'/></emitter>",
      "<sensor type='perspective'><ref id='fog' name='medium'/></sensor>"));
  REQUIRE(d.media.size() == 2);
  REQUIRE(d.shapes.size() == 3);
  CHECK(d.media[0].id == "fog");
  CHECK(d.shapes[0].interior == MediumId{0});
  CHECK_FALSE(d.shapes[0].exterior);
  CHECK_FALSE(d.shapes[0].exterior_is_surrounding);
  CHECK_FALSE(d.shapes[0].material);
  CHECK(d.shapes[1].interior == MediumId{1});
  CHECK(d.shapes[1].exterior == MediumId{0});
  CHECK(d.media[1].scale == 3);
  CHECK_FALSE(d.shapes[2].interior);
  CHECK(d.camera.medium == MediumId{0});
}

TEST_CASE("media: Mitsuba 0.6 has other coefficient names and measured materials and boxes in grids") {
  const Description coeffs = read_volumes(mitsuba06_scene(
      medium("homogeneous", "<rgb name='sigmaS' value='1, 2, 3'/><spectrum name='sigmaA' value='0.5'/>")));
  CHECK(text_of(coefficients<Coefficients>(only_medium(coeffs)).sigma_s) == rgb(1, 2, 3));
  CHECK(text_of(coefficients<Coefficients>(only_medium(coeffs)).sigma_a) == constant(0.5f));

  const Description milk = read_volumes(mitsuba06_scene(
      "<shape type='sphere'><medium name='interior' type='homogeneous'><string name='material' value='Skimmilk'/>"
      "<float name='scale' value='1000'/></medium></shape>"));
  CHECK(text_of(coefficients<Coefficients>(only_medium(milk)).sigma_s) == rgb(0.70f, 1.22f, 1.90f));
  CHECK(only_medium(milk).scale == 1000);
  REQUIRE(milk.shapes[0].material);
  CHECK(std::holds_alternative<NullDescription>(milk.materials[0].model));
  const Description skin = read_volumes(mitsuba06_scene(medium("homogeneous", "")));
  CHECK(text_of(coefficients<Coefficients>(only_medium(skin)).sigma_a) == rgb(0.032f, 0.17f, 0.48f));

  const std::string smoke = volume("density", "gridvolume", file("a.vol")) +
                            volume("albedo", "constvolume", "<spectrum name='value' value='0.9'/>") +
                            "<float name='scale' value='100'/>";
  const Description woodcock = read_volumes(mitsuba06_scene(medium("heterogeneous", smoke)));
  CHECK(std::get<Grid>(coefficients<Pair>(only_medium(woodcock)).sigma_t).use_grid_bbox);
  CHECK(text_of(coefficients<Pair>(only_medium(woodcock)).albedo) == constant(0.9f));
  CHECK(woodcock.integrator.medium_estimator == MediumEstimator::kNullMis);
  const Description simpson = read_volumes(mitsuba06_scene(
      medium("heterogeneous", smoke + "<string name='method' value='simpson'/><float name='stepSize' value='0.5'/>")));
  CHECK(simpson.integrator.medium_estimator == MediumEstimator::kMarching);
  CHECK(simpson.integrator.step_size == 0.5f);
}

TEST_CASE("media: a boundary of Mitsuba 0.6 without a BSDF is a null interface and black on a light") {
  const auto model = [](const std::string& inside) {
    const Description d = read_text(
        mitsuba_scene("<shape type='sphere'><medium name='interior' type='homogeneous'/>" + inside + "</shape>",
                      "<sensor type='perspective'/>", "<integrator type='volpath'/>", "0.6.0"));
    return d.materials.at(static_cast<std::size_t>(d.shapes.at(0).material.value())).model;
  };
  CHECK(std::holds_alternative<NullDescription>(model("")));
  CHECK(std::holds_alternative<DiffuseDescription>(model("<emitter type='area'/>")));
}

TEST_CASE("media: errors of homogeneous media in Mitsuba scenes have line and nearest name") {
  const auto homogeneous = [](const std::string& inside) { return mitsuba_scene(medium("homogeneous", inside)); };
  check_errors(
      {
          {homogeneous("<rgb name='sigma_q' value='1'/>"),
           "unknown property 'sigma_q' of medium 'homogeneous', did you mean 'sigma_"},
          {homogeneous("<rgb name='sigma_t' value='-1'/>"), "expected non-negative values"},
          {homogeneous("<rgb name='albedo' value='1.5'/>"), "expected values within [0, 1]"},
          {homogeneous("<float name='scale' value='-1'/>"), "expected a non-negative number"},
          {homogeneous("<rgb name='emission' value='-1'/>"), "expected non-negative values"},
          {homogeneous("<rgb name='sigma_t' value='1'/><rgb name='sigma_a' value='1'/>"),
           "mixes 'sigma_t' and 'albedo' with"},
          {homogeneous("<string name='material' value='skin1'/>"), "unknown property 'material'"},
          {homogeneous(volume("sigma_t", "gridvolume", file("a.vol"))), "use type 'heterogeneous' for grids"},
          {homogeneous(volume("sigma_s", "gridvolume", file("a.vol"))),
           "has a grid for 'sigma_s', expected the same value"},
          {homogeneous("<rgb name='albedo' value='1'/>" +
                       volume("albedo", "constvolume", "<float name='value' value='1'/>")),
           "is set together with a <volume> of this name"},
          {homogeneous(volume("albdo", "constvolume", "<float name='value' value='1'/>")),
           "takes no nested <volume> of the name 'albdo', did you mean 'albedo'?"},
          {homogeneous("<volume type='constvolume'/>"), "takes no nested <volume> without a name"},
          {homogeneous(volume("albedo", "constvolume", "")), "volume 'constvolume' needs the spectrum 'value'"},
          {homogeneous(volume("albedo", "constvolum", "")),
           "unknown volume plugin 'constvolum', did you mean 'constvolume'?"},
          {homogeneous("<float name='temperature' value='-5'/>"), "expected non-negative values"},
          {homogeneous("<float name='temperature_scale' value='-5'/>"), "expected a non-negative number"},
          {homogeneous("<rgb name='temperature' value='1,2,3'/>"), "has a color for 'temperature', expected a number"},
          {homogeneous("<float name='temperature' value='5'/><float name='emission' value='5'/>"),
           "has both 'emission' and 'temperature', expected one"},
      },
      error_of_volumes);
}

TEST_CASE("media: errors of grids and placement in Mitsuba scenes have line and nearest name") {
  const auto grid = [](const std::string& inside) {
    return mitsuba_scene(medium("heterogeneous", volume("sigma_t", "gridvolume", inside)));
  };
  check_errors(
      {
          {grid(""), "volume 'gridvolume' needs the string 'filename'"},
          {grid(file("gone.vol")), "file 'gone.vol' not found"},
          {grid(file("text.dat")), "expected a .vol, .nvdb or .vdb file"},
          {grid(file("a.vol") + "<string name='filter_type' value='cubic'/>"), "expected trilinear or nearest"},
          {grid(file("a.vol") + "<string name='wrap_mode' value='clam'/>"), "did you mean 'clamp'?"},
          {grid(file("a.vol") + "<string name='grid_name' value='x'/>"), "is set for a .vol file"},
          {grid(file("a.vol") + "<boolean name='fit_to_shape' value='true'/>"), "unknown property 'fit_to_shape'"},
          {mitsuba_scene("<medium type='homogenous'/>"),
           "scene.xml:4: unknown medium plugin 'homogenous', did you mean 'homogeneous'?"},
          {mitsuba_scene("<volume type='constvolume'/>"), "<volume> at the top level is not referenced"},
          {mitsuba_scene("<subsurface type='dipole'/>"), "<subsurface> at the top level is not referenced"},
          {mitsuba_scene("<shape type='sphere'><medium type='homogeneous' name='inside'/></shape>"),
           "shape 'sphere' takes no nested <medium> of the name 'inside' (known: interior, exterior)"},
          {mitsuba_scene("<shape type='sphere'><medium type='homogeneous' name='interior'/>"
                         "<medium type='homogeneous' name='interior'/></shape>"),
           "shape 'sphere' has a second <medium> of the name 'interior'"},
          {mitsuba_scene("<bsdf type='dielectric'><rgb name='sigma_a' value='1'/></bsdf>"),
           "unknown property 'sigma_a'"},
      },
      error_of_volumes);
}

TEST_CASE("media: errors in scenes of Mitsuba 0.6 have the nearest name") {
  check_errors(
      {
          {mitsuba06_scene(medium("homogeneous", "<string name='material' value='skimilk'/>")),
           "expected the name of a measured medium, did you mean 'skimmilk'?"},
          {mitsuba06_scene(
               medium("homogeneous", "<string name='material' value='skin1'/><rgb name='sigmaT' value='1'/>")),
           "is set together with coefficients"},
          {mitsuba06_scene(medium("heterogeneous", "")), "needs the <volume> 'density'"},
          {mitsuba06_scene(
               medium("heterogeneous", "<float name='density' value='1'/><string name='method' value='simson'/>")),
           "did you mean 'simpson'?"},
          {mitsuba06_scene(
               medium("heterogeneous", "<float name='density' value='1'/>" +
                                           volume("orientation", "constvolume", "<float name='value' value='1'/>"))),
           "in the matrices of the phase function 'sggx'"},
      },
      error_of_volumes);
}

}  // namespace sheaf::test_mitsuba_media
