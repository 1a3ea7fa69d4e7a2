// trace_limit: compares the speed of a render with the speed at which Embree traces its rays. See bench/README.md.
#include "bench/trace_limit.h"

#include "core/io/error.h"
#include "core/soa/large_pages.h"
#include "kernels/render/render.h"
#include "kernels/stages/stage_list.h"
#include "scene/compile/compile.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/read_scene.h"
#include "tools/options/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <thread>

namespace sheaf {

namespace {

struct Arguments {
  std::string scene;
  std::vector<std::string> definitions;
  std::uint32_t spp = 4;
  int threads = 0, runs = 5, wave_size = 0, megabytes = 1024, photons = 0;
  bool scaling = false, null_hypothesis = false;
  std::string filter_mode, sampler;
  std::optional<int> rr_depth;
};

/// Measurements with one number of threads, one value per round.
struct Rounds {
  int threads;
  std::vector<double> render_mrays, limit_mrays, ratio, cpu_ratio, trace_fraction, cpu_ns;
};

/// Reduces a render to building a photon map of `photons` photons; the image shrinks to one pixel.
void reduce_to_photon_map(Description& description, int photons) {
  description.integrator.kind = IntegratorKind::kPhotonMapper;
  description.integrator.photons = {};
  description.integrator.photons.global.count = static_cast<std::uint64_t>(photons);
  description.film.width = description.film.height = 1;
  description.film.crop.reset();
  description.sampler.sample_count = 1;
}

std::unique_ptr<Scene> load(const Arguments& arguments) {
  ReadOptions options;
  for (const std::string& definition : arguments.definitions) {
    const std::size_t equals = definition.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Error(ExitCode::kUsage, fmt::format("-D {}: expected name=value", definition));
    options.defines.emplace_back(definition.substr(0, equals), definition.substr(equals + 1));
  }
  Description description = read_scene(arguments.scene, options);
  if (arguments.photons > 0) reduce_to_photon_map(description, arguments.photons);
  description.sampler.kind = arguments.sampler.empty() ? rendered_sampler(description.sampler.kind)
                                                       : kSamplers.option("sampler", arguments.sampler);
  if (arguments.rr_depth) description.integrator.rr_depth = *arguments.rr_depth;
  if (arguments.filter_mode == "importance") description.film.filter_mode = FilterMode::kImportance;
  std::unique_ptr<Scene> scene = compile_scene(description);
  move_to_large_pages();
  return scene;
}

/// The number of samples per pixel whose rays fit into memory, at most the requested number.
std::uint32_t affordable_spp(const Scene& scene, const Arguments& arguments, RenderOptions options) {
  options.samples_per_pixel = 1;
  const Stats stats = render(scene, options).report.stats;
  const std::uint64_t packets = stats[stage_named("intersect")].batches + stats[stage_named("shadow")].batches +
                                stats[stage_named("transmittance")].batches;
  const std::uint64_t budget = static_cast<std::uint64_t>(arguments.megabytes) * 1'000'000 / sizeof(PacketRecord);
  // The number of rays differs between samples, so a tenth is kept in reserve.
  const std::uint64_t spp = budget * 9 / 10 / std::max<std::uint64_t>(packets, 1);
  if (spp == 0)
    throw Error(ExitCode::kUsage, fmt::format("the rays of one sample per pixel do not fit in {} MB; raise --memory "
                                              "or render a smaller image",
                                              arguments.megabytes));
  const std::uint32_t requested = arguments.photons > 0 ? 1 : arguments.spp;
  if (spp >= requested) return requested;
  fmt::print(stderr, "trace_limit: {} instead of {} samples per pixel, to fit the rays in {} MB\n", spp, arguments.spp,
             arguments.megabytes);
  return static_cast<std::uint32_t>(spp);
}

void record(const Scene& scene, RenderOptions options, RayLog& log) {
  options.make_recorder = [&log] { return log.add_worker(); };
  render(scene, options);
  if (!log.complete()) throw Error(ExitCode::kRuntime, "the rays did not fit in memory; raise --memory");
}

void run_round(const Scene& scene, RenderOptions options, const RayLog& log, Rounds& rounds) {
  options.threads = rounds.threads;
  const auto rays = static_cast<double>(log.rays());
  const Stopwatch watch;
  const RenderReport report = render(scene, options).report;
  const double render_cpu = watch.elapsed().cpu_seconds;
  // For a photon map, the time to build the map does not count.
  const double seconds = report.photons.emitted > 0 ? report.photons.trace_seconds : report.render_seconds;
  const Duration limit = log.replay(*scene.view().accel, rounds.threads);
  rounds.render_mrays.push_back(1e-6 * report.rays_per_second() * report.render_seconds / seconds);
  rounds.limit_mrays.push_back(1e-6 * rays / limit.seconds);
  rounds.ratio.push_back(limit.seconds / seconds);
  rounds.cpu_ratio.push_back(limit.cpu_seconds / render_cpu);
  rounds.trace_fraction.push_back(report.trace_fraction() * report.render_seconds / seconds);
  rounds.cpu_ns.push_back(1e9 * render_cpu / rays);
}

void print(const Rounds& rounds) {
  fmt::print("threads {}\n", rounds.threads);
  fmt::print("  render_mrays {:.3f}\n", median(rounds.render_mrays));
  fmt::print("  limit_mrays  {:.3f}\n", median(rounds.limit_mrays));
  fmt::print("  ratio        {:.3f}\n", median(rounds.ratio));
  fmt::print("  cpu_ratio    {:.3f}\n", median(rounds.cpu_ratio));
  fmt::print("  trace_share  {:.3f}\n", median(rounds.trace_fraction));
}

void print_scaling(const Rounds& one, const Rounds& many) {
  fmt::print("scaling from 1 to {} threads\n", many.threads);
  fmt::print("  render       {:.3f}\n", median(many.render_mrays) / median(one.render_mrays));
  fmt::print("  limit        {:.3f}\n", median(many.limit_mrays) / median(one.limit_mrays));
  fmt::print("  cpu          {:.3f}\n", many.threads * median(one.cpu_ns) / median(many.cpu_ns));
}

void print_null_hypothesis(const Scene& scene, int runs) {
  fmt::print("{:<8}{:>6}{:>10}{:>15}{:>13}{:>9}\n", "lane", "wave", "ns/ray", "embree ns/ray", "rest ns/ray", "stamps");
  for (const LaneCost& cost : measure_null_hypothesis(scene, runs))
    fmt::print("{:<8}{:>6}{:>10.1f}{:>15.1f}{:>13.1f}{:>9.1f}\n", cost.lane, cost.wave_size, cost.ns_per_ray,
               cost.trace_ns_per_ray, cost.ns_per_ray - cost.trace_ns_per_ray, cost.stamps_ns_per_ray);
}

void measure(const Arguments& arguments) {
  const std::unique_ptr<Scene> scene = load(arguments);
  if (arguments.null_hypothesis) return print_null_hypothesis(*scene, arguments.runs);
  RenderOptions options;
  options.threads =
      arguments.threads > 0 ? arguments.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  options.wave_size = arguments.wave_size;
  options.samples_per_pixel = affordable_spp(*scene, arguments, options);
  RayLog log(static_cast<std::size_t>(arguments.megabytes) * 1'000'000 / sizeof(PacketRecord));
  record(*scene, options, log);
  fmt::print("{}: {} samples per pixel, {} rays in {} packets, median of {} runs\n", arguments.scene,
             *options.samples_per_pixel, log.rays(), log.packets(), arguments.runs);

  std::vector<Rounds> all;
  if (arguments.scaling && options.threads > 1) all.push_back({1, {}, {}, {}, {}, {}, {}});
  all.push_back({options.threads, {}, {}, {}, {}, {}, {}});
  for (int run = 0; run < arguments.runs; ++run)
    for (Rounds& rounds : all) run_round(*scene, options, log, rounds);
  for (const Rounds& rounds : all) print(rounds);
  if (all.size() == 2) print_scaling(all[0], all[1]);
}

void add_options(Command& program, Arguments& arguments) {
  program.add_option("scene", arguments.scene, "Scene file").required().file();
  program.add_option("--spp", arguments.spp, "Samples per pixel, fewer if their rays do not fit in memory. Default: 4")
      .in_range(1u, 256u);
  program.add_option("--threads", arguments.threads, "Threads. Default: 0, one per logical core").in_range(0, 4096);
  program.add_option("--runs", arguments.runs, "Number of alternating renders and replays. Default: 5")
      .in_range(1, 1000);
  program
      .add_option("--wave-size", arguments.wave_size,
                  "Paths in flight per worker. Default: 0, derived from the L2 cache size")
      .in_range(0, kMaxWaveSize);
  program.add_option("--memory", arguments.megabytes, "Memory for recorded rays, in MB. Default: 1024")
      .in_range(4, 1 << 20);
  program.add_option("-D,--define", arguments.definitions, "name=value: replaces $name in the scene; may be repeated");
  program
      .add_option("--photons", arguments.photons,
                  "Measure photon tracing instead: a photon map of this size and an image of one pixel")
      .in_range(0, 1'000'000'000);
  program.add_option("--filter-mode", arguments.filter_mode, "As in sheaf render").one_of({"weighted", "importance"});
  program.add_option("--sampler", arguments.sampler, "As in sheaf render").one_of(kSamplers.names());
  program.add_option("--rr-depth", arguments.rr_depth, "As in sheaf render").in_range(1, 1 << 20);
  program.add_flag("--scaling", arguments.scaling, "Measure one thread as well");
  program.add_flag("--null", arguments.null_hypothesis,
                   "Compare scalar with wide kernels and single paths with waves on one thread instead");
}

}  // namespace

}  // namespace sheaf

int main(int argc, char** argv) {
  sheaf::Program program("trace_limit",
                         "Compare the speed of a render with the speed at which Embree traces its rays.");
  sheaf::Arguments arguments;
  sheaf::add_options(program, arguments);
  try {
    if (const std::optional<int> exit_code = program.parse(argc, argv)) return *exit_code;
    sheaf::measure(arguments);
  } catch (const sheaf::Error& error) {
    fmt::print(stderr, "trace_limit: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "trace_limit: {}\n", error.what());
    return static_cast<int>(sheaf::ExitCode::kRuntime);
  }
  return 0;
}
