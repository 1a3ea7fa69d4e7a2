// The report of a render as a table.
#include "kernels/guiding/candidate_moments.h"
#include "tools/console/duration.h"
#include "tools/report/report_figures.h"
#include "tools/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace sheaf {

namespace {

/// The name of a light in the report: its location in the scene file, or else its row.
std::string light_name(const RenderReport& report, std::size_t light) {
  const bool known = light < report.light_source_locations.size() && !report.light_source_locations[light].empty();
  return known ? report.light_source_locations[light] : fmt::format("light {}", light);
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
    text += fmt::format("; {} of {} tiles have enough samples for a noise of {:.2g} %", a.reached, a.tiles,
                        a.noise_target * 100);
  return text + "\n";
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
  return fmt::format("{:<28}{:>11}{}\n", fmt::format("memory (BVH: {})", report.bvh), "size",
                     triangles > 0 ? "    bytes/triangle" : "") +
         text;
}

}  // namespace

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
    fmt::format_to(out, "loading: reading {}, textures {}, compiling {}, BVH {}{}\n",
                   format_duration(l.reading_seconds), format_duration(l.texture_seconds),
                   format_duration(l.compile_seconds), format_duration(l.accel_seconds),
                   report.bvh_build.empty() ? "" : " (" + report.bvh_build + ")");
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
      report.rays_per_second() * 1e-6, report.trace_fraction() * 100);
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
