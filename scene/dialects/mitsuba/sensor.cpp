// The Mitsuba dialect: sensor, film, pixel filter, sampler.
#include "scene/dialects/common/frame_limits.h"
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_camera.h"
#include "scene/tables/filter.h"

#include "scene/xml/xml_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace sheaf::mitsuba {

namespace {

constexpr float kFilmDiagonal = 43.266615f;  // diagonal of 36 mm x 24 mm, in mm

PixelFilter read_gaussian(Properties& p) {
  const float stddev = p.number("stddev", 0.5f, kPositive);
  return {PixelFilter::Kind::kGaussian, 4 * stddev, stddev};
}

PixelFilter read_mitchell(Properties& p) {
  PixelFilter filter{PixelFilter::Kind::kMitchell, 2};
  filter.b = p.number("B", 1.0f / 3);
  filter.c = p.number("C", 1.0f / 3);
  return filter;
}

PixelFilter read_lanczos(Properties& p) {
  PixelFilter filter{PixelFilter::Kind::kLanczos};
  filter.lobes = static_cast<float>(p.integer("lobes", 3, 1, 64));
  filter.radius = filter.lobes;
  return filter;
}

constexpr NameTable<PixelFilter (*)(Properties&)> kFilters{
    {{"box",
      [](Properties& p) {
        return PixelFilter{PixelFilter::Kind::kBox, p.number("radius", 0.5f, kPositive)};
      }},
     {"catmullrom",
      [](Properties&) {
        return PixelFilter{PixelFilter::Kind::kCatmullRom, 2};
      }},
     {"gaussian", read_gaussian},
     {"lanczos", read_lanczos},
     {"mitchell", read_mitchell},
     {"tent", [](Properties& p) {
        return PixelFilter{PixelFilter::Kind::kTent, p.number("radius", 1, kPositive)};
      }}}};

PixelFilter read_filter(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  const PixelFilter filter = p.plugin_or("gaussian", kFilters)(p);
  p.reject_unused();
  check_filter_radius(static_cast<double>(filter.radius), p.where());
  return filter;
}

void read_crop(Properties& p, FilmSettings& film) {
  constexpr int kLargest = 1'000'000'000;
  const bool cropped = p.has("crop_offset_x") || p.has("crop_offset_y") || p.has("crop_width") || p.has("crop_height");
  const int x0 = p.integer("crop_offset_x", 0, 0, kLargest), y0 = p.integer("crop_offset_y", 0, 0, kLargest);
  const int width = p.integer("crop_width", film.width - x0, 1, kLargest);
  const int height = p.integer("crop_height", film.height - y0, 1, kLargest);
  if (!cropped) return;
  if (width < 1 || height < 1 || x0 > film.width - width || y0 > film.height - height)
    return p.report(fmt::format("crop window (offset {}, {}, size {} x {}) reaches beyond the film of {} x {} pixels",
                                x0, y0, width, height, film.width, film.height),
                    SceneErrorCode::kOutOfRange, "ignored");
  film.crop = PixelRect{x0, y0, x0 + width, y0 + height};
}

/// Reads the frame size in pixels. Nori scenes specify it in the camera.
void read_frame(Properties& p, FilmSettings& film) {
  film.width = p.integer("width", film.width, 1, 1'000'000'000);
  film.height = p.integer("height", film.height, 1, 1'000'000'000);
  check_frame(film.width, film.height, p.where());
}

/// Reads the bands of a film that is rendered as an `hdrfilm`.
void read_bands(Properties& p) {
  p.context().note(p.where(), "film 'specfilm' rendered as 'hdrfilm': for spectral bands use --spectral-bins");
  for (const XmlElement& child : p.element().children)
    if (child.name == "spectrum") p.ignore({std::string(child.attribute("name")).c_str()});
}

/// Films, with the function that reads what only they have.
constexpr NameTable<void (*)(Properties&)> kFilms{{{"hdrfilm", [](Properties&) {}},
                                                   {"ldrfilm", [](Properties&) {}},
                                                   {"mfilm", [](Properties&) {}},
                                                   {"specfilm", read_bands},
                                                   {"tiledhdrfilm", [](Properties&) {}}}};

void read_film(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  p.plugin_or("hdrfilm", kFilms)(p);
  FilmSettings& film = context.description.film;
  read_frame(p, film);
  read_crop(p, film);
  film.sample_border = p.boolean("sample_border", false);
  if (const XmlElement* filter = p.object("rfilter"))
    read_or_omit(*filter, context, [&] { film.filter = read_filter(*filter, context); });
  if (p.ignore_prefixed("label[")) context.note(p.where(), "film labels ignored");
  if (p.ignore_prefixed("metadata[")) context.note(p.where(), "film metadata ignored");
  if (p.find_string("channel_names")) context.note(p.where(), "'channelNames' ignored: choose layers with --aov");
  p.ignore({"file_format", "pixel_format", "component_format", "banner", "high_quality_edges", "compensate", "gamma",
            "exposure", "key", "burn", "tonemap_method", "attach_log", "digits", "variable", "fprec"});
  p.reject_unused();
}

void read_sampler(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  SamplerSettings& sampler = context.description.sampler;
  sampler.kind = read_sampler_kind(p, "sobol");
  sampler.sample_count = static_cast<std::uint32_t>(p.integer("sample_count", 4, 1, kMaxSampleCount));
  sampler.seed = static_cast<std::uint32_t>(p.integer("seed", 0, 0, std::numeric_limits<int>::max()));
  if (sampler.kind != SamplerKind::kIndependent) p.ignore({"dimension", "scramble", "jitter", "strength"});
  p.reject_unused();
}

/// Parses a length in millimeters, "50mm" or "50".
float parse_focal_length(Properties& p, std::string text) {
  if (text.ends_with("mm")) text.resize(text.size() - 2);
  const float length = parse_float(text, p.where(), "property 'focal_length'");
  if (!(length > 0))
    p.fail_at("focal_length", fmt::format("is {}, expected a positive length", in_quotes(text)),
              SceneErrorCode::kOutOfRange);
  return length;
}

/// Reads the distortion coefficients `kc`: a string of two numbers.
std::array<float, 2> read_distortion(Properties& p) {
  const auto read = [&] {
    const std::vector<float> kc = parse_floats(p.string("kc", "0, 0"), p.where(), "kc");
    if (kc.size() != 2) p.fail_at("kc", fmt::format("has {} numbers, expected two", kc.size()));
    return std::array{kc[0], kc[1]};
  };
  return p.attempt("kc", read).value_or(std::array{0.0f, 0.0f});
}

constexpr float kNearClip = 0.01f;

/// Reads an orthographic camera, or a `telecentric` one with a thin lens. Lens lengths are in world space.
void read_orthographic(Properties& p, CameraDescription& camera) {
  read_clip(p, camera, kNearClip);
  camera.projection = CameraDescription::Projection::kOrthographic;
  const float focus = p.number("focus_distance", camera.far_clip, kPositive);
  if (p.type() == "orthographic") return;
  const float radius = p.number("aperture_radius", 0, kNotNegative);
  camera.aperture_radius = radius / length(camera.to_world.vector({1, 0, 0}));
  camera.focus_distance = focus / length(camera.to_world.vector({0, 0, 1}));
}

/// Returns a transform that maps the origin to `origin` and +z to `direction`.
Transform aim(Vec3d origin, Vec3f direction) {
  const Vec3f up = std::fabs(direction.y) < 0.9f * length(direction) ? Vec3f{0, 1, 0} : Vec3f{1, 0, 0};
  return Transform::look_at(origin, origin + Vec3d(normalize(direction)), up);
}

/// Reads the direction of a sensor: +z if it is invalid.
Vec3f read_sensor_direction(Properties& p) {
  const Vec3f direction = p.vec3("direction", {0, 0, 1});
  const float length = sheaf::length(direction);
  if (length > 0.0f && std::isfinite(length)) return direction;
  p.report_at("direction", "has no length", SceneErrorCode::kOutOfRange);
  return {0, 0, 1};
}

void read_radiance_meter(Properties& p, CameraDescription& camera) {
  camera.projection = CameraDescription::Projection::kRadianceMeter;
  camera.near_clip = 0;
  const bool origin = p.has("origin"), direction = p.has("direction");
  if (p.has("to_world")) return p.ignore({"origin", "direction"});
  if (origin != direction)
    p.report_at(origin ? "origin" : "direction", "is set without the other, expected both 'origin' and 'direction'",
                SceneErrorCode::kMissing);
  if (origin && direction) camera.to_world = aim(p.point("origin", {0, 0, 0}), read_sensor_direction(p));
}

/// Reads the target shape of a distant sensor.
CameraDescription::TargetArea read_target(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  if (p.type() != "rectangle" && p.type() != "disk")
    p.fail("is the target of a sensor, expected 'rectangle' or 'disk'");
  CameraDescription::TargetArea target{p.transform("to_world"), p.type() == "disk"};
  p.ignore({"flip_normals"});
  p.objects("bsdf");
  p.reject_unused();
  return target;
}

void read_distant(Properties& p, CameraDescription& camera) {
  camera.projection = CameraDescription::Projection::kDistant;
  camera.near_clip = 0;
  const bool placed = p.has("to_world");
  if (p.has("direction")) {
    if (placed)
      p.report_conflict("direction", "'to_world'");
    else
      camera.to_world = aim({0, 0, 0}, read_sensor_direction(p));
  }
  if (const XmlElement* shape = p.object("shape")) {
    read_or_omit(*shape, p.context(), [&] { camera.target = read_target(*shape, p.context()); });
  } else if (const auto point = p.find_point("target")) {
    camera.target = *point;
  }
}

void read_spherical(Properties&, CameraDescription& camera) {
  camera.projection = CameraDescription::Projection::kSpherical;
}

void read_thin_lens(Properties& p, CameraDescription& camera) {
  read_clip(p, camera, kNearClip);
  read_fov(p, camera);
  const std::optional<float> radius = p.find_number("aperture_radius", kNotNegative);
  if (!radius) p.report("has no 'aperture_radius'", SceneErrorCode::kMissing, "rendered as 'perspective'");
  camera.aperture_radius = radius.value_or(0);
  camera.focus_distance = p.number("focus_distance", camera.far_clip, kPositive);
}

void read_perspective(Properties& p, CameraDescription& camera) {
  read_clip(p, camera, kNearClip);
  read_fov(p, camera);
  if (p.type() == "perspective_rdist") camera.distortion = read_distortion(p);
  camera.principal_point_x = p.number("principal_point_offset_x", 0);
  camera.principal_point_y = p.number("principal_point_offset_y", 0);
  p.ignore({"focus_distance", "aperture_radius"});
}

using CameraReader = void (*)(Properties&, CameraDescription&);
constexpr NameTable<CameraReader> kCameras{{{"distant", read_distant},
                                            {"orthographic", read_orthographic},
                                            {"perspective", read_perspective},
                                            {"perspective_rdist", read_perspective},
                                            {"radiancemeter", read_radiance_meter},
                                            {"spherical", read_spherical},
                                            {"telecentric", read_orthographic},
                                            {"thinlens", read_thin_lens}}};

void read_camera(Properties& p, CameraReader read, CameraDescription& camera) {
  const Placement placement = p.placement("to_world");
  camera.to_world = placement.to_world;
  camera.motion = add_motion(p.context().description.motions, placement);
  read(p, camera);
}

/// Replaces the pixel filter of sensors that do not form an image by a box filter, and checks their film size.
void check_meter(Properties& p, const CameraDescription& camera) {
  using Projection = CameraDescription::Projection;
  FilmSettings& film = p.context().description.film;
  const bool single = camera.projection == Projection::kRadianceMeter || camera.projection == Projection::kDistant;
  if (!single && camera.projection != Projection::kIrradianceMeter) return;
  if (single && (film.width != 1 || film.height != 1))
    p.fail(fmt::format("has a film of {} x {} pixels, expected one pixel", film.width, film.height));
  film.filter = PixelFilter{};
}

/// Reads film, sampler and medium of a sensor after its camera.
void read_sensor_rest(Properties& p, Reader& reader, CameraDescription& camera) {
  reader.context.description.film.filter = {PixelFilter::Kind::kGaussian, 2.0f, 0.5f};
  read_frame(p, reader.context.description.film);
  if (const XmlElement* film = p.object("film"))
    read_or_omit(*film, reader.context, [&] { read_film(*film, reader.context); });
  if (const XmlElement* sampler = p.object("sampler"))
    read_or_omit(*sampler, reader.context, [&] { read_sampler(*sampler, reader.context); });
  if (const XmlElement* medium = p.object("medium"))
    read_or_omit(*medium, reader.context, [&] { camera.medium = medium_of(*medium, reader); });
  check_meter(p, camera);
}

/// Reads the cameras of a batch, which render side by side. Ignores their own films and samplers.
void read_batch(Properties& p, Reader& reader) {
  Description& description = reader.context.description;
  std::vector<CameraDescription> cameras;
  std::vector<ShutterDescription> shutters;
  for (const XmlElement* element : p.objects("sensor")) {
    Properties child(*element, reader.context);
    const CameraReader* read = kCameras.find(child.type());
    if (read == nullptr || *read == read_radiance_meter || *read == read_distant)
      child.fail("is part of a batch, expected a camera that forms an image");
    cameras.emplace_back().where = element->where;
    read_camera(child, *read, cameras.back());
    shutters.push_back(read_shutter(child));
    child.objects("film"), child.objects("sampler");
    child.reject_unused();
  }
  if (cameras.empty()) p.fail("has no <sensor>, expected at least one");
  // All cameras share one shutter: that of the batch, or of the first camera
  const bool has_shutter = p.has("shutter_open") || p.has("shutter_close");
  const ShutterDescription own = read_shutter(p);
  description.shutter = has_shutter ? own : shutters.front();
  const auto differs = [&](const ShutterDescription& other) {
    const ShutterDescription& first = shutters.front();
    return std::tie(other.open, other.close, other.ramp) != std::tie(first.open, first.close, first.ramp);
  };
  if (!has_shutter && std::any_of(shutters.begin(), shutters.end(), differs))
    p.context().note(p.where(), "the sensors of a batch have different shutters: rendered with that of the first");
  description.camera = cameras.front();
  description.more_cameras.assign(cameras.begin() + 1, cameras.end());
}

/// Sensors that are not one camera.
constexpr NameTable<void (*)(Properties&, Reader&)> kOtherSensors{
    {{"batch", read_batch},
     {"irradiancemeter", [](Properties& p, Reader&) { p.fail("must be nested in a <shape>"); }}}};

/// Sensors nested in shapes.
constexpr NameTable<CameraDescription::Projection> kShapeSensors{
    {{"irradiancemeter", CameraDescription::Projection::kIrradianceMeter}}};

}  // namespace

void read_fov(Properties& p, CameraDescription& camera) {
  camera.fov_axis = read_fov_axis(p);
  const std::optional<float> fov = p.find_number("fov", {0, 180, true});
  std::optional<float> focal_length;
  if (p.is_string("focal_length")) {
    const std::string text = p.string("focal_length", "50mm");
    focal_length = p.attempt("focal_length", [&] { return parse_focal_length(p, text); });
  } else {
    focal_length = p.find_number("focal_length", kPositive);
  }
  if (fov && focal_length)
    p.report("has both 'fov' and 'focal_length', expected one", SceneErrorCode::kDuplicate, "'focal_length' ignored");
  if (fov) {
    camera.fov = *fov;
    return;
  }
  camera.fov = 2 * std::atan(kFilmDiagonal / 2 / focal_length.value_or(50)) * 180 / std::numbers::pi_v<float>;
  camera.fov_axis = CameraDescription::FovAxis::kDiagonal;
}

void read_sensor(const XmlElement& element, Reader& reader) {
  Properties p(element, reader.context);
  CameraDescription& camera = reader.context.description.camera;
  if (const auto* read = kOtherSensors.find(p.type())) {
    (*read)(p, reader);
  } else {
    read_camera(p, p.plugin_or("perspective", kCameras, kOtherSensors), camera);
    reader.context.description.shutter = read_shutter(p);
  }
  camera.where = element.where;
  read_sensor_rest(p, reader, camera);
  p.reject_unused();
}

void read_shape_sensor(const ShapeSensor& sensor, Reader& reader) {
  Properties p(*sensor.element, reader.context);
  if (sensor.shape_type != "rectangle")
    p.fail(fmt::format("is in a {}, expected a 'rectangle'", in_quotes(sensor.shape_type)));
  CameraDescription& camera = reader.context.description.camera;
  camera.where = sensor.element->where;
  camera.projection = p.plugin_or("irradiancemeter", kShapeSensors);
  camera.to_world = sensor.placement.to_world;
  camera.motion = add_motion(reader.context.description.motions, sensor.placement);
  reader.context.description.shutter = read_shutter(p);
  read_sensor_rest(p, reader, camera);
  p.reject_unused();
}

}  // namespace sheaf::mitsuba
