#include "scene/lights/volume_light.h"

#include "scene/lights/light_bounds.h"
#include "scene/lights/list.h"
#include "scene/tables/medium_lookup.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Maximum number of cells along the longest side of a volume light's box.
constexpr int kCells = 32;
/// Sample points per cell along each axis.
constexpr int kPoints = 2;

/// Wavelengths (nm) in spectral mode, instead of red, green and blue.
const Spectrum4 kSeen{600, 550, 450, 500};

/// Emission at a point, W / (m^3 sr).
Vec3f emitted_at(const SceneView& scene, const MediumRow& medium, const MediumSpectra& spectra, Vec3f p) {
  const Float4 emitted =
      medium_coefficients(scene, medium, spectra, p, kSeen).sigma_a * medium_emission(scene, medium, spectra, p, kSeen);
  return {emitted[0], emitted[1], emitted[2]};
}

/// A box divided into cells of about the same size along all axes.
struct Cells {
  Bounds3f box;
  int count[3];
  Vec3f size;

  Cells(const Bounds3f& all, bool one) : box(all) {
    const Vec3f extent = all.max - all.min;
    const float longest = std::max(max_component(extent), 1e-30f);
    const auto along = [&](float side) {
      return one ? 1 : std::clamp(static_cast<int>(std::ceil(kCells * side / longest)), 1, kCells);
    };
    count[0] = along(extent.x);
    count[1] = along(extent.y);
    count[2] = along(extent.z);
    size = {extent.x / static_cast<float>(count[0]), extent.y / static_cast<float>(count[1]),
            extent.z / static_cast<float>(count[2])};
  }
  Bounds3f cell(int x, int y, int z) const {
    const Vec3f low{box.min.x + size.x * static_cast<float>(x), box.min.y + size.y * static_cast<float>(y),
                    box.min.z + size.z * static_cast<float>(z)};
    return {low, low + size};
  }
};

}  // namespace

/// Power of the whole box, of which the medium may fill only a part.
Vec3f VolumeLightKind::power(const SceneView&, const LightRow& light) { return emitted_rgb(light) * (4 * kPi); }

LightBounds VolumeLightKind::bounds(const SceneView&, const LightRow& light, double power) {
  const auto volume = light.data<VolumeLightData>();
  LightBounds out = point_light_bounds(volume.corner, static_cast<float>(power * (0.25 * double(kInvPi))));
  out.upper = volume.corner + volume.extent;
  return out;
}

std::optional<MediumLight> make_volume_light(const SceneView& scene, std::uint32_t index,
                                             std::span<const Bounds3f> boxes, std::uint32_t first_cell) {
  const MediumRow& medium = scene.media.rows[index];
  if ((medium.flags & kMediumEmits) == 0 || boxes.empty()) return std::nullopt;
  Bounds3f all = boxes.front();
  for (const Bounds3f& box : boxes) all.grow(box);
  const MediumSpectra spectra = medium_spectra(scene, medium, kSeen);
  const Cells cells(all, (medium.flags & kMediumHomogeneous) != 0 && boxes.size() == 1);
  std::vector<float> weights;
  Vec3f total{0, 0, 0};
  for (int z = 0; z < cells.count[2]; ++z)
    for (int y = 0; y < cells.count[1]; ++y)
      for (int x = 0; x < cells.count[0]; ++x) {
        const Bounds3f cell = cells.cell(x, y, z);
        Vec3f sum{0, 0, 0};
        if (std::any_of(boxes.begin(), boxes.end(),
                        [&](const Bounds3f& box) { return !intersection(box, cell).is_empty(); }))
          for (int k = 0; k < kPoints * kPoints * kPoints; ++k) {
            const auto at = [](int i) { return (static_cast<float>(i % kPoints) + 0.5f) / kPoints; };
            sum = sum + emitted_at(scene, medium, spectra,
                                   {cell.min.x + cells.size.x * at(k), cell.min.y + cells.size.y * at(k / kPoints),
                                    cell.min.z + cells.size.z * at(k / kPoints / kPoints)});
          }
        weights.push_back(sum.x + sum.y + sum.z);
        total = total + sum;
      }
  const float cell_volume = cells.size.x * cells.size.y * cells.size.z;
  const Vec3f emitted = total * (cell_volume / (kPoints * kPoints * kPoints));
  if (!(max_component(emitted) > 0.0f) || !is_finite(emitted)) return std::nullopt;
  MediumLight light;
  light.alias = build_alias_table(weights);
  const VolumeCells counts{static_cast<std::uint32_t>(cells.count[0]), static_cast<std::uint32_t>(cells.count[1]),
                           static_cast<std::uint32_t>(cells.count[2])};
  const VolumeLightData<Scalar> data{index, first_cell, counts.word(), all.min, all.max - all.min};
  light.row = make_light_row(kLightKind<VolumeLightKind>, emitted, data);
  return light;
}

}  // namespace sheaf
