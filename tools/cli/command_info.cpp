// sheaf info: contents and bounds of a scene file, and the memory for loading and rendering it; or the header of an
// OpenEXR file; or the formats of files that this build reads.
#include "core/image/exr.h"
#include "core/io/memory.h"
#include "kernels/render/render_memory.h"
#include "scene/compile/compile.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/native_color.h"
#include "scene/dialects/read_scene.h"
#include "tools/cli/commands.h"
#include "tools/cli/info_json.h"
#include "tools/console/standard_streams.h"
#include "tools/job/image_files.h"
#include "tools/job/interrupted_image.h"
#include "tools/job/read_options.h"
#include "tools/job/render_job.h"
#include "tools/options/option_groups.h"

#include <fmt/format.h>

#include <cstdio>
#include <iterator>
#include <memory>

namespace sheaf {

namespace {

struct InfoArguments {
  std::string scene;
  bool formats = false, json = false;
  ReadArguments read;
};

/// The settings of photon maps, starting with a comma.
std::string describe_photon_maps(const PhotonMappingSettings& photons) {
  std::string text = fmt::format(", {} photons", photons.global.count);
  if (photons.progressive) text += " per pass";
  if (photons.gathering == PhotonGathering::kIndirect) text += ", direct light by next-event estimation";
  if (photons.gathering == PhotonGathering::kFinal) text += ", final gathering";
  if (photons.gathering != PhotonGathering::kAll || photons.caustic.count > 0)
    text += fmt::format(", {} caustic photons", photons.caustic.count);
  if (photons.volume.count > 0)
    text += fmt::format(", {} volume photons{}", photons.volume.count,
                        photons.uses_beams() ? " as beams in homogeneous media" : "");
  return text;
}

std::string describe_integrator(const IntegratorSettings& integrator) {
  const IntegratorTraits& traits = integrator.traits();
  std::string text = integrator.name();
  if (traits.measures_visibility) return text + fmt::format(", within {} m", integrator.visibility_length);
  if (!traits.uses_lights()) return text;
  const std::string depth = integrator.max_depth < 0 ? "unlimited" : std::to_string(integrator.max_depth);
  if (traits.has_photon_maps()) return text + describe_photon_maps(integrator.photons) + ", max depth " + depth;
  if (traits.source == PathSource::kCamera)
    text += integrator.strategy == LightStrategy::kMis        ? ", multiple importance sampling"
            : integrator.strategy == LightStrategy::kBsdfOnly ? ", BSDF sampling only"
                                                              : ", light sampling only";
  return text + fmt::format(", max depth {}, roulette from depth {}{}", depth, integrator.roulette_depth(),
                            integrator.hide_emitters ? ", emitters hidden" : "");
}

/// `digits`: significant ones.
std::string describe(Vec3d v, int digits = 6) {
  return fmt::format("({:.{}g}, {:.{}g}, {:.{}g})", v.x, digits, v.y, digits, v.z, digits);
}

/// The location of each grid, and the environment map.
std::string describe(const CompileReport& report) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (const PlacedGrid& grid : report.grids) {
    const std::string name =
        grid.name.empty() ? fmt::format("of {}:{}", grid.where.file.string(), grid.where.line) : grid.name;
    if (grid.size[0] == 0) {
      fmt::format_to(out, "grid        {}: empty\n", name);
      continue;
    }
    fmt::format_to(out, "grid        {}: {} to {}, {} x {} x {} voxels{}, {:.3f} MB\n", name, describe(grid.box.min),
                   describe(grid.box.max), grid.size[0], grid.size[1], grid.size[2],
                   grid.channels == 1 ? "" : fmt::format(" of {} numbers", grid.channels),
                   static_cast<double>(grid.bytes) * 1e-6);
  }
  if (report.envmap_width > 0)
    fmt::format_to(out, "environment {} x {} pixels, {:.3f} MB\n", report.envmap_width, report.envmap_height,
                   static_cast<double>(report.envmap_bytes) * 1e-6);
  return text;
}

/// The cameras and animations to choose from, with their numbers.
std::string describe(const FileContents& contents) {
  std::string text;
  const auto out = std::back_inserter(text);
  if (!contents.has_camera)
    fmt::format_to(out, "camera      {}\n", contents.model_bounds ? "none, placed automatically" : "none");
  for (std::size_t i = 0; i < contents.cameras.size(); ++i)
    fmt::format_to(out, "camera      {}: {}\n", i, contents.cameras[i].empty() ? "(no name)" : contents.cameras[i]);
  for (std::size_t i = 0; i < contents.animations.size(); ++i) {
    const auto& [name, times] = contents.animations[i];
    fmt::format_to(out, "animation   {}: {}", i, name.empty() ? "(no name)" : name);
    text += times ? fmt::format(", {:.6g} to {:.6g} s\n", (*times)[0], (*times)[1]) : "\n";
  }
  return text;
}

/// Rays of `sheaf render` without options; infinity if it cannot render the scene. They affect the BVH.
double rays_of_render(const Description& description) {
  try {
    SettingsRemarks remarks;
    return expected_rays(resolve_settings(RenderArguments(), description, remarks));
  } catch (const Error&) { return kInfinity; }
}

/// Peak memory of the program so far, and the expected peak of rendering the scene.
std::string describe_peaks(const Scene& scene) {
  const double now = resident_memory();
  const std::string loading = format_bytes(static_cast<double>(peak_rss_bytes()));
  std::vector<MemoryUse> uses;
  try {
    uses = render_memory(scene, resolve_settings(scene), {});
  } catch (const Error& error) {
    return fmt::format("peak        {} while loading; the scene cannot be rendered: {}\n", loading, error.what());
  }
  double rendering = 0;
  std::string parts;
  for (const MemoryUse& use : uses) {
    rendering += use.bytes;
    parts += fmt::format(", {} for {}", format_bytes(use.bytes), use.what);
  }
  return fmt::format("peak        {} while loading; {} while rendering (estimate): {} for the loaded scene{}\n",
                     loading, format_bytes(now + rendering), format_bytes(now), parts);
}

std::string describe(const Description& description, const FileContents& contents, const Scene& scene,
                     const CompileReport& report) {
  const SceneInfo info = scene.info();
  const FilmSettings& film = description.film;
  std::string text;
  const auto out = std::back_inserter(text);
  const auto megabytes = [](std::size_t bytes) { return static_cast<double>(bytes) * 1e-6; };
  // Describe the settings
  fmt::format_to(out, "file        {}\n", description.file.string());
  fmt::format_to(out, "film        {} x {} pixels", film.width, film.height);
  if (film.crop) {
    fmt::format_to(out, ", crop {},{},{},{}", film.crop->x0, film.crop->y0, film.crop->x1, film.crop->y1);
  }
  const SamplerSettings& sampler = description.sampler;
  const SamplerKind rendered = rendered_sampler(sampler.kind);
  fmt::format_to(out, "\nsampler     {}{}, {} samples per pixel, seed {}\n", kSamplers.name_of(rendered),
                 rendered == sampler.kind ? "" : fmt::format(" for {}", kSamplers.name_of(sampler.kind)),
                 sampler.sample_count, sampler.seed);
  fmt::format_to(out, "integrator  {}\n", describe_integrator(description.integrator));
  // Describe the contents
  fmt::format_to(out, "shapes      {} ({} triangles, {} vertices, {} quadrics)\n", info.shapes, info.triangles,
                 info.vertices, info.quadrics);
  if (info.curve_segments > 0) fmt::format_to(out, "curves      {} segments\n", info.curve_segments);
  if (info.sdf_cells > 0) fmt::format_to(out, "sdf grids   {} cells with a surface\n", info.sdf_cells);
  if (info.groups > 0) {
    fmt::format_to(out, "instances   {} of {} group{} ({} triangles)\n", info.instances, info.groups,
                   info.groups == 1 ? "" : "s", info.instanced_triangles);
  }
  fmt::format_to(out, "materials   {}\n", info.materials);
  if (!description.media.empty()) fmt::format_to(out, "media       {}\n", description.media.size());
  fmt::format_to(out, "lights      {}\n", info.lights);
  text += describe(contents);
  if (info.shapes > 0) {
    const int digits = scene.origin() == Vec3d() ? 6 : 12;
    const auto bounds = contents.model_bounds.value_or(std::array<Vec3d, 2>{info.bounds_min, info.bounds_max});
    fmt::format_to(out, "bounds      {} to {}{}\n", describe(bounds[0], digits), describe(bounds[1], digits),
                   contents.model_bounds ? " (of the model alone)" : "");
  }
  // Describe memory and messages
  text += describe(report);
  fmt::format_to(out, "memory      {:.3f} MB of tables, {:.3f} MB of acceleration structure\n",
                 megabytes(info.table_bytes), megabytes(info.accel_bytes));
  text += describe_peaks(scene);
  for (const std::string& note : description.notes) fmt::format_to(out, "note        {}\n", note);
  for (const std::string& substitute : description.substitutions) fmt::format_to(out, "warning     {}\n", substitute);
  for (const std::string& warning : scene.warnings()) fmt::format_to(out, "warning     {}\n", warning);
  return text;
}

/// Object names of a Cryptomatte manifest: the strings before colons.
std::vector<std::string> manifest_names(const std::string& manifest) {
  std::vector<std::string> names;
  std::string word;
  bool inside = false;
  for (std::size_t i = 0; i < manifest.size(); ++i) {
    const char c = manifest[i];
    if (inside && c == '\\' && i + 1 < manifest.size()) {
      word += manifest[++i];
    } else if (c == '"') {
      inside = !inside;
      if (inside) word.clear();
    } else if (inside) {
      word += c;
    } else if (c == ':') {
      names.push_back(word);
    }
  }
  return names;
}

std::string describe(const ExrHeader& header, const std::string& file) {
  std::string text;
  const auto out = std::back_inserter(text);
  const auto window = [&](const PixelRect& r) { return fmt::format("{},{},{},{}", r.x0, r.y0, r.x1, r.y1); };
  fmt::format_to(out, "file        {}\n", file);
  fmt::format_to(out, "image       {} x {} pixels, {} channels\n", header.window.width(), header.window.height(),
                 header.channels.size());
  if (const std::string interrupted = interruption(header.attributes); !interrupted.empty())
    fmt::format_to(out, "warning     {}\n", interrupted);
  fmt::format_to(out, "windows     data {}, display {}\n", window(header.window), window(header.frame));
  for (const ExrHeader::Channel& channel : header.channels)
    fmt::format_to(out, "channel     {} ({})\n", channel.name, channel.type);
  for (const ExrMetadata::Attribute& attribute : header.attributes) {
    const auto* words = std::get_if<std::string>(&attribute.value);
    const bool manifest = attribute.name.starts_with("cryptomatte/") && attribute.name.ends_with("/manifest");
    // Cryptomatte: the names of the manifest
    if (manifest && words != nullptr) {
      const std::vector<std::string> names = manifest_names(*words);
      fmt::format_to(out, "names       {}: {} entries\n", attribute.name, names.size());
      for (const std::string& name : names) fmt::format_to(out, "name        {}\n", name);
      continue;
    }
    // Attributes for merging parts: settings line by line, and the number of ids.
    if (words != nullptr && attribute.name == "sheaf/settings") {
      for (std::size_t at = 0; at < words->size(); at = std::min(words->find('\n', at), words->size()) + 1)
        fmt::format_to(out, "setting     {}\n", words->substr(at, words->find('\n', at) - at));
      continue;
    }
    if (words != nullptr && attribute.name.starts_with("sheaf/ids/")) {
      fmt::format_to(out, "ids         {}: {} entries\n", attribute.name, words->size() / 8);
      continue;
    }
    fmt::format_to(out, "attribute   {} = ", attribute.name);
    std::visit([&](const auto& value) { fmt::format_to(out, "{}\n", value); }, attribute.value);
  }
  return text;
}

}  // namespace

