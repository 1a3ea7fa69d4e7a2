// The Nori dialect: emitters.
#include "scene/dialects/nori/reader.h"
#include "scene/dialects/xml/read_emitter.h"

#include "core/math/frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf::nori {

namespace {

/// Reports that two alternatives are set. `ignored`: the property that has no effect.
void report_both(Properties& p, const std::string& first, const std::string& second, const std::string& ignored) {
  p.report(fmt::format("has both '{} and '{}, expected one", first, second), SceneErrorCode::kDuplicate,
           fmt::format("'{}' ignored", ignored));
  p.ignore({ignored.c_str()});
}

void read_point_light(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<PointLightDescription>();
  light.position = p.point("position", {0, 0, 0});
  light.intensity = p.spectrum("intensity", light.intensity, SpectrumRole::kEmission);
  const auto power = p.find_spectrum("power", SpectrumRole::kEmission);
  if (power && p.has("intensity")) report_both(p, "power' (W)", "intensity' (W/sr)", "intensity");
  if (power) light.intensity = scaled(*power, 1.0f / (4.0f * std::numbers::pi_v<float>));
}

/// Returns a coordinate system with its origin at `position` and +z along `direction`.
Transform aim(Vec3d position, Vec3f direction) {
  const Frame<Scalar> frame = Frame<Scalar>::from_normal(normalize(direction));
  Matrix4 m;
  const Vec3d columns[4] = {frame.s, frame.t, frame.n, position};
  for (std::size_t j = 0; j < 4; ++j) {
    m.m[0][j] = columns[j].x;
    m.m[1][j] = columns[j].y;
    m.m[2][j] = columns[j].z;
  }
  return Transform(m);
}

/// Reads `toWorld`, or `position` with `direction` or the target `lookAt`. The default direction is +z.
Transform read_placement(Properties& p) {
  const bool position = p.has("position"), direction = p.has("direction"), look_at = p.has("lookAt");
  if (p.has("toWorld")) {
    for (const char* other : {"position", "direction", "lookAt"})
      if (p.has(other)) report_both(p, "toWorld'", std::string(other) + "'", other);
    return p.transform("toWorld");
  }
  if (direction && look_at) report_both(p, "direction'", "lookAt'", "direction");
  if (!position && !direction && !look_at) return Transform();
  const Vec3d origin = p.point("position", {0, 0, 0});
  Vec3f towards = p.vec3("direction", {0, 0, 1});
  if (look_at) towards = (p.point("lookAt", {0, 0, 0}) - origin).rounded();
  return aim(origin, checked_direction(p, look_at ? "lookAt" : "direction", towards));
}

/// Solid angle (sr) that converts a spot light's intensity to its power. The cosine of its cone is the mean of the
/// cosines at the start and the end of the falloff.
float solid_angle(const SpotLightDescription& light) {
  const auto cosine = [](float degrees) { return std::cos(degrees * std::numbers::pi_v<float> / 180); };
  return 2 * std::numbers::pi_v<float> * (1 - 0.5f * (cosine(light.beam_width) + cosine(light.cutoff_angle)));
}

void read_spot_light(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<SpotLightDescription>();
  light.falloff = SpotLightDescription::Falloff::kSmooth;
  light.to_world = read_placement(p);
  light.intensity = p.spectrum("intensity", light.intensity, SpectrumRole::kEmission);
  const auto power = p.find_spectrum("power", SpectrumRole::kEmission);
  if (power && p.has("intensity")) report_both(p, "power' (W)", "intensity' (W/sr)", "intensity");
  light.cutoff_angle = p.number("totalWidth", 30, {0, 180, true});
  constexpr float kUsualEdge = 5;
  const float usual = std::max(light.cutoff_angle - kUsualEdge, 0.0f);
  // A falloff that starts outside the cone has no effect.
  light.beam_width = std::min(p.number("falloffStart", usual, kNotNegative), light.cutoff_angle);
  if (power) light.intensity = scaled(*power, 1.0f / solid_angle(light));
}

void read_directional_light(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<DirectionalLightDescription>();
  light.direction = read_direction(p, "toWorld");
  if (p.has("irradiance") && p.has("intensity")) report_both(p, "irradiance'", "intensity'", "irradiance");
  const char* name = p.has("intensity") ? "intensity" : "irradiance";
  light.irradiance = p.spectrum(name, light.irradiance, SpectrumRole::kEmission);
}

/// Reads an environment map with a texture for radiance: a constant color or an image.
void read_textured_envmap(Properties& p, const XmlElement& texture, LightDescription& light) {
  const SpectrumInput radiance = texture_of(texture, p.context());
  if (const auto* constant = std::get_if<SpectrumDescription>(&radiance)) {
    light.model = ConstantLightDescription{*constant};
    return;
  }
  const auto index = static_cast<std::size_t>(std::get<TextureId>(radiance));
  const auto* bitmap = std::get_if<BitmapDescription>(&p.context().description.textures[index].model);
  if (bitmap == nullptr) p.fail("has a texture that is not an image, expected an image or a color");
  if (bitmap->channel != BitmapDescription::Channel::kColor)
    p.fail("has a texture of a single channel, expected an image or a color");
  EnvmapDescription map;
  map.file = bitmap->file;
  map.to_world = p.transform("toWorld");
  map.scale = p.number("scale", 1, kNotNegative);
  map.mis_compensation = true;
  light.model = std::move(map);
}

/// Reads an environment map from a file, or with a texture.
void read_envmap(Properties& p, LightDescription& light) {
  if (const XmlElement* texture = p.any_texture())
    read_textured_envmap(p, *texture, light);
  else
    light.model = EnvmapDescription::read(p);
}

/// Lights that Mitsuba writes differently.
constexpr LightReader kReaders[] = {
    {"directional", read_directional_light},
    {"envmap", read_envmap},
    {"point", read_point_light},
    {"spot", read_spot_light},
};

}  // namespace

void read_emitter(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  LightDescription light;
  light.where = element.where;
  if (const std::string* id = element.find_attribute("id")) light.id = *id;
  if (p.type() == "area") p.fail("must be nested in a <mesh>");
  find_plugin<LightReader>(p, {kReaders, light_readers()}, {"area"}).read(p, light);
  read_light_motion(p, "toWorld", light);
  p.reject_unused();
  context.description.lights.push_back(std::move(light));
}

}  // namespace sheaf::nori
