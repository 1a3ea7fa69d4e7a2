#include "scene/compile/compile_lights.h"

#include "scene/lights/area_light.h"
#include "scene/lights/light_bounds.h"
#include "scene/lights/light_context.h"
#include "scene/lights/light_powers.h"
#include "scene/spectra/spectrum_rgb.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// The texture of a shape's radiance, if it has one.
std::optional<TextureId> radiance_texture_of(const ShapeDescription& shape) {
  if (!shape.radiance) return std::nullopt;
  const auto* texture = std::get_if<TextureId>(&*shape.radiance);
  return texture != nullptr ? std::optional(*texture) : shape.radiance_scale;
}

/// Some of the steps of an instance, for the ray offsets of its lights.
std::vector<LightInstance::Step> steps_for_offsets(const std::vector<MotionStepRow>& steps) {
  constexpr std::size_t kParts = 8;
  std::vector<LightInstance::Step> out;
  const std::size_t segments = steps.size() - 1;
  for (std::size_t i = 0; i <= std::min(segments, kParts); ++i) {
    const std::size_t step = segments <= kParts ? i : i * segments / kParts, before = std::min(step, segments - 1);
    LightInstance::Step added{make_instance(std::to_array(steps[step].matrix), 0, 0), {}};
    for (std::size_t k = 0; k < 12; ++k)
      added.speed[k] = std::fabs(steps[before + 1].matrix[k] - steps[before].matrix[k]) * static_cast<float>(segments);
    out.push_back(added);
  }
  return out;
}

/// Adds lights to the tables, in order.
class LightTableBuilder {
 public:
  LightTableBuilder(const Description& description, const CompiledGeometry& geometry, const CompiledMedia& media,
                    SpectrumSet* set, MotionCompiler& motion, SceneNaming& naming, ErrorSink& errors,
                    SceneTables& scene)
      : in_(description),
        geometry_(geometry),
        media_(media),
        motion_(motion),
        naming_(naming),
        errors_(errors),
        scene_(scene),
        context_{scene.integrator,
                 std::span(scene.textures.rows).first(in_.textures.size()),
                 set,
                 out_.tables.envmap,
                 out_.tables.frames,
                 out_.warnings} {}

  CompiledLights run() {
    add_area_lights();
    const std::vector<PlacedLight> placed = place_lights();
    add_lights(placed, false);
    add_volume_lights();
    lights_.bounded_count = count();
    add_lights(placed, true);
    // Kernels read row zero in inactive lanes
    if (lights_.triangle_alias.empty()) lights_.triangle_alias.emplace_back();
    if (lights_.triangles.empty()) lights_.triangles.emplace_back();
    if (lights_.frames.empty()) lights_.frames.emplace_back();
    if (lights_.uvs.empty()) lights_.uvs.emplace_back();
    if (out_.spectra.empty()) out_.spectra.emplace_back();
    return std::move(out_);
  }

 private:
  /// A shape that emits light.
  struct Emitter {
    std::uint32_t shape;  ///< row
    AreaEmission emission;
  };
  /// A light of the description.
  struct PlacedLight {
    CompiledLight light;
    const LightDescription* from;
  };

  std::uint32_t count() const { return static_cast<std::uint32_t>(lights_.rows.size()); }

  /// The view of the scene with the lights that have been added.
  SceneView view() const {
    SceneView view = scene_.view();
    view.lights = lights_.view();
    return view;
  }

  void omit(const SourceLocation& where, const SceneError& error) {
    errors_.report(at_location(where, error), "light left out");
  }

  /// Emission of a shape; empty if it is black or cannot be compiled.
  std::optional<AreaEmission> emission_of(const ShapeDescription& shape) {
    if (!shape.radiance) return std::nullopt;
    try {
      return emission_of(shape, *shape.radiance);
    } catch (const SceneError& error) { omit(shape.where, error); }
    return std::nullopt;
  }