void add_info_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<InfoArguments>();
  Command command =
      program.add_command("info",
                          "Print the contents and bounds of a scene file, its cameras and animations, the bounds of "
                          "its grids, and the memory for loading and rendering it; or print the header of an OpenEXR "
                          "file.");
  command.add_option("scene", arguments->scene, "Scene file, or image (.exr); - reads a scene from the standard input")
      .file();
  command.begin_group(kOutputOptions);
  command.add_flag("--formats", arguments->formats, "Print the file formats that this build reads and writes");
  command.add_flag("--json", arguments->json, "Print the same as JSON");
  add_read_options(command, arguments->read);
  command.on_call([arguments, &exit_code] {
    exit_code = 0;
    if (arguments->formats == !arguments->scene.empty())
      throw Error(ExitCode::kUsage, arguments->formats ? "--formats takes no scene" : "scene is required");
    if (arguments->formats) {
      const std::vector<ListedFormat> formats = file_formats();
      std::fputs((arguments->json ? info_json(formats) : describe(formats)).c_str(), stdout);
      return;
    }
    StandardStreams streams;
    arguments->scene = streams.read_scene(arguments->scene);
    arguments->read.from_working_folder = streams.has_scene();
    if (extension_of(arguments->scene) == ".exr") check_is_exr(arguments->scene);
    if (std::filesystem::is_regular_file(arguments->scene) && is_exr(arguments->scene)) {
      const ExrHeader header = read_exr_header(arguments->scene);
      const std::string text =
          arguments->json ? info_json(header, arguments->scene) : printable(describe(header, arguments->scene));
      std::fputs(text.c_str(), stdout);
      return;
    }
    FileContents contents;
    ReadOptions reading = read_options(arguments->scene, arguments->read);
    reading.contents = &contents;
    reading.surroundings.default_studio = Studio::kNone;  // count what the file has
    Description description = read_scene(arguments->scene, reading);
    CompileReport report;
    CompileOptions options;
    options.report = &report;
    options.color = native_color(arguments->scene);
    options.expected_rays = rays_of_render(description);
    ErrorSink errors(arguments->read.lenient, description.substitutions);
    options.errors = &errors;
    const std::unique_ptr<Scene> scene = compile_scene(description, options);
    const std::string text = arguments->json ? info_json(description, contents, *scene, report)
                                             : printable(describe(description, contents, *scene, report));
    std::fputs(text.c_str(), stdout);
  });
}

}  // namespace sheaf
