// Emitters shared by the Nori and Mitsuba dialects: constant light, environment maps and area lights.
#include "scene/dialects/common/read_emitter.h"

#include "scene/dialects/common/read_texture.h"

namespace sheaf {

namespace {

/// Reads `radiance` (default 1).
ConstantLightDescription read_constant(Properties& p) {
  return {p.spectrum("radiance", SpectrumDescription::constant(1), SpectrumRole::kEmission)};
}

/// Reads `filename`, `scale` (default 1), `to_world`, `mis_compensation` (default true) and `gamma` of Mitsuba 0.6.
/// Ignores its `cache`.
EnvmapDescription read_envmap(Properties& p) {
  EnvmapDescription map;
  map.file = p.file("filename");
  map.scale = p.number("scale", 1, kNotNegative);
  map.to_world = p.transform("to_world");
  map.mis_compensation = p.boolean("mis_compensation", true);
  map.raw = read_linear_gamma(p);
  p.ignore({"cache"});
  return map;
}

}  // namespace

const std::vector<std::string>& shared_emitter_names() {
  static const std::vector<std::string> kNames = {"constant", "envmap"};
  return kNames;
}

bool read_shared_emitter(Properties& p, LightDescription& light) {
  if (p.type() == "constant") {
    light.model = read_constant(p);
  } else if (p.type() == "envmap") {
    light.model = read_envmap(p);
  } else {
    return false;
  }
  return true;
}

void read_area_emitter(const XmlElement& element, ReadContext& context, ShapeDescription& shape,
                       std::initializer_list<const char*> ignored) {
  Properties p(element, context);
  if (const std::string* id = element.find_attribute("id")) shape.emitter_id = *id;
  shape.emits_along_normal = p.type() == "directionalarea";
  // Some files name the emitter after its shape.
  const bool is_area = p.type() == "area" || p.type().ends_with("_emitter");
  if (!is_area && !shape.emits_along_normal) p.fail_plugin({"area", "directionalarea"});
  shape.radiance = p.spectrum_input("radiance", SpectrumDescription::constant(1), SpectrumRole::kEmission);
  p.ignore(ignored);
  p.reject_unused();
}

Vec3f read_direction(Properties& p, const char* to_world) {
  const bool placed = p.has(to_world);
  if (placed && p.has("direction")) p.fail(std::string("has both 'direction' and '") + to_world + "', expected one");
  Vec3f direction = p.vec3("direction", {0, 0, 1});
  if (placed) direction = p.transform(to_world).vector({0, 0, 1});
  check_direction(p, "direction", direction);
  return direction;
}

void check_direction(Properties& p, const char* name, Vec3f direction) {
  const float squared = length_squared(direction);
  if (!(squared > 0.0f) || !is_finite(squared)) p.fail_at(name, "has no length");
}

}  // namespace sheaf