  std::optional<AreaEmission> emission_of(const ShapeDescription& shape, const SpectrumInput& from) const {
    const auto* spectrum = std::get_if<SpectrumDescription>(&from);
    const Vec3f radiance = spectrum != nullptr ? emission_rgb(*spectrum) : Vec3f{1, 1, 1};
    if (!(max_component(radiance) > 0.0f)) return std::nullopt;
    const std::optional<TextureId> texture = radiance_texture_of(shape);
    return AreaEmission{radiance,
                        texture ? context_.texture_row(*texture, shape.where) : kNone,
                        context_.emission_row(from, shape.where),
                        shape.emits_along_normal,
                        shape.emits_on_both_sides,
                        !shape.is_visible,
                        coat_of(shape),
                        shape.power};
  }

  /// The clearcoat over a shape's emission.
  LightCoatRow coat_of(const ShapeDescription& shape) const {
    if (const float* strength = std::get_if<float>(&shape.emission_coat))
      return {std::clamp(*strength, 0.0f, 1.0f), kNone};
    return {0, context_.texture_row(std::get<TextureId>(shape.emission_coat), shape.where)};
  }

  void add_area_lights() {
    std::vector<ShapeRow>& shapes = scene_.geometry.shapes;
    // Shapes outside of groups
    for (std::uint32_t shape = 0; shape < geometry_.ungrouped_shapes; ++shape)
      if (const auto emission = emission_of(*geometry_.sources[shape].shape)) {
        shapes[shape].light = count();
        add_area_light({shape, *emission}, nullptr);
      }
    // Collect those of groups
    std::vector<std::vector<Emitter>> emitters(geometry_.groups.size());
    for (std::size_t group = 0; group < emitters.size(); ++group) {
      const ShapeRange& range = geometry_.groups[group];
      for (std::uint32_t shape = range.first_shape; shape < range.first_shape + range.shape_count; ++shape)
        if (const auto emission = emission_of(*geometry_.sources[shape].shape)) {
          shapes[shape].light = static_cast<std::uint32_t>(emitters[group].size());
          emitters[group].push_back({shape, *emission});
        }
    }
    // Add them for each instance
    auto moving = geometry_.moving_instances.begin();
    for (std::uint32_t i = 0; i < scene_.geometry.instances.size(); ++i) {
      InstanceRow& instance = scene_.geometry.instances[i];
      instance.first_light = count();
      const bool moves = moving != geometry_.moving_instances.end() && moving->instance == i;
      if (const std::vector<Emitter>& of_group = emitters[instance.group]; !of_group.empty())
        add_instance_lights(instance, of_group, moves ? &*moving : nullptr);
      if (moves) ++moving;
    }
  }

  /// `moving`: the motion of the instance; null: it is static.
  void add_instance_lights(const InstanceRow& instance, const std::vector<Emitter>& emitters,
                           const MovingInstance* moving) {
    if (moving == nullptr) {
      const LightInstance placed{instance};
      for (const Emitter& emitter : emitters) add_area_light(emitter, &placed);
      return;
    }
    const MotionRow& motion = scene_.motion.instances[moving->instance];
    const auto first = scene_.motion.steps.begin() + motion.first_step;
    const std::vector<MotionStepRow> steps(first, first + motion.segment_count + 1);
    try {
      const LightInstance placed{make_instance(moving->rest, instance.first_shape, instance.group),
                                 steps_for_offsets(steps)};
      for (const Emitter& emitter : emitters) add_area_light(emitter, &placed);
      const MotionRow from_rest = motion_.add(steps_from_rest(steps, std::to_array(placed.rest.to_world)));
      for (std::uint32_t light = instance.first_light; light < count(); ++light)
        MotionCompiler::set(motion_.tables().lights, light, from_rest);
    } catch (const SceneError& error) { omit(geometry_.sources[emitters[0].shape].shape->where, error); }
  }

