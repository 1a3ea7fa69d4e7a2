// The pbrt dialect: lights. Light spectra are scaled to unit luminance, so a light of L = 1 has the film value 1. The
// film's exposure is multiplied into the lights.
#include "core/sampling/octahedral.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

SpectrumDescription read_emission(Parameters& p, const char* name) {
  return find_spectrum(p, name, Use::kLight).value_or(SpectrumDescription::constant(1));
}

/// Returns `scale` times the exposure.
float read_scale(Parameters& p) { return p.number("scale", 1, kNotNegative) * p.reader().exposure; }

/// Returns a coordinate system with its origin at `from` and +z towards `to`.
Transform along_axis(Parameters& p) {
  const Vec3d from = p.point("from", {0, 0, 0}), to = p.point("to", {0, 0, 1});
  if (from == to) p.fail("has equal 'from' and 'to', expected a direction");
  const Vec3d axis = to - from;
  const bool upright = std::fabs(axis.y) > std::fabs(axis.x) + std::fabs(axis.z);
  return p.reader().attributes.transform.start *
         Transform::look_at(from, to, upright ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0});
}

LightKinds::Model read_point(Parameters& p) {
  const SpectrumDescription intensity = read_emission(p, "I");
  float scale = read_scale(p);
  if (const auto power = p.find_number("power"); power && *power > 0.0f) scale *= *power / (4 * kPi);
  return PointLightDescription{p.reader().attributes.transform.start.precise_point(p.point("from", {0, 0, 0})),
                               scaled(intensity, scale)};
}

LightKinds::Model read_spot(Parameters& p) {
  SpotLightDescription light;
  light.falloff = SpotLightDescription::Falloff::kSmooth;
  light.cutoff_angle = p.number("coneangle", 30, {0, 180, true});
  light.beam_width = light.cutoff_angle - p.number("conedeltaangle", 5, {0, double{light.cutoff_angle}, false});
  light.to_world = along_axis(p);
  const SpectrumDescription intensity = read_emission(p, "I");
  float scale = read_scale(p);
  if (const auto power = p.find_number("power"); power && *power > 0.0f) {
    const float start = std::cos(light.beam_width * kPi / 180), end = std::cos(light.cutoff_angle * kPi / 180);
    scale *= *power / (2 * kPi * ((1 - start) + (start - end) / 2));
  }
  light.intensity = scaled(intensity, scale);
  return light;
}

LightKinds::Model read_distant(Parameters& p) {
  const Transform axis = along_axis(p);
  float scale = read_scale(p);
  if (const auto illuminance = p.find_number("illuminance"); illuminance && *illuminance > 0.0f) scale *= *illuminance;
  return DirectionalLightDescription{axis.vector({0, 0, 1}), scaled(read_emission(p, "L"), scale)};
}

LightKinds::Model read_infinite(Parameters& p) {
  if (!p.numbers("portal", 3).empty())
    p.reader().note(p.where(), p.title() + ": 'portal' ignored: it affects sampling only");
  float scale = read_scale(p);
  const auto illuminance = p.find_number("illuminance");
  const bool lit = illuminance && *illuminance > 0.0f;
  if (!p.has("filename")) {
    if (lit) scale *= *illuminance / kPi;
    return ConstantLightDescription{scaled(read_emission(p, "L"), scale)};
  }
  if (p.has("L")) p.fail("has both 'L' and 'filename', expected one");
  EnvmapDescription light;
  light.file = p.file("filename");
  light.scale = scale;
  if (lit) {
    // Irradiance on a plane that faces +z in light space.
    const double mean = mean_luminance(
        read_linear_image(light.file, false, p.where()),
        [](const double*, double x, double y) {
          return std::max(0.0, double{equal_area_direction<Scalar>(static_cast<float>(x), static_cast<float>(y)).z});
        },
        nullptr);
    if (!(mean > 0))
      p.fail_at("illuminance", "is set for an image that is black towards +z, expected a brighter image");
    light.scale *= *illuminance / (4 * kPi * static_cast<float>(mean));
  }
  light.to_world = p.reader().attributes.transform.start;
  light.layout = EnvmapDescription::Layout::kOctahedral;
  light.mis_compensation = true;
  return light;
}

/// Adds an image texture without interpolation, as pbrt's image lights use it. `upright`: the first row is at v = 1.
TextureId add_light_bitmap(Parameters& p, const std::filesystem::path& file, bool upright) {
  BitmapDescription bitmap;
  bitmap.file = file;
  bitmap.filter = TextureFilter::kNearest;
  bitmap.wrap_u = bitmap.wrap_v = TextureWrap::kClamp;
  TextureDescription texture;
  texture.model = std::move(bitmap);
  texture.where = p.where();
  if (!upright) texture.to_uv = {1, 0, 0, 0, -1, 1};
  return append(p.reader(), std::move(texture));
}

/// Cubed cosine of the direction through an image position; about[0] and about[1] are half width and half height.
double cosine_cubed(const double* about, double x, double y) {
  const double across = (2 * x - 1) * about[0], up = (2 * y - 1) * about[1];
  return std::pow(1 + across * across + up * up, -1.5);
}

