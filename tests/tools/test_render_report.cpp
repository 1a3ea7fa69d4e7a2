// The report of a render as text and as JSON, and the sums of its counters.
#include "core/simd/simd.h"
#include "tests/support/contains.h"
#include "tests/support/near.h"
#include "tools/report/report_figures.h"
#include "tools/report/report_text.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_render_report {

using test::contains;

namespace {

Stats make_stats(std::uint64_t factor) {
  Stats stats;
  for (std::size_t i = 0; i < kMaxStages; ++i) {
    stats.stages[i] = {factor, 100 * factor, 10 * factor, 5 * factor * kWidth, 1000 * factor};
  }
  stats.rays = {factor, 2 * factor, 3 * factor};
  stats.trace_ticks = 4 * factor;
  stats.samples = 5 * factor;
  stats.dropped = {6 * factor, 7 * factor};
  stats.gathering = {8 * factor, 9 * factor};
  stats.volume_gathering = {10 * factor, 11 * factor};
  return stats;
}

}  // namespace

TEST_CASE("stats of workers add up in every field") {
  Stats sum = make_stats(1);
  sum += make_stats(10);
  const Stats expected = make_stats(11);
  for (std::size_t i = 0; i < kMaxStages; ++i) {
    CHECK(sum.stages[i].calls == expected.stages[i].calls);
    CHECK(sum.stages[i].items == expected.stages[i].items);
    CHECK(sum.stages[i].batches == expected.stages[i].batches);
    CHECK(sum.stages[i].active_lanes == expected.stages[i].active_lanes);
    CHECK(sum.stages[i].ticks == expected.stages[i].ticks);
  }
  CHECK(sum.rays.total() == 66);
  CHECK(sum.trace_ticks == 44);
  CHECK(sum.samples == 55);
  CHECK(sum.dropped.rays == 66);
  CHECK(sum.dropped.samples == 77);
  CHECK(sum.gathering.queries == 88);
  CHECK(sum.gathering.photons == 99);
  CHECK(sum.volume_gathering.queries == 110);
  CHECK(sum.volume_gathering.photons == 121);
}

TEST_CASE("an empty report has no rays and no share") {
  CHECK(RenderReport().rays_per_second() == 0);
  CHECK(RenderReport().trace_fraction() == 0);
}

TEST_CASE("a report of photon maps has the queries of their stages and the radii of the first and last pass") {
  RenderReport report;
  report.stage_names = {"intersect", "gather", "gather_volume"};
  report.stats.stages[1].ticks = static_cast<std::uint64_t>(2e-3 / seconds_per_tick());
  report.stats.stages[2].ticks = static_cast<std::uint64_t>(3e-3 / seconds_per_tick());
  report.stats.gathering = {500, 40'000};
  report.stats.volume_gathering = {1000, 2000};
  report.photons = {700, 600, 0.25, 0.5, 16, {0.5f, 0.25f, 0, 0.125f, 60, 5400}, {0.05f, 0.025f, 0, 0.0125f, 61, 5500}};
  const std::string table = to_table(report), json = to_json(report);
  CHECK(contains(table, "500 photon queries at surfaces: 80.0 photons in 4000 ns each, 50.00 ns per photon\n"));
  CHECK(contains(table, "1000 photon queries along rays: 2.0 photons in 3000 ns each, 1500.00 ns per photon\n"));
  CHECK(contains(table,
                 "photon maps of the first pass: 60 photons, 0.0 MB, surface radius 0.5 m, caustic radius 0.25 m, beam "
                 "radius 0.125 m\n"));
  CHECK(contains(table,
                 "photon maps of pass 16: 61 photons, 0.0 MB, surface radius 0.05 m, caustic radius 0.025 m, beam "
                 "radius 0.0125 m\n"));
  CHECK(contains(json, "\"passes\": 16"));
  CHECK(contains(json, "\"bytes\": 5500"));
  CHECK(contains(json, "\"queries\": 500"));
  report.photons.passes = 1;
  CHECK(contains(to_table(report), "\nphoton maps: 60 photons"));
  report.photons = {};
  CHECK_FALSE(contains(to_table(report), "photon"));
}

TEST_CASE("a report as JSON and as a table") {
  RenderReport report;
  report.scene = "folder/\"quoted\"\xff.xml";  // not valid UTF-8
  report.integrator = "path";
  report.threads = 2;
  report.render_seconds = 2;
  report.stats = make_stats(1);
  report.stats.trace_ticks = static_cast<std::uint64_t>(3 / seconds_per_tick());
  report.stage_names = {"light_candidates", "unused", "sort"};
  report.stats[Stage{1}].items = 0;
  CHECK(report.trace_fraction() == near(0.75, 1e-3));
  CHECK(report.rays_per_second() == near(3));
  report.photons = {700, 600, 0.25, 0.5, 1, {0.25f, 0, 0.125f, 0, 600, 54'000}, {0.25f, 0, 0.125f, 0, 600, 54'000}};
  const std::string json = to_json(report);
  CHECK(contains(json, "\"stored\": 600"));
  CHECK(contains(to_table(report), "700 photons emitted in 0.25 s, 600 stored in maps in 0.50 s"));
  CHECK(contains(json, "\\\"quoted\\\""));
  CHECK(contains(json, "\"name\": \"light_candidates\""));
  CHECK(contains(json, "\"rays_per_second\": 3.0"));
  CHECK(contains(json, "\"abandoned\": "));
  const std::string table = to_table(report);
  CHECK(contains(table, "light_candidates"));
  CHECK(contains(table, "sort"));
  CHECK(contains(json, "unused"));
  CHECK_FALSE(contains(table, "unused"));
  CHECK(contains(table, "dropped: 6 rays, 7 samples"));
}

TEST_CASE("a report tells which lights cost most, and what they bring") {
  RenderReport report;
  report.render_seconds = 10;
  report.spp = 64;
  Stats one, other;
  one.rays.shadow = 600;
  one.lights = {{500, 100, 30.0}, {0, 0, 0.0}};
  other.rays.shadow = 400;
  other.lights = {{100, 20, 10.0}, {0, 0, 0.0}, {300, 300, 60.0}};
  report.stats = one;
  report.stats += other;
  report.light_source_locations = {"room.xml:12"};
  CHECK(report.stats.lights[0].rays == 600);
  CHECK(costliest_lights(report.stats) == std::vector<std::size_t>{0, 2});
  CHECK(costliest_lights(report.stats, 1) == std::vector<std::size_t>{0});
  const std::string json = to_json(report), table = to_table(report);
  CHECK(contains(json, "\"where\": \"room.xml:12\""));
  CHECK(contains(json, "\"radiance_share\": 0.4"));
  CHECK(contains(json, "\"noise\": null"));
  CHECK(contains(table, "room.xml:12"));
  CHECK(contains(table, "light 2"));
  CHECK(contains(table, "60.0%"));
  CHECK_FALSE(contains(table, "noise"));
}

TEST_CASE("a report says how long an image of less noise would take") {
  RenderReport report;
  report.render_seconds = 10;
  report.spp = 64;
  report.noise = 0.04;
  CHECK(report.samples_factor(0.02) == near(4));
  const std::string table = to_table(report);
  CHECK(contains(table, "noise 4.00 % of a pixel's value"));
  CHECK(contains(table, "2 % takes about 256 spp, 40 s"));
  CHECK(contains(table, "1 % takes about 1024 spp, 2 min 40 s"));
  CHECK(contains(to_json(report), "\"seconds_to_one_percent\": 160.0"));
}

}  // namespace sheaf::test_render_report