  void add_area_light(const Emitter& emitter, const LightInstance* instance) {
    GeometryTables& geometry = scene_.geometry;
    const ShapeRow& row = geometry.shapes[emitter.shape];
    const ShapeTables tables{geometry.vertices.data(), geometry.triangles.data(), geometry.quadrics.data(),
                             scene_.motion.view().deformations};
    // Build the light
    LightTableOffsets positions{static_cast<std::uint32_t>(lights_.triangle_alias.size()),
                                static_cast<std::uint32_t>(lights_.uvs.size()), row.first_triangle};
    if (instance != nullptr) positions.quadric = static_cast<std::uint32_t>(geometry.quadrics.size());
    AreaLight light = make_area_light(row, emitter.shape, tables, emitter.emission, positions, instance);
    constexpr std::size_t kRowWords = sizeof(LightTriangleRow) / sizeof(float);
    if (kRowWords * (lights_.triangles.size() + light.triangles.size()) > kMaxTableWords)
      throw SceneError(fmt::format("the lights have more than {} triangles in all", kMaxTableWords / kRowWords));
    // Scale it to the given power
    SpectrumRow spectrum = emitter.emission.spectrum;
    if (emitter.emission.power) {
      const float factor = *emitter.emission.power / (exitance_factor(light.row) * light.area);
      light.row.radiance = light.row.radiance * factor;
      spectrum.scale *= factor;
    }
    // Append its rows
    if (const LightCoatRow& coat = emitter.emission.coat; coat.strength > 0 || coat.texture != kNone) {
      lights_.coats.push_back(coat);
      if (lights_.coats.size() >= std::size_t(1) << (32 - kLightCoatShift))
        throw SceneError("too many emitting shapes with a clearcoat");
      light.row.flags |= static_cast<std::uint32_t>(lights_.coats.size()) << kLightCoatShift;
    }
    const ShapeDescription& shape = *geometry_.sources[emitter.shape].shape;
    add_row(light.row, spectrum, shape.where, emitter_name(shape));
    lights_.has_textured_area_lights = lights_.has_textured_area_lights || light.row.needs_texture_query();
    lights_.triangle_alias.insert(lights_.triangle_alias.end(), light.alias.begin(), light.alias.end());
    lights_.triangles.insert(lights_.triangles.end(), light.triangles.begin(), light.triangles.end());
    lights_.uvs.insert(lights_.uvs.end(), light.uvs.begin(), light.uvs.end());
    if (light.quadric) geometry.quadrics.push_back(*light.quadric);
  }

  /// Makes the rows of the description's lights.
  std::vector<PlacedLight> place_lights() {
    std::vector<PlacedLight> placed;
    for (const LightDescription& light : in_.lights) {
      try {
        auto row = compile_light(light, context_);
        // A black environment lights nothing, but it is what camera rays see.
        if (LightKinds::is_environment(light.model) && !(row && max_component(emitted_rgb(row->row)) > 0.0f))
          lights_.has_black_environment = true;
        if (row) placed.push_back({*row, &light});
      } catch (const SceneError& error) { omit(light.where, error); }
    }
    return placed;
  }

  /// Adds those that are at infinity or not, unless they are black.
  void add_lights(const std::vector<PlacedLight>& placed, bool at_infinity) {
    for (const auto& [light, from] : placed) {
      if (is_infinite(light.row) != at_infinity || !(max_component(emitted_rgb(light.row)) > 0.0f)) continue;
      if (light_compiler_of(light.row).domain == LightDomain::kEnvironment) {
        if (lights_.environment != kNone) {
          omit(from->where, SceneError("a scene may have only one environment light", SceneErrorCode::kDuplicate));
          continue;
        }
        lights_.environment = count();
      }
      add_row(light.row, light.spectrum, from->where, from->id);
      if (const AnimatedTransform* motion = motion_.transform(from->motion)) move_last_light(*motion);
    }
  }

  void move_last_light(const AnimatedTransform& motion) {
    const std::uint32_t row = count() - 1;
    MotionProbes probes = MotionProbes::of_directions();
    if (!is_infinite(lights_.rows[row])) {
      const LightBounds bounds = bounds_of_light(view(), row, 1);
      for (const Vec3f p : {bounds.lower, bounds.upper}) probes.add_point(p);
    }
    const MotionRow moved = motion_.add_from_rest(motion, probes);
    if (moved.segment_count > 0) MotionCompiler::set(motion_.tables().lights, row, moved);
  }

  /// Makes lights of emitting media if lights are sampled and the estimator supports it.
  void add_volume_lights() {
    if (scene_.integrator.strategy == LightStrategy::kBsdfOnly ||
        scene_.integrator.medium_estimator == MediumEstimator::kMarching)
      return;
    for (std::uint32_t i = 0; i < scene_.media.rows.size(); ++i) {
      const auto first_cell = static_cast<std::uint32_t>(lights_.triangle_alias.size());
      const auto light = make_volume_light(view(), i, media_.boxes[i], first_cell);
      if (!light) continue;
      scene_.media.rows[i].light = count();
      add_row(light->row, {}, {}, in_.media.at(i).id);
      if (media_.motions[i].segment_count > 0)
        MotionCompiler::set(motion_.tables().lights, count() - 1, media_.motions[i]);
      lights_.triangle_alias.insert(lights_.triangle_alias.end(), light->alias.begin(), light->alias.end());
    }
  }

