// The footprint of textures at hits: in closed form on squares, for camera rays and scattered rays, instances and the
// samples of a pixel.
#include "core/image/image.h"
#include "kernels/stages/ray_footprint.h"
#include "scene/compile/compile_camera.h"
#include "tests/support/instancing_testing.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"

#include <cmath>

namespace sheaf::test_ray_footprint {

namespace {

constexpr float kDistance = 4, kScale = 3;

/// A textured square of 6 x 6 m that faces the camera from 4 m, alone or as an instance of a square of 2 x 2 m.
Description textured_square(bool instanced) {
  Description d = empty_scene(16, 16);
  BitmapDescription bitmap;
  bitmap.made = std::make_shared<const Image>(64, 64, std::vector<std::string>{"Y"});
  d.textures.emplace_back().model = bitmap;
  const MaterialId material = add_material(d, DiffuseDescription{TextureId{0}});
  const Transform turned = Transform::translate({0, 0, kDistance}) * Transform::rotate({0, 1, 0}, 180);
  add_rectangle(d, instanced ? Transform() : turned * Transform::scale({kScale, kScale, 1}), material);
  if (!instanced) return d;
  const std::uint32_t group = add_group(d, std::move(d.shapes));
  d.shapes.clear();
  add_instance(d, group, turned * Transform::scale({kScale, kScale, 1}));
  return d;
}

/// Width of the footprint along u, m, of a ray along +z with the given flags and pdf.
template <class L>
double width_of(const Scene& scene, std::uint32_t flags, float pdf, std::uint32_t sample, bool from_light = false) {
  TestWave test(3);
  for (int i = 0; i < 3; ++i) {
    const Slot slot = test.add_active({0.1f * static_cast<float>(i), 0.2f, 0}, {0, 0, 1}, flags);
    test.wave.radiance.row(slot).scatter_pdf = pdf;
    test.wave.paths.row(slot).sample = sample;
  }
  const StageContext context = from_light ? test.photon_context(scene, 3) : test.context(scene);
  intersect<L>(context, test.wave);
  sort_surfaces<L>(context, test.wave);
  surface_inputs<L>(context, test.wave);
  const int column = test.wave.runs[static_cast<int>(kClosureKind<DiffuseClosure>)].column_begin;
  const TexturedItem<Scalar> item = test.wave.textured.load<Scalar>(column + 2);
  CHECK(item.footprint.x == near(static_cast<double>(item.footprint.y)));
  return std::sqrt(static_cast<double>(item.footprint.x)) * 2 * kScale;
}

}  // namespace

TEST_CASE_TEMPLATE("ray footprint: camera rays have the width of a pixel over the root of the sample's number", L,
                   SHEAF_STAGE_LANES) {
  for (const bool instanced : {false, true}) {
    const auto scene = compile_scene(textured_square(instanced));
    // The field of view is 90 degrees: pixels in a corner of the film are narrower by the squared cosine, a third
    const double pixel = 2.0 / 16 / 3;
    CHECK(width_of<L>(*scene, kRayFromCamera, 0, 0) == near(pixel * kDistance, 1e-3));
    CHECK(width_of<L>(*scene, kRayFromCamera, 0, 3) == near(pixel * kDistance / 2, 1e-3));
    CHECK(width_of<L>(*scene, kRayFromCamera, 0, 99) == near(pixel * kDistance / 10, 1e-3));
    // Behind a mirror
    CHECK(width_of<L>(*scene, 0, 0, 3) == near(pixel * kDistance / 2, 1e-3));
    // Scattered: a fraction of the diameter of the cone of solid angle 1 / pdf
    const double cone = std::sqrt(4 / (3.14159265 * 2.5)) * static_cast<double>(kScatteredFootprint);
    CHECK(width_of<L>(*scene, 0, 2.5f, 0) == near(cone * kDistance, 1e-3));
    CHECK(width_of<L>(*scene, 0, 2.5f, 8) == near(cone * kDistance / 3, 1e-3));
  }
}

TEST_CASE_TEMPLATE("ray footprint: photons, and scenes without mip levels, have none", L, SHEAF_STAGE_LANES) {
  Description d = textured_square(false);
  CHECK(width_of<L>(*compile_scene(d), 0, 2.5f, 0) > 0.1);
  std::get<BitmapDescription>(d.textures[0].model).filter = TextureFilter::kNearest;
  CHECK(width_of<L>(*compile_scene(d), 0, 2.5f, 0) == 0);
  d = textured_square(false);
  d.integrator.kind = IntegratorKind::kLightTracer;
  CHECK(width_of<L>(*compile_scene(d), 0, 2.5f, 0, true) == 0);
}

TEST_CASE("ray footprint: cones of cameras") {
  CameraDescription camera;
  camera.near_clip = 0.5f;
  camera.fov = 2 * 45;
  const PixelCone perspective = pixel_cone_of(make_camera(camera, 200, 100), 200, 100);
  CHECK(perspective.spread == near(0.01 / (1 + 1 + 0.25)));
  CHECK(perspective.width == near(0.5 * 0.01 / 2.25));
  camera.projection = CameraDescription::Projection::kOrthographic;
  const PixelCone orthographic = pixel_cone_of(make_camera(camera, 200, 100), 200, 100);
  CHECK(orthographic.spread == 0);
  CHECK(orthographic.width == near(0.01));
  camera.projection = CameraDescription::Projection::kSpherical;
  CHECK(pixel_cone_of(make_camera(camera, 200, 50), 200, 50).spread == near(3.14159265 / 100));
  camera.projection = CameraDescription::Projection::kIrradianceMeter;
  CHECK(pixel_cone_of(make_camera(camera, 200, 100), 200, 100).width == 0);
}

}  // namespace sheaf::test_ray_footprint
