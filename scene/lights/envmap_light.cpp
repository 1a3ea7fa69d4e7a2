#include "scene/lights/envmap_light.h"

#include "core/io/memory.h"
#include "core/math/frame.h"
#include "scene/lights/daylight.h"
#include "scene/lights/framed_light.h"
#include "scene/lights/make_envmap.h"
#include "scene/lights/octahedral_envmap.h"
#include "scene/tables/render_settings.h"
#include "scene/xml/linear_gamma.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Whether MIS compensation may leave dark directions to BSDF sampling. Requires that BSDF sampling reaches all light
/// that light sampling finds; otherwise the unsampled light would be lost. Photons have no second strategy.
bool can_compensate(const IntegratorSettings& integrator) {
  return integrator.traits().source == PathSource::kCamera && integrator.strategy == LightStrategy::kMis &&
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
  const SpectrumRow spectrum = context.emission_row(SpectrumDescription::constant(1), where);
  context.envmap = std::move(map);
  return context.light({context.envmap.mean, spectrum});
}

}  // namespace

EnvmapDescription EnvmapDescription::read(Properties& p) {
  EnvmapDescription map;
  map.file = p.file("filename");
  map.scale = p.number("scale", 1, kNotNegative);
  map.to_world = p.placement("to_world").to_world;
  map.mis_compensation = p.boolean("mis_compensation", true);
  map.raw = read_linear_gamma(p);
  p.ignore({"cache"});
  return map;
}

void set_rotation(Envmap& map, const Transform& to_world, const SourceLocation& where) {
  const std::array<double, 9> rotation = rotation_of(to_world, "an environment map", where);
  std::transform(rotation.begin(), rotation.end(), map.to_map, [](double v) { return static_cast<float>(v); });
}

std::optional<CompiledLight> EnvmapDescription::compile(const SourceLocation& where, LightContext& context) const {
  EnvmapImage image = read_envmap_image(file, raw);
  const UnusableValues unusable = replace_unusable(image);
  if (const std::size_t bad = unusable.dark + unusable.infinite; bad > 0) {
    std::string text = fmt::format("{}: {} values that are negative or not finite", file.string(), bad);
    if (unusable.infinite == 0) {
      text += " count as 0";
    } else {
      text += fmt::format(": {} count as 0, {} infinite as {}", unusable.dark, unusable.infinite,
                          static_cast<int>(kInfiniteTexel));
    }
    context.warnings.push_back(std::move(text));
  }
  if (layout == Layout::kOctahedral) image = lat_long_of_octahedral(image, file);
  const double nodes = static_cast<double>(image.width) * image.height;
  const MemoryUse uses[] = {{"its tables", nodes * sizeof(EnvmapColumn), "use a smaller map"},
                            {"its spectra", context.spectra != nullptr ? nodes * 4 * sizeof(float) : 0, {}}};
  check_memory(fmt::format("the environment map '{}' of {} x {} pixels", file.string(), image.width, image.height),
               uses);
  Envmap map = make_envmap(std::move(image), scale, mis_compensation && can_compensate(context.integrator));
  set_rotation(map, to_world, where);
  return place_map(std::move(map), context, file.string() + ": the environment map", where);
}

std::optional<CompiledLight> SkyDescription::compile(const SourceLocation& where, LightContext& context) const {
  const auto frame = Frame<Scalar>::from_normal(up);
  Envmap map = make_envmap(sky_image(*this, frame.s), 1, can_compensate(context.integrator));
  const Vec3f rows[3] = {cross(up, frame.s), up, frame.s};
  for (std::size_t i = 0; i < 3; ++i)
    map.to_map[3 * i] = rows[i].x, map.to_map[3 * i + 1] = rows[i].y, map.to_map[3 * i + 2] = rows[i].z;
  return place_map(std::move(map), context, SceneError(where, "the sky").what(), where);
}

}  // namespace sheaf
