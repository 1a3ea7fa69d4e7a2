// The Mitsuba dialect (0.6, 2, 3): top-level elements of a scene.
#include "scene/dialects/mitsuba/reader.h"

#include "scene/dialects/common/choose_camera.h"
#include "scene/dialects/common/moving_groups.h"
#include "scene/dialects/mitsuba/read_mitsuba.h"
#include "scene/dialects/model/auto_camera.h"

namespace sheaf {

namespace {

/// Whether the version attribute names a release before 2.0.
bool is_before_version_2(const XmlElement& root) {
  const std::string* version = root.find_attribute("version");
  return version != nullptr && (version->starts_with("0.") || version->starts_with("1."));
}

/// Rejects a top-level object that needs a parent unless another object refers to it.
void expect_referenced(const XmlElement& element, const char* expected, const ReadContext& context) {
  if (!context.scene.is_referenced(element))
    throw SceneError(element.where,
                     fmt::format("<{}> at the top level is not referenced, expected it {}", element.name, expected));
}

[[noreturn]] void fail_unknown(const XmlElement& element) {
  const std::vector<std::string> known = {"sensor",     "shape",   "bsdf",    "texture",    "emitter",
                                          "integrator", "film",    "sampler", "rfilter",    "spectrum",
                                          "rgb",        "default", "include", "path",       "alias",
                                          "medium",     "phase",   "volume",  "subsurface", "animation"};
  throw SceneError(
      element.where,
      fmt::format("unknown element <{}> in a Mitsuba scene{}", element.name, did_you_mean(element.name, known)),
      SceneErrorCode::kUnknownName);
}

bool is_spectrum(const XmlElement& e) {
  return e.name == "spectrum" || e.name == "rgb" || e.name == "srgb" || e.name == "blackbody";
}

}  // namespace

namespace {

/// Elements that are read after all others.
struct DeferredElements {
  std::vector<const XmlElement*> sensors;
  const XmlElement* integrator = nullptr;
};

void read_child(const XmlElement& child, mitsuba::Reader& reader, DeferredElements& deferred) {
  ReadContext& context = reader.context;
  const std::string& kind = child.name;
  if (kind == "shape") {
    mitsuba::read_shape(child, reader);
  } else if (kind == "bsdf") {
    mitsuba::material_of(child, reader);
  } else if (kind == "medium") {
    mitsuba::medium_of(child, reader);
  } else if (kind == "texture") {
    if (!context.scene.is_referenced(child)) mitsuba::texture_of(child, context);
  } else if (kind == "emitter") {
    mitsuba::read_emitter(child, reader);
  } else if (kind == "sensor") {
    deferred.sensors.push_back(&child);
  } else if (kind == "integrator") {
    if (context.scene.is_referenced(child)) return;
    if (deferred.integrator != nullptr)
      throw SceneError(child.where, "a second <integrator>, expected one", SceneErrorCode::kDuplicate);
    deferred.integrator = &child;
  } else if (kind == "film" || kind == "sampler") {
    expect_referenced(child, "inside a <sensor>", context);
  } else if (kind == "rfilter") {
    expect_referenced(child, "inside a <film>", context);
  } else if (is_spectrum(child) || kind == "animation") {
    expect_referenced(child, "inside an object", context);
  } else if (kind == "phase" || kind == "volume") {
    expect_referenced(child, "inside a <medium>", context);
  } else if (kind == "subsurface") {
    expect_referenced(child, "inside a <shape>", context);
  } else if (kind == "ref") {
    throw SceneError(child.where, "<ref> at the top level, expected it inside an object");
  } else {
    fail_unknown(child);
  }
}

/// Reads the chosen sensor. Those of shapes come after the others.
void read_camera(mitsuba::Reader& reader, const std::vector<const XmlElement*>& sensors) {
  ReadContext& context = reader.context;
  std::vector<const XmlElement*> all = sensors;
  for (const mitsuba::ShapeSensor& sensor : reader.shape_sensors) all.push_back(sensor.element);
  std::vector<std::string> names;
  for (const XmlElement* sensor : all) {
    const std::string* id = sensor->find_attribute("id");
    names.push_back(id == nullptr ? "" : *id);
  }
  if (all.empty()) return substitute_camera(context.scene.root(), "<sensor>", context);
  context.cameras = names;
  const std::size_t chosen = choose_camera(context.camera, names, context.scene.root().where.file.string());
  for (std::size_t i = 1; i < all.size() && context.camera.empty(); ++i)
    context.note(all[i]->where, "sensor ignored: only the first one is rendered (choose another by --camera)");
  if (chosen < sensors.size()) {
    read_or_omit(*all[chosen], context, [&] { mitsuba::read_sensor(*all[chosen], reader); });
  } else {
    const mitsuba::ShapeSensor& sensor = reader.shape_sensors[chosen - sensors.size()];
    read_or_omit(*all[chosen], context, [&] { mitsuba::read_shape_sensor(sensor, reader); });
  }
}

}  // namespace

void read_mitsuba(ReadContext& context) {
  const XmlElement& root = context.scene.root();
  context.readers.texture = mitsuba::texture_of;
  mitsuba::Reader reader{context, is_before_version_2(root)};
  context.exchanges_checkerboards = !is_before_version_2(root);
  DeferredElements deferred;
  for (const XmlElement& child : root.children)
    read_or_omit(child, context, [&] { read_child(child, reader, deferred); });
  separate_moving_shapes(context.description, context.errors);
  // Read the camera, then the integrator
  read_camera(reader, deferred.sensors);
  if (deferred.integrator != nullptr) {
    read_or_omit(*deferred.integrator, context, [&] { mitsuba::read_integrator(*deferred.integrator, reader); });
  } else {
    context.note(root.where, "the scene has no <integrator>, rendered with 'path'");
  }
}

}  // namespace sheaf
