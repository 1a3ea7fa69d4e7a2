#include "kernels/passes/render_report.h"

#include "core/io/duration.h"
#include "kernels/guiding/candidate_trial.h"
#include "scene/scene.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <iterator>

namespace sheaf {

namespace {

double ratio(double a, double b) { return b > 0 ? a / b : 0.0; }

}  // namespace

std::string integrator_name(const IntegratorSettings& integrator) {
  if (integrator.kind == IntegratorKind::kNormals) return "normals";
  if (integrator.kind == IntegratorKind::kDepth) return "depth";
  if (integrator.kind == IntegratorKind::kVisibility) return "av";
  if (integrator.kind == IntegratorKind::kLightTracer) return "ptracer";
  if (integrator.kind == IntegratorKind::kPhotonMapper) return integrator.photons.progressive ? "sppm" : "photonmapper";
  if (integrator.ends_at_diffuse) return "whitted";
  if (integrator.strategy == LightStrategy::kBsdfOnly) return "path_mats";
  if (integrator.strategy == LightStrategy::kLightOnly) return "path_ems";
  return integrator.max_depth == 2 ? "direct" : "path";
}

std::vector<std::size_t> costliest_lights(const Stats& stats, std::size_t count) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < stats.lights.size(); ++i)
    if (stats.lights[i].rays > 0) order.push_back(i);
  const auto more = [&](std::size_t a, std::size_t b) {
    return std::pair(stats.lights[b].rays, a) < std::pair(stats.lights[a].rays, b);
  };
  std::sort(order.begin(), order.end(), more);
  order.resize(std::min(order.size(), count));
  return order;
}

double RenderReport::rays_per_second() const { return ratio(static_cast<double>(stats.rays.total()), render_seconds); }

double RenderReport::trace_share() const {
  return ratio(static_cast<double>(stats.trace_ticks) * seconds_per_tick(), render_seconds * threads);
}

double RenderReport::samples_factor(double target) const { return noise ? (*noise / target) * (*noise / target) : 0.0; }

namespace {

using Json = nlohmann::ordered_json;

/// The name of a light in the report: its location in the scene file, or else its row.
std::string light_name(const RenderReport& report, std::size_t light) {
  const bool known = light < report.light_source_locations.size() && !report.light_source_locations[light].empty();
  return known ? report.light_source_locations[light] : "light " + std::to_string(light);
}

double total_light_radiance(const Stats& stats) {
  double total = 0;
  for (const LightStats& light : stats.lights) total += light.radiance;
  return total;
}

Json lights_json(const RenderReport& report) {
  Json lights = Json::array();
  const double total = total_light_radiance(report.stats);
  for (const std::size_t i : costliest_lights(report.stats)) {
    const LightStats& light = report.stats.lights[i];
    lights.push_back(
        {{"light", i},
         {"where", i < report.light_source_locations.size() ? report.light_source_locations[i] : std::string()},
         {"shadow_rays", light.rays},
         {"arrived", light.arrived},
         {"radiance_share", ratio(light.radiance, total)}});
  }
  return lights;
}

/// The lights with the most shadow rays.
std::string lights_table(const RenderReport& report) {
  constexpr std::size_t kLines = 5;
  std::string text;
  const auto rays = static_cast<double>(report.stats.rays.shadow);
  for (const std::size_t i : costliest_lights(report.stats, kLines)) {
    const LightStats& light = report.stats.lights[i];
    fmt::format_to(std::back_inserter(text), "{:<28}{:>10.1f}%{:>10.1f}%{:>12.1f}%\n", light_name(report, i),
                   100 * ratio(static_cast<double>(light.rays), rays),
                   100 * ratio(static_cast<double>(light.arrived), static_cast<double>(light.rays)),
                   100 * ratio(light.radiance, total_light_radiance(report.stats)));
  }
  if (text.empty() || report.stats.lights.size() < 2) return {};
  return fmt::format("{:<28}{:>11}{:>11}{:>13}\n", "light", "shadow rays", "unoccluded", "contribution") + text;
}

/// The result of adaptive sampling.
std::string adaptive_line(const RenderReport& report) {
  if (!report.adaptive) return {};
  const AdaptiveSummary& a = *report.adaptive;
  std::string text = fmt::format("{:.1f} spp on average, {} to {}", a.mean_samples, a.min_samples, a.max_samples);
  if (a.noise_target > 0)
    text += fmt::format("; {} of {} tiles have reached a noise of {:.2g} %", a.reached, a.tiles, a.noise_target * 100);
  return text + "\n";
}

Json adaptive_json(const RenderReport& report) {
  if (!report.adaptive) return {};
  const AdaptiveSummary& a = *report.adaptive;
  return {{"noise_target", a.noise_target}, {"mean_spp", a.mean_samples}, {"min_spp", a.min_samples},
          {"max_spp", a.max_samples},       {"tiles", a.tiles},           {"tiles_reached", a.reached}};
}

/// The noise of the image, and the samples and time to halve it and to reduce it to 1 %.
std::string noise_line(const RenderReport& report) {
  if (!report.noise || !(*report.noise > 0)) return {};
  std::string text = fmt::format("noise {:.2f} % of a pixel's value (rms)", *report.noise * 100);
  if (report.adaptive) return text + "\n";
  for (const double target : {*report.noise / 2, 0.01}) {
    const double factor = report.samples_factor(target);
    if (factor < 1.5) continue;
    text += fmt::format("; {:.2g} % takes about {:.0f} spp, {}", target * 100, report.spp * factor,
                        format_duration(report.render_seconds * factor));
  }
  return text + "\n";
}

/// The time of a stage per query of photon maps and per photon, if the render has any.
struct GatheringTime {
  double ns_per_query = 0, ns_per_photon = 0, photons_per_query = 0;

