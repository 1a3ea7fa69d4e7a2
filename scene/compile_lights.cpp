// Lights as rows of tables: what shapes, media and the description's own lights emit, and the tables that choose among
// them.
#include "scene/compile_materials.h"
#include "scene/compile_media.h"
#include "scene/light_bounds.h"
#include "scene/scene_compiler.h"

#include <algorithm>

namespace sheaf {

SpectrumRow SceneCompiler::emission_row(const SpectrumInput& emission, const SourceLocation& where) {
  if (!spectra_) return {};
  const auto* spectrum = std::get_if<SpectrumDescription>(&emission);
  try {
    return spectra_->row(spectrum != nullptr ? *spectrum : SpectrumDescription::constant(1), SpectrumUse::kIlluminant);
  } catch (const SceneError& error) { throw SceneError(where, error.what()); }
}

std::optional<AreaEmission> SceneCompiler::emission_of(const ShapeDescription& shape) {
  if (!shape.radiance) return std::nullopt;
  if (const auto* texture = std::get_if<TextureId>(&*shape.radiance))
    return AreaEmission{{1, 1, 1}, texture_row(*texture, shape.where), emission_row(*texture, shape.where)};
  const Vec3f radiance = emission_rgb(std::get<SpectrumDescription>(*shape.radiance));
  if (!(max_component(radiance) > 0.0f)) return std::nullopt;
  return AreaEmission{radiance, kNone, emission_row(*shape.radiance, shape.where)};
}

std::uint32_t SceneCompiler::texture_row(TextureId id, const SourceLocation& where) const {
  if (static_cast<std::size_t>(id) >= in_.textures.size())
    throw SceneError(where, "refers to a texture that does not exist");
  return static_cast<std::uint32_t>(id);
}

void SceneCompiler::add_area_light(const ShapeRow& row, const Emitter& emitter, const InstanceRow* instance) {
  const ShapeTables tables{out_->vertices_.data(), out_->triangles_.data(), out_->quadrics_.data()};
  LightPlaces places{static_cast<std::uint32_t>(out_->triangle_alias_.size()),
                     static_cast<std::uint32_t>(out_->light_uvs_.size()), row.first_triangle};
  if (instance != nullptr) places.quadric = static_cast<std::uint32_t>(out_->quadrics_.size());
  AreaLight light = make_area_light(row, emitter.shape, tables, emitter.emission, places, instance);
  constexpr std::size_t kRowWords = sizeof(LightTriangleRow) / sizeof(float);
  if (kRowWords * (out_->light_triangles_.size() + light.triangles.size()) > kMaxWords)
    throw SceneError("the lights have more than " + std::to_string(kMaxWords / kRowWords) + " triangles in all");
  out_->lights_.push_back(light.row);
  out_->light_spectra_.push_back(emitter.emission.spectrum);
  out_->has_textured_lights_ = out_->has_textured_lights_ || light.row.texture != kNone;
  out_->triangle_alias_.insert(out_->triangle_alias_.end(), light.alias.begin(), light.alias.end());
  out_->light_triangles_.insert(out_->light_triangles_.end(), light.triangles.begin(), light.triangles.end());
  out_->light_uvs_.insert(out_->light_uvs_.end(), light.uvs.begin(), light.uvs.end());
  if (light.quadric) out_->quadrics_.push_back(*light.quadric);
}

void SceneCompiler::add_volume_lights() {
  if (in_.integrator.strategy == LightStrategy::kBsdfOnly ||
      in_.integrator.medium_estimator == MediumEstimator::kMarching)
    return;
  for (std::uint32_t i = 0; i < out_->media_.size(); ++i) {
    const auto first_cell = static_cast<std::uint32_t>(out_->triangle_alias_.size());
    const auto light = make_volume_light(out_->view(), i, medium_boxes_[i], first_cell);
    if (!light) continue;
    out_->media_[i].light = static_cast<std::uint32_t>(out_->lights_.size());
    out_->lights_.push_back(light->row);
    out_->light_spectra_.emplace_back();
    out_->triangle_alias_.insert(out_->triangle_alias_.end(), light->alias.begin(), light->alias.end());
  }
}

void SceneCompiler::add_lights() {
  std::vector<std::pair<PlacedLight, SourceLocation>> placed;
  for (const LightDescription& light : in_.lights)
    if (auto row = place_light(light)) {
      row->spectrum = spectrum_of(light);
      placed.emplace_back(std::move(*row), light.where);
    }
  for (const bool infinite : {false, true}) {
    for (const auto& [light, where] : placed)
      if (is_infinite(light.row) == infinite) push_light(light, where);
    if (!infinite) add_volume_lights();
    if (!infinite) out_->bounded_light_count_ = static_cast<std::uint32_t>(out_->lights_.size());
  }
  out_->counts_.lights = out_->lights_.size();
}

void SceneCompiler::push_light(PlacedLight light, const SourceLocation& where) {
  const Vec3f emitted{light.row.radiance[0], light.row.radiance[1], light.row.radiance[2]};
  if (!(max_component(emitted) > 0.0f)) return;
  const auto kind = static_cast<LightKind>(light.row.kind);
  if (kind == LightKind::kConstant || kind == LightKind::kEnvmap) {
    if (out_->environment_ != kNone) throw SceneError(where, "a scene may have only one environment light");
    out_->environment_ = static_cast<std::uint32_t>(out_->lights_.size());
  }
  if (light.frame) {
    light.row.detail = static_cast<std::uint32_t>(out_->light_frames_.size());
    out_->light_frames_.push_back(*light.frame);
  }
  out_->lights_.push_back(light.row);
  out_->light_spectra_.push_back(light.spectrum);
}

SpectrumRow SceneCompiler::spectrum_of(const LightDescription& light) {
  return std::visit(Overloaded{
                        [&](const PointLightDescription& l) { return emission_row(l.intensity, light.where); },
                        [&](const ConstantLightDescription& l) { return emission_row(l.radiance, light.where); },
                        [&](const SpotLightDescription& l) { return emission_row(l.intensity, light.where); },
                        [&](const DirectionalLightDescription& l) { return emission_row(l.irradiance, light.where); },
                        [&](const ProjectorDescription& l) {
                          SpectrumRow row = emission_row(l.irradiance, light.where);
                          row.scale *= kPi * l.scale;
                          return row;
                        },
                        [&](const EnvmapDescription&) {
                          return emission_row(SpectrumDescription::constant(1), light.where);
                        },
                    },
                    light.model);
}

std::optional<PlacedLight> SceneCompiler::place_light(const LightDescription& light) {
  using Placed = std::optional<PlacedLight>;
  const SourceLocation& where = light.where;
  return std::visit(Overloaded{
                        [&](const PointLightDescription& l) -> Placed {
                          return make_point_light(emission_rgb(l.intensity), l.position);
                        },
                        [&](const ConstantLightDescription& l) -> Placed {
                          return make_constant_light(emission_rgb(l.radiance));
                        },
                        [&](const SpotLightDescription& l) -> Placed {
                          if (l.texture) texture_row(*l.texture, where);
                          return make_spot_light(l, where);
                        },
                        [&](const DirectionalLightDescription& l) -> Placed {
                          return make_directional_light(l, where);
                        },
                        [&](const ProjectorDescription& l) -> Placed { return place_projector(l, where); },
                        [&](const EnvmapDescription& l) -> Placed { return place_envmap(l, where); },
                    },
                    light.model);
}

PlacedLight SceneCompiler::place_projector(const ProjectorDescription& light, const SourceLocation& where) const {
  double aspect = 1;
  if (const auto* id = std::get_if<TextureId>(&light.irradiance)) {
    const TextureRow& row = out_->textures_.rows[texture_row(*id, where)];
    if (row.kind == TextureKind::kBitmap) aspect = double(row.bitmap.width) / row.bitmap.height;
  }
  return make_projector(light, aspect, where);
}

std::optional<PlacedLight> SceneCompiler::place_envmap(const EnvmapDescription& light, const SourceLocation& where) {
  const EnvmapPicture picture = read_envmap_picture(light.file);
  if (const std::size_t bad = count_unusable(picture); bad > 0)
    out_->warnings_.push_back(light.file.string() + ": " + std::to_string(bad) +
                              " values that are negative or not finite count as 0");
  // Without BSDF sampling what is not sampled would be lost.
  const bool compensate = light.mis_compensation && in_.integrator.strategy == LightStrategy::kMis;
  Envmap map = make_envmap(picture, light.scale, compensate);
  set_rotation(map, light.to_world, where);
  if (!(max_component(map.mean) > 0.0f)) {
    out_->warnings_.push_back(light.file.string() + ": the environment map is black");
    return std::nullopt;
  }
  if (out_->color_ == ColorMode::kSpectral) uplift_nodes(map);
  const PlacedLight placed = make_envmap_light(map);
  if (out_->environment_ == kNone) out_->envmap_ = std::move(map);
  return placed;
}

void SceneCompiler::select_lights() {
  const SceneView view = out_->view();
  std::vector<float> weights;
  for (std::uint32_t i = 0; i < view.light_count; ++i) {
    const Vec3f power = light_power(view, i);
    out_->light_powers_.push_back(power);
    // Much of what an environment sends through the bounding sphere meets nothing: at its full power it would take
    // the samples of lights inside.
    constexpr double kEnvironmentShare = 0.25;
    const double share = i == view.environment ? kEnvironmentShare : 1.0;
    const double mean = (double(power.x) + power.y + power.z) / 3.0 * share;
    // Weights must be positive and finite however large the light.
    weights.push_back(static_cast<float>(std::clamp(mean, 1e-30, 1e30)));
  }
  if (weights.empty()) return;
  out_->light_alias_ = build_alias_table(weights);
  std::vector<LightBounds> bounds;
  for (std::uint32_t i = 0; i < view.bounded_light_count; ++i) bounds.push_back(bounds_of_light(view, i, weights[i]));
  out_->light_tree_ = build_light_tree(bounds);
}

}  // namespace sheaf
