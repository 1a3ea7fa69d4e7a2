// Participating media of Nori: shapes, grids, emission, global media, and errors.
#include "tests/scene/dialects/medium_files.h"
#include "tests/support/scene_errors.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_nori_media {

using namespace test;
using namespace medium_files;

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
  CHECK((direct.fit_to_shape && direct.grid == "density" && direct.format == Grid::Format::kSparse));
  CHECK(density(volume("density", "nanovdb", file("a.nvdb"))).fit_to_shape);
  CHECK(density(volume("density", "vol", file("a.vol"))).format == Grid::Format::kVol);
  CHECK_FALSE(density(volume("density", "gridvolume", file("a.vol") + "<transform name='toWorld'/>")).fit_to_shape);
  CHECK_FALSE(density(file("a.vol") + "<boolean name='fitToShape' value='false'/>").fit_to_shape);
}

TEST_CASE("media: emission is given by color or temperature") {
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

TEST_CASE("media: errors in Nori scenes have line and nearest name") {
  check_errors(
      {
          {nori_mesh("<medium type='homogen'/>"), "scene.xml:2: unknown medium plugin 'homogen'"},
          {nori_mesh(medium("homogeneous", "") + medium("homogeneous", "")), "has 2 nested <medium>, expected one"},
          {nori_mesh(medium("heterogeneous", "")), "needs the <volume> 'density' or the string 'filename'"},
          {nori_mesh(medium("heterogeneous", file("a.vol") + volume("density", "vol", file("a.vol")))),
           "is set together with the <volume> 'density'"},
          {nori_mesh(medium("heterogeneous", volume("density", "nanovdb", file("a.vol")))),
           "expected a .nvdb or .vdb file"},
          {nori_mesh(medium("heterogeneous", volume("density", "vol", file("a.nvdb")))), "expected a .vol file"},
          {nori_mesh(medium("heterogeneous", volume("density", "vol",
                                                    file("a.vol") + "<transform name='toWorld'/>"
                                                                    "<boolean name='fitToShape' value='true'/>"))),
           "is true together with 'toWorld'"},
          {nori_mesh(medium("homogeneous", volume("density", "vol", file("a.vol")))),
           "use type 'heterogeneous' for grids"},
          {nori_mesh(medium("homogeneous", "<color name='density' value='1,2,3'/>")), "has a color for 'density'"},
          {nori_mesh(medium("homogeneous", "<color name='sigmaT' value='1'/><color name='sigmaS' value='1'/>")),
           "mixes 'sigma_t' and 'albedo' with 'sigma_a' and 'sigma_s'"},
          {nori_mesh("<bsdf type='dielectric'><color name='sigmaA' value='1'/></bsdf>" + medium("homogeneous", "")),
           "has a <medium> and a bsdf with 'sigmaA'"},
          {nori_mesh("<bsdf type='diffuse'><color name='sigmaA' value='1'/></bsdf>"), "unknown property 'sigmaA'"},
          {nori_mesh("<bsdf type='dielectric'><color name='sigmaA' value='-1'/></bsdf>"),
           "expected non-negative values"},
          {nori_mesh("<bsdf type='blendbsdf'><bsdf type='null'><color name='sigmaA' value='1'/></bsdf>"
                     "<bsdf type='null'><color name='sigmaA' value='1'/></bsdf></bsdf>"),
           "is set by two materials of one surface"},
          {nori_scene(medium("homogeneous", "") + medium("homogeneous", "")),
           "scene.xml:2: a second <medium>, expected one"},
          {nori_scene(medium("heterogeneous", file("a.vol") + "<boolean name='fitToShape' value='true'/>")),
           "is true in a medium without a shape"},
      },
      error_of_volumes);
}

}  // namespace sheaf::test_nori_media
