// Compiles lights: area lights, volume lights and the description's own lights, and the tables for light selection.
#include "scene/compile/scene_compiler.h"
#include "scene/lights/light_bounds.h"
#include "scene/lights/light_powers.h"
#include "scene/spectra/spectrum_rgb.h"

#include <algorithm>

namespace sheaf {

LightContext SceneCompiler::light_context() {
  return {in_.integrator,
          std::span(out_->textures_.rows).first(in_.textures.size()),
          spectra(),
          out_->lights_.envmap,
          out_->lights_.frames,
          out_->warnings_};
}

std::optional<AreaEmission> SceneCompiler::emission_of(const ShapeDescription& shape) {
  if (!shape.radiance) return std::nullopt;
  const LightContext context = light_context();
  const auto* spectrum = std::get_if<SpectrumDescription>(&*shape.radiance);
  const Vec3f radiance = spectrum != nullptr ? emission_rgb(*spectrum) : Vec3f{1, 1, 1};
  if (!(max_component(radiance) > 0.0f)) return std::nullopt;
  const std::optional<TextureId> texture = emission_texture_of(shape);
  return AreaEmission{radiance,
                      texture ? context.texture_row(*texture, shape.where) : kNone,
                      context.emission_row(*shape.radiance, shape.where),
                      shape.emits_along_normal,
                      shape.emits_on_both_sides,
                      !shape.is_visible,
                      coat_of(shape),
                      shape.power};
}

LightCoatRow SceneCompiler::coat_of(const ShapeDescription& shape) {
  if (const float* strength = std::get_if<float>(&shape.emission_coat))
    return {std::clamp(*strength, 0.0f, 1.0f), kNone};
  return {0, light_context().texture_row(std::get<TextureId>(shape.emission_coat), shape.where)};
}

std::optional<TextureId> SceneCompiler::emission_texture_of(const ShapeDescription& shape) {
  if (!shape.radiance) return std::nullopt;
  const auto* texture = std::get_if<TextureId>(&*shape.radiance);
  return texture != nullptr ? std::optional(*texture) : shape.radiance_scale;
}

void SceneCompiler::add_area_light(const ShapeRow& row, const Emitter& emitter, const LightInstance* instance) {
  const ShapeTables tables{out_->geometry_.vertices.data(), out_->geometry_.triangles.data(),
                           out_->geometry_.quadrics.data(), out_->motion_.view().deformations};
  // Build the light
  LightPlaces places{static_cast<std::uint32_t>(out_->lights_.triangle_alias.size()),
                     static_cast<std::uint32_t>(out_->lights_.uvs.size()), row.first_triangle};
  if (instance != nullptr) places.quadric = static_cast<std::uint32_t>(out_->geometry_.quadrics.size());
  AreaLight light = make_area_light(row, emitter.shape, tables, emitter.emission, places, instance);
  constexpr std::size_t kRowWords = sizeof(LightTriangleRow) / sizeof(float);
  if (kRowWords * (out_->lights_.triangles.size() + light.triangles.size()) > kMaxWords)
    throw SceneError("the lights have more than " + std::to_string(kMaxWords / kRowWords) + " triangles in all");
  // Scale it to the given power
  SpectrumRow spectrum = emitter.emission.spectrum;
  if (emitter.emission.power) {
    const float factor = *emitter.emission.power / (exitance_factor(light.row) * light.area);
    light.row.radiance = light.row.radiance * factor;
    spectrum.scale *= factor;
  }
  // Append its rows
  if (const LightCoatRow& coat = emitter.emission.coat; coat.strength > 0 || coat.texture != kNone) {
    out_->lights_.coats.push_back(coat);
    if (out_->lights_.coats.size() >= std::size_t(1) << (32 - kLightCoatShift))
      throw SceneError("too many emitting shapes with a clearcoat");
    light.row.flags |= static_cast<std::uint32_t>(out_->lights_.coats.size()) << kLightCoatShift;
  }
  add_light_row(light.row, spectrum, emitter.where, emitter.name);
  out_->lights_.has_textured_area_lights = out_->lights_.has_textured_area_lights || light.row.needs_texture_query();
  out_->lights_.triangle_alias.insert(out_->lights_.triangle_alias.end(), light.alias.begin(), light.alias.end());
  out_->lights_.triangles.insert(out_->lights_.triangles.end(), light.triangles.begin(), light.triangles.end());
  out_->lights_.uvs.insert(out_->lights_.uvs.end(), light.uvs.begin(), light.uvs.end());
  if (light.quadric) out_->geometry_.quadrics.push_back(*light.quadric);
}

void SceneCompiler::add_volume_lights() {
  if (in_.integrator.strategy == LightStrategy::kBsdfOnly ||
      in_.integrator.medium_estimator == MediumEstimator::kMarching)
    return;
  for (std::uint32_t i = 0; i < out_->media_.rows.size(); ++i) {
    const auto first_cell = static_cast<std::uint32_t>(out_->lights_.triangle_alias.size());
    const auto light = make_volume_light(out_->make_view(), i, medium_boxes_[i], first_cell);
    if (!light) continue;
    out_->media_.rows[i].light = static_cast<std::uint32_t>(out_->lights_.rows.size());
    add_light_row(light->row, {}, {}, in_.media.at(i).id);
    if (medium_motions_[i].segment_count > 0) {
      out_->motion_.lights.resize(out_->lights_.rows.size() - 1);
      out_->motion_.lights.push_back(medium_motions_[i]);
    }
    out_->lights_.triangle_alias.insert(out_->lights_.triangle_alias.end(), light->alias.begin(), light->alias.end());
  }
}

void SceneCompiler::add_lights() {
  LightContext context = light_context();
  std::vector<std::pair<CompiledLight, const LightDescription*>> placed;
  for (const LightDescription& light : in_.lights) {
    try {
      auto row = compile_light(light, context);
      // A black environment lights nothing, but it is what camera rays see.
      if (LightKinds::is_environment(light.model) && !(row && max_component(emitted_rgb(row->row)) > 0.0f))
        out_->lights_.has_black_environment = true;
      if (row) placed.emplace_back(*row, &light);
    } catch (const SceneError& error) { throw at_place(light.where, error); }
  }
  for (const bool infinite : {false, true}) {
    for (const auto& [light, from] : placed)
      if (is_infinite(light.row) == infinite) push_light(light, *from);
    if (!infinite) add_volume_lights();
    if (!infinite) out_->lights_.bounded_count = static_cast<std::uint32_t>(out_->lights_.rows.size());
  }
  out_->counts_.lights = out_->lights_.rows.size();
}

void SceneCompiler::push_light(const CompiledLight& light, const LightDescription& from) {
  if (!(max_component(emitted_rgb(light.row)) > 0.0f)) return;
  if (light_compiler_of(light.row).domain == LightDomain::kEnvironment) {
    if (out_->lights_.environment != kNone) throw SceneError(from.where, "a scene may have only one environment light");
    out_->lights_.environment = static_cast<std::uint32_t>(out_->lights_.rows.size());
  }
  add_light_row(light.row, light.spectrum, from.where, from.id);
  if (from.motion) move_last_light(*from.motion);
}

void SceneCompiler::add_light_row(const LightRow& row, const SpectrumRow& spectrum, const SourceLocation& where,
                                  const std::string& name) {
  out_->lights_.rows.push_back(row);
  naming_.add_light(light_compiler_of(row).label, name);
  out_->spectra_.lights.push_back(spectrum);
  if (out_->lights_.source_locations.size() < kMaxReportedLights) out_->lights_.source_locations.push_back(where);
}

void SceneCompiler::select_lights() {
  const SceneView view = out_->make_view();
  std::vector<float> weights;
  out_->lights_.powers = light_powers(view);
  for (std::uint32_t i = 0; i < view.lights.count; ++i) {
    const Vec3f power = out_->lights_.powers[i];
    // Much of an environment's light passes the bounding sphere without hitting anything. With its full power it would
    // take samples from lights inside.
    constexpr double kEnvironmentShare = 0.25;
    const double share = i == view.lights.environment ? kEnvironmentShare : 1.0;
    const double mean = (double(power.x) + power.y + power.z) / 3.0 * share;
    // Weights must be positive and finite for lights of any power.
    weights.push_back(static_cast<float>(std::clamp(mean, 1e-30, 1e30)));
  }
  if (weights.empty()) return;
  out_->lights_.alias = build_alias_table(weights);
  std::vector<LightBounds> bounds;
  for (std::uint32_t i = 0; i < view.lights.bounded_count; ++i)
    bounds.push_back(moved_bounds(bounds_of_light(view, i, weights[i]), i));
  out_->lights_.tree = build_light_tree(bounds);
}

}  // namespace sheaf
