// Environment map lights: row and power. compile_envmap.cpp builds the tables of the map.
#include "scene/compile/compile_envmap.h"
#include "scene/compile/daylight.h"
#include "scene/compile/light.h"
#include "scene/compile/lights/light_rotation.h"
#include "scene/compile/octahedral_envmap.h"

#include "core/frame.h"
#include "core/memory.h"

#include <algorithm>

namespace sheaf {

namespace {

struct EnvmapRows {
  static constexpr LightDomain kDomain = LightDomain::kEnvironment;

  static Vec3f power(const SceneView& scene, const LightRow& light) {
    const float disk = kPi * scene.radius * scene.radius;
    return emitted_rgb(light) * (4 * kPi * disk);
  }
};

/// Whether MIS compensation may leave dark directions to BSDF sampling. Requires that BSDF sampling reaches all light
/// that light sampling finds; otherwise the unsampled light would be lost. Photons have no second strategy.
bool can_compensate(const Description& description) {
  const IntegratorSettings& integrator = description.integrator;
  return integrator.kind == IntegratorKind::kPath && integrator.strategy == LightStrategy::kMis &&
         !integrator.ends_at_diffuse;
}

/// Installs a map, already rotated, as the scene's environment. If it is black, warns about `what` and returns nothing.
std::optional<CompiledLight> place_map(Envmap map, LightContext& context, const std::string& what,
                                       const SourceLocation& where) {
  if (!(max_component(map.mean) > 0.0f)) {
    context.warnings.push_back(what + " is black");
    return std::nullopt;
  }
  if (context.spectra != nullptr) uplift_nodes(map);
  CompiledLight placed{make_light_row(LightKind::kEnvmap, map.mean, {0, 0, 0}), std::nullopt,
                       context.emission_row(SpectrumDescription::constant(1), where)};
  context.envmap = std::move(map);
  return placed;
}

}  // namespace

LightCompiler light_compiler(LightTag<LightKind::kEnvmap>) { return make_light_compiler<EnvmapRows>(); }

void set_rotation(Envmap& map, const Transform& to_world, const SourceLocation& where) {
  const std::array<double, 9> rotation = rotation_of(to_world, "an environment map", where);
  std::transform(rotation.begin(), rotation.end(), map.to_map, [](double v) { return static_cast<float>(v); });
}

std::optional<CompiledLight> place_light(const LightToPlace<EnvmapDescription>& l) {
  const EnvmapDescription& light = l.light;
  LightContext& context = l.context;
  EnvmapImage picture = read_envmap_image(light.file, light.raw);
  const UnusableValues unusable = replace_unusable(picture);
  if (const std::size_t bad = unusable.dark + unusable.infinite; bad > 0) {
    std::string text = light.file.string() + ": " + std::to_string(bad) + " values that are negative or not finite";
    if (unusable.infinite == 0) {
      text += " count as 0";
    } else {
      text += ": " + std::to_string(unusable.dark) + " count as 0, " + std::to_string(unusable.infinite) +
              " infinite as " + std::to_string(static_cast<int>(kInfiniteTexel));
    }
    context.warnings.push_back(std::move(text));
  }
  if (light.layout == EnvmapDescription::Layout::kOctahedral) picture = lat_long_of_octahedral(picture, light.file);
  const double nodes = static_cast<double>(picture.width) * picture.height;
  const MemoryUse uses[] = {{"its tables", nodes * sizeof(EnvmapColumn), "use a smaller map"},
                            {"its spectra", context.spectra != nullptr ? nodes * 4 * sizeof(float) : 0, {}}};
  check_memory("the environment map '" + light.file.string() + "' of " + std::to_string(picture.width) + " x " +
                   std::to_string(picture.height) + " pixels",
               uses);
  Envmap map =
      make_envmap(std::move(picture), light.scale, light.mis_compensation && can_compensate(context.description));
  set_rotation(map, light.to_world, l.where);
  return place_map(std::move(map), context, light.file.string() + ": the environment map", l.where);
}

std::optional<CompiledLight> place_light(const LightToPlace<SkyDescription>& l) {
  const SkyDescription& sky = l.light;
  const auto frame = Frame<Scalar>::from_normal(sky.up);
  Envmap map = make_envmap(sky_image(sky, frame.s), 1, can_compensate(l.context.description));
  const Vec3f rows[3] = {cross(sky.up, frame.s), sky.up, frame.s};
  for (std::size_t i = 0; i < 3; ++i)
    map.to_map[3 * i] = rows[i].x, map.to_map[3 * i + 1] = rows[i].y, map.to_map[3 * i + 2] = rows[i].z;
  return place_map(std::move(map), l.context, SceneError(l.where, "the sky").what(), l.where);
}

}  // namespace sheaf
