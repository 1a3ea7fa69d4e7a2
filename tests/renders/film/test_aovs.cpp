// Layers of the first surface against known planes, maps and materials; halves of the samples; light groups.
#include "core/io/error.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"

#include <memory>

namespace sheaf::test_aovs {

namespace {

const AovSet kSurfaces{aov_named("albedo"),   aov_named("normal"), aov_named("geometric_normal"),
                       aov_named("position"), aov_named("depth"),  aov_named("uv")};

Image render_image(const Description& d, const RenderOptions& options, ColorMode color = ColorMode::kRgb) {
  CompileOptions compile;
  compile.color = color;
  return render(*compile_scene(d, compile), options).to_image();
}

RenderOptions with(AovSet aovs, std::uint32_t samples = 4) {
  RenderOptions options;
  options.aovs = aovs;
  options.samples_per_pixel = samples;
  return options;
}

float value(const Image& image, int x, int y, const char* channel) {
  const int c = image.find_channel(channel);
  REQUIRE(c >= 0);
  return image.at(x, y, c);
}

Vec3f vector(const Image& image, int x, int y, const std::string& layer, const char* components = "XYZ") {
  const auto one = [&](int i) { return value(image, x, y, (layer + "." + components[i]).c_str()); };
  return {one(0), one(1), one(2)};
}

/// `tolerance`: relative to the length of the vector.
void check_vector(Vec3f found, Vec3f expected, double tolerance = 1e-5) {
  const double distance = tolerance * static_cast<double>(length(expected));
  CHECK(found.x == within(expected.x, distance));
  CHECK(found.y == within(expected.y, distance));
  CHECK(found.z == within(expected.z, distance));
}

/// A square of side 20 at z = 4, perpendicular to the camera's axis.
Description wall(MaterialId (*add)(Description&)) {
  Description d = empty_scene(8, 8);
  add_rectangle(d, Transform::translate({0, 0, 4}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({10, 10, 1}),
                add(d));
  add_constant_light(d, 1);
  return d;
}

MaterialId colored(Description& d) { return add_diffuse_rgb(d, 0.2f, 0.4f, 0.6f); }

/// The wall is rotated about y, so that world x and texture u have opposite directions.
void check_wall(const Image& image, int x, int y) {
  check_vector(vector(image, x, y, "N"), {0, 0, -1});
  check_vector(vector(image, x, y, "Ng"), {0, 0, -1});
  CHECK(value(image, x, y, "Z") == near(4));
  const Vec3f p = vector(image, x, y, "P");
  CHECK(p.z == near(4));
  CHECK(value(image, x, y, "uv.U") == near(0.5 - 0.05 * double{p.x}));
  CHECK(value(image, x, y, "uv.V") == near(0.5 + 0.05 * double{p.y}));
}

}  // namespace

TEST_CASE("layers: a wall has the known values in both color modes and both filter modes") {
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral})
    for (const FilterMode mode : {FilterMode::kWeighted, FilterMode::kImportance})
      for (const bool wide : {false, true}) {
        CAPTURE(static_cast<int>(color));
        CAPTURE(static_cast<int>(mode));
        Description d = wall(colored);
        d.film.filter_mode = mode;
        if (wide) d.film.filter.kind = PixelFilter::Kind::kGaussian;
        const Image image = render_image(d, with(kSurfaces, 64), color);
        for (const auto& [x, y] : {std::pair{0, 0}, {3, 5}, {7, 7}}) {
          // With filter importance sampling, weights vary, and means are not exact.
          if (mode == FilterMode::kWeighted || !wide) check_wall(image, x, y);
          const Vec3f p = vector(image, x, y, "P");
          const float width = wide ? 0.3f : 0.1f;
          CHECK(std::fabs(p.x - (3.5f - static_cast<float>(x))) < width);
          CHECK(std::fabs(p.y - (3.5f - static_cast<float>(y))) < width);
        }
        check_vector(vector(image, 4, 4, "albedo", "RGB"), {0.2f, 0.4f, 0.6f}, color == ColorMode::kRgb ? 1e-5 : 0.02);
      }
}

