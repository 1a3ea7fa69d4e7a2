// Participating media in scene files of both dialects: descriptions and error messages.
#include <doctest/doctest.h>

#include "scene/description/voxels.h"
#include "scene/dialects/common/integrator_name.h"
#include "scene/dialects/common/medium_estimator_name.h"
#include "tests/support/scene_files.h"

#include <cstdint>
#include <fstream>
#include <numbers>

namespace sheaf::test_medium_reading {

using namespace test;

namespace {

using Grid = GridVolumeDescription;
using Pair = ExtinctionAlbedoDescription;
using Coefficients = AbsorptionScatteringDescription;

/// A folder with empty files of the kinds that volumes refer to.
struct Volumes {
  TemporaryFolder folder;
  Volumes() {
    for (const char* name : {"a.vol", "a.nvdb", "a.vdb", "a.VOL", "mesh.obj"}) write_below(folder, name, "");
    write_below(folder, "vol.dat", "VOL\3");
    write_below(folder, "nanovdb.dat", "NanoVDB0");
    write_below(folder, "openvdb.dat", " BDV....");
    write_below(folder, "text.dat", "hello");
  }
  std::filesystem::path scene(const std::string& text) const { return write_below(folder, "scene.xml", text); }
};

Description read_volumes(const std::string& text) { return read_scene(Volumes().scene(text)); }
std::string error_of_volumes(const std::string& text) {
  const Volumes volumes;
  return error_of(volumes.scene(text));
}

/// Writes a grid of one voxel of value 1 with a box.
void write_vol(const std::filesystem::path& path, Vec3f low, Vec3f high) {
  std::ofstream out(path, std::ios::binary);
  const auto put = [&](auto v) { out.write(reinterpret_cast<const char*>(&v), sizeof(v)); };
  out.write("VOL\x03", 4);
  for (const std::int32_t v : {1, 1, 1, 1, 1}) put(v);
  for (const float v : {low.x, low.y, low.z, high.x, high.y, high.z, 1.0f}) put(v);
}

std::string old_scene(const std::string& inside) {
  return mitsuba_scene(inside, "<sensor type='perspective'/>", "<integrator type='volpath'/>", "0.6.0");
}
/// The medium is in line 2.
std::string nori_scene(const std::string& inside, const std::string& integrator = "<integrator type='path'/>") {
  return "<scene>\n" + inside + "\n<camera type='perspective'/>" + integrator + "</scene>";
}
std::string nori_mesh(const std::string& inside) { return nori_scene("<mesh type='sphere'>" + inside + "</mesh>"); }

std::string medium(const std::string& type, const std::string& inside) {
  return "<medium type='" + type + "'>" + inside + "</medium>";
}
std::string volume(const std::string& name, const std::string& type, const std::string& inside) {
  return "<volume name='" + name + "' type='" + type + "'>" + inside + "</volume>";
}
std::string file(const std::string& name) { return "<string name='filename' value='" + name + "'/>"; }

const MediumDescription& only_medium(const Description& d) {
  REQUIRE(d.media.size() == 1);
  return d.media[0];
}
template <class T> const T& coefficients(const MediumDescription& m) {
  REQUIRE(std::holds_alternative<T>(m.coefficients));
  return std::get<T>(m.coefficients);
}
std::string dump(const VolumeInput& input) {
  const auto* spectrum = std::get_if<SpectrumDescription>(&input);
  return spectrum != nullptr ? test::dump(*spectrum) : "grid " + std::get<Grid>(input).file.filename().string();
}
std::string text_of(const SpectrumDescription& s) { return test::dump(s); }
std::string text_of(const VolumeInput& v) { return test::dump(std::get<SpectrumDescription>(v)); }
std::string constant(float v) { return text_of(SpectrumDescription::constant(v)); }
std::string rgb(float r, float g, float b) { return text_of(SpectrumDescription::rgb(r, g, b)); }

}  // namespace

TEST_CASE("media: homogeneous media of Mitsuba have the documented defaults and parameters") {
  const Description plain = read_volumes(mitsuba_scene(medium("homogeneous", "")));
  CHECK(dump(coefficients<Pair>(only_medium(plain)).sigma_t) == constant(1));
  CHECK(dump(coefficients<Pair>(only_medium(plain)).albedo) == constant(0.75f));
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
  CHECK(dump(coefficients<Pair>(m).sigma_t) == rgb(1, 20, 3));
  CHECK(dump(coefficients<Pair>(m).albedo) == rgb(0.9f, 0.5f, 1));
  CHECK(m.scale == 0);
  CHECK(dump(*m.emission) == rgb(0, 5, 0));
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
  CHECK(emission.format == Grid::Format::kNanoVdb);
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
    CHECK(length(box.first - low) == doctest::Approx(0));
    CHECK(length(box.second - high) == doctest::Approx(0));
  };
  const auto constant_at = [&](const std::string& steps) {
    const std::string place = "<transform name='to_world'>" + steps + "</transform>";
    return read_volumes(mitsuba_scene(
        medium("heterogeneous", volume("sigma_t", "constvolume", "<float name='value' value='2'/>" + place))));
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
    write_vol(folder / "box.vol", {-1, 0, 0}, {1, 1, 2});
    return read_scene(
        write_below(folder, "scene.xml",
                    mitsuba_scene(medium("heterogeneous", volume("sigma_t", "gridvolume",
                                                                 file("box.vol") + "<transform name='to_world'>" +
                                                                     steps + "</transform>" + more)))));
  };
  CHECK_FALSE(only_medium(grid_at("<rotate y='1' angle='-90'/><scale value='2'/>", "")).density);
  const std::string turned = "<translate value='-0.5, -0.5, 0'/><rotate z='1' angle='45'/>";
  check_box(box_of(grid_at(turned, "")), {-half, -half, 0}, {half, half, 1});
  check_box(box_of(grid_at("<rotate z='1' angle='45'/>", "<boolean name='use_grid_bbox' value='true'/>")),
            {-half - half, -half, 0}, {half, half + half, 2});
  // This does not apply to homogeneous media, to Nori, or to versions before 2.
  CHECK_FALSE(only_medium(read_volumes(mitsuba_scene(medium(
                              "homogeneous", volume("sigma_t", "constvolume", "<float name='value' value='2'/>")))))
                  .density);
  CHECK_FALSE(only_medium(read_volumes(old_scene(medium(
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
  CHECK(format("nanovdb.dat") == Grid::Format::kNanoVdb);
}

TEST_CASE("media: phase functions of every kind are read") {
  const Description d = read_volumes(
      mitsuba_scene(medium("homogeneous",
                           "<phase type='blendphase'><float name='weight' value='0.25'/><phase type='rayleigh'/>"
                           "<phase type='blendphase'>" +
                               volume("weight", "volcache",
                                      "<integer name='blockSize' value='8'/><volume type='constvolume'>"
                                      "<float name='value' value='1'/></volume>") +
                               "<phase type='isotropic'/><phase type='hg'/></phase></phase>")));
  REQUIRE(only_medium(d).phase);
  REQUIRE(d.phases.size() == 5);
  const auto at = [&](PhaseId id) -> const PhaseDescription& { return d.phases[static_cast<std::size_t>(id)]; };
  const auto& outer = std::get<BlendPhaseDescription>(at(*only_medium(d).phase).model);
  CHECK(outer.weight == 0.25f);
  CHECK(std::holds_alternative<RayleighDescription>(at(outer.nested[0]).model));
  const auto& inner = std::get<BlendPhaseDescription>(at(outer.nested[1]).model);
  CHECK(inner.weight == 1);
  CHECK(std::holds_alternative<IsotropicPhaseDescription>(at(inner.nested[0]).model));
  CHECK(std::get<HenyeyGreensteinDescription>(at(inner.nested[1]).model).g == 0.8f);
}

TEST_CASE("media: microflakes may be constant or a grid") {
  const auto flakes = [](const std::string& inside) -> SggxDescription {
    const Description d =
        read_volumes(mitsuba_scene(medium("homogeneous", "<phase type='sggx'>" + inside + "</phase>")));
    REQUIRE(d.phases.size() == 1);
    return std::get<SggxDescription>(d.phases[0].model);
  };
  const auto numbers = flakes(volume("S", "constvolume", "<string name='value' value='1, 2, 3, 0.1, 0.2, -0.3'/>"));
  CHECK(std::get<std::array<float, 6>>(numbers.matrix) == std::array<float, 6>{1, 2, 3, 0.1f, 0.2f, -0.3f});
  const auto grid =
      flakes(volume("S", "gridvolume", file("a.vol") + "<transform name='to_world'><translate x='2'/></transform>"));
  CHECK(std::get<Grid>(grid.matrix).to_world.point({1, 0, 0}) == Vec3f{3, 0, 0});
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

TEST_CASE("media: mixtures of phase functions become nested blends and constant volumes may have transforms") {
  const Description d = read_text(mitsuba_scene(
      "<medium type='homogeneous'><phase type='mixturephase'><string name='weights' value='0.2, 0.3, 0.5'/>"
      "<phase type='rayleigh'/><phase type='isotropic'/><phase type='hg'/></phase>"
      "<volume name='albedo' type='constvolume'><float name='value' value='0.5'/>"
      "<transform name='to_world'><translate x='1'/></transform></volume></medium>"));
  REQUIRE(d.phases.size() == 5);
  const auto whole = std::get<BlendPhaseDescription>(d.phases.at(4).model);
  CHECK(d.media.at(0).phase == PhaseId{4});
  CHECK(whole.weight == doctest::Approx(0.8));
  CHECK(std::holds_alternative<RayleighDescription>(d.phases.at(static_cast<std::size_t>(whole.nested[0])).model));
  const auto rest = std::get<BlendPhaseDescription>(d.phases.at(static_cast<std::size_t>(whole.nested[1])).model);
  CHECK(rest.weight == doctest::Approx(0.625));
  CHECK(std::holds_alternative<IsotropicPhaseDescription>(d.phases.at(static_cast<std::size_t>(rest.nested[0])).model));
  const auto error = [](const std::string& weights) {
    return error_of_text(
        mitsuba_scene("<medium type='homogeneous'><phase type='mixturephase'>"
                      "<string name='weights' value='" +
                      weights +
                      "'/>"
                      "<phase type='rayleigh'/><phase type='hg'/></phase></medium>"));
  };
  CHECK(contains(error("1"), "has 2 nested <phase> and 1 weights"));
  CHECK(contains(error("0.5, 0.2"), "expected 1"));
  CHECK(contains(error("2, -1"), "a non-negative number"));
  CHECK(error("3, 1").empty());
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
  const Description coeffs = read_volumes(
      old_scene(medium("homogeneous", "<rgb name='sigmaS' value='1, 2, 3'/><spectrum name='sigmaA' value='0.5'/>")));
  CHECK(text_of(coefficients<Coefficients>(only_medium(coeffs)).sigma_s) == rgb(1, 2, 3));
  CHECK(text_of(coefficients<Coefficients>(only_medium(coeffs)).sigma_a) == constant(0.5f));

  const Description milk = read_volumes(old_scene(
      "<shape type='sphere'><medium name='interior' type='homogeneous'><string name='material' value='Skimmilk'/>"
      "<float name='scale' value='1000'/></medium></shape>"));
  CHECK(text_of(coefficients<Coefficients>(only_medium(milk)).sigma_s) == rgb(0.70f, 1.22f, 1.90f));
  CHECK(only_medium(milk).scale == 1000);
  REQUIRE(milk.shapes[0].material);
  CHECK(std::holds_alternative<NullDescription>(milk.materials[0].model));
  const Description skin = read_volumes(old_scene(medium("homogeneous", "")));
  CHECK(text_of(coefficients<Coefficients>(only_medium(skin)).sigma_a) == rgb(0.032f, 0.17f, 0.48f));

  const std::string smoke = volume("density", "gridvolume", file("a.vol")) +
                            volume("albedo", "constvolume", "<spectrum name='value' value='0.9'/>") +
                            "<float name='scale' value='100'/>";
  const Description woodcock = read_volumes(old_scene(medium("heterogeneous", smoke)));
  CHECK(std::get<Grid>(coefficients<Pair>(only_medium(woodcock)).sigma_t).use_grid_bbox);
  CHECK(dump(coefficients<Pair>(only_medium(woodcock)).albedo) == constant(0.9f));
  CHECK(woodcock.integrator.medium_estimator == MediumEstimator::kNullMis);
  const Description simpson = read_volumes(old_scene(
      medium("heterogeneous", smoke + "<string name='method' value='simpson'/><float name='stepSize' value='0.5'/>")));
  CHECK(simpson.integrator.medium_estimator == MediumEstimator::kMarching);
  CHECK(simpson.integrator.step_size == 0.5f);
}

TEST_CASE("media: a mesh of Nori contains its medium and its exterior is the surrounding medium") {
  for (const char* names : {"sigmaA sigmaS", "sigma_a sigma_s"}) {
    const std::string text = names, a = text.substr(0, 7 - (text[5] == 'A')), s = text.substr(text.find(' ') + 1);
    const Description d = read_volumes(
        nori_mesh(medium("homogeneous", "<color name='" + a + "' value='1, 2, 3'/><color name='" + s +
                                            "' value='4, 5, 6'/>"
                                            "<float name='density' value='3'/><float name='scale' value='2'/>"
                                            "<phasefunction type='rayleigh'/>")));
    CHECK(text_of(coefficients<Coefficients>(only_medium(d)).sigma_a) == rgb(1, 2, 3));
    CHECK(text_of(coefficients<Coefficients>(only_medium(d)).sigma_s) == rgb(4, 5, 6));
    CHECK(only_medium(d).scale == 6);
    CHECK(only_medium(d).phase);
    const ShapeDescription& shape = d.shapes[0];
    CHECK(shape.interior == MediumId{0});
    CHECK(shape.exterior_is_surrounding);
    REQUIRE(shape.material);
    CHECK(std::holds_alternative<NullDescription>(d.materials[0].model));
  }
  const Description glass = read_volumes(nori_mesh("<bsdf type='dielectric'/>" + medium("homogeneous", "")));
  CHECK(glass.materials.size() == 1);
  CHECK(std::holds_alternative<DielectricDescription>(glass.materials[0].model));
  CHECK_FALSE(read_volumes(nori_mesh("")).shapes[0].exterior_is_surrounding);
}

TEST_CASE("media: grids of Nori fill the shape unless they have a transform") {
  const auto density = [](const std::string& inside) {
    const Description d = read_volumes(nori_mesh(medium("heterogeneous", inside + "<phase type='hg'/>")));
    REQUIRE(only_medium(d).density);
    return *only_medium(d).density;
  };
  const Grid direct = density(file("a.nvdb") + "<string name='gridName' value='density'/>");
  CHECK((direct.fit_to_shape && direct.grid == "density" && direct.format == Grid::Format::kNanoVdb));
  CHECK(density(volume("density", "nanovdb", file("a.nvdb"))).fit_to_shape);
  CHECK(density(volume("density", "vol", file("a.vol"))).format == Grid::Format::kVol);
  CHECK_FALSE(density(volume("density", "gridvolume", file("a.vol") + "<transform name='toWorld'/>")).fit_to_shape);
  CHECK_FALSE(density(file("a.vol") + "<boolean name='fitToShape' value='false'/>").fit_to_shape);
}

TEST_CASE("media: emission is given by colour or temperature") {
  const Description fire = read_volumes(nori_mesh(medium(
      "heterogeneous", file("a.nvdb") +
                           volume("temperature", "nanovdb", file("a.nvdb") + "<string name='gridname' value='heat'/>") +
                           "<float name='temperatureScale' value='1500'/><float name='emissionScale' value='0.01'/>")));
  REQUIRE(only_medium(fire).temperature);
  CHECK(only_medium(fire).temperature->grid == "heat");
  CHECK(only_medium(fire).temperature_scale == 1500);
  CHECK(only_medium(fire).emission_scale == 0.01f);
  const Description glow = read_volumes(nori_mesh(
      medium("homogeneous", "<float name='temperature' value='2'/><float name='temperatureScale' value='1500'/>")));
  const auto& emission = std::get<SpectrumDescription>(*only_medium(glow).emission);
  CHECK(std::get<SpectrumDescription::Blackbody>(emission.value).temperature == 3000);
  CHECK_FALSE(
      read_volumes(nori_mesh(medium("homogeneous", "<float name='temperature' value='0'/>"))).media[0].emission);
}

TEST_CASE("media: a scene of Nori may have a global medium and its glass may absorb") {
  const Description fog = read_volumes(nori_scene(medium("homogeneous", "<color name='sigmaT' value='0.1'/>")));
  CHECK(fog.camera.medium == MediumId{0});
  const Description placed = read_volumes(nori_scene(medium("heterogeneous", file("a.vol"))));
  CHECK_FALSE(placed.media[0].density->fit_to_shape);

  for (const char* type : {"dielectric", "roughdielectric", "null"}) {
    const Description d =
        read_volumes(nori_mesh("<bsdf type='" + std::string(type) + "'><color name='sigmaA' value='1, 2, 3'/></bsdf>"));
    CHECK(text_of(coefficients<Coefficients>(only_medium(d)).sigma_a) == rgb(1, 2, 3));
    CHECK(text_of(coefficients<Coefficients>(only_medium(d)).sigma_s) == constant(0));
    CHECK(d.shapes[0].interior == MediumId{0});
    CHECK(d.shapes[0].exterior_is_surrounding);
  }
}

TEST_CASE("media: volumetric integrator names select strategy and estimator") {
  for (const char* name : {"vol_path", "vol_path_mis", "path_mis_vol", "path_vol_mis", "medium_path", "medium_path_mis",
                           "volpath_mis", "volpath", "volpathmis", "volpath_simple"}) {
    CAPTURE(name);
    REQUIRE(find_integrator(name) != nullptr);
    CHECK(find_integrator(name)->strategy == LightStrategy::kMis);
    CHECK(find_integrator(name)->kind == IntegratorKind::kPath);
    const std::string text = "<integrator type='" + std::string(name) + "'/>";
    CHECK(read_volumes(mitsuba_scene("", "<sensor type='perspective'/>", text)).notes.empty());
  }
  for (const char* name : {"vol_path_mats", "medium_path_mats"})
    CHECK(find_integrator(name)->strategy == LightStrategy::kBsdfOnly);

  const auto integrator = [](const std::string& type, const std::string& estimator) {
    return "<integrator type='" + type + "'><string name='medium_estimator' value='" + estimator +
           "'/><float name='stepSize' value='0.25'/></integrator>";
  };
  for (const std::string& name : kMediumEstimators.names()) {
    const auto nori = read_volumes(nori_scene("", integrator("vol_path_mis", name))).integrator;
    const auto mitsuba =
        read_volumes(mitsuba_scene("", "<sensor type='perspective'/>", integrator("volpathmis", name))).integrator;
    for (const IntegratorSettings& read : {nori, mitsuba}) {
      CHECK(kMediumEstimators.name_of(read.medium_estimator) == name);
      CHECK(read.step_size == 0.25f);
    }
    CHECK(kMediumEstimators.name_of(kMediumEstimators.option("medium estimator", name)) == name);
  }
  CHECK_THROWS_WITH_AS(kMediumEstimators.option("medium estimator", "deltas"),
                       "unknown medium estimator 'deltas', did you mean 'delta'? (known: null_mis, delta, ratio, "
                       "marching)",
                       Error);
  CHECK(contains(error_of_volumes(nori_scene("", integrator("path", "rati"))),
                 "expected null_mis, delta, ratio or marching, did you mean 'ratio'?"));
  CHECK(contains(
      error_of_volumes(nori_scene("", "<integrator type='path'><float name='stepSize' value='0'/></integrator>")),
      "expected a positive number"));
}

TEST_CASE("media: errors in Mitsuba scenes have line and nearest name") {
  const auto homogeneous = [](const std::string& inside) { return mitsuba_scene(medium("homogeneous", inside)); };
  const auto tabphase = [](const std::string& inside) {
    return mitsuba_scene(medium("homogeneous", "<phase type='tabphase'>" + inside + "</phase>"));
  };
  const auto grid = [](const std::string& inside) {
    return mitsuba_scene(medium("heterogeneous", volume("sigma_t", "gridvolume", inside)));
  };
  const auto phase = [&](const std::string& inside) { return homogeneous("\n" + inside); };
  struct Case {
    std::string text;
    const char* expected;
  };
  const Case cases[] = {
      {mitsuba_scene("<medium type='homogenous'/>"),
       "scene.xml:4: unknown medium plugin 'homogenous', did you mean 'homogeneous'?"},
      {homogeneous("<rgb name='sigma_q' value='1'/>"),
       "unknown property 'sigma_q' of medium 'homogeneous', did you mean 'sigma_"},
      {homogeneous("<rgb name='sigma_t' value='-1'/>"), "expected non-negative values"},
      {homogeneous("<rgb name='albedo' value='1.5'/>"), "expected values within [0, 1]"},
      {homogeneous("<float name='scale' value='-1'/>"), "expected a non-negative number"},
      {phase("<phase type='sggx'/>"), "scene.xml:5: phase 'sggx' needs the <volume> 'S'"},
      {phase("<phase type='sggx'>" + volume("S", "constvolume", "<string name='value' value='1 2 3'/>") + "</phase>"),
       "has 3 numbers, expected six: xx yy zz xy xz yz"},
      {phase("<phase type='sggx'>" + volume("S", "constvolume", "<float name='value' value='1'/>") + "</phase>"),
       "given as <float>, expected string"},
      {phase("<phase type='sggx'>" + volume("S", "gridvolume", file("a.nvdb")) + "</phase>"), "expected a .vol file"},
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
      {homogeneous("<rgb name='temperature' value='1,2,3'/>"), "has a colour for 'temperature', expected a number"},
      {homogeneous("<float name='temperature' value='5'/><float name='emission' value='5'/>"),
       "has both 'emission' and 'temperature', expected one"},
      {phase("<phase type='hgg'/>"), "scene.xml:5: unknown phase plugin 'hgg', did you mean 'hg'?"},
      {phase("<phase type='microflake'/>"), "unknown phase plugin 'microflake'"},
      {phase("<phase type='hg'><float name='g' value='1'/></phase>"), "expected a number between -1 and 1"},
      {phase("<phase type='hg'><float name='g' value='-1'/></phase>"), "expected a number between -1 and 1"},
      {phase("<phase type='isotropic'/><phase type='isotropic'/>"), "has 2 nested <phase>, expected one"},
      {phase("<phase type='blendphase'><phase type='hg'/></phase>"), "has 1 nested <phase>, expected two"},
      {phase("<phase type='blendphase'><float name='weight' value='2'/></phase>"), "expected values within [0, 1]"},
      {phase("<phase type='blendphase'>" + volume("weight", "gridvolume", file("a.vol")) + "</phase>"),
       "has a grid for 'weight', expected the same value everywhere"},
      {grid(""), "volume 'gridvolume' needs the string 'filename'"},
      {grid(file("gone.vol")), "file 'gone.vol' not found"},
      {grid(file("a.vdb")), "an OpenVDB file, expected .nvdb or .vol"},
      {grid(file("openvdb.dat")), "an OpenVDB file, expected .nvdb or .vol"},
      {grid(file("text.dat")), "expected a .vol or .nvdb file"},
      {grid(file("a.vol") + "<string name='filter_type' value='cubic'/>"), "expected trilinear or nearest"},
      {grid(file("a.vol") + "<string name='wrap_mode' value='clam'/>"), "did you mean 'clamp'?"},
      {grid(file("a.vol") + "<string name='grid_name' value='x'/>"), "is set for a .vol file"},
      {grid(file("a.vol") + "<boolean name='fit_to_shape' value='true'/>"), "unknown property 'fit_to_shape'"},
      {tabphase(""), "phase 'tabphase' needs the string 'values'"},
      {tabphase("<string name='values' value='1'/>"), "has 1 numbers, expected at least two"},
      {tabphase("<string name='values' value='1, -2, 3'/>"), "has -2.000000, expected a non-negative number"},
      {tabphase("<string name='values' value='0, 0'/>"), "add up to 0.000000, expected more than 0"},
      {tabphase("<string name='values' value='1, x'/>"), "'x'"},
      {mitsuba_scene("<phase type='hg'/>"),
       "<phase> at the top level is not referenced, expected it inside a <medium>"},
      {mitsuba_scene("<volume type='constvolume'/>"), "<volume> at the top level is not referenced"},
      {mitsuba_scene("<subsurface type='dipole'/>"), "<subsurface> at the top level is not referenced"},
      {mitsuba_scene("<shape type='sphere'><medium type='homogeneous' name='inside'/></shape>"),
       "shape 'sphere' takes no nested <medium> of the name 'inside' (known: interior, exterior)"},
      {mitsuba_scene("<shape type='sphere'><medium type='homogeneous' name='interior'/>"
                     "<medium type='homogeneous' name='interior'/></shape>"),
       "shape 'sphere' has a second <medium> of the name 'interior'"},
      {mitsuba_scene("<bsdf type='dielectric'><rgb name='sigma_a' value='1'/></bsdf>"), "unknown property 'sigma_a'"},
      {old_scene(medium("homogeneous", "<string name='material' value='skimilk'/>")),
       "expected the name of a measured medium, did you mean 'skimmilk'?"},
      {old_scene(medium("homogeneous", "<string name='material' value='skin1'/><rgb name='sigmaT' value='1'/>")),
       "is set together with coefficients"},
      {old_scene(medium("heterogeneous", "")), "needs the <volume> 'density'"},
      {old_scene(medium("heterogeneous", "<float name='density' value='1'/><string name='method' value='simson'/>")),
       "did you mean 'simpson'?"},
      {old_scene(medium("heterogeneous", "<float name='density' value='1'/>" +
                                             volume("orientation", "constvolume", "<float name='value' value='1'/>"))),
       "in the matrices of the phase function 'sggx'"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const std::string message = error_of_volumes(c.text);
    CAPTURE(message);
    CHECK(contains(message, c.expected));
  }
}

TEST_CASE("media: errors in Nori scenes have line and nearest name") {
  struct Case {
    std::string text;
    const char* expected;
  };
  const Case cases[] = {
      {nori_mesh("<medium type='homogen'/>"), "scene.xml:2: unknown medium plugin 'homogen'"},
      {nori_mesh(medium("homogeneous", "") + medium("homogeneous", "")), "has 2 nested <medium>, expected one"},
      {nori_mesh(medium("heterogeneous", "")), "needs the <volume> 'density' or the string 'filename'"},
      {nori_mesh(medium("heterogeneous", file("a.vol") + volume("density", "vol", file("a.vol")))),
       "is set together with the <volume> 'density'"},
      {nori_mesh(medium("heterogeneous", volume("density", "nanovdb", file("a.vol")))), "expected a .nvdb file"},
      {nori_mesh(medium("heterogeneous", volume("density", "vol", file("a.nvdb")))), "expected a .vol file"},
      {nori_mesh(medium("heterogeneous", volume("density", "vol",
                                                file("a.vol") + "<transform name='toWorld'/>"
                                                                "<boolean name='fitToShape' value='true'/>"))),
       "is true together with 'toWorld'"},
      {nori_mesh(medium("homogeneous", volume("density", "vol", file("a.vol")))), "use type 'heterogeneous' for grids"},
      {nori_mesh(medium("homogeneous", "<color name='density' value='1,2,3'/>")), "has a colour for 'density'"},
      {nori_mesh(medium("homogeneous", "<color name='sigmaT' value='1'/><color name='sigmaS' value='1'/>")),
       "mixes 'sigma_t' and 'albedo' with 'sigma_a' and 'sigma_s'"},
      {nori_mesh("<bsdf type='dielectric'><color name='sigmaA' value='1'/></bsdf>" + medium("homogeneous", "")),
       "has a <medium> and a bsdf with 'sigmaA'"},
      {nori_mesh("<bsdf type='diffuse'><color name='sigmaA' value='1'/></bsdf>"), "unknown property 'sigmaA'"},
      {nori_mesh("<bsdf type='dielectric'><color name='sigmaA' value='-1'/></bsdf>"), "expected non-negative values"},
      {nori_mesh("<bsdf type='blendbsdf'><bsdf type='null'><color name='sigmaA' value='1'/></bsdf>"
                 "<bsdf type='null'><color name='sigmaA' value='1'/></bsdf></bsdf>"),
       "is set by two materials of one surface"},
      {nori_scene(medium("homogeneous", "") + medium("homogeneous", "")),
       "scene.xml:2: a second <medium>, expected one"},
      {nori_scene(medium("heterogeneous", file("a.vol") + "<boolean name='fitToShape' value='true'/>")),
       "is true in a medium without a shape"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const std::string message = error_of_volumes(c.text);
    CAPTURE(message);
    CHECK(contains(message, c.expected));
  }
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

}  // namespace sheaf::test_medium_reading
