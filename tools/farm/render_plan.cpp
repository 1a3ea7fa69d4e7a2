#include "tools/farm/render_plan.h"

#include "core/io/error.h"
#include "scene/dialects/read_scene.h"
#include "tools/job/apply_arguments.h"

#include <algorithm>
#include <iterator>

namespace sheaf {

RenderPlan plan_render(const std::vector<std::string>& words) {
  Program program("sheaf", "");
  RenderArguments arguments;
  Command command = add_render_options(program, arguments);
  RenderPlan plan;
  command.on_call([&] {
    for (const GivenOption& option : command.given()) {
      plan.given.push_back(option.name);
      const auto has_name = [&](const char* name) { return option.name == name; };
      if (std::any_of(std::begin(kOutputOptionNames), std::end(kOutputOptionNames), has_name))
        plan.output_options.emplace_back(option.name, option.values);
    }
  });
  // Parse the options as `sheaf render` does
  std::vector<std::string> line{"sheaf", "render"};
  line.insert(line.end(), words.begin(), words.end());
  std::vector<char*> pointers;
  for (std::string& word : line) pointers.push_back(word.data());
  if (program.parse(static_cast<int>(pointers.size()), pointers.data()))
    throw Error(ExitCode::kUsage, "not an option of 'sheaf render'");
  // Read the scene and apply the options
  const AovSet aovs = wanted_aovs(arguments);
  Description scene = read_scene(arguments.scene, read_options(arguments.scene, arguments.read));
  std::vector<std::string> details;
  plan.crop = apply_arguments(arguments, scene, details);
  // Fill in the plan
  plan.integrator = scene.integrator.kind;
  const PhotonMappingSettings& photons = scene.integrator.photons;
  const bool maps = scene.integrator.traits().has_photon_maps();
  plan.samples = maps && photons.progressive && photons.max_passes > 0
                     ? rounded_sample_count(scene.sampler.kind, static_cast<std::uint32_t>(photons.max_passes))
                     : scene.sampler.sample_count;
  if (maps && photons.gathering == PhotonGathering::kFinal)
    plan.gather_rays = static_cast<std::uint32_t>(photons.gather_rays);
  plan.sets_given = arguments.replicates > 0;
  plan.sets = plan.sets_given ? static_cast<std::uint32_t>(arguments.replicates)
                              : default_replicates(scene.sampler.kind, std::uint64_t{plan.samples} * plan.gather_rays);
  if (aovs.contains(aov_named("variance")) || aovs.contains(aov_named("half"))) plan.sets = std::max(plan.sets, 2u);
  return plan;
}

}  // namespace sheaf
