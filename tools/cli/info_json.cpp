#include "tools/cli/info_json.h"

#include "core/io/memory.h"
#include "core/io/version.h"
#include "kernels/render/render_memory.h"
#include "scene/dialects/common/setting_names.h"

#include <nlohmann/json.hpp>

namespace sheaf {

namespace {

using InfoJson = nlohmann::ordered_json;

InfoJson vector_json(Vec3f v) { return {v.x, v.y, v.z}; }
/// With few digits if the numbers are those of floats.
InfoJson vector_json(Vec3d v) { return Vec3d(v.rounded()) == v ? vector_json(v.rounded()) : InfoJson{v.x, v.y, v.z}; }

InfoJson rect_json(const PixelRect& r) { return {r.x0, r.y0, r.x1, r.y1}; }

std::string text_of(const InfoJson& json) {
  return json.dump(2, ' ', false, InfoJson::error_handler_t::replace) + "\n";
}

InfoJson grids_json(const CompileReport& report) {
  InfoJson grids = InfoJson::array();
  for (const PlacedGrid& grid : report.grids)
    grids.push_back({{"name", grid.name},
                     {"where", fmt::format("{}:{}", grid.where.file.string(), grid.where.line)},
                     {"min", vector_json(grid.box.min)},
                     {"max", vector_json(grid.box.max)},
                     {"size", grid.size},
                     {"channels", grid.channels},
                     {"bytes", grid.bytes}});
  return grids;
}

InfoJson animations_json(const FileContents& contents) {
  InfoJson animations = InfoJson::array();
  for (const auto& [name, times] : contents.animations)
    animations.push_back({{"name", name},
                          {"start", times ? InfoJson((*times)[0]) : InfoJson()},
                          {"end", times ? InfoJson((*times)[1]) : InfoJson()}});
  return animations;
}

/// The memory that rendering adds to the loaded scene, in bytes by purpose.
InfoJson rendering_json(const Scene& scene) {
  InfoJson json;
  try {
    for (const MemoryUse& use : render_memory(scene, resolve_settings(scene), {})) json[use.what] = use.bytes;
  } catch (const Error&) { return {}; }
  return json;
}

}  // namespace

std::string info_json(const Description& description, const FileContents& contents, const Scene& scene,
                      const CompileReport& report) {
  const SceneInfo info = scene.info();
  const FilmSettings& film = description.film;
  const SamplerSettings& sampler = description.sampler;
  // Describe the settings
  InfoJson json{{"file", description.file.string()},
                {"width", film.width},
                {"height", film.height},
                {"crop", film.crop ? rect_json(*film.crop) : InfoJson()},
                {"sampler", kSamplers.name_of(sampler.kind)},
                {"rendered_sampler", kSamplers.name_of(rendered_sampler(sampler.kind))},
                {"spp", sampler.sample_count},
                {"seed", sampler.seed},
                {"integrator", description.integrator.name()},
                {"max_depth", description.integrator.max_depth}};
  // Describe the contents
  json.update({{"shapes", info.shapes},
               {"triangles", info.triangles},
               {"vertices", info.vertices},
               {"quadrics", info.quadrics},
               {"curve_segments", info.curve_segments},
               {"sdf_cells", info.sdf_cells},
               {"groups", info.groups},
               {"instances", info.instances},
               {"instanced_triangles", info.instanced_triangles},
               {"materials", info.materials},
               {"media", description.media.size()},
               {"lights", info.lights}});
  json["cameras"] = contents.has_camera ? InfoJson(contents.cameras) : InfoJson();
  json["animations"] = animations_json(contents);
  const auto bounds = contents.model_bounds.value_or(std::array<Vec3d, 2>{info.bounds_min, info.bounds_max});
  const bool has_bounds = info.shapes > 0;
  json["bounds"] = has_bounds ? InfoJson{{"min", vector_json(bounds[0])}, {"max", vector_json(bounds[1])}} : InfoJson();
  json["grids"] = grids_json(report);
  json["environment"] = {{"width", report.envmap_width}, {"height", report.envmap_height}};
  // Describe memory and messages
  json["memory"] = {{"tables", info.table_bytes},
                    {"acceleration_structure", info.accel_bytes},
                    {"environment", report.envmap_bytes},
                    {"textures", report.texture_bytes},
                    {"peak_while_loading", peak_rss_bytes()},
                    {"loaded", resident_memory()},
                    {"rendering", rendering_json(scene)}};
  InfoJson files = InfoJson::array(), warnings = InfoJson::array();
  for (const std::filesystem::path& file : description.files) files.push_back(file.string());
  for (const std::string& substitute : description.substitutions) warnings.push_back(substitute);
  for (const std::string& warning : scene.warnings()) warnings.push_back(warning);
  json.update({{"files", files}, {"notes", description.notes}, {"warnings", warnings}});
  return text_of(json);
}

std::string info_json(const ExrHeader& header, const std::string& file) {
  InfoJson channels = InfoJson::array(), attributes = InfoJson::object();
  for (const ExrHeader::Channel& channel : header.channels)
    channels.push_back({{"name", channel.name}, {"type", channel.type}});
  for (const ExrMetadata::Attribute& attribute : header.attributes)
    std::visit([&](const auto& value) { attributes[attribute.name] = value; }, attribute.value);
  return text_of({{"file", file},
                  {"width", header.window.width()},
                  {"height", header.window.height()},
                  {"data_window", rect_json(header.window)},
                  {"display_window", rect_json(header.frame)},
                  {"channels", channels},
                  {"attributes", attributes}});
}

std::string info_json(const std::vector<ListedFormat>& formats) {
  InfoJson list = InfoJson::array();
  for (const ListedFormat& format : formats)
    list.push_back({{"kind", format.kind},
                    {"name", format.name},
                    {"extensions", format.extensions},
                    {"written", format.is_written},
                    {"reader", format.reader.empty() ? "sheaf" : format.reader},
                    {"available", format.is_available}});
  return text_of({{"version", kSheafVersion}, {"formats", list}});
}

}  // namespace sheaf