  GatheringTime(const RenderReport& report, std::string_view stage, const Stats::Gathering& counts) {
    double seconds = 0;
    for (std::size_t i = 0; i < report.stage_names.size(); ++i)
      if (report.stage_names[i] == stage) seconds = report.stats.stages[i].seconds();
    const auto queries = static_cast<double>(counts.queries), photons = static_cast<double>(counts.photons);
    ns_per_query = ratio(seconds * 1e9, queries);
    ns_per_photon = ratio(seconds * 1e9, photons);
    photons_per_query = ratio(photons, queries);
  }
};

/// Counts and times of the photon maps.
std::string photons_table(const RenderReport& report) {
  const RenderReport::Photons& photons = report.photons;
  if (photons.emitted == 0) return {};
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{} photons emitted in {}, {} stored in maps in {}\n", photons.emitted,
                 format_duration(photons.trace_seconds), photons.stored, format_duration(photons.index_seconds));
  // Describe the first and the last maps
  const auto maps = [&](const char* name, const RenderReport::Photons::Maps& m) {
    fmt::format_to(out, "{}: {} photons, {:.1f} MB", name, m.photons, static_cast<double>(m.bytes) * 1e-6);
    for (const auto& [kind, radius] : {std::pair{"surface", m.global_radius}, std::pair{"caustic", m.caustic_radius},
                                       std::pair{"volume", m.volume_radius}, std::pair{"beam", m.beam_radius}})
      if (radius > 0) fmt::format_to(out, ", {} radius {:.4g} m", kind, radius);
    text += '\n';
  };
  if (photons.passes == 1) maps("photon maps", photons.first);
  if (photons.passes > 1) {
    maps("photon maps of the first pass", photons.first);
    maps(fmt::format("photon maps of pass {}", photons.passes).c_str(), photons.last);
  }
  // Describe the queries
  const auto queries = [&](const char* where, const char* stage, const Stats::Gathering& counts) {
    const GatheringTime time(report, stage, counts);
    if (counts.queries > 0)
      fmt::format_to(out, "{} photon queries {}: {:.1f} photons in {:.0f} ns each, {:.2f} ns per photon\n",
                     counts.queries, where, time.photons_per_query, time.ns_per_query, time.ns_per_photon);
  };
  queries("at surfaces", "gather", report.stats.gathering);
  queries("along rays", "gather_volume", report.stats.volume_gathering);
  return text;
}

Json photons_json(const RenderReport& report) {
  const RenderReport::Photons& photons = report.photons;
  const auto maps = [](const RenderReport::Photons::Maps& m) -> Json {
    return {{"global_radius", m.global_radius},
            {"caustic_radius", m.caustic_radius},
            {"volume_radius", m.volume_radius},
            {"beam_radius", m.beam_radius},
            {"photons", m.photons},
            {"bytes", m.bytes}};
  };
  const auto queries = [&](const char* stage, const Stats::Gathering& counts) -> Json {
    const GatheringTime time(report, stage, counts);
    return {{"queries", counts.queries},
            {"photons", counts.photons},
            {"ns_per_query", time.ns_per_query},
            {"ns_per_photon", time.ns_per_photon}};
  };
  return {{"emitted", photons.emitted},
          {"stored", photons.stored},
          {"trace_seconds", photons.trace_seconds},
          {"index_seconds", photons.index_seconds},
          {"passes", photons.passes},
          {"first_pass", maps(photons.first)},
          {"last_pass", maps(photons.last)},
          {"at_surfaces", queries("gather", report.stats.gathering)},
          {"along_rays", queries("gather_volume", report.stats.volume_gathering)}};
}

