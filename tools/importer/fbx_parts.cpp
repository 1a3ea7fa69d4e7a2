#include "tools/importer/fbx_parts.h"

#include "tools/importer/fbx_document.h"
#include "tools/importer/lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

namespace sheaf::importer {

namespace {

/// Properties by name: the values that follow the name, two types and the flags.
using Properties = std::map<std::string, std::vector<FbxValue>>;

Properties properties_of(const FbxElement& element) {
  Properties out;
  for (const FbxElement& list : element.children)
    if (list.name == "Properties70")
      for (const FbxElement& p : list.children)
        if (p.name == "P" && p.values.size() > 4)
          out.try_emplace(p.values[0].text, p.values.begin() + 4, p.values.end());
  return out;
}

/// A model (a node), a node attribute, such as a camera, or a layer of models.
struct Object {
  std::string name, kind;
  bool is_model = false;
  Properties properties;
  const Properties* defaults = nullptr;  ///< those of the file's template

  const std::vector<FbxValue>* find(const char* property) const {
    if (const auto own = properties.find(property); own != properties.end()) return &own->second;
    if (defaults == nullptr) return nullptr;
    const auto shared = defaults->find(property);
    return shared == defaults->end() ? nullptr : &shared->second;
  }
  /// Nothing if the property does not exist or is not finite.
  std::optional<double> number(const char* property) const {
    const std::vector<FbxValue>* const values = find(property);
    if (values == nullptr || !std::isfinite((*values)[0].number)) return std::nullopt;
    return (*values)[0].number;
  }
  double number(const char* property, double default_value) const { return number(property).value_or(default_value); }
  /// The value of an enumeration of the FBX SDK.
  int choice(const char* property, int default_value) const {
    constexpr double kMax = 99;
    return static_cast<int>(std::clamp(number(property, default_value), 0.0, kMax));
  }
};

/// The name without its class, which follows in the binary form and precedes in the text form.
std::string plain_name(const std::string& name) {
  if (const std::size_t end = name.find(std::string("\0\1", 2)); end != name.npos) return name.substr(0, end);
  constexpr std::string_view kClass = "Model::";
  return name.starts_with(kClass) ? name.substr(kClass.size()) : name;
}

/// Half of a field of view in degrees, as its tangent. Nothing if the angle is not in (0, 180).
std::optional<double> half_tangent(std::optional<double> degrees) {
  if (!degrees || !(*degrees > 0 && *degrees < 180)) return std::nullopt;
  return std::tan(*degrees * std::numbers::pi / 360);
}

/// Width over height of the image; 0 if the file does not say it. FbxCamera: AspectRatioMode.
double image_aspect(const Object& camera) {
  constexpr int kFixedWidth = 3, kFixedHeight = 4;
  const double width = camera.number("AspectWidth", 0), height = camera.number("AspectHeight", 0);
  const double pixel = camera.number("PixelAspectRatio", 1);
  const int mode = camera.choice("AspectRatioMode", 0);
  double aspect = height > 0 ? width / height : 0;
  if (mode == kFixedWidth && height > 0) aspect = 1 / height;
  if (mode == kFixedHeight) aspect = width;
  if (!(aspect > 0) || !std::isfinite(aspect)) return 0;
  return pixel > 0 && std::isfinite(pixel) ? aspect * pixel : aspect;
}

/// Whether a film, or an orthographic view, fills the image's height rather than its width. FbxCamera: GateFit.
bool fits_height(const Object& camera, double film_aspect, double aspect) {
  constexpr int kVertical = 1, kFill = 3, kOverscan = 4;
  const int fit = camera.choice("GateFit", 0);
  return fit == kVertical || (fit == kFill && aspect < film_aspect) || (fit == kOverscan && aspect > film_aspect);
}

/// The lens by focal length (mm) and film (inches).
Lens focal_length_lens(const Object& camera, double aspect) {
  constexpr double kMillimeters = 25.4;
  constexpr double kFilmWidth = 0.816, kFilmHeight = 0.612;  // those of the FBX SDK
  const double focal_length = camera.number("FocalLength", 0);
  const double width = camera.number("FilmWidth", kFilmWidth), height = camera.number("FilmHeight", kFilmHeight);
  if (!(focal_length > 0 && width > 0 && height > 0)) return {};
  if (aspect == 0) aspect = width / height;
  if (fits_height(camera, width / height, aspect))
    return {std::nullopt, height * kMillimeters / (2 * focal_length), aspect};
  return {width * kMillimeters / (2 * focal_length), std::nullopt, aspect};
}

/// The lens that the aperture mode names, or else one that the file has data for.
Lens lens_of(const Object& camera) {
  enum Mode { kHorizontalAndVertical, kHorizontal, kVertical, kFocalLength, kModes };
  const double aspect = image_aspect(camera);
  const auto angle = half_tangent(camera.number("FieldOfView"));
  const auto x = half_tangent(camera.number("FieldOfViewX")), y = half_tangent(camera.number("FieldOfViewY"));
  const Lens lenses[kModes] = {{x, y, x && y ? 0 : aspect},
                               {angle, std::nullopt, aspect},
                               {std::nullopt, angle, aspect},
                               focal_length_lens(camera, aspect)};
  int mode = std::min<int>(camera.choice("ApertureMode", kVertical), kFocalLength);
  // Properties of the camera itself override the defaults of its template
  const auto has = [&](const char* property) { return camera.properties.contains(property); };
  if (!has("ApertureMode") && has("FocalLength") && !has("FieldOfView")) mode = kFocalLength;
  for (const int choice : {mode, int{kFocalLength}, int{kHorizontal}, int{kHorizontalAndVertical}})
    if (lenses[choice].x || lenses[choice].y) return lenses[choice];
  return {};
}

/// Converts a camera; adds a note instead if it has no lens.
void add_camera(const Object& from, const std::string& name, NodeParts& to, std::vector<std::string>& notes) {
  Camera camera;
  camera.name = name;
  camera.forward = {1, 0, 0};
  if (from.choice("CameraProjectionType", 0) == 1) {
    constexpr double kWidth = 30;  // units of the file at a zoom of 1
    const double half = kWidth / 2 * from.number("OrthoZoom", 1), aspect = image_aspect(from);
    const bool is_height = fits_height(from, 1, aspect > 0 ? aspect : 1);
    set_orthographic(camera, is_height ? std::nullopt : std::optional(half),
                     is_height ? std::optional(half) : std::nullopt, aspect);
  } else {
    set_perspective(camera, lens_of(from));
  }
  add_valid(std::move(camera), to, notes);
}

Light light_of(const Object& from, const std::string& name) {
  enum Type { kPoint, kDirectional, kSpot };
  enum Decay { kNone, kLinear };
  Light light;
  light.name = name;
  light.direction = {0, -1, 0};
  const int type = from.choice("LightType", kPoint);
  light.kind = type == kPoint         ? Light::Kind::kPoint
               : type == kDirectional ? Light::Kind::kDirectional
               : type == kSpot        ? Light::Kind::kSpot
                                      : Light::Kind::kOther;
  const double intensity = from.number("Intensity", 100) / 100;
  const std::vector<FbxValue>* const color = from.find("Color");
  for (std::size_t k = 0; k < 3; ++k)
    light.color[k] = intensity * (color != nullptr && color->size() > 2 ? (*color)[k].number : 1);
  // The decay starts at a distance, where the light is half as bright.
  const int decay = from.choice("DecayType", kNone);
  const double start = from.number("DecayStart", 1);
  if (decay == kLinear) light.attenuation = {0, 2 / start, 0};
  if (decay > kLinear) light.attenuation = {0, 0, 2 / (start * start)};
  // The angles are those of whole cones.
  const double half = std::numbers::pi / 360;
  light.outer_angle = from.number("OuterAngle", 45) * half;
  light.inner_angle = from.number("InnerAngle", 0) * half;
  return light;
}

/// The objects of a file and the hierarchy of its models.
class FbxParts {
 public:
  explicit FbxParts(const std::vector<FbxElement>& file) {
    for (const FbxElement& element : file) read_templates(element);
    for (const FbxElement& element : file) read_objects(element);
    for (const FbxElement& element : file) read_connections(element);
    for (const auto& [id, object] : objects_)
      if (object.kind == "DisplayLayer" && object.number("Show", 1) == 0)
        for (const std::int64_t member : children_[id]) in_hidden_layer_.insert(member);
  }

