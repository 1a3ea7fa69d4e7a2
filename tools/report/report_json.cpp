// The report of a render as JSON text.
#include "tools/report/report_figures.h"
#include "tools/report/report_text.h"

#include <nlohmann/json.hpp>

namespace sheaf {

namespace {

using Json = nlohmann::ordered_json;

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

Json adaptive_json(const RenderReport& report) {
  if (!report.adaptive) return {};
  const AdaptiveSummary& a = *report.adaptive;
  return {{"noise_target", a.noise_target}, {"mean_spp", a.mean_samples}, {"min_spp", a.min_samples},
          {"max_spp", a.max_samples},       {"tiles", a.tiles},           {"tiles_reached", a.reached}};
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
        {"gain", report.guiding.gain ? Json(*report.guiding.gain) : Json()},
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
      {"bvh_build", report.bvh_build},
      {"memory", memory_json(report)},
      {"samples", report.stats.samples},
      {"rays", {{"camera", rays.camera}, {"light", rays.light}, {"scatter", rays.scatter}, {"shadow", rays.shadow}}},
      {"rays_per_second", report.rays_per_second()},
      {"trace_share", report.trace_fraction()},
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

}  // namespace sheaf
