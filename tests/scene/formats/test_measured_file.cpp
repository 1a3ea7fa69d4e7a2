// Files of measured BRDFs: fields and error messages.
#include "scene/formats/measured_file.h"
#include "scene/formats/tensor_file.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/measured_testing.h"

#include "scene/compile/compile.h"

#include <doctest/doctest.h>

#include <cstring>
#include <functional>

namespace sheaf::test_measured_file {

namespace {

using Fields = std::vector<TensorField>;

MeasuredBrdf small_brdf(std::size_t channels = 3) {
  return TabulatedFacets{.theta = {0, 1}, .side = 4, .sample_side = 3, .channels = channels}.tabulate();
}

std::string error_of_bytes(const std::string& bytes) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.bsdf", bytes);
  try {
    read_measured(folder / "a.bsdf", false);
  } catch (const SceneError& error) {
    const std::string message = error.what(), start = (folder / "a.bsdf").string() + ": ";
    CHECK(message.starts_with(start));
    return message.substr(std::min(start.size(), message.size()));
  }
  return {};
}

TensorField& field(Fields& fields, const std::string& name) {
  return *std::find_if(fields.begin(), fields.end(), [&](const TensorField& f) { return f.name == name; });
}

/// The error for the file of small_brdf() after a change.
std::string error_with(const std::function<void(Fields&)>& change, std::size_t channels = 3) {
  Fields fields = measured_fields(small_brdf(channels));
  change(fields);
  return error_of_bytes(tensor_bytes(fields));
}

}  // namespace

TEST_CASE("measured files: all fields are read") {
  const TemporaryFolder folder;
  for (const std::size_t channels : {std::size_t{3}, std::size_t{5}}) {
    MeasuredBrdf expected = small_brdf(channels);
    expected.values.values[7] = -0.5f;
    write_bytes(folder / "a.bsdf", tensor_bytes(measured_fields(expected)));
    const MeasuredBrdf found = read_measured(folder / "a.bsdf", true);
    expected.values.values[7] = 0;
    CHECK(found.phi == expected.phi);
    CHECK(found.theta == expected.theta);
    CHECK(found.wavelengths == expected.wavelengths);
    CHECK(found.channels == channels);
    CHECK(found.jacobian);
    for (auto grids : {&MeasuredBrdf::ndf, &MeasuredBrdf::sigma, &MeasuredBrdf::vndf, &MeasuredBrdf::luminance,
                       &MeasuredBrdf::values}) {
      CHECK((found.*grids).width == (expected.*grids).width);
      CHECK((found.*grids).height == (expected.*grids).height);
      CHECK((found.*grids).values == (expected.*grids).values);
    }
  }
}

TEST_CASE("measured files: either spectra or colors are read as requested") {
  const TemporaryFolder folder;
  Fields fields = measured_fields(small_brdf(5));
  fields.push_back(field(fields, "spectra"));
  fields.back().name = "rgb";
  fields.back().shape[2] = 3;
  write_bytes(folder / "a.bsdf", tensor_bytes(fields));
  CHECK(read_measured(folder / "a.bsdf", true).channels == 5);
  CHECK(read_measured(folder / "a.bsdf", false).channels == 3);
  CHECK(read_measured(folder / "a.bsdf", false).wavelengths.empty());
}