LightKinds::Model read_projection(Parameters& p) {
  ProjectorDescription light;
  light.constant_intensity = true;
  light.fov = p.number("fov", 90, {0, 180, true});
  light.fov_axis = CameraDescription::FovAxis::kSmaller;
  light.scale = read_scale(p);
  // The first image column is at -x in pbrt and at +x here.
  light.to_world = p.reader().attributes.transform.start * Transform::scale({-1, 1, 1});
  const std::filesystem::path file = p.file("filename");
  light.irradiance = add_light_bitmap(p, file, false);
  const auto power = p.find_number("power");
  if (!power || !(*power > 0.0f)) return light;
  const Image image = read_linear_image(file, false, p.where());
  const double half = std::tan(double{light.fov} * double{kPi} / 360), aspect = double(image.width) / image.height;
  const double about[] = {half * std::max(aspect, 1.0), half * std::max(1 / aspect, 1.0)};
  const double mean = mean_luminance(image, cosine_cubed, about);
  if (!(mean > 0)) p.fail_at("power", "is set for a black image, expected a brighter image");
  light.scale *= static_cast<float>(double{*power} / (4 * about[0] * about[1] * mean));
  return light;
}

/// Converts an image to gray as pbrt does, by the mean of red, green and blue.
std::shared_ptr<const Image> gray_image(const Image& image) {
  auto gray = std::make_shared<Image>(image.width, image.height, std::vector<std::string>{"Y"});
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    gray->data[i] = (image.data[3 * i] + image.data[3 * i + 1] + image.data[3 * i + 2]) / 3;
  return gray;
}

LightKinds::Model read_goniometric(Parameters& p) {
  if (!p.has("filename")) return read_point(p);
  GoniometricLightDescription light;
  const std::filesystem::path file = p.file("filename");
  const std::shared_ptr<const Image> image = gray_image(read_linear_image(file, false, p.where()));
  if (image->width != image->height)
    p.fail_at("filename", fmt::format("is an image of {} x {} pixels, expected a square equal-area image", image->width,
                                      image->height));
  float scale = read_scale(p);
  if (const auto power = p.find_number("power"); power && *power > 0.0f) {
    double sum = 0;
    for (const float value : image->data) sum += double{value};
    if (!(sum > 0)) p.fail_at("power", "is set for a black image, expected a brighter image");
    scale *= *power / (4 * kPi * static_cast<float>(sum / static_cast<double>(image->data.size())));
  }
  light.intensity = scaled(read_emission(p, "I"), scale);
  light.image = add_light_bitmap(p, {}, true);
  auto& bitmap = std::get<BitmapDescription>(p.reader().description.textures.back().model);
  bitmap.made = image;
  // pbrt exchanges y and z before the octahedral mapping.
  Matrix4 swap;
  swap.m[1] = {0, 0, 1, 0}, swap.m[2] = {0, 1, 0, 0};
  light.to_world = p.reader().attributes.transform.start * Transform(swap);
  return light;
}

/// A light of the pbrt dialect.
struct NamedLight {
  std::string_view name;
  LightKinds::Model (*read)(Parameters& p);
};

constexpr NamedLight kLights[] = {
    {"distant", read_distant}, {"goniometric", read_goniometric}, {"infinite", read_infinite},
    {"point", read_point},     {"projection", read_projection},   {"spot", read_spot},
};

}  // namespace

void read_light(Reader& reader, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("LightSource '{}'", entity.type), entity.where, std::move(entity.parameters));
  std::vector<std::string> known;
  for (const NamedLight& light : kLights) {
    if (light.name == entity.type) {
      LightDescription description{light.read(p), entity.where};
      p.reject_unused();
      reader.note_rest(entity.where, "lights");
      reader.description.lights.push_back(std::move(description));
      return;
    }
    known.emplace_back(light.name);
  }
  throw SceneError(entity.where, fmt::format("unknown light '{}'{}", entity.type, did_you_mean(entity.type, known)),
                   SceneErrorCode::kUnknownName);
}

AreaLight read_area_light(Reader& reader, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("AreaLightSource '{}'", entity.type), entity.where, std::move(entity.parameters));
  if (entity.type != "diffuse" && entity.type != "area")
    throw SceneError(entity.where,
                     fmt::format("unknown area light '{}'{}", entity.type, did_you_mean(entity.type, {"diffuse"})),
                     SceneErrorCode::kUnknownName);
  AreaLight light;
  light.where = entity.where;
  // Read the power and the radiance, which may be an image
  const float scale = read_scale(p);
  const auto power = p.find_number("power");
  if (power && *power > 0.0f) light.power = *power;
  if (p.has("filename")) {
    if (p.has("L")) p.fail("has both 'L' and 'filename', expected one");
    BitmapDescription bitmap;
    bitmap.file = p.file("filename");
    bitmap.wrap_u = bitmap.wrap_v = TextureWrap::kClamp;
    bitmap.change.scale = scale;
    if (light.power) {
      const double mean = mean_luminance(read_linear_image(bitmap.file, false, entity.where));
      if (!(mean > 0)) p.fail_at("power", "is set for a black image, expected a brighter image");
      bitmap.change.scale *= static_cast<float>(1 / mean);
    }
    light.radiance = add_bitmap(reader, std::move(bitmap), entity.where);
  } else {
    light.radiance = scaled(read_emission(p, "L"), scale);
  }
  light.two_sided = p.boolean("twosided", false);
  p.reject_unused();
  return light;
}

}  // namespace sheaf::pbrt
