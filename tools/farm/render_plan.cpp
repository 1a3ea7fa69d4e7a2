#include "tools/farm/render_plan.h"

#include "core/io/error.h"
#include "scene/dialects/read_model.h"
#include "scene/dialects/read_scene.h"
#include "tools/job/render_job.h"

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
  std::vector<std::string> line{"render"};
  line.insert(line.end(), words.begin(), words.end());
  program.parse(line);
  // Read the scene and apply the options
  LoadedScene loaded;
  loaded.description = read_scene(arguments.scene, read_options(arguments));
  if (has_studio(loaded.description) && arguments.output.exposure.empty())
    plan.output_options.emplace_back("exposure", "auto");
  prepare(arguments, loaded);
  plan.settings = loaded.settings;
  return plan;
}

}  // namespace sheaf
