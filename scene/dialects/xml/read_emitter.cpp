// Emitters of the Nori and Mitsuba dialects.
#include "scene/dialects/xml/read_emitter.h"

#include "scene/description.h"

namespace sheaf {

namespace {

void read_area_emitter(const XmlElement& element, ReadContext& context, ShapeDescription& shape,
                       std::initializer_list<const char*> ignored) {
  Properties p(element, context);
  // Some files name the emitter after its shape.
  const bool is_area = p.type() == "area" || p.type().ends_with("_emitter");
  const bool along_normal = p.type() == "directionalarea";
  if (!is_area && !along_normal) p.fail_plugin({"area", "directionalarea"});
  if (const std::string* id = element.find_attribute("id")) shape.emitter_id = *id;
  shape.emits_along_normal = along_normal;
  shape.radiance = p.spectrum_input("radiance", SpectrumDescription::constant(1), SpectrumRole::kEmission);
  p.ignore(ignored);
  p.reject_unused();
}

}  // namespace

void find_area_emitter(const XmlElement& element, ReadContext& context, ShapeDescription& shape,
                       std::initializer_list<const char*> ignored) {
  read_or_omit(element, context, [&] { read_area_emitter(element, context, shape, ignored); });
}

void read_light_motion(Properties& p, const char* to_world, LightDescription& light) {
  if (!p.is_animation(to_world) || std::holds_alternative<ConstantLightDescription>(light.model)) return;
  light.motion = add_motion(p.context().description.motions, p.placement(to_world));
}

Vec3f read_direction(Properties& p, const char* to_world) {
  const bool placed = p.has(to_world);
  if (placed && p.has("direction"))
    p.fail(fmt::format("has both 'direction' and '{}', expected one", to_world), SceneErrorCode::kDuplicate);
  const Vec3f direction = placed ? p.placement(to_world).to_world.vector({0, 0, 1}) : p.vec3("direction", {0, 0, 1});
  return checked_direction(p, "direction", direction);
}

Vec3f checked_direction(Properties& p, const char* name, Vec3f direction) {
  const float squared = length_squared(direction);
  if (squared > 0.0f && is_finite(squared)) return direction;
  p.report_at(name, "has no length", SceneErrorCode::kOutOfRange);
  return {0, 0, 1};
}

}  // namespace sheaf