  FileParts convert() {
    // Visit the models as Assimp does: parents first, in the order of the connections
    struct Open {
      std::int64_t id;
      bool is_shown;
    };
    std::vector<Open> open = {{0, true}};
    std::set<std::int64_t> visited;
    while (!open.empty()) {
      const Open parent = open.back();
      open.pop_back();
      bool is_shown = parent.is_shown;
      if (parent.id != 0) is_shown = add_model(parent.id, parent.is_shown);
      const auto children = children_.find(parent.id);
      if (children == children_.end()) continue;
      for (auto child = children->second.rbegin(); child != children->second.rend(); ++child)
        if (is_model(*child) && visited.insert(*child).second) open.push_back({*child, is_shown});
    }
    return std::move(out_);
  }

 private:
  void read_templates(const FbxElement& definitions) {
    if (definitions.name != "Definitions") return;
    for (const FbxElement& type : definitions.children)
      for (const FbxElement& shared : type.children)
        if (shared.name == "PropertyTemplate" && !shared.values.empty())
          templates_.try_emplace(shared.values[0].text, properties_of(shared));
  }

  void read_objects(const FbxElement& objects) {
    if (objects.name != "Objects") return;
    for (const FbxElement& element : objects.children) {
      if (element.values.size() < 3) continue;
      Object object{element.values[1].text, element.values[2].text, element.name == "Model", properties_of(element)};
      const auto shared = templates_.find(object.is_model ? "FbxNode" : "Fbx" + object.kind);
      if (shared != templates_.end()) object.defaults = &shared->second;
      objects_.try_emplace(element.values[0].integer, std::move(object));
    }
  }