TEST_CASE("measured files: malformed files are errors with a message") {
  const auto without = [](const char* name) {
    return error_with([&](Fields& f) { std::erase_if(f, [&](const TensorField& g) { return g.name == name; }); });
  };
  CHECK(test::contains(without("ndf"), "has no field 'ndf' (it has: description, jacobian, luminance, phi_i"));
  CHECK(test::contains(without("rgb"), "has neither a field 'rgb' nor a field 'spectra'"));
  CHECK(test::contains(without("jacobian"), "has no field 'jacobian'"));
  CHECK(without("description") == "");
  CHECK(error_with([](Fields& f) { std::erase_if(f, [](auto& g) { return g.name == "wavelengths"; }); }, 5) != "");
  const auto with = [](const char* name, const std::function<void(TensorField&)>& change) {
    return error_with([&](Fields& f) { change(field(f, name)); });
  };
  CHECK(with("theta_i", [](TensorField& f) { f.type = 5; }) == "field 'theta_i' holds uint32, expected float32");
  CHECK(with("theta_i", [](TensorField& f) { f.type = 12; }) ==
        "field 'theta_i' has the type 12, expected one from 1 to 11");
  CHECK(with("theta_i", [](TensorField& f) { f.shape = {1, 2}; }) == "field 'theta_i' has 2 dimensions, expected 1");
  CHECK(with("theta_i", [](TensorField& f) { f.shape = {}; }) == "field 'theta_i' has 0 dimensions, expected 1");
  CHECK(with("theta_i", [](TensorField& f) { f.shape = {0}; }) == "field 'theta_i' is empty along one dimension");
  CHECK(with("theta_i", [](TensorField& f) { f.shape.resize(17, 1); }) ==
        "field 'theta_i' has 17 dimensions, expected at most 16");
  CHECK(with("theta_i", [](TensorField& f) { std::swap(f.bytes[2], f.bytes[6]), std::swap(f.bytes[3], f.bytes[7]); }) ==
        "field 'theta_i': its numbers do not increase");
  CHECK(with("vndf", [](TensorField& f) { std::memcpy(f.bytes.data() + 8, "\0\0\xc0\x7f", 4); }) ==
        "field 'vndf': its number 2 is not finite");
  CHECK(with("vndf", [](TensorField& f) {
          f.shape = {2, 1, 4, 4};
        }) == "field 'vndf' has 2 x 1 x 4 x 4 numbers, expected 1 x 2 grids");
  CHECK(with("vndf", [](TensorField& f) {
          f.shape = {1, 2, 16, 1};
        }) == "field 'vndf' has grids with a side of 1 points, expected 2 to 65536");
  CHECK(with("rgb", [](TensorField& f) {
          f.shape = {1, 2, 3, 2, 2};
        }) == "field 'rgb' has grids of 2 x 2, expected 3 x 3 as of field 'luminance'");
  for (const std::uint64_t huge : {std::uint64_t{1} << 40, std::uint64_t{1} << 63, ~std::uint64_t{0}})
    for (const std::vector<std::uint64_t>& shape : {std::vector<std::uint64_t>{huge}, {huge, huge}, {4, huge, 4}})
      CHECK(test::contains(with("ndf", [&](TensorField& f) { f.shape = shape; }), "does not fit into the file's"));
  CHECK(error_with([](Fields& f) { f.push_back(f[0]); }) == "field 'phi_i' appears twice");
  CHECK(error_with([](Fields& f) {
          f[0] = tensor_field("phi_i", {3}, {-1.0f, 0.0f, 1.0f});
        }) == "field 'phi_i' goes from -1 to 1 (expected a full, half or quarter turn, in radians)");
}

TEST_CASE("measured files: every truncated or damaged file is an error or a material and never a crash") {
  const std::string bytes = tensor_bytes(measured_fields(small_brdf()));
  CHECK(error_of_bytes(bytes) == "");
  CHECK(test::contains(error_of_bytes("tensor"), "expected a tensor file"));
  std::string other = bytes;
  other[12] = 2;
  CHECK(error_of_bytes(other) == "expected version 1.0 of the format, found 2.0");
  for (std::size_t size = 0; size < 512; size += 3) CHECK(error_of_bytes(bytes.substr(0, size)) != "");
  CHECK(test::contains(error_of_bytes(bytes.substr(0, bytes.size() - 7)), "truncated?"));
  for (std::size_t i = 0; i < 420; i += 2)
    for (const char damage : {'\0', '\x7f', '\xff'}) {
      std::string damaged = bytes;
      damaged[i] = damage;
      error_of_bytes(damaged);
    }
}

TEST_CASE("measured files: equal files share a table and errors name the line of the scene") {
  const TemporaryFolder folder;
  write_bytes(folder / "a.bsdf", tensor_bytes(measured_fields(small_brdf())));
  write_bytes(folder / "b.bsdf", "tensor");
  const auto material = [](const std::string& file) {
    return "<shape type='sphere'><bsdf type='measured'><string name='filename' value='" + file + "'/></bsdf></shape>";
  };
  const auto scene = [&](const std::string& inside) {
    return read_scene(test::write_below(folder, "scene.xml", test::mitsuba_scene(inside)));
  };
  const auto one = compile_scene(scene(material("a.bsdf")), {});
  const auto two = compile_scene(scene(material("a.bsdf") + "\n" + material("a.bsdf")), {});
  REQUIRE(one->view().materials.closure_tables != nullptr);
  CHECK(one->view().materials.closure_tables[0] == two->view().materials.closure_tables[0]);
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    CompileOptions options;
    options.color = color;
    std::string message;
    try {
      compile_scene(scene(material("b.bsdf")), options);
    } catch (const SceneError& error) { message = error.what(); }
    CHECK(test::contains(message, "scene.xml:4: "));
    CHECK(test::contains(message, "b.bsdf: expected a tensor file"));
  }
  CHECK(test::contains(test::error_of_text(test::mitsuba_scene("<bsdf type='measured'/>")),
                       "scene.xml:4: bsdf 'measured' needs the string 'filename'"));
}

}  // namespace sheaf::test_measured_file
