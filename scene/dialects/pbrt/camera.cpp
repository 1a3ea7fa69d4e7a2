// The pbrt dialect: camera, film, pixel filter.
#include "core/simd/saturate.h"
#include "scene/dialects/common/frame_limits.h"
#include "scene/dialects/pbrt/reader.h"
#include "scene/tables/filter.h"

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

/// pbrt's screen window: the visible part of the screen plane, where the shorter side of a square image spans [-1, 1].
struct ScreenWindow {
  double x0, x1, y0, y1;
  bool standard;  ///< not set by the file
};

ScreenWindow read_window(Parameters& p, const FilmSettings& film) {
  const double own = static_cast<double>(film.width) / film.height;
  const double aspect = double{p.number("frameaspectratio", static_cast<float>(own), kPositive)};
  const bool specified = p.has("screenwindow") || p.has("frameaspectratio");
  const std::vector<float> window = p.numbers("screenwindow", 4);
  if (!window.empty()) {
    if (window.size() != 4 || !(window[0] < window[1]) || !(window[2] < window[3]))
      p.fail_at("screenwindow", "is invalid, expected four numbers: left, right, bottom, top");
    return {double{window[0]}, double{window[1]}, double{window[2]}, double{window[3]}, false};
  }
  const double wide = std::max(specified ? aspect : own, 1.0), high = std::max(1 / (specified ? aspect : own), 1.0);
  return {-wide, wide, -high, high, !specified};
}

/// Sets the principal point. Returns the scale of camera space that non-square pixels need.
Transform frame_window(Parameters& p, const ScreenWindow& window, const FilmSettings& film, CameraDescription& camera) {
  const double width = window.x1 - window.x0, height = window.y1 - window.y0;
  camera.principal_point_x = static_cast<float>(0.5 + window.x0 / width);
  camera.principal_point_y = static_cast<float>(-0.5 - window.y0 / height);
  const double stretch = height / width * film.width / film.height;
  if (std::fabs(stretch - 1) < 1e-6) return {};
  if (camera.aperture_radius > 0.0f)
    p.unsupported("a lens together with pixels that are not square", "rendered with an elliptical lens");
  return Transform::scale({1, static_cast<float>(stretch), 1});
}

/// Camera to world space: pbrt's camera space has +x to the right, Sheaf's to the left.
Transform mirrored(const Transform& world_from_camera) { return world_from_camera * Transform::scale({-1, 1, 1}); }

void read_perspective(Parameters& p, CameraDescription& camera, const Transform& world_from_camera) {
  const Transform to_world = mirrored(world_from_camera);
  const FilmSettings& film = p.reader().description.film;
  const ScreenWindow window = read_window(p, film);
  camera.fov = p.number("fov", 90, {0, 180, true});
  camera.fov_axis = CameraDescription::FovAxis::kSmaller;
  const float radius = p.number("lensradius", 0, kNotNegative), distance = p.number("focaldistance", 1e6f, kPositive);
  if (radius > 0.0f) camera.aperture_radius = radius, camera.focus_distance = distance;
  camera.to_world = to_world;
  if (window.standard) return;
  const double half = std::tan(double{camera.fov} * 3.14159265358979323846 / 360) * (window.x1 - window.x0) / 2;
  camera.fov = static_cast<float>(std::atan(half) * 360 / 3.14159265358979323846);
  camera.fov_axis = CameraDescription::FovAxis::kX;
  camera.to_world = to_world * frame_window(p, window, film, camera);
}

void read_orthographic(Parameters& p, CameraDescription& camera, const Transform& world_from_camera) {
  const Transform to_world = mirrored(world_from_camera);
  const FilmSettings& film = p.reader().description.film;
  const ScreenWindow window = read_window(p, film);
  camera.projection = CameraDescription::Projection::kOrthographic;
  const float radius = p.number("lensradius", 0, kNotNegative), distance = p.number("focaldistance", 1e6f, kPositive);
  const auto half = static_cast<float>((window.x1 - window.x0) / 2);
  if (radius > 0.0f) camera.aperture_radius = radius / half, camera.focus_distance = distance;
  camera.to_world = to_world * Transform::scale({half, half, 1}) * frame_window(p, window, film, camera);
}

