// The Mitsuba dialect: emitters.
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_daylight.h"
#include "scene/dialects/xml/read_emitter.h"
#include "scene/dialects/xml/read_texture.h"

#include <iterator>

namespace sheaf::mitsuba {

namespace {

void read_point_light(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<PointLightDescription>();
  const bool placed = p.has("to_world");
  light.position = p.point("position", {0, 0, 0});
  if (placed && p.has("position"))
    p.report("has both 'position' and 'to_world', expected one", SceneErrorCode::kDuplicate, "'position' ignored");
  if (placed) light.position = p.placement("to_world").to_world.translation();
  light.intensity = p.spectrum("intensity", SpectrumDescription::constant(1), SpectrumRole::kEmission);
}

void read_spot_light(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<SpotLightDescription>();
  light.to_world = p.placement("to_world").to_world;
  light.intensity = p.spectrum("intensity", SpectrumDescription::constant(1), SpectrumRole::kEmission);
  light.cutoff_angle = p.number("cutoff_angle", 20, {0, 180, true});
  light.beam_width = p.number("beam_width", 0.75f * light.cutoff_angle, {0, light.cutoff_angle, false});
  const std::optional<SpectrumInput> texture = p.find_spectrum_input("texture", SpectrumRole::kEmission);
  if (!texture) return;
  if (!(light.cutoff_angle < 90)) {
    p.report_at("cutoff_angle", "is too large for a spot with a texture, expected less than 90 degrees",
                SceneErrorCode::kOutOfRange);
    light.cutoff_angle = 20;
    light.beam_width = std::min(light.beam_width, light.cutoff_angle);
  }
  light.texture = texture_showing(*texture, p.where(), p.context());
}

void read_directional_light(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<DirectionalLightDescription>();
  light.direction = read_direction(p, "to_world");
  light.irradiance = p.spectrum("irradiance", SpectrumDescription::constant(1), SpectrumRole::kEmission);
}

void read_beam(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<BeamDescription>();
  light.to_world = p.placement("to_world").to_world;
  light.power = p.spectrum("power", SpectrumDescription::constant(1), SpectrumRole::kEmission);
}

void read_projector(Properties& p, LightDescription& out) {
  auto& light = out.model.emplace<ProjectorDescription>();
  light.to_world = p.placement("to_world").to_world;
  light.irradiance = p.spectrum_input("irradiance", SpectrumDescription::constant(1), SpectrumRole::kEmission);
  light.scale = p.number("scale", 1, kNotNegative);
  CameraDescription camera;
  read_fov(p, camera);
  light.fov = camera.fov;
  light.fov_axis = camera.fov_axis;
}

/// Lights that Nori writes differently, or that it does not have.
constexpr LightReader kReaders[] = {
    {"collimated", read_beam},   {"directional", read_directional_light},
    {"point", read_point_light}, {"projector", read_projector},
    {"spot", read_spot_light},
};

}  // namespace

void read_emitter(const XmlElement& element, Reader& reader) {
  Properties p(element, reader.context);
  std::vector<LightDescription> lights(1);
  LightDescription& light = lights[0];
  light.where = element.where;
  // Read the emitter by its type
  if (is_daylight(p.type())) {
    lights = read_daylight(p, reader.before_version_2);
  } else if (p.type() == "area" || p.type() == "directionalarea") {
    if (!reader.context.scene.is_referenced(element)) p.fail("must be nested in a <shape>, or referred to by one");
    return;
  } else {
    std::vector<std::string> others = daylight_names();
    others.insert(others.end(), {"area", "directionalarea"});
    find_plugin<LightReader>(p, {kReaders, light_readers()}, std::move(others)).read(p, light);
    read_light_motion(p, "to_world", light);
  }
  // Reject unknown properties, and append the lights
  if (p.type() == "constant") p.ignore({"to_world"});
  p.ignore({"sampling_weight"});
  p.objects("medium");  // enclosing medium; found from the surrounding shapes
  p.reject_unused();
  if (const std::string* id = element.find_attribute("id"))
    for (LightDescription& each : lights) each.id = *id;
  std::vector<LightDescription>& all = reader.context.description.lights;
  std::move(lights.begin(), lights.end(), std::back_inserter(all));
}

}  // namespace sheaf::mitsuba
