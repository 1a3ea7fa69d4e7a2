// The pbrt dialect: media on grids in the scene file, and procedural clouds.
#include "core/simd/saturate.h"
#include "scene/description/voxels.h"
#include "scene/dialects/pbrt/noise.h"
#include "scene/dialects/pbrt/reader.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

/// Reads the resolution nx, ny, nz of a voxel box without values.
DenseVolume read_box(Parameters& p) {
  DenseVolume box;
  const char* const names[3] = {"nx", "ny", "nz"};
  for (std::size_t axis = 0; axis < 3; ++axis) box.size[axis] = p.integer(names[axis], 1, 1, kMaxGridSide - 2);
  return box;
}

/// Maps the voxels to the box from p0 to p1.
void place_box(Parameters& p, DenseVolume& box) {
  const Vec3f a = p.vec3("p0", {0, 0, 0}), b = p.vec3("p1", {1, 1, 1});
  const Vec3f low{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}, size = abs(b - a);
  if (!(std::min({size.x, size.y, size.z}) > 0.0f)) p.fail("is flat, expected 'p0' and 'p1' to differ along all axes");
  const auto side = [&](float length, std::size_t axis) { return length / static_cast<float>(box.size[axis]); };
  box.grid_to_local = Transform::translate(low) *
                      Transform::scale({side(size.x, 0), side(size.y, 1), side(size.z, 2)}) *
                      Transform::translate({0.5f, 0.5f, 0.5f});
}

/// Returns an in-memory grid in medium space. `values` has x fastest.
GridVolumeDescription made_grid(Parameters& p, DenseVolume box, int channels, std::vector<float> values) {
  box.channels = channels;
  box.values = std::move(values);
  GridVolumeDescription grid;
  grid.format = GridVolumeDescription::Format::kInMemory;
  grid.to_world = p.reader().attributes.transform.start;
  p.reader().note_rest(p.where(), "media");
  grid.made = std::make_shared<const DenseVolume>(std::move(box));
  return grid;
}

/// Reads the grid of a parameter: 1 or 3 non-negative numbers per voxel. Returns nullopt if the parameter is missing.
std::optional<GridVolumeDescription> find_grid(Parameters& p, const char* name, const DenseVolume& box, int channels,
                                               Use use = Use::kUnbounded) {
  const Parameter* list = p.find(name);
  if (list == nullptr) return std::nullopt;
  const char* const type = channels == 3 ? "rgb" : "float";
  if (list->type != type)
    p.fail_at(name, fmt::format("is of the type {}, expected {} for each voxel", list->type, type));
  std::vector<float> values = p.numbers(name, static_cast<std::size_t>(channels));
  std::size_t expected = static_cast<std::size_t>(channels);
  for (const int side : box.size) expected *= static_cast<std::size_t>(side);
  if (values.size() != expected)
    p.fail_at(name, fmt::format("has {} numbers, expected {} by 'nx', 'ny' and 'nz'", values.size(), expected));
  if (channels == 3)
    for (std::size_t i = 0; i < values.size(); i += 3) {
      const Vec3f rgb = to_rec709(p, {values[i], values[i + 1], values[i + 2]}, use);
      values[i] = rgb.x, values[i + 1] = rgb.y, values[i + 2] = rgb.z;
    }
  for (const float value : values)
    if (value < 0.0f) p.fail_at(name, fmt::format("has {}, expected a non-negative number", value));
  return made_grid(p, box, channels, std::move(values));
}

/// Voxels along the longest side of a cloud.
constexpr int kCloudVoxels = 192;

}  // namespace

void read_uniform_grid(Parameters& p, MediumDescription& medium) {
  DenseVolume box = read_box(p);
  place_box(p, box);
  box.ends_at_zero = true;
  medium.coefficients = read_coefficients(p);
  medium.scale = p.number("scale", 1, kNotNegative);
  medium.density = find_grid(p, "density", box, 1);
  if (!medium.density) p.fail("needs 'density', a float for each voxel");
  std::optional<SpectrumDescription> light = find_spectrum(p, "Le", Use::kLight);
  std::optional<GridVolumeDescription> temperature = find_grid(p, "temperature", box, 1);
  if (light && temperature) p.fail("has both 'Le' and 'temperature', expected one");
  medium.emission_factor = find_grid(p, "Lescale", box, 1);
  if (temperature) return set_temperature(p, medium, std::move(*temperature), 1);
  if (light) medium.emission = std::move(*light);
  p.ignore({"temperaturescale", "temperatureoffset", "temperaturecutoff"});
}

void read_rgb_grid(Parameters& p, MediumDescription& medium) {
  DenseVolume box = read_box(p);
  place_box(p, box);
  box.ends_at_zero = true;
  std::optional<GridVolumeDescription> absorption = find_grid(p, "sigma_a", box, 3);
  std::optional<GridVolumeDescription> scattering = find_grid(p, "sigma_s", box, 3);
  if (!absorption && !scattering) p.fail("needs 'sigma_a' or 'sigma_s', an rgb for each voxel");
  // A missing coefficient is 1.
  const auto ones = [&] {
    std::size_t count = 3;
    for (const int side : box.size) count *= static_cast<std::size_t>(side);
    return made_grid(p, box, 3, std::vector<float>(count, 1.0f));
  };
  AbsorptionScatteringDescription both;
  both.sigma_a = absorption ? std::move(*absorption) : ones();
  both.sigma_s = scattering ? std::move(*scattering) : ones();
  medium.coefficients = std::move(both);
  medium.scale = p.number("scale", 1, kNotNegative);
  const float emission = p.number("Lescale", 1, kNotNegative);
  std::optional<GridVolumeDescription> light = find_grid(p, "Le", box, 3, Use::kLight);
  if (!light) return;
  medium.emission = std::move(*light);
  medium.emission_scale = emission * kLuminanceIntegral;
}

void read_cloud(Parameters& p, MediumDescription& medium) {
  medium.coefficients = read_coefficients(p);
  const CloudShape cloud{double{p.number("density", 1, kNotNegative)}, double{p.number("wispiness", 1)},
                         double{p.number("frequency", 5)}};
  // Choose the resolution
  const Vec3f size = abs(p.vec3("p1", {1, 1, 1}) - p.vec3("p0", {0, 0, 0}));
  const float sides[3] = {size.x, size.y, size.z}, longest = std::max({size.x, size.y, size.z});
  DenseVolume box;
  for (std::size_t axis = 0; axis < 3; ++axis)
    box.size[axis] = std::clamp(saturate<int>(static_cast<double>(std::ceil(kCloudVoxels * sides[axis] / longest))), 1,
                                kCloudVoxels);
  place_box(p, box);
  // Evaluate the cloud at the voxels
  const auto nx = static_cast<std::size_t>(box.size[0]), ny = static_cast<std::size_t>(box.size[1]);
  std::vector<float> values(nx * ny * static_cast<std::size_t>(box.size[2]));
  tbb::parallel_for(0, box.size[2], [&](int z) {
    for (std::size_t i = 0; i < nx * ny; ++i) {
      const std::size_t x = i % nx, y = i / nx;
      const Vec3f at = box.grid_to_local.point({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
      values[static_cast<std::size_t>(z) * nx * ny + i] =
          static_cast<float>(cloud_density(cloud, double{at.x}, double{at.y}, double{at.z}));
    }
  });
  medium.density = made_grid(p, std::move(box), 1, std::move(values));
}

}  // namespace sheaf::pbrt