/// Reads a camera with a full spherical view, +y up.
void read_spherical(Parameters& p, CameraDescription& camera, const Transform& world_from_camera) {
  camera.projection = CameraDescription::Projection::kSpherical;
  static constexpr NameTable<bool> kMappings{{{"equalarea", true}, {"equirectangular", false}}};
  camera.equal_area = p.choice("mapping", kMappings, true);
  // The equal-area mapping exchanges y and z. The equirectangular mapping has -x in the image center, and -z a quarter
  // turn later.
  Matrix4 axes;
  if (camera.equal_area)
    axes.m[1] = {0, 0, 1, 0}, axes.m[2] = {0, 1, 0, 0};
  else
    axes.m[0] = {0, 0, -1, 0}, axes.m[2] = {1, 0, 0, 0};
  camera.to_world = world_from_camera * Transform(axes);
  p.ignore({"frameaspectratio", "screenwindow", "lensradius", "focaldistance"});
}

/// Reads a camera with a lens system as a perspective one.
void read_realistic(Parameters& p, CameraDescription& camera, const Transform& world_from_camera) {
  p.unsupported("cameras of this kind", "rendered as perspective");
  p.ignore({"lensfile", "aperturediameter", "focusdistance", "aperture"});
  read_perspective(p, camera, world_from_camera);
  camera.fov = 40;
}

constexpr NameTable<void (*)(Parameters&, CameraDescription&, const Transform& world_from_camera)> kCameras{
    {{"orthographic", read_orthographic},
     {"perspective", read_perspective},
     {"realistic", read_realistic},
     {"spherical", read_spherical}}};

PixelRect read_crop_window(Parameters& p, const FilmSettings& film, std::vector<float> c) {
  if (c.size() != 4) p.fail_at("cropwindow", "is invalid, expected four numbers: x0, x1, y0, y1");
  const auto pixel = [](float fraction, int size) {
    // Single precision, as in pbrt.
    const float edge = std::ceil(std::clamp(fraction, 0.0f, 1.0f) * static_cast<float>(size));
    return std::min(saturate<int>(static_cast<double>(edge)), size);
  };
  return {pixel(std::min(c[0], c[1]), film.width), pixel(std::min(c[2], c[3]), film.height),
          pixel(std::max(c[0], c[1]), film.width), pixel(std::max(c[2], c[3]), film.height)};
}

void read_crop(Parameters& p, FilmSettings& film) {
  const std::vector<float> bounds = p.numbers("pixelbounds", 4), window = p.numbers("cropwindow", 4);
  if (bounds.empty() && window.empty()) return;
  PixelRect crop{0, 0, film.width, film.height};
  if (!window.empty()) {
    crop = read_crop_window(p, film, window);
  } else {
    const auto bounded = [](float v, int size) { return std::clamp(saturate<int>(static_cast<double>(v)), 0, size); };
    crop = {bounded(bounds[0], film.width), bounded(bounds[2], film.height), bounded(bounds[1], film.width),
            bounded(bounds[3], film.height)};
  }
  if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1)
    p.fail_at(window.empty() ? "pixelbounds" : "cropwindow", "is empty, expected at least one pixel of the film");
  film.crop = crop;
}

using Kind = PixelFilter::Kind;

PixelFilter read_gaussian(Parameters& p, float) {
  const float sigma = p.number("sigma", 0.5f, kPositive);
  return {Kind::kGaussian, 4 * sigma, sigma};
}

PixelFilter read_mitchell(Parameters& p, float radius) {
  if (radius != 2.0f) p.unsupported("a radius other than 2", "rendered with 2");
  return {Kind::kMitchell, 2, 0.5f, p.number("B", 1.0f / 3), p.number("C", 1.0f / 3)};
}

PixelFilter read_sinc(Parameters& p, float) {
  PixelFilter filter = p.reader().description.film.filter;
  filter.kind = Kind::kLanczos;
  filter.lobes = std::clamp(std::round(p.number("tau", 3, kPositive)), 1.0f, 64.0f);
  filter.radius = filter.lobes;
  return filter;
}

/// Reads a pixel filter of the given radius; `radius` is the default one.
struct FilterReader {
  PixelFilter (*read)(Parameters& p, float radius);
  float radius;
};
constexpr NameTable<FilterReader> kFilters{{{"box",
                                             {[](Parameters&, float radius) {
                                                return PixelFilter{Kind::kBox, radius};
                                              },
                                              0.5f}},
                                            {"gaussian", {read_gaussian, 1.5f}},
                                            {"mitchell", {read_mitchell, 2}},
                                            {"sinc", {read_sinc, 4}},
                                            {"triangle",
                                             {[](Parameters&, float radius) {
                                                return PixelFilter{Kind::kTent, radius};
                                              },
                                              2}}}};

}  // namespace