TEST_CASE("layers: every layer of the first surface gets values") {
  Description d = wall(colored);
  d.motions.emplace_back(std::vector<AnimatedTransform::Key>{
      {0, d.camera.to_world}, {1, Transform::translate({0.1f, 0.1f, 0}) * d.camera.to_world}});
  d.camera.motion = MotionId{0};
  d.shutter.close = 1;
  const Image image = render_image(d, with(aovs_from_names("all"), 16));
  for (const AovEntry& entry : kAovList) {
    if (entry.source != AovSource::kVertex) continue;
    CAPTURE(std::string(entry.name));
    float largest = 0;
    for (const std::string_view channel : entry.channels)
      if (!channel.empty()) largest = std::max(largest, std::abs(value(image, 1, 2, std::string(channel).c_str())));
    CHECK(largest > 0);
  }
}

TEST_CASE("layers: depth is measured along the camera axis for every camera transform") {
  Description d = wall(colored);
  d.camera.to_world = Transform::translate({1, 0.5f, -2}) * Transform::scale({3, 3, 3});
  const Image image = render_image(d, with(kSurfaces));
  CHECK(value(image, 0, 0, "Z") == near(6));
  CHECK(value(image, 7, 3, "Z") == near(6));
  // A panorama has no axis, so that depth is the distance.
  d.camera.projection = CameraDescription::Projection::kSpherical;
  d.camera.to_world = Transform();
  const Image around = render_image(d, with(kSurfaces, 1));
  for (int x = 0; x < 8; ++x) {
    const Vec3f p = vector(around, x, 4, "P");
    CHECK(value(around, x, 4, "Z") == near(length(p)));
  }
}

TEST_CASE("layers: samples without a hit are zero and count in the mean") {
  Description d = wall(colored);
  // Half of the samples of each pixel at x = 4 miss the wall.
  d.shapes[0].to_world =
      Transform::translate({1.5f, 0, 4}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({2, 10, 1});
  const Image image = render_image(d, with(kSurfaces, 256));
  CHECK(value(image, 7, 2, "Z") == 0);
  check_vector(vector(image, 7, 2, "albedo", "RGB"), {0, 0, 0});
  check_vector(vector(image, 4, 2, "N"), {0, 0, -0.5f}, 0.01);
  CHECK(value(image, 4, 2, "Z") == near(2, 0.01));
}

TEST_CASE("layers: normals include normal maps and face the camera") {
  Description d = empty_scene(4, 4);
  const Vec3f n = normalize(Vec3f{0.3f, 0.2f, 0.9f});
  Image normals(1, 1, {"R", "G", "B"});
  normals.data = {0.5f * n.x + 0.5f, 0.5f * n.y + 0.5f, 0.5f * n.z + 0.5f};
  BitmapDescription map;
  map.raw = true;
  map.made = std::make_shared<const Image>(normals);
  d.textures.emplace_back().model = map;
  const MaterialId mapped = add_material(d, NormalMapDescription{TextureId{0}, false, add_diffuse(d, 0.5f)});
  const Transform position = Transform::translate({0, 0, 4}) * Transform::scale({10, 10, 1});
  add_rectangle(d, position * Transform::rotate({0, 1, 0}, 180), mapped);
  Image image = render_image(d, with(kSurfaces));
  check_vector(vector(image, 1, 2, "N"), {-n.x, n.y, -n.z}, 1e-3);
  check_vector(vector(image, 1, 2, "Ng"), {0, 0, -1});
  // One-sided surface, seen from behind.
  d.shapes[0].to_world = position;
  d.shapes[0].material = add_diffuse(d, 0.5f);
  image = render_image(d, with(kSurfaces));
  check_vector(vector(image, 1, 2, "N"), {0, 0, -1});
  check_vector(vector(image, 1, 2, "Ng"), {0, 0, -1});
}

TEST_CASE("layers: the albedo is the reflectance under constant illumination") {
  struct Variant {
    const char* name;
    MaterialId (*add)(Description&);
    double allowed;
  };
  const Variant variants[] = {
      {"diffuse", colored, 1e-4},
      {"mirror", [](Description& d) { return add_mirror(d, 0.9f); }, 1e-4},
      {"plastic", [](Description& d) { return add_material(d, PlasticDescription{}); }, 0.02},
      {"rough metal",
       [](Description& d) {
         ConductorDescription metal;
         metal.specular_reflectance = SpectrumDescription::rgb(0.9f, 0.6f, 0.3f);
         metal.roughness = RoughnessDescription{};
         return add_material(d, metal);
       },
       0.02},
      {"principled", [](Description& d) { return add_material(d, PrincipledDescription{}); }, 0.04},
  };
  for (const Variant& variant : variants) {
    CAPTURE(std::string(variant.name));
    Description d = wall(variant.add);
    // One surface under a constant environment of radiance 1.
    d.integrator.max_depth = 2;
    d.integrator.rr_depth = 3;
    d.integrator.strategy = LightStrategy::kBsdfOnly;  // noise-free where the BSDF is sampled exactly
    d.sampler.kind = SamplerKind::kIndependent;
    const Image image = render_image(d, with({aov_named("albedo")}, 1024));
    Vec3f light{}, albedo{};
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        light = light + Vec3f{image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)} * (1.0f / 64);
        albedo = albedo + vector(image, x, y, "albedo", "RGB") * (1.0f / 64);
      }
    CHECK(std::fabs(albedo.x - light.x) < variant.allowed);
    CHECK(std::fabs(albedo.y - light.y) < variant.allowed);
    CHECK(std::fabs(albedo.z - light.z) < variant.allowed);
  }
}

