// Cameras and lights of COLLADA.
#include "tools/importer/collada_document.h"
#include "tools/importer/lens.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

namespace sheaf::importer {

namespace {

constexpr double kRadians = std::numbers::pi / 180;

/// The number in a child element; empty without that element.
std::optional<double> number(const pugi::xml_node& parent, const char* child) {
  const std::vector<double> values = numbers_of(parent.child(child));
  return values.empty() ? std::nullopt : std::optional(values.front());
}

/// Half of an angle in degrees, as its tangent. Nothing if the angle is not in (0, 180).
std::optional<double> half_tangent(std::optional<double> degrees) {
  if (!degrees || !(*degrees > 0 && *degrees < 180)) return std::nullopt;
  return std::tan(*degrees * kRadians / 2);
}

Camera read_camera(const pugi::xml_node& from, const std::string& name) {
  Camera camera;
  camera.name = name;
  const pugi::xml_node technique = from.child("optics").child("technique_common");
  const auto aspect_of = [](const pugi::xml_node& lens) {
    const double aspect = number(lens, "aspect_ratio").value_or(0);
    return aspect > 0 && std::isfinite(aspect) ? aspect : 0;
  };
  if (const pugi::xml_node view = technique.child("orthographic")) {
    set_orthographic(camera, number(view, "xmag"), number(view, "ymag"), aspect_of(view));
  } else {
    const pugi::xml_node lens = technique.child("perspective");
    set_perspective(camera, {half_tangent(number(lens, "xfov")), half_tangent(number(lens, "yfov")), aspect_of(lens)});
  }
  return camera;
}

/// Sets the cone of a light whose intensity is cos^exponent of the angle up to `outer` (radians), and zero beyond. The
/// light of glTF decreases from the inner to the outer angle by a smooth step in the cosine; the inner angle is such
/// that both have the same flux. Where even an inner angle of 0 has more flux, the outer angle is smaller.
void set_cone(Light& light, double outer, double exponent) {
  const double cos_outer = std::cos(outer);
  const double flux = (1 - std::pow(cos_outer, exponent + 1)) / (exponent + 1);  // over 2 pi, on an axis of 1
  const double cos_inner = 2 * (1 - flux) - cos_outer;
  light.outer_angle = outer;
  light.inner_angle = std::min(std::acos(std::clamp(cos_inner, -1.0, 1.0)), outer);
  if (cos_inner > 1) light.outer_angle = std::acos(std::clamp(1 - 2 * flux, -1.0, 1.0));
}

void read_spot(const pugi::xml_node& light, const pugi::xml_node& spot, Light& to) {
  const double exponent = number(spot, "falloff_exponent").value_or(0);
  double angle = number(spot, "falloff_angle").value_or(180);
  if (!(angle > 0)) angle = 180;
  set_cone(to, std::min(angle, 180.0) * kRadians / 2, exponent > 0 && std::isfinite(exponent) ? exponent : 0);
  // Extensions of FCollada and OpenCOLLADA: the angle at which the light ends
  for (const pugi::xml_node& extra : light.children("extra"))
    for (const char* const name : {"outer_cone", "falloff"}) {
      const pugi::xml_node outer =
          extra.find_node([&](const pugi::xml_node& element) { return std::string_view(element.name()) == name; });
      const std::vector<double> degrees = numbers_of(outer);
      if (degrees.empty() || !(degrees.front() >= angle && degrees.front() <= 180)) continue;
      to.inner_angle = angle * kRadians / 2;
      to.outer_angle = degrees.front() * kRadians / 2;
    }
}

Light read_light(const pugi::xml_node& from, const std::string& name) {
  Light light;
  light.name = name;
  const pugi::xml_node technique = from.child("technique_common");
  pugi::xml_node kind = technique.first_child();
  while (kind && kind.type() != pugi::node_element) kind = kind.next_sibling();
  const std::string_view type = kind.name();
  light.kind = type == "directional" ? Light::Kind::kDirectional
               : type == "point"     ? Light::Kind::kPoint
               : type == "spot"      ? Light::Kind::kSpot
                                     : Light::Kind::kOther;
  const std::vector<double> color = numbers_of(kind.child("color"));
  if (color.size() >= 3) std::copy_n(color.begin(), 3, light.color.begin());
  light.attenuation = {number(kind, "constant_attenuation").value_or(1), number(kind, "linear_attenuation").value_or(0),
                       number(kind, "quadratic_attenuation").value_or(0)};
  if (light.kind == Light::Kind::kSpot) read_spot(from, kind, light);
  // An extension of FCollada
  const pugi::xml_node factor =
      from.find_node([](const pugi::xml_node& element) { return std::string_view(element.name()) == "intensity"; });
  if (const std::vector<double> intensity = numbers_of(factor); !intensity.empty())
    for (double& channel : light.color) channel *= intensity.front();
  return light;
}

}  // namespace

void take_optics(ColladaDocument& document, FileParts& out) {
  for (pugi::xml_node& node : document.nodes) {
    const std::string name = node.attribute("id").value();
    NodeParts parts;
    for (const pugi::xml_node& instance : node.children("instance_camera"))
      if (const pugi::xml_node camera = document.target(instance.attribute("url")))
        add_valid(read_camera(camera, name), parts, out.notes);
    for (const pugi::xml_node& instance : node.children("instance_light"))
      if (const pugi::xml_node light = document.target(instance.attribute("url")))
        parts.lights.push_back(read_light(light, name));
    while (node.remove_child("instance_camera")) {}
    while (node.remove_child("instance_light")) {}
    if (!parts.cameras.empty() || !parts.lights.empty()) out.nodes[name].push_back(std::move(parts));
  }
}

}  // namespace sheaf::importer
