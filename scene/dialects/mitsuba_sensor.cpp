// The Mitsuba dialect: sensor, film, pixel filter, sampler.
#include "scene/dialects/mitsuba.h"
#include "scene/dialects/read_camera.h"

#include "scene/xml/xml_values.h"

#include <cmath>
#include <numbers>

namespace sheaf::mitsuba {

namespace {

constexpr float kFilmDiagonal = 43.266615f;  // 36 mm x 24 mm

FilterDescription read_filter(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  using Kind = FilterDescription::Kind;
  FilterDescription filter;
  if (p.type() == "box") {
    filter = {Kind::kBox, p.number("radius", 0.5f, kPositive)};
  } else if (p.type() == "tent") {
    filter = {Kind::kTent, p.number("radius", 1, kPositive)};
  } else if (p.type() == "gaussian") {
    const float stddev = p.number("stddev", 0.5f, kPositive);
    filter = {Kind::kGaussian, 4 * stddev, stddev};
  } else if (p.type() == "mitchell") {
    filter.kind = Kind::kMitchell;
    filter.radius = 2;
    filter.b = p.number("B", 1.0f / 3);
    filter.c = p.number("C", 1.0f / 3);
  } else if (p.type() == "catmullrom") {
    filter.kind = Kind::kCatmullRom;
    filter.radius = 2;
  } else if (p.type() == "lanczos") {
    filter.kind = Kind::kLanczos;
    filter.lobes = static_cast<float>(p.integer("lobes", 3, 1, 64));
    filter.radius = filter.lobes;
  } else {
    p.fail_plugin({"box", "catmullrom", "gaussian", "lanczos", "mitchell", "tent"});
  }
  p.finish();
  return filter;
}

void read_crop(Properties& p, FilmDescription& film) {
  constexpr int kLargest = 1'000'000'000;
  const bool cropped = p.has("crop_offset_x") || p.has("crop_offset_y") || p.has("crop_width") || p.has("crop_height");
  const int x0 = p.integer("crop_offset_x", 0, 0, kLargest), y0 = p.integer("crop_offset_y", 0, 0, kLargest);
  const int width = p.integer("crop_width", film.width - x0, 1, kLargest);
  const int height = p.integer("crop_height", film.height - y0, 1, kLargest);
  if (!cropped) return;
  if (width < 1 || height < 1 || x0 > film.width - width || y0 > film.height - height)
    p.fail("crop window (offset " + std::to_string(x0) + ", " + std::to_string(y0) + ", size " + std::to_string(width) +
           " x " + std::to_string(height) + ") reaches beyond the film of " + std::to_string(film.width) + " x " +
           std::to_string(film.height) + " pixels");
  film.crop = PixelRect{x0, y0, x0 + width, y0 + height};
}

/// The size of the frame; Nori's scenes give it to the camera.
void read_frame(Properties& p, FilmDescription& film) {
  film.width = p.integer("width", film.width, 1, 1'000'000'000);
  film.height = p.integer("height", film.height, 1, 1'000'000'000);
  check_frame(film.width, film.height, p.where());
}

void read_film(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  if (p.type() != "hdrfilm" && p.type() != "ldrfilm" && p.type() != "mfilm")
    p.fail_plugin({"hdrfilm", "ldrfilm", "mfilm"});
  FilmDescription& film = context.description.film;
  read_frame(p, film);
  read_crop(p, film);
  if (const XmlElement* filter = p.object("rfilter"))
    read_or_as(*filter, context, "gaussian", [&] { film.filter = read_filter(*filter, context); });
  p.accept({"file_format", "pixel_format", "component_format", "banner", "sample_border", "high_quality_edges",
            "compensate", "gamma", "exposure", "key", "burn", "tonemap_method", "attach_log", "digits", "variable",
            "fprec"});
  p.finish();
}

void read_sampler(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  SamplerDescription& sampler = context.description.sampler;
  sampler.kind = read_sampler_kind(p);
  sampler.sample_count = static_cast<std::uint32_t>(p.integer("sample_count", 4, 1, kMaxSampleCount));
  sampler.seed = static_cast<std::uint32_t>(p.integer("seed", 0, 0, std::numeric_limits<int>::max()));
  if (sampler.kind != SamplerKind::kIndependent) p.accept({"dimension", "scramble", "jitter", "strength"});
  p.finish();
}

/// Millimetres out of "50mm" or "50".
float parse_focal_length(Properties& p, std::string text) {
  if (text.ends_with("mm")) text.resize(text.size() - 2);
  const float length = parse_float(text, p.where(), "property 'focal_length'");
  if (!(length > 0)) p.fail_at("focal_length", "is " + in_quotes(text) + ", expected a positive length");
  return length;
}

void read_camera(Properties& p, CameraDescription& camera) {
  camera.to_world = p.transform("to_world");
  read_clip(p, camera, 0.01f);
  p.accept({"shutter_open", "shutter_close"});
  if (p.type() == "orthographic") {
    camera.projection = CameraDescription::Projection::kOrthographic;
    p.accept({"focus_distance"});
    return;
  }
  read_fov(p, camera);
  if (p.type() == "thinlens") {
    const std::optional<float> radius = p.find_number("aperture_radius", kNotNegative);
    if (!radius) p.fail("has no 'aperture_radius'");
    camera.aperture_radius = *radius;
    camera.focus_distance = p.number("focus_distance", camera.far_clip, kPositive);
    return;
  }
  camera.principal_point_x = p.number("principal_point_offset_x", 0);
  camera.principal_point_y = p.number("principal_point_offset_y", 0);
  p.accept({"focus_distance", "aperture_radius"});
}

}  // namespace

void read_fov(Properties& p, CameraDescription& camera) {
  camera.fov_axis = read_fov_axis(p);
  const std::optional<float> fov = p.find_number("fov", {0, 180, true});
  std::optional<float> focal_length;
  if (p.is_string("focal_length")) {
    focal_length = parse_focal_length(p, *p.find_string("focal_length"));
  } else {
    focal_length = p.find_number("focal_length", kPositive);
  }
  if (fov && focal_length) p.fail("has both 'fov' and 'focal_length', expected one");
  if (fov) {
    camera.fov = *fov;
    return;
  }
  camera.fov = 2 * std::atan(kFilmDiagonal / 2 / focal_length.value_or(50)) * 180 / std::numbers::pi_v<float>;
  camera.fov_axis = CameraDescription::FovAxis::kDiagonal;
}

void read_sensor(const XmlElement& element, Reader& reader) {
  Properties p(element, reader.context);
  if (p.type() != "perspective" && p.type() != "thinlens" && p.type() != "orthographic")
    p.fail_plugin({"orthographic", "perspective", "thinlens"});
  CameraDescription& camera = reader.context.description.camera;
  camera.where = element.where;
  read_camera(p, camera);
  read_frame(p, reader.context.description.film);
  reader.context.description.film.filter = {FilterDescription::Kind::kGaussian, 2.0f, 0.5f};
  if (const XmlElement* film = p.object("film"))
    read_or_as(*film, reader.context, "hdrfilm", [&] { read_film(*film, reader.context); });
  if (const XmlElement* sampler = p.object("sampler"))
    read_or_as(*sampler, reader.context, "sobol", [&] { read_sampler(*sampler, reader.context); });
  if (const XmlElement* medium = p.object("medium")) camera.medium = medium_of(*medium, reader);
  p.finish();
}

}  // namespace sheaf::mitsuba