  /// `name`: may be empty.
  void add_row(const LightRow& row, const SpectrumRow& spectrum, const SourceLocation& where, const std::string& name) {
    lights_.rows.push_back(row);
    naming_.add_light(light_compiler_of(row).label, name);
    out_.spectra.push_back(spectrum);
    if (lights_.source_locations.size() < kMaxReportedLights) lights_.source_locations.push_back(where);
  }

  const Description& in_;
  const CompiledGeometry& geometry_;
  const CompiledMedia& media_;
  MotionCompiler& motion_;
  SceneNaming& naming_;
  ErrorSink& errors_;
  SceneTables& scene_;
  CompiledLights out_;
  LightTables& lights_ = out_.tables;
  LightContext context_;
};

/// Bounds of a light at all steps of its motion.
LightBounds moved_bounds(const LightBounds& bounds, const std::vector<InstanceRow>& steps) {
  if (steps.empty()) return bounds;
  const auto axis_at = [&](const InstanceRow& step) {
    return normalize(InstancePlacement<Scalar>(step).vector(bounds.axis));
  };
  LightBounds moved = bounds;
  moved.axis = axis_at(steps[(steps.size() - 1) / 2]);
  Bounds3f all = Bounds3f::empty();
  double widest = 0;
  for (const InstanceRow& step : steps) {
    all.grow(instance_bounds(step, {bounds.lower, bounds.upper}));
    widest = std::max(widest, std::acos(std::clamp(double(dot(moved.axis, axis_at(step))), -1.0, 1.0)));
  }
  moved.lower = all.min;
  moved.upper = all.max;
  // Widen the cone of normals by the largest turn of its axis
  const double angle = std::acos(std::clamp(double(bounds.cos_theta_o), -1.0, 1.0)) + widest;
  moved.cos_theta_o = static_cast<float>(std::cos(std::min(angle, double(kPi))));
  return moved;
}

}  // namespace

std::vector<TextureId> emission_textures(const ShapeDescription& shape) {
  std::vector<TextureId> out;
  if (const std::optional<TextureId> texture = radiance_texture_of(shape)) out.push_back(*texture);
  if (const auto* texture = std::get_if<TextureId>(&shape.emission_coat); texture != nullptr && shape.radiance)
    out.push_back(*texture);
  return out;
}

CompiledLights compile_lights(const Description& description, const CompiledGeometry& geometry,
                              const CompiledMedia& media, SpectrumSet* set, MotionCompiler& motion, SceneNaming& naming,
                              ErrorSink& errors, SceneTables& scene) {
  return LightTableBuilder(description, geometry, media, set, motion, naming, errors, scene).run();
}

void select_lights(const MotionCompiler& motion, SceneTables& scene) {
  const SceneView view = scene.view();
  LightTables& lights = scene.lights;
  std::vector<float> weights;
  lights.powers = light_powers(view);
  for (std::uint32_t i = 0; i < view.lights.count; ++i) {
    const Vec3f power = lights.powers[i];
    // Much of an environment's light passes the bounding sphere without hitting anything. With its full power it would
    // take samples from lights inside.
    constexpr double kEnvironmentFraction = 0.25;
    const double fraction = i == view.lights.environment ? kEnvironmentFraction : 1.0;
    const double mean = (double(power.x) + power.y + power.z) / 3.0 * fraction;
    // Weights must be positive and finite for lights of any power.
    weights.push_back(static_cast<float>(std::clamp(mean, 1e-30, 1e30)));
  }
  if (weights.empty()) return;
  lights.alias = build_alias_table(weights);
  std::vector<LightBounds> bounds;
  for (std::uint32_t i = 0; i < view.lights.bounded_count; ++i)
    bounds.push_back(
        moved_bounds(bounds_of_light(view, i, weights[i]), motion.placements(motion.of(motion.tables().lights, i))));
  lights.tree = build_light_tree(bounds);
}

}  // namespace sheaf
