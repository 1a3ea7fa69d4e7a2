// The Nori dialect: camera, mesh, bsdf, emitter, sampler, integrator, rfilter; camelCase names; no references.
#include "scene/dialects/nori.h"
#include "scene/dialects/integrator_name.h"
#include "scene/dialects/light_selector_name.h"
#include "scene/dialects/medium_estimator_name.h"
#include "scene/dialects/read_camera.h"
#include "scene/dialects/read_emitter.h"
#include "scene/dialects/read_photon_mapping.h"

namespace sheaf {

namespace {

/// A radius other than the one that the filter's other parameters imply is left out, and said so.
void check_radius(Properties& p, const FilterDescription& filter) {
  const float radius = p.number("radius", filter.radius, kPositive);
  if (radius != filter.radius)
    p.context().note(p.where(), "rfilter '" + p.type() + "' has the radius " + std::to_string(filter.radius) +
                                    " pixels; the given radius is not used");
}

FilterDescription read_filter(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  FilterDescription filter;
  if (p.type() == "box") {
    filter.kind = FilterDescription::Kind::kBox;
    filter.radius = 0.5f;
  } else if (p.type() == "tent") {
    filter.kind = FilterDescription::Kind::kTent;
    filter.radius = 1;
  } else if (p.type() == "gaussian") {
    filter.kind = FilterDescription::Kind::kGaussian;
    filter.stddev = p.number("stddev", 0.5f, kPositive);
    filter.radius = 4 * filter.stddev;
    check_radius(p, filter);
  } else if (p.type() == "mitchell") {
    filter.kind = FilterDescription::Kind::kMitchell;
    filter.radius = 2;
    check_radius(p, filter);
    filter.b = p.number("B", 1.0f / 3);
    filter.c = p.number("C", 1.0f / 3);
  } else {
    p.fail_plugin({"box", "gaussian", "mitchell", "tent"});
  }
  p.finish();
  return filter;
}

/// The one of two names that the property goes by.
std::optional<float> find_either(Properties& p, const char* name, const char* other, NumberRange range) {
  if (p.has(name) && p.has(other))
    p.fail("has both '" + std::string(name) + "' and '" + other + "', expected one");
  return p.has(name) ? p.find_number(name, range) : p.find_number(other, range);
}

/// A thin lens, under the names that renderers of this dialect give to it.
void read_lens(Properties& p, CameraDescription& camera) {
  const auto radius = find_either(p, "apertureRadius", "lensRadius", kNotNegative);
  const auto distance = find_either(p, "focusDistance", "focalDistance", kPositive);
  if (p.type() == "thinlens" && !radius) p.fail("has no 'apertureRadius'");
  camera.aperture_radius = radius.value_or(0.0f);
  if (camera.aperture_radius > 0 && !distance) p.fail("has a lens but no 'focusDistance'");
  camera.focus_distance = distance.value_or(kInfinity);
}

void read_camera(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  if (p.type() != "perspective" && p.type() != "thinlens" && p.type() != "orthographic")
    p.fail_plugin({"orthographic", "perspective", "thinlens"});
  CameraDescription& camera = context.description.camera;
  FilmDescription& film = context.description.film;
  camera.where = element.where;
  // Nori's camera space has x to the right of the picture; its scenes begin with scale -1, 1, 1 before a lookat.
  camera.to_world = p.transform("toWorld") * Transform::scale({-1, 1, 1});
  if (p.type() == "orthographic") {
    camera.projection = CameraDescription::Projection::kOrthographic;
  } else {
    camera.fov = p.number("fov", 30, {0, 180, true});
    camera.fov_axis = CameraDescription::FovAxis::kX;
    read_lens(p, camera);
  }
  read_clip(p, camera, 1e-4f);
  film.width = p.integer("width", 1280, 1, 1'000'000'000);
  film.height = p.integer("height", 720, 1, 1'000'000'000);
  check_frame(film.width, film.height, element.where);
  film.filter = {FilterDescription::Kind::kGaussian, 2.0f, 0.5f};
  if (const XmlElement* filter = p.object("rfilter")) film.filter = read_filter(*filter, context);
  p.finish();
}

void read_sampler(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  SamplerDescription& sampler = context.description.sampler;
  sampler.kind = read_sampler_kind(p);
  sampler.sample_count = static_cast<std::uint32_t>(p.integer("sampleCount", 1, 1, kMaxSampleCount));
  p.finish();
}

void read_integrator(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  const NamedIntegrator* named = find_integrator(p.type());
  if (named == nullptr) p.fail_plugin(integrator_names());
  IntegratorDescription& integrator = context.description.integrator;
  apply(*named, integrator);
  if (transports_light(named->kind)) {
    if (!named->direct) {
      integrator.max_depth = p.integer("maxDepth", -1, -1, 1'000'000);
      integrator.rr_depth = p.integer("rrDepth", 5, 1, 1'000'000);
    }
    integrator.hide_emitters = p.boolean("hideEmitters", false);
    read_light_sampling(p, integrator);
    read_medium_estimation(p, integrator);
    if (named->kind == IntegratorKind::kPhotonMapper) read_photon_mapping(p, integrator.photons);
  }
  p.finish();
}

/// The material of a mesh and what it holds. Without a material, a medium has a boundary that light does not notice.
void read_inside(Properties& p, ShapeDescription& shape) {
  ReadContext& context = p.context();
  std::optional<SpectrumDescription> absorption;
  const XmlElement* bsdf = p.object("bsdf");
  const XmlElement* medium = p.object("medium");
  if (bsdf != nullptr) shape.material = nori::read_bsdf(*bsdf, context, absorption);
  if (absorption && medium != nullptr) p.fail("holds a <medium> and a bsdf with 'sigmaA', expected one or the other");
  if (medium != nullptr) shape.interior = nori::read_medium(*medium, context, true);
  if (absorption) shape.interior = nori::add_absorption(*bsdf, *absorption, context);
  shape.exterior_is_surrounding = shape.interior.has_value();
  if (medium == nullptr || bsdf != nullptr) return;
  MaterialDescription boundary;
  boundary.model = NullDescription{};
  boundary.where = p.where();
  shape.material = add_material(context, std::move(boundary));
}

void read_mesh(const XmlElement& element, ReadContext& context) {
  if (read_instancing(element, context, [&](const XmlElement& e) { read_mesh(e, context); })) return;
  Properties p(element, context);
  ShapeDescription shape;
  shape.where = element.where;
  if (p.type() == "obj") {
    shape.geometry = MeshFileShape{p.file("filename"), MeshFileShape::Format::kObj, false, false};
  } else if (p.type() == "sphere") {
    const Vec3f center = p.vec3("center", {0, 0, 0});
    shape.geometry = SphereShape{center, p.number("radius", 1, kPositive)};
  } else {
    p.fail_plugin({"obj", "sphere"});
  }
  shape.to_world = p.transform("toWorld");
  read_inside(p, shape);
  if (const XmlElement* emitter = p.object("emitter")) shape.radiance = read_area_emitter(*emitter, context);
  p.finish();
  context.description.shapes.push_back(std::move(shape));
}

}  // namespace

void read_nori(ReadContext& context) {
  context.readers.texture = nori::texture_of;
  const XmlElement* camera = nullptr;
  const XmlElement* sampler = nullptr;
  const XmlElement* integrator = nullptr;
  auto keep = [](const XmlElement*& slot, const XmlElement& element) {
    if (slot != nullptr) throw SceneError(element.where, "a second <" + element.name + ">, expected one");
    slot = &element;
  };
  for (const XmlElement& child : context.scene.root().children) {
    if (child.name == "camera") {
      keep(camera, child);
    } else if (child.name == "sampler") {
      keep(sampler, child);
    } else if (child.name == "integrator") {
      keep(integrator, child);
    } else if (child.name == "mesh") {
      read_mesh(child, context);
    } else if (child.name == "medium") {
      if (context.description.camera.medium) throw SceneError(child.where, "a second <medium>, expected one");
      context.description.camera.medium = nori::read_medium(child, context, false);
    } else if (child.name == "emitter") {
      nori::read_emitter(child, context);
    } else {
      throw SceneError(child.where,
                       "unknown element <" + child.name + "> in a Nori scene" +
                           did_you_mean(child.name, {"camera", "sampler", "integrator", "mesh", "emitter", "medium"}));
    }
  }
  const SourceLocation& where = context.scene.root().where;
  if (camera == nullptr) throw SceneError(where, "the scene has no <camera>");
  if (integrator == nullptr) throw SceneError(where, "the scene has no <integrator>");
  read_camera(*camera, context);
  read_integrator(*integrator, context);
  context.description.sampler.sample_count = 1;
  if (sampler != nullptr) read_sampler(*sampler, context);
}

}  // namespace sheaf
