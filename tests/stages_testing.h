// Waves for tests of stages: paths set up by hand in scattered slots, with neighbours that must stay as they are.
#pragma once

#include "kernels/stages.h"
#include "scene/compile.h"
#include "tests/records_testing.h"
#include "tests/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace sheaf {

/// Path counts with partial, whole and several tiles.
inline const std::vector<int> kTailSizes = {1, kWidth - 1, kWidth, kWidth + 1, 2 * kWidth + 3, 37};

/// A wave with room for `paths` paths and some spare slots. Slots come in no particular order, and every row is filled
/// with a pattern, so that a stage that writes to a slot it was not given is found out.
class TestWave {
 public:
  explicit TestWave(int paths, int spare = 5) : wave(paths + spare), samples(static_cast<std::size_t>(paths)) {
    const int capacity = paths + spare;
    std::mt19937 random(7);
    std::shuffle(wave.free.data(), wave.free.data() + wave.free.size(), random);
    for (int slot = 0; slot < capacity; ++slot)
      for_each_row(static_cast<Slot>(slot), [](float* row) { std::fill_n(row, 8, bits_float(kPattern)); });
    wave.begin({{0, 0, paths, 1}, 0, 1, paths}, samples.data());
  }

  /// Takes a free slot for a path whose pixel and sample buffer index are the number of paths added before. Its ray
  /// starts at `origin`; the caller puts the slot on a list.
  Slot add(Vec3f origin, Vec3f direction, std::uint32_t flags = 0) {
    const Slot slot = wave.free.pop();
    const auto index = static_cast<std::uint32_t>(added_++);
    RayState<Scalar> ray{origin, kInfinity, direction, flags};
    ThroughputState<Scalar> path{Spectrum4(1.0f), 1, 0, index, 0};
    RadianceState<Scalar> radiance{Spectrum4(0.0f), 0, 1, 1, index};
    wave.rays.set(slot, ray);
    wave.throughput.set(slot, path);
    wave.radiance.set(slot, radiance);
    return slot;
  }
  /// The same, with a ray to be traced.
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
  std::vector<FilmSample> samples;

 private:
  static constexpr std::uint32_t kPattern = 0xdeadbeefu;

  template <class F> void for_each_row(Slot slot, F&& f) {
    f(wave.rays.row(slot));
    f(wave.hits.row(slot));
    f(wave.throughput.row(slot));
    f(wave.radiance.row(slot));
  }

  int added_ = 0;
};

/// Every slot stands on exactly one list; between sort_surfaces and scatter that may be `sorted`.
inline void check_conservation(const Wave& wave, bool shading = false) {
  std::vector<int> seen(static_cast<std::size_t>(wave.capacity));
  for (const SlotList* list : {&wave.free, &wave.active, &wave.miss, &wave.composite, &wave.surface, &wave.finished})
    for (const Slot slot : list->span()) ++seen.at(slot);
  if (shading)
    for (const Slot slot : wave.sorted.span()) ++seen.at(slot);
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

}  // namespace sheaf
