#include "scene/compile/media/compile_media.h"

#include "scene/compile/overloaded.h"
#include "scene/lights/list.h"

#include <algorithm>

namespace sheaf {

namespace {

bool is_grid(const VolumeInput& input) { return std::holds_alternative<GridVolumeDescription>(input); }

const SggxDescription* flakes_of(const PhaseDescription* phase) {
  return phase != nullptr ? std::get_if<SggxDescription>(&phase->model) : nullptr;
}

bool has_grid(const MediumInput& medium) {
  const MediumDescription& m = *medium.description;
  const SggxDescription* flakes = flakes_of(medium.phase);
  return m.density || m.temperature ||
         (flakes != nullptr && std::holds_alternative<GridVolumeDescription>(flakes->matrix)) ||
         std::visit(
             Overloaded{
                 [&](const ExtinctionAlbedoDescription& c) { return is_grid(c.sigma_t) || is_grid(c.albedo); },
                 [&](const AbsorptionScatteringDescription& c) { return is_grid(c.sigma_a) || is_grid(c.sigma_s); }},
             m.coefficients);
}

/// The media of a description, before their shapes are known.
std::vector<MediumInput> medium_inputs(const Description& description, const IntegratorSettings& integrator,
                                       const std::vector<std::uint32_t>& row_of_phase, ErrorSink& errors) {
  if (description.media.size() > kMaxMedia) throw SceneError(fmt::format("more than {} media", kMaxMedia));
  std::vector<MediumInput> media;
  for (const MediumDescription& m : description.media) {
    // The last row is isotropic
    const std::size_t phase = m.phase ? static_cast<std::size_t>(*m.phase) : row_of_phase.size() - 1;
    media.push_back({&m, m.phase ? &description.phases.at(phase) : nullptr, row_of_phase.at(phase), {}});
    if (flakes_of(media.back().phase) != nullptr && integrator.traits().has_photon_maps() &&
        integrator.photons.volume.count > 0)
      media.back().make_empty(SceneError(m.where,
                                         "photons cannot be gathered in a medium of microflakes (expected a phase "
                                         "function other than 'sggx', or no photons in media)",
                                         SceneErrorCode::kUnsupported),
                              errors);
  }
  return media;
}

/// Adds the boundaries of shapes, and the shapes to the media inside and outside of them.
void add_boundaries(const CompiledGeometry& geometry, const MotionCompiler& motion, std::vector<MediumInput>& media,
                    ErrorSink& errors, std::vector<ShapeRow>& shapes, std::vector<BoundaryRow>& boundaries) {
  for (const BoundaryShape& boundary : geometry.boundaries) {
    const ShapeDescription* const shape = geometry.sources[boundary.shape].shape;
    const ShapeGroup* const group = geometry.sources[boundary.shape].group;
    // The medium on a side of the shape, encoded as in BoundaryRow
    const auto hold = [&](const std::optional<MediumId>& id) -> std::uint32_t {
      if (!id) return 0;
      MediumInput& medium = media.at(static_cast<std::size_t>(*id));
      if (group != nullptr && (has_grid(medium) || medium.description->emission)) {
        errors.report(SceneError(shape->where, "a medium in a shape group must be homogeneous and must not emit",
                                 SceneErrorCode::kUnsupported),
                      "medium left out");
        return 0;
      }
      medium.shapes.push_back({boundary.box, group == nullptr ? motion.transform(shape->motion) : nullptr});
      return static_cast<std::uint32_t>(*id) + 1;
    };
    shapes[boundary.shape].boundary = static_cast<std::uint32_t>(boundaries.size());
    const std::uint32_t interior = hold(shape->interior);
    boundaries.push_back({interior, hold(shape->exterior)});
  }
}

}  // namespace

void MediumInput::make_empty(const SceneError& error, ErrorSink& errors) {
  errors.report(at_location(description->where, error), kEmptySubstitute);
  static const MediumDescription kEmpty = [] {
    MediumDescription empty;
    empty.coefficients =
        AbsorptionScatteringDescription{SpectrumDescription::constant(0), SpectrumDescription::constant(0)};
    return empty;
  }();
  description = &kEmpty;
  phase = nullptr;
}

CompiledMedia compile_media(const Description& description, const IntegratorSettings& integrator,
                            const CompiledGeometry& geometry, const std::vector<std::uint32_t>& row_of_phase,
                            SpectrumSet* set, MotionCompiler& motion, ErrorSink& errors,
                            std::vector<ShapeRow>& shapes) {
  CompiledMedia out;
  std::vector<MediumInput> media = medium_inputs(description, integrator, row_of_phase, errors);
  add_boundaries(geometry, motion, media, errors, shapes, out.tables.boundaries);
  add_medium_rows(media, geometry.bounds, set, integrator.step_size, errors, out);
  move_media(media, geometry.bounds, motion, errors, out);
  const std::optional<MediumId>& camera_medium = description.camera.medium;
  if (camera_medium) out.tables.camera_medium = static_cast<std::uint32_t>(*camera_medium) + 1;
  return out;
}

void bound_outer_medium(const MotionCompiler& motion, SceneTables& scene) {
  const LightTables& lights = scene.lights;
  if (scene.media.rows.empty() || lights.bounded_count == lights.rows.size()) return;
  for (std::uint32_t i = 0; i < lights.bounded_count; ++i) {
    const auto position = light_compiler_of(lights.rows[i]).position;
    if (position == nullptr) continue;
    for (const Vec3f p : motion.positions(MotionCompiler::of(scene.motion.lights, i), position(lights.rows[i])))
      scene.radius = std::max(scene.radius, length(p - scene.center));
  }
  // Slightly larger than necessary, so that rounding does not shorten rays between two points of the scene. Less than
  // half the length of shadow rays to lights at infinity.
  scene.media.outer_radius = 1.01f * scene.radius;
}

}  // namespace sheaf
