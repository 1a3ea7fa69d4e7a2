// The pbrt dialect: lights. Spectra of light are scaled to a luminance of 1, so that 1 on the film is what a light of
// L = 1 looks like; the film's exposure is multiplied in here.
#include "scene/dialects/pbrt.h"

#include <cmath>

namespace sheaf::pbrt {

namespace {

SpectrumDescription read_emission(Parameters& p, const char* name) {
  return find_spectrum(p, name, Use::kLight).value_or(SpectrumDescription::constant(1));
}

/// scale, times the exposure.
float read_scale(Parameters& p) { return p.number("scale", 1, kNotNegative) * p.reader().exposure; }

/// A direction, as the axis from `from` to `to`.
Transform along_axis(Parameters& p) {
  const Vec3f from = p.vec3("from", {0, 0, 0}), to = p.vec3("to", {0, 0, 1});
  if (from == to) p.fail("has 'from' and 'to' at the same place, expected a direction");
  const Vec3f axis = to - from;
  const bool upright = std::fabs(axis.y) > std::fabs(axis.x) + std::fabs(axis.z);
  return p.reader().attributes.transform * Transform::look_at(from, to, upright ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0});
}

PointLightDescription read_point(Parameters& p) {
  const SpectrumDescription intensity = read_emission(p, "I");
  float scale = read_scale(p);
  if (const auto power = p.find_number("power"); power && *power > 0.0f) scale *= *power / (4 * kPi);
  return {p.reader().attributes.transform.point(p.vec3("from", {0, 0, 0})), scaled(intensity, scale)};
}

SpotLightDescription read_spot(Parameters& p) {
  SpotLightDescription light;
  light.falloff = SpotLightDescription::Falloff::kSmooth;
  light.cutoff_angle = p.number("coneangle", 30, {0, 180, true});
  light.beam_width = light.cutoff_angle - p.number("conedeltaangle", 5, {0, double{light.cutoff_angle}, false});
  light.to_world = along_axis(p);
  const SpectrumDescription intensity = read_emission(p, "I");
  float scale = read_scale(p);
  if (const auto power = p.find_number("power"); power && *power > 0.0f) {
    const float start = std::cos(light.beam_width * kPi / 180), end = std::cos(light.cutoff_angle * kPi / 180);
    scale *= *power / (2 * kPi * ((1 - start) + (start - end) / 2));
  }
  light.intensity = scaled(intensity, scale);
  return light;
}

DirectionalLightDescription read_distant(Parameters& p) {
  const Transform axis = along_axis(p);
  float scale = read_scale(p);
  if (const auto illuminance = p.find_number("illuminance"); illuminance && *illuminance > 0.0f) scale *= *illuminance;
  return {axis.vector({0, 0, 1}), scaled(read_emission(p, "L"), scale)};
}

decltype(LightDescription::model) read_infinite(Parameters& p) {
  if (!p.numbers("portal", 3).empty())
    p.reader().note(p.where(), p.title() + ": 'portal' only helps to find the light, and is not used");
  float scale = read_scale(p);
  const auto illuminance = p.find_number("illuminance");
  const bool lit = illuminance && *illuminance > 0.0f;
  if (!p.has("filename")) {
    if (lit) scale *= *illuminance / kPi;
    return ConstantLightDescription{scaled(read_emission(p, "L"), scale)};
  }
  if (p.has("L")) p.fail("has both 'L' and 'filename', expected one");
  if (lit) p.unsupported("'illuminance' of a picture", "the picture is taken as it is");
  EnvmapDescription light;
  light.file = p.file("filename");
  light.scale = scale;
  light.to_world = p.reader().attributes.transform;
  light.layout = EnvmapDescription::Layout::kOctahedral;
  return light;
}

/// Lights that have no counterpart: a point light of the same intensity takes their place.
PointLightDescription read_stand_in(Parameters& p) {
  p.unsupported("lights of this kind", "a point light of the same intensity is taken");
  p.accept({"filename", "fov"});
  return read_point(p);
}

}  // namespace

void read_light(Reader& reader, Entity entity) {
  Parameters p(reader, "LightSource '" + entity.type + "'", entity.where, std::move(entity.parameters));
  LightDescription light;
  light.where = entity.where;
  if (entity.type == "point") {
    light.model = read_point(p);
  } else if (entity.type == "spot") {
    light.model = read_spot(p);
  } else if (entity.type == "distant") {
    light.model = read_distant(p);
  } else if (entity.type == "infinite") {
    light.model = read_infinite(p);
  } else if (entity.type == "goniometric" || entity.type == "projection") {
    light.model = read_stand_in(p);
  } else {
    const std::vector<std::string> known = {"distant", "goniometric", "infinite", "point", "projection", "spot"};
    throw SceneError(entity.where, "unknown light '" + entity.type + "'" + did_you_mean(entity.type, known));
  }
  p.finish();
  reader.description.lights.push_back(std::move(light));
}

AreaLight read_area_light(Reader& reader, Entity entity) {
  Parameters p(reader, "AreaLightSource '" + entity.type + "'", entity.where, std::move(entity.parameters));
  if (entity.type != "diffuse" && entity.type != "area")
    throw SceneError(entity.where, "unknown area light '" + entity.type + "'" + did_you_mean(entity.type, {"diffuse"}));
  AreaLight light;
  light.where = entity.where;
  const float scale = read_scale(p);
  if (p.has("filename")) {
    if (p.has("L")) p.fail("has both 'L' and 'filename', expected one");
    BitmapDescription picture;
    picture.file = p.file("filename");
    picture.wrap_u = picture.wrap_v = BitmapDescription::Wrap::kClamp;
    picture.change.scale = scale;
    light.radiance = add_picture(reader, std::move(picture), entity.where);
  } else {
    light.radiance = scaled(read_emission(p, "L"), scale);
  }
  if (const auto power = p.find_number("power"); power && *power > 0.0f) light.power = *power;
  if (p.boolean("twosided", false))
    p.unsupported("light to both sides ('twosided')", "it shines on the side of the normal");
  p.finish();
  return light;
}

}  // namespace sheaf::pbrt
