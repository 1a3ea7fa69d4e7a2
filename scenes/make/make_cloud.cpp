// make_cloud: writes procedural volumes as NanoVDB files or as Mitsuba's .vol files; deterministic for a given seed.
// The grid "density" and the optional grid "temperature" hold values from 0 to 1 in the cube [-1, 1]^3 with +y up.
#include "core/io/error.h"
#include "core/io/output_file.h"
#include "scene/formats/nanovdb.h"
#include "tools/options/options.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

namespace sheaf {

namespace {

float smooth_step(float lo, float hi, float x) {
  const float t = std::clamp((x - lo) / (hi - lo), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

float mix(float t, float a, float b) { return a + t * (b - a); }

/// Random values that depend only on integer coordinates, a stream and the seed.
class Lattice {
 public:
  explicit Lattice(std::uint32_t seed) : seed_(seed * 0x9e3779b9u + 0x7f4a7c15u) {}

  /// Uniform in [0, 1).
  float value(int x, int y, int z, std::uint32_t stream) const {
    std::uint32_t h = seed_ ^ stream * 0x85ebca6bu;
    for (const int i : {x, y, z}) {
      h = (h ^ static_cast<std::uint32_t>(i)) * 0xcc9e2d51u;
      h ^= h >> 15;
    }
    h *= 0x2c1b3c6du;
    h ^= h >> 13;
    return static_cast<float>(h >> 8) * 0x1p-24f;
  }

 private:
  std::uint32_t seed_;
};

/// Value noise: smoothly interpolated lattice values, with mean 1/2.
float value_noise(const Lattice& lattice, Vec3f p, std::uint32_t stream) {
  const float fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const float tx = smooth_step(0, 1, p.x - fx), ty = smooth_step(0, 1, p.y - fy), tz = smooth_step(0, 1, p.z - fz);
  const auto along_x = [&](int dy, int dz) {
    return mix(tx, lattice.value(x, y + dy, z + dz, stream), lattice.value(x + 1, y + dy, z + dz, stream));
  };
  return mix(tz, mix(ty, along_x(0, 0), along_x(1, 0)), mix(ty, along_x(0, 1), along_x(1, 1)));
}

/// Cellular noise of round lumps: 1 minus the distance to the nearest of jittered points, one per cell (Worley 1996).
float lump_noise(const Lattice& lattice, Vec3f p, std::uint32_t stream) {
  const float fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  float nearest = 4;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int cx = x + dx, cy = y + dy, cz = z + dz;
        const Vec3f point{static_cast<float>(cx) + lattice.value(cx, cy, cz, stream),
                          static_cast<float>(cy) + lattice.value(cx, cy, cz, stream + 1),
                          static_cast<float>(cz) + lattice.value(cx, cy, cz, stream + 2)};
        nearest = std::min(nearest, length_squared(point - p));
      }
  return std::max(0.0f, 1 - std::sqrt(nearest));
}

/// Sum of octaves, each with half the scale and amplitude of the previous one; roughly in [0, 1].
template <class Noise> float octaves(Noise&& noise, const Lattice& lattice, Vec3f p, int count, std::uint32_t stream) {
  float sum = 0, weight = 0.5f, total = 0;
  for (int i = 0; i < count; ++i) {
    sum += weight * noise(lattice, p, stream + 8 * static_cast<std::uint32_t>(i));
    total += weight;
    weight *= 0.5f;
    p = p * 2.03f + Vec3f{3.1f, 7.7f, 5.3f};
  }
  return sum / total;
}

struct Sample {
  float density = 0, temperature = 0;
};

/// A procedural volume in [-1, 1]^3.
class Model {
 public:
  virtual ~Model() = default;
  virtual Sample at(Vec3f p) const = 0;
};

/// Cumulus cloud: towers of spheres over a flat base, with a surface perturbed by lumps and billows.
class Cumulus : public Model {
 public:
  explicit Cumulus(std::uint32_t seed) : lattice_(seed) {
    for (int i = 0; i < kSpheres; ++i) {
      const auto random = [&](std::uint32_t stream) { return lattice_.value(i, 0, 0, 100 + stream); };
      const float angle = 2 * kPi * random(0), reach = 0.62f * std::sqrt(random(1));
      const float height = (1 - reach) * random(2);
      const float radius = mix(random(3), 0.16f, 0.3f) * (1.25f - 0.5f * height);
      spheres_.push_back({{reach * std::cos(angle), kBase + 0.12f + 0.95f * height, reach * std::sin(angle)}, radius});
    }
  }

  Sample at(Vec3f p) const override {
    float depth = -1;  // depth below the surface of the spheres
    for (const Sphere& s : spheres_) depth = std::max(depth, s.radius - length(p - s.center));
    constexpr float kReach = 0.16f;
    if (depth < -kReach || p.y < kBase - 0.1f) return {};
    const float lumps = octaves(lump_noise, lattice_, p * 4.0f, 3, 0);
    const float billows = octaves(value_noise, lattice_, p * 6.0f, 5, 40);
    const float surface = depth + kReach * (1.4f * lumps + 1.1f * billows - 1.35f);
    const float base = smooth_step(kBase - 0.06f, kBase + 0.05f, p.y + 0.12f * (billows - 0.5f));
    const float density = smooth_step(0, 0.09f, surface) * base * mix(billows, 0.55f, 1.0f);
    return {density, density * smooth_step(0, 0.4f, depth)};
  }

 private:
  struct Sphere {
    Vec3f center;
    float radius;
  };
  static constexpr int kSpheres = 28;
  static constexpr float kBase = -0.45f;
  Lattice lattice_;
  std::vector<Sphere> spheres_;
};

/// A plume of smoke that widens and meanders as it rises, hot near its base.
class Smoke : public Model {
 public:
  explicit Smoke(std::uint32_t seed) : lattice_(seed) {}

  Sample at(Vec3f p) const override {
    const float height = 0.5f * (p.y + 0.95f);  // 0 at the base
    if (height < 0 || height > 0.97f) return {};
    const auto drift = [&](std::uint32_t stream) {
      return octaves(value_noise, lattice_, {1.7f * p.x, 2.2f * p.y, 1.7f * p.z}, 4, stream) - 0.5f;
    };
    const Vec3f q{p.x + 0.9f * height * drift(0), p.y, p.z + 0.9f * height * drift(50)};
    const float radius = mix(height, 0.14f, 0.5f), distance = std::sqrt(q.x * q.x + q.z * q.z) / radius;
    if (distance > 1.3f) return {};
    const float wisps = octaves(value_noise, lattice_, {7 * q.x, 5 * q.y, 7 * q.z}, 5, 100);
    const float inside = 1.1f - distance + 1.5f * (wisps - 0.5f);
    const float ends = smooth_step(0, 0.03f, height) * smooth_step(0.97f, 0.6f, height);
    const float density = smooth_step(0, 0.5f, inside) * ends * mix(height, 1.0f, 0.35f);
    const float heat = smooth_step(0.1f, 1.0f, inside) * smooth_step(0.75f, 0.0f, height + 0.3f * (wisps - 0.5f));
    return {density, ends * heat};
  }

 private:
  Lattice lattice_;
};

/// Density grows linearly from 0 at x = -1 to 1 at x = 1, and temperature likewise along y.
class Ramp : public Model {
 public:
  Sample at(Vec3f p) const override { return {0.5f * (p.x + 1), 0.5f * (p.y + 1)}; }
};

class Constant : public Model {
 public:
  Sample at(Vec3f) const override { return {1, 1}; }
};

enum Kind { kCloud, kSmoke, kRamp, kConstant };

std::unique_ptr<Model> make_model(int kind, std::uint32_t seed) {
  switch (kind) {
    case kSmoke:
      return std::make_unique<Smoke>(seed);
    case kRamp:
      return std::make_unique<Ramp>();
    case kConstant:
      return std::make_unique<Constant>();
    default:
      return std::make_unique<Cumulus>(seed);
  }
}

Vec3f voxel_center(const std::array<int, 3>& voxel, int resolution) {
  const auto coordinate = [&](int i) { return (static_cast<float>(2 * i + 1) / static_cast<float>(resolution)) - 1; };
  return {coordinate(voxel[0]), coordinate(voxel[1]), coordinate(voxel[2])};
}

/// Fills the non-empty blocks of a grid with `resolution`^3 voxels.
void sample(const Model& model, int resolution, VoxelBlocks& density, VoxelBlocks& temperature) {
  const int blocks = (resolution + VoxelBlocks::kSide - 1) / VoxelBlocks::kSide;
  std::vector<float> d(VoxelBlocks::kVoxels), t(VoxelBlocks::kVoxels);
  const auto add_block = [&](const std::array<int, 3>& b) {
    for (int i = 0; i < VoxelBlocks::kVoxels; ++i) {
      const int x = 8 * b[0] + (i & 7), y = 8 * b[1] + (i >> 3 & 7), z = 8 * b[2] + (i >> 6);
      const bool is_inside = std::max({x, y, z}) < resolution;
      const Sample s = is_inside ? model.at(voxel_center({x, y, z}, resolution)) : Sample{};
      d[static_cast<std::size_t>(i)] = s.density;
      t[static_cast<std::size_t>(i)] = s.temperature;
    }
    const auto is_set = [](float v) { return v != 0; };
    if (std::any_of(d.begin(), d.end(), is_set)) std::copy(d.begin(), d.end(), density.add(b).begin());
    if (std::any_of(t.begin(), t.end(), is_set)) std::copy(t.begin(), t.end(), temperature.add(b).begin());
  };
  for (int z = 0; z < blocks; ++z)
    for (int y = 0; y < blocks; ++y)
      for (int x = 0; x < blocks; ++x) add_block({x, y, z});
}

/// Writes the density as a .vol file of version 3 with 32-bit floats; scene/formats/vol.h has the layout.
void write_vol(const std::filesystem::path& path, const Model& model, int resolution) {
  OutputFile file(path);
  const auto put = [&](std::uint32_t bits) {
    for (int shift = 0; shift < 32; shift += 8) file.stream().put(static_cast<char>(bits >> shift & 255));
  };
  const auto put_float = [&](float value) { put(std::bit_cast<std::uint32_t>(value)); };
  const auto side = static_cast<std::uint32_t>(resolution);
  file.stream() << "VOL\3";
  for (const std::uint32_t number : {1u, side, side, side, 1u}) put(number);
  for (const float bound : {-1, -1, -1, 1, 1, 1}) put_float(bound);
  for (int z = 0; z < resolution; ++z)
    for (int y = 0; y < resolution; ++y)
      for (int x = 0; x < resolution; ++x) put_float(model.at(voxel_center({x, y, z}, resolution)).density);
  file.commit();
}

int run(int argc, char** argv) {
  Program program("make_cloud", "Write a procedural volume as a NanoVDB file, or as a .vol file of Mitsuba.");
  std::string out;
  int resolution = 128;
  std::uint32_t seed = 1;
  int kind = kCloud;
  bool with_temperature = false;
  // Parse the options
  const std::map<std::string, int> kinds{
      {"cloud", kCloud}, {"smoke", kSmoke}, {"ramp", kRamp}, {"constant", kConstant}};
  program.add_option("OUT", out, "Output file: .nvdb, or .vol for the density alone").required().file();
  program.add_option("--resolution", resolution, "Voxels along each side").in_range(1, 1024);
  program.add_option("--seed", seed, "Seed of the noise");
  program.add_option("--kind", kind, "Kind of volume: cloud, smoke, ramp or constant").one_of_named(kinds);
  program.add_flag("--temperature", with_temperature, "Also write the grid 'temperature'");
  if (const std::optional<int> exit_code = program.parse(argc, argv)) return *exit_code;
  // Sample the model and write the grids
  if (std::filesystem::path(out).extension() == ".vol") {
    if (with_temperature) throw Error(ExitCode::kUsage, "--temperature needs an .nvdb file");
    write_vol(out, *make_model(kind, seed), resolution);
    return 0;
  }
  VoxelBlocks density(1), temperature(1);
  sample(*make_model(kind, seed), resolution, density, temperature);
  const float side = 2.0f / static_cast<float>(resolution), first = 0.5f * side - 1;
  const Transform map = Transform::translate({first, first, first}) * Transform::scale({side, side, side});
  std::vector<NanoVdbGrid> grids{{"density", &density, map}};
  if (with_temperature) grids.push_back({"temperature", &temperature, map});
  write_nanovdb(out, grids);
  return 0;
}

}  // namespace

}  // namespace sheaf

int main(int argc, char** argv) {
  try {
    return sheaf::run(argc, argv);
  } catch (const sheaf::Error& error) {
    std::fprintf(stderr, "make_cloud: %s\n", error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_cloud: %s\n", error.what());
    return static_cast<int>(sheaf::ExitCode::kRuntime);
  }
}