  void read_connections(const FbxElement& connections) {
    if (connections.name != "Connections") return;
    for (const FbxElement& c : connections.children) {
      if (c.values.size() < 3) continue;
      if (c.values[0].text == "OO") children_[c.values[2].integer].push_back(c.values[1].integer);
      if (c.values[0].text == "OP" && c.values.size() > 3 && c.values[3].text == "Visibility")
        if (is_model(c.values[2].integer))
          out_.notes.push_back(
              fmt::format("node '{}': its visibility is animated (not supported; its static value remains)",
                          plain_name(objects_[c.values[2].integer].name)));
    }
  }

  bool is_model(std::int64_t id) const {
    const auto found = objects_.find(id);
    return found != objects_.end() && found->second.is_model;
  }

  /// Adds the parts of a model and returns whether its children are shown.
  bool add_model(std::int64_t id, bool parent_is_shown) {
    const Object& model = objects_[id];
    const std::string name = plain_name(model.name);
    NodeParts parts;
    const bool inherits = model.number("Visibility Inheritance", 1) != 0;
    const bool is_visible =
        model.number("Visibility", 1) > 0 && !in_hidden_layer_.contains(id) && (parent_is_shown || !inherits);
    parts.is_hidden = !is_visible || model.number("Show", 1) == 0;
    if (const auto attributes = children_.find(id); attributes != children_.end())
      for (const std::int64_t child : attributes->second) {
        const auto found = objects_.find(child);
        if (found == objects_.end() || found->second.is_model) continue;
        if (found->second.kind == "Camera") add_camera(found->second, name, parts, out_.notes);
        if (found->second.kind == "Light") parts.lights.push_back(light_of(found->second, name));
      }
    out_.nodes[name].push_back(std::move(parts));
    return is_visible;
  }

  std::map<std::string, Properties> templates_;
  std::map<std::int64_t, Object> objects_;
  std::map<std::int64_t, std::vector<std::int64_t>> children_;
  std::set<std::int64_t> in_hidden_layer_;
  FileParts out_;
};

}  // namespace

FileParts fbx_parts(std::string_view bytes) { return FbxParts(read_fbx(bytes)).convert(); }

}  // namespace sheaf::importer