TEST_CASE("layers: the albedo of glass is one") {
  const Image image = render_image(wall([](Description& d) { return add_glass(d); }), with(kSurfaces));
  check_vector(vector(image, 4, 4, "albedo", "RGB"), {1, 1, 1});
}

TEST_CASE("layers: the first half is the image of half the samples and features have variances") {
  Description d = wall(colored);
  add_sphere(d, {0.3f, 0.2f, 3}, 1, add_mirror(d));
  add_point_light(d, {1, 2, 0}, 10);
  const Image image =
      render_image(d, with({aov_named("half"), aov_named("variance"), aov_named("normal"), aov_named("depth")}, 32));
  RenderOptions half_options;
  half_options.samples_per_pixel = 16;
  const Image half = render_image(d, half_options);
  bool same = true, differs = false;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x)
      for (int c = 0; c < 3; ++c) {
        const float first = image.at(x, y, image.find_channel("half.R") + c);
        same = same && first == half.at(x, y, c);
        differs = differs || first != image.at(x, y, c);
      }
  CHECK(same);
  CHECK(differs);
  CHECK(value(image, 0, 0, "variance.Z") < 1e-9);
  double largest = 0;
  for (int x = 0; x < 8; ++x) largest = std::max(largest, double{value(image, x, 4, "variance.N.X")});
  CHECK(largest > 1e-6);
  for (const char* name : {"variance.N.Y", "variance.R", "variance.B"}) CHECK(image.find_channel(name) >= 0);
  // Independent samples form one replicate, which is split into halves.
  d.sampler.kind = SamplerKind::kIndependent;
  const Image independent = render_image(d, with({aov_named("half")}, 32));
  half_options.seed = 0;
  const Image first = render_image(d, half_options);
  CHECK(value(independent, 3, 3, "half.G") == first.at(3, 3, 1));
}