ShutterDescription read_shutter(Reader& reader, const DirectiveArguments& camera) {
  ShutterDescription shutter{0, 1};
  for (const Parameter& parameter : camera.parameters)
    if (parameter.numbers.size() == 1 && (parameter.name == "shutteropen" || parameter.name == "shutterclose"))
      (parameter.name == "shutteropen" ? shutter.open : shutter.close) = parameter.numbers[0];
  if (shutter.close < shutter.open) {
    reader.warn(camera.where, fmt::format("Camera: 'shutteropen' {} is later than 'shutterclose' {}: exchanged",
                                          number_text(shutter.open), number_text(shutter.close)));
    std::swap(shutter.open, shutter.close);
  } else if (shutter.close == shutter.open) {
    reader.note(
        camera.where,
        fmt::format("Camera: the shutter opens and closes at {}: a still without motion blur, with the exposure of 1 s",
                    number_text(shutter.open)));
  }
  return shutter;
}

double exposure_time(const ShutterDescription& shutter) {
  return shutter.close > shutter.open ? shutter.close - shutter.open : 1;
}

void read_film(Reader& reader, DirectiveArguments entity, float shutter) {
  Parameters p(reader, fmt::format("Film '{}'", entity.type), entity.where, std::move(entity.parameters));
  const std::vector<std::string> known = {"gbuffer", "rgb", "spectral"};
  if (std::find(known.begin(), known.end(), entity.type) == known.end())
    throw SceneError(
        entity.where,
        fmt::format("unknown film '{}'{}{}", entity.type, did_you_mean(entity.type, known), known_names(known)),
        SceneErrorCode::kUnknownName);
  FilmSettings& film = reader.description.film;
  film.width = p.integer("xresolution", 1280, 1, 1'000'000'000);
  film.height = p.integer("yresolution", 720, 1, 1'000'000'000);
  check_frame(film.width, film.height, entity.where);
  read_crop(p, film);
  const std::string sensor = p.string("sensor", "cie1931");
  if (sensor != "cie1931")
    p.unsupported(fmt::format("the sensor '{}', expected cie1931", sensor), "rendered as cie1931");
  if (p.number("whitebalance", 0, kNotNegative) != 0.0f) p.unsupported("'whitebalance'", "ignored");
  if (p.has("maxcomponentvalue")) {
    reader.note(entity.where, p.title() + ": 'maxcomponentvalue' ignored: samples are not clamped");
    p.ignore({"maxcomponentvalue"});
  }
  reader.exposure = shutter * p.number("iso", 100, kPositive) / 100;
  p.ignore({"filename", "savefp16", "diagonal", "coordinatesystem", "lambdamin", "lambdamax", "nbuckets"});
  p.reject_unused();
}

void read_filter(Reader& reader, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("PixelFilter '{}'", entity.type), entity.where, std::move(entity.parameters));
  const FilterReader& filter_reader = plugin(kFilters, "filter", entity.type, entity.where);
  const float radius = p.number("xradius", filter_reader.radius, kPositive);
  if (p.number("yradius", filter_reader.radius, kPositive) != radius)
    p.unsupported("a filter of different 'xradius' and 'yradius'", "rendered with 'xradius' for both");
  reader.description.film.sample_border = true;
  PixelFilter& filter = reader.description.film.filter;
  filter = filter_reader.read(p, radius);
  p.reject_unused();
  check_filter_radius(static_cast<double>(filter.radius), entity.where);
}

void read_camera(Reader& reader, DirectiveArguments entity, const TransformPair& world_from_camera,
                 const std::string& outside) {
  Parameters p(reader, fmt::format("Camera '{}'", entity.type), entity.where, std::move(entity.parameters));
  CameraDescription& camera = reader.description.camera;
  camera.where = entity.where;
  camera.medium = medium_of(reader, outside, entity.where);
  p.ignore({"shutteropen", "shutterclose"});
  plugin(kCameras, "camera", entity.type, entity.where)(p, camera, world_from_camera.start);
  p.reject_unused();
  if (!world_from_camera.moves()) return;
  const Placement placement =
      reader.placement(world_from_camera, entity.where) * (world_from_camera.start.inverse() * camera.to_world);
  camera.to_world = placement.to_world;
  camera.motion = add_motion(reader.description.motions, placement);
}

}  // namespace sheaf::pbrt