/// Memory by cause, largest first, without causes below 0.1 MB.
std::vector<MemoryUse> largest_uses(const RenderReport& report) {
  constexpr double kMinBytes = 1e5;
  std::vector<MemoryUse> uses = report.memory;
  std::erase_if(uses, [](const MemoryUse& use) { return use.bytes < kMinBytes; });
  std::stable_sort(uses.begin(), uses.end(), [](const MemoryUse& a, const MemoryUse& b) { return a.bytes > b.bytes; });
  return uses;
}

std::string memory_table(const RenderReport& report) {
  std::string text;
  const auto triangles = static_cast<double>(report.triangles);
  for (const MemoryUse& use : largest_uses(report)) {
    fmt::format_to(std::back_inserter(text), "{:<28}{:>11}", use.what, format_bytes(use.bytes));
    if (triangles > 0) fmt::format_to(std::back_inserter(text), "{:>18.1f}", use.bytes / triangles);
    text += "\n";
  }
  if (text.empty()) return text;
  return fmt::format("{:<28}{:>11}{}\n", "memory (BVH: " + report.bvh + ")", "size",
                     triangles > 0 ? "    bytes/triangle" : "") +
         text;
}

Json memory_json(const RenderReport& report) {
  Json uses = Json::array();
  for (const MemoryUse& use : report.memory) uses.push_back({{"what", use.what}, {"bytes", use.bytes}});
  return uses;
}

Json stages_json(const RenderReport& report) {
  Json stages = Json::array();
  for (std::size_t i = 0; i < report.stage_names.size(); ++i) {
    const StageStats& stage = report.stats.stages[i];
    stages.push_back({{"name", report.stage_names[i]},
                      {"items", stage.items},
                      {"calls", stage.calls},
                      {"seconds", stage.seconds()},
                      {"ns_per_item", stage.ns_per_item()},
                      {"lane_fill", stage.lane_fill()}});
  }
  return stages;
}

}  // namespace