TEST_CASE("layers: each camera of a batch has depth along its own axis") {
  Description d = empty_scene(8, 4);
  const MaterialId gray = add_two_sided(d, add_diffuse(d, 0.5f));
  // Walls perpendicular to the axes of both cameras, at different distances. Each fills the view of its camera.
  add_rectangle(d, Transform::translate({0, 0, 5}) * Transform::scale({50, 50, 1}), gray);
  add_rectangle(
      d, Transform::translate({-7, 0, -15}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({20, 50, 1}), gray);
  CameraDescription second = d.camera;
  second.to_world = Transform::look_at({2, 0, -6}, {-1, 0, -6}, {0, 1, 0});
  d.more_cameras.push_back(second);
  const Image image = render_image(d, with({aov_named("depth"), aov_named("position")}, 16));
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) CHECK(value(image, x, y, "Z") == near(5, 1e-5));
    for (const int x : {5, 6}) {
      CHECK(value(image, x, y, "P.X") == near(-7, 1e-5));
      CHECK(value(image, x, y, "Z") == near(9, 1e-5));
    }
  }
}

TEST_CASE("layers: the first half is the smaller one for an odd number of replicates") {
  Description d = wall(colored);
  add_point_light(d, {1, 2, 0}, 10);
  add_sphere(d, {0.3f, 0.2f, 3}, 1, add_two_sided(d, add_diffuse(d, 0.7f)));
  for (const int sets : {3, 5}) {
    CAPTURE(sets);
    RenderOptions options = with({aov_named("half")}, static_cast<std::uint32_t>(8 * sets));
    options.replicates = sets;
    const Image image = render_image(d, options);
    // Renders only the samples of the replicates that make up the half.
    options.samples = SampleRange{0, static_cast<std::uint32_t>(8 * (sets / 2))};
    const Image part = render_image(d, options);
    double difference = 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        for (int c = 0; c < 3; ++c) {
          CHECK(image.at(x, y, image.find_channel("half.R") + c) == part.at(x, y, c));
          difference += std::fabs(double{part.at(x, y, c)} - double{image.at(x, y, c)});
        }
    CHECK(difference > 1e-3);
  }
}

TEST_CASE("layers: media and masks do not count as surfaces and the surfaces behind them do") {
  Description d = wall(colored);
  MediumDescription thin = fog(0.1f, 0.9f);
  fill(d, add_sphere(d, {0, 0, 2}, 1, add_material(d, NullDescription{})), add_medium(d, thin));
  Image image = render_image(d, with(kSurfaces, 1024));
  // The sphere is about 2 long in the middle: exp(-0.1 * length) of the samples pass it.
  CHECK(value(image, 4, 4, "Z") == near(4 * std::exp(-0.1 * 1.85), 0.03));
  CHECK(value(image, 0, 0, "Z") == near(4));
  d = wall(colored);
  add_rectangle(d, Transform::translate({0, 0, 2}) * Transform::scale({10, 10, 1}),
                add_material(d, MaskDescription{0.25f, add_diffuse(d, 1)}));
  image = render_image(d, with(kSurfaces, 1024));
  CHECK(value(image, 4, 4, "Z") == near(0.25 * 2 + 0.75 * 4, 0.02));
}

TEST_CASE("layers: layers without data are errors") {
  Description d = wall(colored);
  const auto fails = [&](const RenderOptions& options) {
    try {
      render_image(d, options);
    } catch (const Error& error) { return error.exit_code() == ExitCode::kUsage; }
    return false;
  };
  CHECK(fails(with({aov_named("half")}, 1)));
  d.integrator.kind = IntegratorKind::kNormals;
  CHECK(fails(with({aov_named("normal")})));
  d.integrator.kind = IntegratorKind::kPath;
  d.integrator.max_depth = 1;
  CHECK(fails(with({aov_named("normal")})));
  CHECK_FALSE(fails(with({aov_named("variance")})));
  d.integrator.kind = IntegratorKind::kLightTracer;
  CHECK(fails(with({aov_named("half")})));
  CHECK_THROWS_WITH(aovs_from_names("albedo,normals"), doctest::Contains("did you mean 'normal'? (known: albedo"));
  CHECK(aovs_from_names("depth,uv,depth") == AovSet{aov_named("uv"), aov_named("depth")});
  CHECK(aovs_from_names("all").contains(aov_named("half")));
  CHECK(aovs_from_names("") == AovSet());
}

}  // namespace sheaf::test_aovs
