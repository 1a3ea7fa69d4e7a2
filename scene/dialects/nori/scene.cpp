// The Nori dialect: camera, mesh, bsdf, emitter, sampler, integrator and rfilter. Names are camelCase; there are no
// references.
#include "scene/dialects/common/frame_limits.h"
#include "scene/dialects/nori/reader.h"
#include "scene/dialects/xml/read_instances.h"
#include "scene/materials/reading.h"

#include "scene/dialects/common/integrators.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/model/auto_camera.h"
#include "scene/dialects/nori/read_nori.h"
#include "scene/dialects/xml/read_camera.h"
#include "scene/dialects/xml/read_emitter.h"
#include "scene/dialects/xml/read_geometry.h"
#include "scene/dialects/xml/read_photon_mapping.h"
#include "scene/tables/filter.h"

namespace sheaf {

namespace {

/// Adds a note if the given radius differs from the radius implied by the filter's other parameters.
void check_radius(Properties& p, const PixelFilter& filter) {
  const float radius = p.number("radius", filter.radius, kPositive);
  if (radius != filter.radius)
    p.context().note(p.where(), fmt::format("rfilter '{}' has the radius {} pixels, the given radius is ignored",
                                            p.type(), filter.radius));
}

PixelFilter read_gaussian(Properties& p) {
  PixelFilter filter{PixelFilter::Kind::kGaussian};
  filter.stddev = p.number("stddev", 0.5f, kPositive);
  filter.radius = 4 * filter.stddev;
  check_radius(p, filter);
  return filter;
}

PixelFilter read_mitchell(Properties& p) {
  PixelFilter filter{PixelFilter::Kind::kMitchell, 2};
  check_radius(p, filter);
  filter.b = p.number("B", 1.0f / 3);
  filter.c = p.number("C", 1.0f / 3);
  return filter;
}

constexpr NameTable<PixelFilter (*)(Properties&)> kFilters{{{"box",
                                                             [](Properties&) {
                                                               return PixelFilter{PixelFilter::Kind::kBox, 0.5f};
                                                             }},
                                                            {"gaussian", read_gaussian},
                                                            {"mitchell", read_mitchell},
                                                            {"tent", [](Properties&) {
                                                               return PixelFilter{PixelFilter::Kind::kTent, 1};
                                                             }}}};

PixelFilter read_nori_filter(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  const PixelFilter filter = p.plugin_or("gaussian", kFilters)(p);
  p.reject_unused();
  check_filter_radius(static_cast<double>(filter.radius), p.where());
  return filter;
}

/// The name of a property that has two alternative names: the one that is present, or null.
const char* find_either(Properties& p, const char* name, const char* other) {
  if (p.has(name) && p.has(other)) {
    p.report(fmt::format("has both '{}' and '{}', expected one", name, other), SceneErrorCode::kDuplicate,
             fmt::format("'{}' ignored", other));
    p.ignore({other});
  }
  return p.has(name) ? name : p.has(other) ? other : nullptr;
}

/// Reads a thin lens; forks of Nori use several names for its properties.
void read_lens(Properties& p, CameraDescription& camera) {
  const char* radius = find_either(p, "apertureRadius", "lensRadius");
  const char* distance = find_either(p, "focusDistance", "focalDistance");
  if (p.type() == "thinlens" && radius == nullptr)
    p.report("needs the float 'apertureRadius'", SceneErrorCode::kMissing, "rendered as 'perspective'");
  camera.aperture_radius = p.number(radius != nullptr ? radius : "apertureRadius", 0, kNotNegative);
  camera.focus_distance = distance != nullptr ? p.find_number(distance, kPositive).value_or(kInfinity) : kInfinity;
  if (!(camera.aperture_radius > 0) || distance != nullptr) return;
  p.report("has a lens but no 'focusDistance', expected both", SceneErrorCode::kMissing, "rendered as 'perspective'");
  camera.aperture_radius = 0;
}

void read_camera(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  using Projection = CameraDescription::Projection;
  static constexpr NameTable<Projection> kCameras{{{"orthographic", Projection::kOrthographic},
                                                   {"perspective", Projection::kPerspective},
                                                   {"thinlens", Projection::kPerspective}}};
  CameraDescription& camera = context.description.camera;
  FilmSettings& film = context.description.film;
  camera.where = element.where;
  // Nori's camera space has +x to the right in ETH's version, to the left upstream; see docs/scene-format/nori.md.
  camera.to_world = p.transform("toWorld");
  if (context.mirrors_nori_camera) camera.to_world = camera.to_world * Transform::scale({-1, 1, 1});
  camera.projection = p.plugin_or("perspective", kCameras);
  if (camera.projection == Projection::kPerspective) {
    camera.fov = p.number("fov", 30, {0, 180, true});
    camera.fov_axis = read_fov_axis(p);
    read_lens(p, camera);
  }
  read_clip(p, camera, 1e-4f);
  film.width = p.integer("width", 1280, 1, 1'000'000'000);
  film.height = p.integer("height", 720, 1, 1'000'000'000);
  check_frame(film.width, film.height, element.where);
  film.filter = {PixelFilter::Kind::kGaussian, 2.0f, 0.5f};
  if (const XmlElement* filter = p.object("rfilter"))
    read_or_omit(*filter, context, [&] { film.filter = read_nori_filter(*filter, context); });
  p.reject_unused();
}

void read_sampler(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  SamplerSettings& sampler = context.description.sampler;
  sampler.kind = read_sampler_kind(p, "independent");
  sampler.sample_count = static_cast<std::uint32_t>(p.integer("sampleCount", 1, 1, kMaxSampleCount));
  p.reject_unused();
}

void read_integrator(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  if (nori::read_exercise(p)) return p.reject_unused();
  // Find the integrator
  const IntegratorMatch found = integrator_or_path(p, nori::kExercises.names());
  IntegratorSettings& integrator = context.description.integrator;
  apply(found, integrator);
  // Read its properties
  if (integrator.traits().uses_lights()) {
    if (!found.entry->is_direct) {
      integrator.max_depth = p.integer("maxDepth", -1, -1, 1'000'000);
      if (p.has("rrDepth")) integrator.rr_depth = p.integer("rrDepth", 0, 1, 1'000'000);
    }
    integrator.hide_emitters = p.boolean("hideEmitters", false);
    read_light_sampling(p, integrator);
    read_medium_estimation(p, integrator);
    if (integrator.traits().has_photon_maps()) read_photon_mapping(p, integrator.photons);
    p.ignore({"inmedium"});  // whether the camera is in a medium; found from the surrounding shapes
  }
  if (found.is_substitute()) {
    p.ignore_all();
    report_substitution(element.where, p.type(), found, context.remarks);
  }
  p.reject_unused();
}

/// Reads a parallelogram with a corner at `origin` and sides `u` and `v`; its normal is along u x v.
void read_parallelogram(Properties& p, bool, ShapeDescription& shape) {
  const Vec3d origin = p.point("origin", {0, 0, 0});
  const Vec3f u = p.vec3("u", {1, 0, 0}), v = p.vec3("v", {0, 1, 0});
  const Vec3f n = cross(u, v);
  if (!(length_squared(n) > 0.0f)) p.fail("has no area: 'u' and 'v' are parallel", SceneErrorCode::kOutOfRange);
  const Vec3d columns[4] = {u * 0.5f, v * 0.5f, normalize(n), origin + Vec3d(u) * 0.5 + Vec3d(v) * 0.5};
  Matrix4 m;
  for (std::size_t j = 0; j < 4; ++j) {
    m.m[0][j] = columns[j].x;
    m.m[1][j] = columns[j].y;
    m.m[2][j] = columns[j].z;
  }
  shape.geometry = RectangleShape{};
  shape.to_world = Transform(m);
}

constexpr NameTable<GeometryReader> kShapes{{{"parallelogram", read_parallelogram}}};

/// Reads material and interior medium of a mesh. A medium without a material gets a null interface.
void read_inside(Properties& p, ShapeDescription& shape) {
  ReadContext& context = p.context();
  std::optional<SpectrumDescription> absorption;
  const XmlElement* bsdf = p.object("bsdf");
  const XmlElement* medium = p.object("medium");
  if (bsdf != nullptr) shape.material = nori::read_bsdf(*bsdf, context, absorption);
  if (absorption && medium != nullptr)
    p.report("has a <medium> and a bsdf with 'sigmaA', expected one of them", SceneErrorCode::kDuplicate,
             "'sigmaA' ignored");
  if (medium != nullptr)
    read_or_omit(*medium, context, [&] { shape.interior = nori::read_medium(*medium, context, true); });
  if (absorption && medium == nullptr) shape.interior = nori::add_absorption(*bsdf, *absorption, context);
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
  if (const std::string* id = element.find_attribute("id")) shape.id = *id;
  const GeometryReader* own = kShapes.find(p.type());
  const GeometryReader read = own != nullptr ? *own : p.plugin(kSharedShapes, kShapes);
  read(p, false, shape);
  shape.to_world = p.transform("toWorld") * shape.to_world;
  p.ignore({"name"});
  read_inside(p, shape);
  if (const XmlElement* emitter = p.object("emitter")) find_area_emitter(*emitter, context, shape);
  p.reject_unused();
  context.description.shapes.push_back(std::move(shape));
}

/// Elements that are read after all others.
struct LastElements {
  const XmlElement* camera = nullptr;
  const XmlElement* sampler = nullptr;
  const XmlElement* integrator = nullptr;
};

void keep(const XmlElement*& slot, const XmlElement& element) {
  if (slot != nullptr)
    throw SceneError(element.where, fmt::format("a second <{}>, expected one", element.name),
                     SceneErrorCode::kDuplicate);
  slot = &element;
}

void read_child(const XmlElement& child, ReadContext& context, LastElements& last) {
  if (child.name == "camera") {
    keep(last.camera, child);
  } else if (child.name == "sampler") {
    keep(last.sampler, child);
  } else if (child.name == "integrator") {
    keep(last.integrator, child);
  } else if (child.name == "mesh") {
    read_mesh(child, context);
  } else if (child.name == "medium") {
    if (context.description.camera.medium)
      throw SceneError(child.where, "a second <medium>, expected one", SceneErrorCode::kDuplicate);
    context.description.camera.medium = nori::read_medium(child, context, false);
  } else if (child.name == "emitter") {
    nori::read_emitter(child, context);
  } else if (child.name == "denoiser") {
    context.note(child.where, "<denoiser> ignored: use --denoise");
  } else {
    const std::vector<std::string> known = {"camera", "sampler", "integrator", "mesh", "emitter", "medium", "denoiser"};
    throw SceneError(child.where,
                     fmt::format("unknown element <{}> in a Nori scene{}", child.name, did_you_mean(child.name, known)),
                     SceneErrorCode::kUnknownName);
  }
}

}  // namespace

void read_nori(ReadContext& context) {
  context.readers.texture = nori::texture_of;
  const XmlElement& root = context.scene.root();
  LastElements last;
  for (const XmlElement& child : root.children) read_or_omit(child, context, [&] { read_child(child, context, last); });
  if (last.camera != nullptr) {
    read_or_omit(*last.camera, context, [&] { read_camera(*last.camera, context); });
  } else {
    substitute_camera(root, "<camera>", context);
  }
  if (last.integrator != nullptr) {
    read_or_omit(*last.integrator, context, [&] { read_integrator(*last.integrator, context); });
  } else {
    context.errors.report(SceneError(root.where, "the scene has no <integrator>", SceneErrorCode::kMissing),
                          "rendered with 'path'");
  }
  context.description.sampler.sample_count = 1;
  if (last.sampler != nullptr) read_or_omit(*last.sampler, context, [&] { read_sampler(*last.sampler, context); });
}

}  // namespace sheaf