std::string to_json(const RenderReport& report) {
  const Stats::Rays& rays = report.stats.rays;
  const Json json{
      {"scene", report.scene},
      {"integrator", report.integrator},
      {"color", report.color},
      {"width", report.width},
      {"height", report.height},
      {"spp", report.spp},
      {"interrupted", report.interrupted},
      {"mean_samples", report.mean_samples},
      {"threads", report.threads},
      {"isa", report.isa},
      {"wave_size", report.wave_size},
      {"seed", report.seed},
      {"load_seconds", report.load_seconds},
      {"build_seconds", report.build_seconds},
      {"loading",
       {{"reading_seconds", report.loading.reading_seconds},
        {"texture_seconds", report.loading.texture_seconds},
        {"compile_seconds", report.loading.compile_seconds},
        {"accel_seconds", report.loading.accel_seconds}}},
      {"render_seconds", report.render_seconds},
      {"photons", photons_json(report)},
      {"guiding",
       {{"passes", report.guiding.passes},
        {"samples", report.guiding.samples},
        {"records", report.guiding.records},
        {"cells", report.guiding.cells},
        {"trace_seconds", report.guiding.trace_seconds},
        {"fit_seconds", report.guiding.fit_seconds},
        {"gain", report.guiding.gain ? nlohmann::ordered_json(*report.guiding.gain) : nlohmann::ordered_json()},
        {"used", report.guiding.is_used}}},
      {"candidates", {{"count", report.candidates.count}, {"gains", report.candidates.gains}}},
      {"caustics",
       {{"attempts", report.stats.chains.attempts},
        {"solutions", report.stats.chains.solutions},
        {"trials", report.stats.chains.trials},
        {"capped", report.stats.chains.capped},
        {"rays", report.stats.chains.rays}}},
      {"peak_rss_bytes", report.peak_rss_bytes},
      {"peak_private_bytes", report.peak_private_bytes},
      {"triangles", report.triangles},
      {"bvh", report.bvh},
      {"memory", memory_json(report)},
      {"samples", report.stats.samples},
      {"rays", {{"camera", rays.camera}, {"light", rays.light}, {"scatter", rays.scatter}, {"shadow", rays.shadow}}},
      {"rays_per_second", report.rays_per_second()},
      {"trace_share", report.trace_share()},
      {"noise", report.noise ? Json(*report.noise) : Json()},
      {"seconds_to_one_percent", report.noise ? Json(report.render_seconds * report.samples_factor(0.01)) : Json()},
      {"adaptive", adaptive_json(report)},
      {"stages", stages_json(report)},
      {"lights", lights_json(report)},
      {"collisions",
       {{"real", report.stats.collisions.real},
        {"null", report.stats.collisions.null},
        {"shadow", report.stats.collisions.shadow},
        {"abandoned", report.stats.collisions.abandoned}}},
      {"dropped", {{"rays", report.stats.dropped.rays}, {"samples", report.stats.dropped.samples}}}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_table(const RenderReport& report) {
  const Stats& stats = report.stats;
  std::string text;
  const auto out = std::back_inserter(text);
  // Describe the render and its times
  fmt::format_to(out, "{}: {} x {}, {} spp, {} threads, {}, waves of {}\n", report.integrator, report.width,
                 report.height, report.spp, report.threads, report.isa, report.wave_size);
  if (report.interrupted) fmt::format_to(out, "interrupted after {:.4g} samples per pixel\n", report.mean_samples);
  fmt::format_to(out, "load {}, build {}, render {}, peak memory {:.1f} MB\n", format_duration(report.load_seconds),
                 format_duration(report.build_seconds), format_duration(report.render_seconds),
                 static_cast<double>(report.peak_rss_bytes) * 1e-6);
  if (const RenderReport::Loading& l = report.loading; l.reading_seconds > 0)
    fmt::format_to(out, "loading: reading {}, textures {}, compiling {}, BVH {}\n", format_duration(l.reading_seconds),
                   format_duration(l.texture_seconds), format_duration(l.compile_seconds),
                   format_duration(l.accel_seconds));
  text += photons_table(report);
  if (const RenderReport::Guiding& guiding = report.guiding; guiding.passes > 0)
    fmt::format_to(out, "guide: {} samples in {} passes in {}, {} cells trained with {} directions in {}\n",
                   guiding.samples, guiding.passes, format_duration(guiding.trace_seconds), guiding.cells,
                   guiding.records, format_duration(guiding.fit_seconds));
  if (const std::optional<double>& gain = report.guiding.gain)
    fmt::format_to(out, "guide: {}, error x cost is {:.2f} times as high without it\n",
                   report.guiding.is_used ? "used" : "not used", *gain);
  if (const std::vector<double>& gains = report.candidates.gains; !gains.empty()) {
    fmt::format_to(out, "light candidates: {} per vertex; error x cost is", report.candidates.count);
    for (std::size_t i = 1; i < gains.size(); ++i)
      fmt::format_to(out, "{} {:.2f} with {}", i > 1 ? "," : "", 1 / gains[i], kCandidateCounts[i]);
    text += " times that with 1\n";
  }
  if (const Stats::Chains& chains = stats.chains; chains.attempts > 0)
    fmt::format_to(out, "caustics: {} chains in {} attempts, {} trials, {} at the limit of trials, {} rays\n",
                   chains.solutions, chains.attempts, chains.trials, chains.capped, chains.rays);
  fmt::format_to(
      out, "{} samples, {} rays (camera {}, light {}, scatter {}, shadow {}), {:.2f} M rays/s, {:.1f} % in Embree\n",
      stats.samples, stats.rays.total(), stats.rays.camera, stats.rays.light, stats.rays.scatter, stats.rays.shadow,
      report.rays_per_second() * 1e-6, report.trace_share() * 100);
  // List the stages
  fmt::format_to(out, "{:<18}{:>14}{:>10}{:>11}{:>10}{:>11}\n", "stage", "items", "calls", "seconds", "ns/item",
                 "lane fill");
  for (std::size_t i = 0; i < report.stage_names.size(); ++i) {
    const StageStats& stage = stats.stages[i];
    if (stage.items == 0) continue;
    fmt::format_to(out, "{:<18}{:>14}{:>10}{:>11.3f}{:>10.1f}{:>10.1f}%\n", report.stage_names[i], stage.items,
                   stage.calls, stage.seconds(), stage.ns_per_item(), stage.lane_fill() * 100);
  }
  // Add lights, noise and media
  text += lights_table(report);
  text += memory_table(report);
  text += adaptive_line(report) + noise_line(report);
  if (const TrackingCounts& c = stats.collisions; c.real + c.null + c.shadow > 0)
    fmt::format_to(out, "medium collisions: {} real, {} null ({:.2f} per real one), {} of shadow rays\n", c.real,
                   c.null, ratio(static_cast<double>(c.null), static_cast<double>(c.real)), c.shadow);
  if (stats.dropped.rays + stats.dropped.samples > 0) {
    fmt::format_to(out, "dropped: {} rays, {} samples\n", stats.dropped.rays, stats.dropped.samples);
  }
  return text;
}

}  // namespace sheaf
