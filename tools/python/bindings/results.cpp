// Lists of options and plugins, and what programs do with rendered images.
#include "core/image/image_encoding.h"
#include "core/io/error.h"
#include "kernels/denoise/denoise.h"
#include "scene/dialects/read_scene.h"
#include "scene/xml/query_recorder.h"
#include "tools/job/image_files.h"
#include "tools/python/bindings/session.h"

#include <algorithm>
#include <set>

namespace sheaf {

namespace {

/// The options that `declare` adds to a command.
template <class Arguments, class Declare> std::vector<OptionHelp> declared_options(const Declare& declare) {
  Program program("sheaf", "");
  Arguments arguments;
  declare(program, arguments);
  std::vector<OptionHelp> options;
  for (const CommandHelp& command : program.help().commands)
    for (const OptionHelp& option : command.options)
      if (!option.is_argument && option.names.front() != "-h") options.push_back(option);
  return options;
}

/// Makes a function that declares the options of a part in a command of their own.
template <class Arguments> std::vector<OptionHelp> options_of(void (*add)(Command&, Arguments&)) {
  return declared_options<Arguments>([add](Program& program, Arguments& arguments) {
    Command command = program.add_command("options", "");
    command.begin_group(kAdvancedOptions);
    add(command, arguments);
  });
}

/// The arguments of a part with these values.
template <class Arguments> Arguments arguments_of(void (*add)(Command&, Arguments&), const OptionValues& values) {
  Program program("sheaf", "");
  Arguments arguments;
  Command command = program.add_command("options", "");
  add(command, arguments);
  command.set(values);
  return arguments;
}

OutputSettings output_settings(const RenderedImage& result, const OptionValues& values) {
  const auto arguments = arguments_of<OutputArguments>(add_output_options, values);
  OutputSettings settings = sheaf::output_settings(arguments);
  if (result.has_studio) set_model_defaults(arguments, settings);
  return settings;
}

/// An element with a plugin that does not exist.
XmlElement unknown_plugin(const char* element, const char* name = nullptr) {
  XmlElement made;
  made.name = element;
  made.attributes = {{"type", "?"}};
  if (name != nullptr) made.attributes.push_back({"name", name});
  return made;
}

XmlElement around(const char* element, const char* type, std::vector<XmlElement> children) {
  XmlElement made = unknown_plugin(element);
  made.attributes.front().value = type;
  made.children = std::move(children);
  return made;
}

}  // namespace

ReadOptions read_options(const std::string& file, const OptionValues& values) {
  return read_options(std::filesystem::path(file), arguments_of<ReadArguments>(add_read_options, values));
}

std::vector<OptionHelp> read_option_list() { return options_of<ReadArguments>(add_read_options); }

std::vector<OptionHelp> output_option_list() { return options_of<OutputArguments>(add_output_options); }

std::vector<OptionHelp> render_option_list() {
  std::set<std::string> others{"--output", "--format",  "--stats", "--frames",
                               "--fps",    "--verbose", "--quiet", "--skip-existing"};
  const auto exclude = [&others](const std::vector<OptionHelp>& options) {
    for (const OptionHelp& option : options) others.insert(option.names.back());
  };
  exclude(read_option_list());
  exclude(output_option_list());
  exclude(options_of<CheckpointArguments>(add_checkpoint_options));
  exclude(options_of<PreviewArguments>(add_preview_options));
  std::vector<OptionHelp> options = declared_options<RenderArguments>(
      [](Program& program, RenderArguments& arguments) { add_render_options(program, arguments); });
  std::erase_if(options, [&others](const OptionHelp& option) { return others.contains(option.names.back()); });
  return options;
}

std::map<std::string, std::vector<std::string>> plugin_names() {
  // A scene for each element, with the parents that readers expect
  const XmlElement sensor = around("sensor", "perspective", {});
  const auto in_sensor = [](XmlElement child) { return around("sensor", "perspective", {std::move(child)}); };
  std::vector<std::vector<XmlElement>> scenes;
  for (const char* element : {"bsdf", "emitter", "medium", "shape", "texture"})
    scenes.push_back({unknown_plugin(element)});
  scenes.push_back({sensor, unknown_plugin("integrator")});
  scenes.push_back({unknown_plugin("sensor")});
  scenes.push_back({in_sensor(unknown_plugin("film"))});
  scenes.push_back({in_sensor(unknown_plugin("sampler"))});
  scenes.push_back({in_sensor(around("film", "hdrfilm", {unknown_plugin("rfilter")}))});
  scenes.push_back({around("medium", "homogeneous", {unknown_plugin("phase")})});
  scenes.push_back({around("medium", "heterogeneous", {unknown_plugin("volume", "sigma_t")})});
  scenes.push_back({around("shape", "sphere", {unknown_plugin("subsurface")})});
  scenes.push_back({around("shape", "sphere", {unknown_plugin("emitter")})});
  scenes.push_back({around("bsdf", "diffuse", {unknown_plugin("spectrum", "reflectance")})});
  // Take the names from the errors
  std::map<std::string, std::set<std::string>> known{{"shape", {"mesh", "shapegroup", "instance"}}};
  for (std::vector<XmlElement>& children : scenes) {
    QueryRecorder recorder;
    XmlElement root;
    root.name = "scene";
    root.attributes = {{"version", "3.0.0"}};
    root.children = std::move(children);
    try {
      ExpandedScene scene(std::move(root), "");
      read_scene(scene, "", {});
    } catch (const Error&) {}  // expected
    for (const auto& [element, names] : recorder.plugins) known[element].insert(names.begin(), names.end());
  }
  std::map<std::string, std::vector<std::string>> out;
  for (const auto& [element, names] : known) out[element] = {names.begin(), names.end()};
  return out;
}

void write_result(const RenderedImage& result, const std::string& file, const OptionValues& options) {
  const OutputSettings settings = output_settings(result, options);
  check_image_name(file);
  std::optional<Image> displayed;
  std::optional<double> exposure;
  write_image(file, result.image, result.metadata, settings, [&]() -> const Image& {
    displayed = displayed_image(result.image, settings, exposure);
    return *displayed;
  });
}

std::vector<unsigned char> encode_png(const RenderedImage& result, const OptionValues& options) {
  std::optional<double> exposure;
  return encode_image(displayed_image(result.image, output_settings(result, options), exposure));
}

RenderedImage read_result(const std::string& file) {
  check_is_image(file);
  RenderedImage result;
  result.image = read_image(file);
  if (is_exr(file)) result.metadata = read_exr_metadata(file);
  return result;
}

RenderedImage merge_results(const std::vector<const RenderedImage*>& parts, const MergeOptions& options) {
  std::vector<MergeSource> sources;
  for (const RenderedImage* part : parts)
    sources.push_back({part_in_memory(fmt::format("part {}", sources.size() + 1), part->image, part->metadata),
                       [part] { return part->image; }});
  MergedImage merged = merge_parts(sources, options);
  RenderedImage result;
  result.image = std::move(merged.image);
  result.metadata = std::move(merged.metadata);
  result.interrupted = merged.interrupted;
  return result;
}

RenderedImage denoise_result(const RenderedImage& result, const std::string& method, int threads) {
  const Denoiser denoiser = kDenoisers.option("denoiser", method);
  check_denoiser(denoiser);
  RenderedImage out = result;
  DenoiseResult denoised = denoise(result.image, denoiser, threads);
  add_denoise_attribute(out.metadata, denoised);
  out.image = std::move(denoised.image);
  return out;
}

}  // namespace sheaf
