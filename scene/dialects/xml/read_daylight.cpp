// Sun and sky emitters of the Mitsuba dialect: positions and size of the sun, and parameters of the sky.
#include "scene/dialects/xml/read_daylight.h"

#include "scene/dialects/common/sun_position.h"

#include <algorithm>
#include <cmath>

namespace sheaf::mitsuba {

namespace {

/// Number of sun positions for a moving sun, and columns of the resulting sky map.
constexpr int kSunSamples = 8192, kTimedResolution = 256;

/// Transforms directions from the emitter's space to world space.
class DaylightSpace {
 public:
  DaylightSpace(Properties& p, bool y_is_up) : to_world_(p.transform("to_world")), y_is_up_(y_is_up) {}

  Vec3f up() const { return world(y_is_up_ ? Vec3f{0, 1, 0} : Vec3f{0, 0, 1}); }
  /// Converts components to the east, to the north and upwards.
  Vec3f direction(const std::array<double, 3>& v) const {
    const auto east = static_cast<float>(v[0]), north = static_cast<float>(v[1]), up = static_cast<float>(v[2]);
    return world(y_is_up_ ? Vec3f{east, up, -north} : Vec3f{-north, -east, up});
  }

 private:
  Vec3f world(Vec3f v) const { return normalize(to_world_.vector(v)); }

  Transform to_world_;
  bool y_is_up_;
};

void read_location(Properties& p, SunTime& time) {
  time.latitude = double(p.number("latitude", static_cast<float>(time.latitude), {-90, 90, false}));
  time.longitude = double(p.number("longitude", static_cast<float>(time.longitude), {-360, 360, false}));
  time.timezone = double(p.number("timezone", static_cast<float>(time.timezone), {-24, 24, false}));
}

constexpr int kFirstYear = -4000, kLastYear = 10000;

SunTime read_time(Properties& p) {
  SunTime time;
  read_location(p, time);
  time.year = p.integer("year", time.year, kFirstYear, kLastYear);
  time.month = p.integer("month", time.month, 1, 12);
  time.day = p.integer("day", time.day, 1, 31);
  time.hour = double(p.number("hour", 15, {0, 24, false}));
  time.minute = double(p.number("minute", 0, {0, 60, false}));
  time.second = double(p.number("second", 0, {0, 60, false}));
  return time;
}

/// Reads `sun_direction` (world space), or computes the position of the sun from location and time.
Vec3f read_sun(Properties& p, const DaylightSpace& space) {
  if (!p.has("sun_direction")) return space.direction(sun_position(read_time(p)));
  for (const char* other : {"year", "month", "day", "hour", "minute", "second", "latitude", "longitude", "timezone"})
    if (p.has(other)) p.report_conflict(other, "'sun_direction'");
  const std::optional<Vec3f> direction = p.find_vec3("sun_direction");
  if (!direction) return space.direction(sun_position(SunTime()));
  const float length = sheaf::length(*direction);
  if (length > 0.0f && std::isfinite(length)) return *direction * (1.0f / length);
  p.report_at("sun_direction", "has no length", SceneErrorCode::kOutOfRange);
  return space.direction(sun_position(SunTime()));
}

/// Returns sun positions at times that spread over the days of a date range and over the hours of each day.
std::vector<Vec3f> read_suns(Properties& p, const DaylightSpace& space) {
  SunTime begin, end;
  // Read the range of dates and hours
  read_location(p, begin);
  begin.year = p.integer("start_year", 2025, kFirstYear, kLastYear);
  begin.month = p.integer("start_month", 1, 1, 12);
  begin.day = p.integer("start_day", 1, 1, 31);
  end = begin;
  end.year = p.integer("end_year", begin.year + 1, kFirstYear, kLastYear);
  end.month = p.integer("end_month", begin.month, 1, 12);
  end.day = p.integer("end_day", begin.day, 1, 31);
  const double days = days_since_2000(end) - days_since_2000(begin);
  if (days < 0)
    p.report_at("end_year", fmt::format("puts the last day {} days before the first, expected it after", -days),
                SceneErrorCode::kOutOfRange);
  const double first_hour = double(p.number("window_start_time", 7, {0, 24, false}));
  const double last_hour = double(p.number("window_end_time", 19, {first_hour, 24, false}));
  p.ignore({"shutter_open", "shutter_close"});
  std::vector<Vec3f> suns;
  // Spread sun positions over days and hours
  const int first_day = begin.day;
  for (int i = 0; i < kSunSamples; ++i) {
    begin.day = first_day + static_cast<int>((i + 0.5) / kSunSamples * std::max(days, 1.0));
    const double golden = (i + 0.5) * 0.6180339887498949;
    begin.hour = first_hour + (last_hour - first_hour) * (golden - std::floor(golden));
    suns.push_back(space.direction(sun_position(begin)));
  }
  return suns;
}

/// Reads the angular radius of the sun, degrees.
float read_radius(Properties& p) {
  if (p.has("sun_aperture") && p.has("sun_radius_scale")) p.report_conflict("sun_aperture", "'sunRadiusScale'");
  const bool by_aperture = p.has("sun_aperture");
  const float aperture = p.number("sun_aperture", 2 * SunDescription::kSunRadius, {0, 180, true});
  const float scale = p.number("sun_radius_scale", 1, {0, 89 / double(SunDescription::kSunRadius), false});
  return by_aperture ? 0.5f * aperture : SunDescription::kSunRadius * scale;
}

}  // namespace

const std::vector<std::string>& daylight_names() {
  static const std::vector<std::string> kNames = {"sky", "sun", "sunsky", "timed_sunsky"};
  return kNames;
}

bool is_daylight(const std::string& type) {
  return std::find(daylight_names().begin(), daylight_names().end(), type) != daylight_names().end();
}

std::vector<LightDescription> read_daylight(Properties& p, bool y_is_up) {
  const bool timed = p.type() == "timed_sunsky";
  const DaylightSpace space(p, y_is_up);
  SkyDescription sky;
  SunDescription sun;
  sky.up = sun.up = space.up();
  // Read the position of the sun
  sky.suns = timed ? read_suns(p, space) : std::vector<Vec3f>{read_sun(p, space)};
  sun.direction = sky.suns.front();
  // Read the parameters of sky and sun
  sky.turbidity = sun.turbidity = p.number("turbidity", 3, {1, 10, false});
  sky.albedo = p.spectrum("albedo", SpectrumDescription::constant(y_is_up ? 0.2f : 0.3f), SpectrumRole::kReflectance);
  const float scale = p.number("scale", 1, kNotNegative);
  sky.scale = p.number("sky_scale", scale, kNotNegative);
  sun.scale = p.number("sun_scale", scale, kNotNegative);
  sky.stretch = sun.stretch = p.number("stretch", 1, {1, 2, false});
  sky.extend = p.boolean("extend", false);
  sky.resolution = p.integer("resolution", timed ? kTimedResolution : 512, 4, 16384) & ~1;
  sun.radius = read_radius(p);
  if (p.boolean("complex_sun", false))
    p.context().note(p.where(), "'complex_sun' ignored: the sun has uniform radiance");
  if (timed) sky.sun_scale = sun.scale;
  std::vector<LightDescription> lights;
  // Append the requested parts
  if (p.type() != "sun") lights.push_back({std::move(sky), p.where()});
  if (p.type() != "sky" && !timed) lights.push_back({sun, p.where()});
  return lights;
}

}  // namespace sheaf::mitsuba
