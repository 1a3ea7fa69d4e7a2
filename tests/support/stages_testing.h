// Waves for tests of stages: hand-made paths in scattered slots, next to slots that must stay unchanged.
#pragma once

#include "kernels/film/camera_task.h"
#include "kernels/film/film_layout.h"
#include "kernels/photons/light_task.h"
#include "kernels/stages/stage_list.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/records_testing.h"
#include "tests/support/stage_lanes.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace sheaf {

/// Path counts with partial, whole and several tiles.
inline const std::vector<int> kTailSizes = {1, kWidth - 1, kWidth, kWidth + 1, 2 * kWidth + 3, 37};

/// A wave with room for `paths` paths and some spare slots. Slots are shuffled, and every row is filled with a pattern,
/// which reveals writes to slots that a stage was not given.
class TestWave {
 public:
  explicit TestWave(int paths, int spare = 5) : wave(paths + spare) {
    const int capacity = paths + spare;
    std::mt19937 random(7);
    std::shuffle(wave.free.data(), wave.free.data() + wave.free.size(), random);
    for (int slot = 0; slot < capacity; ++slot)
      for_each_row(static_cast<Slot>(slot), [](float* row) { std::fill_n(row, 8, bits_float(kPattern)); });
    begin({0, 0, paths, 1}, 0, 1, paths);
  }

  /// Begins a task with samples of all pixels of a rectangle and the given AOVs.
  void begin(const PixelRect& rectangle, std::uint32_t first_sample, std::uint32_t sample_count, int frame_width,
             AovSet aovs = {}) {
    pixels_ = samples_of(rectangle, {frame_width}, first_sample, sample_count);
    const FilmLayout layout = film_layout(aovs, false);
    task.begin(pixels_, {frame_width}, layout.size(), 0, AovChannels(layout, aovs));
  }

  /// The context of a stage for this scene and task.
  StageContext context(const Scene& scene) { return StageContext(scene, task); }
  /// The context of a stage of the light pass that emits `count` photons.
  StageContext photon_context(const Scene& scene, int count) {
    const SplatFilter filter({}, FilterMode::kImportance, {});
    photons.begin(7, count, filter.bounds({0, 0, scene.film().width, scene.film().height}));
    StageContext context(scene);
    const bool stores = context.integrator.kind != IntegratorKind::kLightTracer;
    context.start_at_lights(stores ? PassKind::kPhoton : PassKind::kLight, photons);
    return context;
  }

  /// Allocates a slot for a path. Its pixel and its sample buffer index are the number of paths added before. Its ray
  /// starts at `origin`. The caller pushes the slot onto a list.
  Slot add(Vec3f origin, Vec3f direction, std::uint32_t flags = 0) {
    const Slot slot = wave.free.pop();
    const auto index = static_cast<std::uint32_t>(added_++);
    RayState<Scalar> ray{origin, kInfinity, direction, flags};
    PathState<Scalar> path{Spectrum4(1.0f), 1, 0, index, 0};
    RadianceState<Scalar> radiance{Spectrum4(0.0f), 0, 1, 1, index};
    wave.rays.set(slot, ray);
    wave.paths.set(slot, path);
    wave.radiance.set(slot, radiance);
    return slot;
  }
  /// Adds a path whose ray is to be traced.
  Slot add_active(Vec3f origin, Vec3f direction, std::uint32_t flags = 0) {
    const Slot slot = add(origin, direction, flags);
    wave.active.push(slot);
    return slot;
  }

  /// Whether all rows of free slots still hold the pattern.
  bool spare_rows_untouched() {
    bool untouched = true;
    for (const Slot slot : wave.free.span())
      for_each_row(slot, [&](const float* row) {
        untouched = untouched && std::all_of(row, row + 8, [](float w) { return float_bits(w) == kPattern; });
      });
    return untouched;
  }

  Wave wave;
  CameraTask task;
  LightTask photons;

 private:
  static constexpr std::uint32_t kPattern = 0xdeadbeefu;

