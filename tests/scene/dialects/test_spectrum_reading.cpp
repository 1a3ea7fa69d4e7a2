// Spectra of Mitsuba in every notation, and spectrum files.
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_spectrum_reading {

using namespace test;

namespace {

std::string reflectance_of(const std::string& property) {
  const Description d = read_text(mitsuba_scene("<bsdf type='diffuse'>" + property + "</bsdf>"));
  return dump(std::get<DiffuseDescription>(d.materials.at(0).model).reflectance);
}

std::string radiance_of(const std::string& property) {
  return dump(*read_text(mitsuba_scene("<shape type='sphere'><emitter type='area'>" + property + "</emitter></shape>"))
                   .shapes.at(0)
                   .radiance);
}

}  // namespace

TEST_CASE("Mitsuba: spectra are read in every notation") {
  CHECK(reflectance_of("<rgb name='reflectance' value='0.25'/>") == "rgb 0x1p-2 0x1p-2 0x1p-2");
  CHECK(reflectance_of("<rgb name='reflectance' value='0.25 0.5, 1'/>") == "rgb 0x1p-2 0x1p-1 0x1p+0");
  CHECK(reflectance_of("<rgb name='reflectance' value='#ff0000'/>") == "rgb 0x1p+0 0x0p+0 0x0p+0");
  CHECK(reflectance_of("<srgb name='reflectance' value='#00ff00'/>") == "rgb 0x0p+0 0x1p+0 0x0p+0");
  CHECK(reflectance_of("<float name='reflectance' value='0.25'/>") == "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum name='reflectance' value='0.25'/>") == "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum name='reflectance' value='400:0.5, 700:0.25'/>") ==
        "table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  CHECK(reflectance_of(
            "<texture type='rawconstant' name='reflectance'><vector name='value' value='0.1,0.2,0.3'/></texture>") ==
        reflectance_of("<rgb name='reflectance' value='0.1,0.2,0.3'/>"));
  CHECK(
      reflectance_of("<spectrum type='rawconstant' name='reflectance'><float name='value' value='0.25'/></spectrum>") ==
      "constant 0x1p-2");
  CHECK(reflectance_of("<texture type='volume' name='reflectance'><volume name='volume' type='constvolume'>"
                       "<float name='value' value='0.25'/></volume></texture>") == "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum type='uniform' name='reflectance'><float name='value' value='0.25'/></spectrum>") ==
        "constant 0x1p-2");
  CHECK(reflectance_of("<spectrum type='irregular' name='reflectance'><string name='wavelengths' value='400, 700'/>"
                       "<string name='values' value='0.5, 0.25'/></spectrum>") ==
        "table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  CHECK(reflectance_of("<spectrum type='regular' name='reflectance'><float name='wavelength_min' value='400'/><float "
                       "name='wavelength_max' value='700'/><string name='values' value='0.5, 0.25'/></spectrum>") ==
        "table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  const std::string blackbody = "blackbody 0x1.388p+12 0x1p+1";
  CHECK(radiance_of("<blackbody name='radiance' temperature='5000K' scale='2'/>") == blackbody);
  CHECK(radiance_of("<spectrum type='blackbody' name='radiance'><float name='temperature' value='5000'/><float "
                    "name='scale' value='2'/></spectrum>") == blackbody);
  CHECK(radiance_of("<spectrum type='d65' name='radiance'><float name='scale' value='2'/></spectrum>") ==
        "constant 0x1p+1");
  const Description d = read_text(mitsuba_scene("<bsdf type='diffuse'><srgb name='reflectance' value='0.5'/></bsdf>"));
  const auto& reflectance = std::get<DiffuseDescription>(d.materials.at(0).model).reflectance;
  CHECK(std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(reflectance).value).value.x == near(0.21404));
}

TEST_CASE("Mitsuba: spectra are read from files") {
  const TemporaryFolder folder;
  const auto scene =
      write_below(folder, "scene.xml",
                  mitsuba_scene("<bsdf type='diffuse'><spectrum name='reflectance' filename='data/a.spd'/></bsdf>"));
  auto message = [&](const std::string& spd) {
    write_below(folder, "data/a.spd", spd);
    return error_of(scene);
  };
  CHECK(message("# a comment\n400 0.5\n\n700\t0.25 # the end\n").empty());
  const Description d = read_scene(scene);
  CHECK(dump(d.materials.at(0)) == "diffuse table 0x1.9p+8:0x1p-1 0x1.5ep+9:0x1p-2");
  CHECK(contains(message("400 0.5\n300 0.5\n"), "data/a.spd:2: wavelengths must increase"));
  CHECK(contains(message("400 0.5\n500\n"), "data/a.spd:2: expected a wavelength and a value, found '500'"));
  CHECK(contains(message("400 0.5\n500 x\n"), "data/a.spd:2: spectrum value is 'x', expected a number"));
  CHECK(contains(message(""), "data/a.spd: spectrum needs at least two"));
  CHECK(contains(message("400 2\n500 2\n"), "scene.xml:4: property 'reflectance' of bsdf 'diffuse' contains 2"));
}

}  // namespace sheaf::test_spectrum_reading