  template <class F> void for_each_row(Slot slot, F&& f) {
    const auto words = [slot](auto& group) { return reinterpret_cast<float*>(&group.row(slot)); };
    f(words(wave.rays));
    f(words(wave.hits));
    f(words(wave.paths));
    f(words(wave.radiance));
  }

  std::vector<PixelSamples> pixels_;
  int added_ = 0;
};

/// Checks that every slot is on exactly one list; it may also be on `emitter`.
inline void check_conservation(const Wave& wave) {
  std::vector<int> seen(static_cast<std::size_t>(wave.capacity));
  for (const SlotList PathPool::*list : PathPool::kLists)
    if (list != &PathPool::emitter)
      for (const Slot slot : (wave.*list).span()) ++seen.at(slot);
  CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
}

inline bool contains(const SlotList& list, Slot slot) {
  return std::find(list.span().begin(), list.span().end(), slot) != list.span().end();
}

/// A room with every kind of closure and light in view of a camera at the origin.
inline Description mixed_scene(int width = 16, int height = 16) {
  Description d = empty_scene(width, height);
  d.sampler.seed = 5;
  add_rectangle(d,
                Transform::translate({0, -1.5f, 4}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}),
                add_diffuse_rgb(d, 0.7f, 0.5f, 0.3f));
  const MaterialId red = add_diffuse_rgb(d, 0.8f, 0.1f, 0.1f), green = add_diffuse_rgb(d, 0.1f, 0.8f, 0.1f);
  add_rectangle(d, Transform::translate({-2, 0, 4}) * Transform::rotate({0, 1, 0}, -60),
                add_material(d, TwoSidedDescription{red, green}));
  ConductorDescription metal;
  metal.ior = {SpectrumDescription::rgb(0.2f, 0.9f, 1.2f), SpectrumDescription::rgb(3.5f, 2.5f, 2)};
  add_sphere(d, {-0.7f, -0.5f, 4}, 0.8f, add_material(d, metal));
  add_sphere(d, {1, -0.6f, 3}, 0.7f, add_glass(d));
  add_shape(d, CylinderShape{}, Transform::translate({1.8f, -0.5f, 4}) * Transform::scale({0.4f, 0.7f, 1}),
            add_diffuse(d, 0.6f));
  add_area_light_rectangle(
      d, Transform::translate({0, 1.8f, 4}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({0.6f, 0.6f, 1}), 10);
  add_area_light_sphere(d, {1.5f, 1, 4}, 0.3f, 5);
  emit(add_shape(d, DiskShape{},
                 Transform::translate({-1.6f, 1.2f, 4}) * Transform::rotate({0, 1, 0}, 160) *
                     Transform::scale({0.5f, 0.3f, 1})),
       4);
  add_point_light(d, {0, 0.5f, 2}, 3);
  add_constant_light(d, 0.5f);
  return d;
}

/// Adds surfaces that transmit light, media and a texture to mixed_scene().
inline void add_media_and_masks(Description& d) {
  const MaterialId inside = add_diffuse(d, 0.6f);
  add_rectangle(d,
                Transform::translate({0.4f, 0.2f, 2.2f}) * Transform::rotate({0, 1, 0}, 170) *
                    Transform::scale({0.5f, 0.5f, 0.5f}),
                add_material(d, MaskDescription{0.4f, inside}));
  CheckerboardDescription board;
  board.color0 = SpectrumDescription::rgb(0.1f, 0.2f, 0.3f);
  TextureDescription texture;
  texture.model = board;
  d.textures.push_back(texture);
  add_rectangle(d, Transform::translate({-1, -0.4f, 3}) * Transform::rotate({0, 1, 0}, 170),
                add_material(d, DiffuseDescription{static_cast<TextureId>(d.textures.size() - 1)}));
  ShapeDescription& ball = add_sphere(d, {0.6f, 0.9f, 3}, 0.5f);
  fill(d, ball, add_medium(d, fog(2, 0.7f)));
}

}  // namespace sheaf
