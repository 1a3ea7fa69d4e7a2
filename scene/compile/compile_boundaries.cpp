// Placement of media: on the sides of shapes, around the scene, and around the camera.
#include "scene/compile/compile_media.h"
#include "scene/compile/medium_probe.h"
#include "scene/compile/scene_compiler.h"

#include <algorithm>
#include <span>

namespace sheaf {

namespace {

bool holds_flakes_on_grid(const PhaseDescription& phase) {
  const auto* flakes = std::get_if<SggxDescription>(&phase.model);
  return flakes != nullptr && std::holds_alternative<GridVolumeDescription>(flakes->matrix);
}

}  // namespace

std::uint32_t SceneCompiler::hold(std::optional<MediumId> medium, const ShapeDescription& shape, const GridBox& box) {
  if (!medium) return 0;
  const auto index = static_cast<std::size_t>(*medium);
  const MediumDescription& m = in_.media.at(index);
  const auto is_grid = [](const VolumeInput& input) { return std::holds_alternative<GridVolumeDescription>(input); };
  const bool has_grid =
      m.density || m.temperature ||
      (m.phase && holds_flakes_on_grid(in_.phases.at(static_cast<std::size_t>(*m.phase)))) ||
      std::visit(
          Overloaded{
              [&](const ExtinctionAlbedoDescription& c) { return is_grid(c.sigma_t) || is_grid(c.albedo); },
              [&](const AbsorptionScatteringDescription& c) { return is_grid(c.sigma_a) || is_grid(c.sigma_s); }},
          m.coefficients);
  const bool in_group = group_emitters_ != nullptr && shape_motion_ == nullptr;
  if (in_group && (has_grid || m.emission))
    throw SceneError(shape.where, "a medium in a shape group must be homogeneous and must not emit");
  medium_shapes_.resize(in_.media.size());
  medium_shapes_[index].push_back({box, shape_motion_});
  return static_cast<std::uint32_t>(index) + 1;
}

void SceneCompiler::add_media() {
  medium_shapes_.resize(in_.media.size());
  if (in_.media.size() > kMaxMedia) throw SceneError("more than " + std::to_string(kMaxMedia) + " media");
  // Collect the media with their phase functions and bounds
  std::vector<PlacedMedium> placed;
  for (std::size_t i = 0; i < in_.media.size(); ++i) {
    const MediumDescription& m = in_.media[i];
    const std::size_t phase = m.phase ? static_cast<std::size_t>(*m.phase) : row_of_phase_.size() - 1;
    const auto* flakes = m.phase ? std::get_if<SggxDescription>(&in_.phases.at(phase).model) : nullptr;
    if (flakes != nullptr && in_.integrator.kind == IntegratorKind::kPhotonMapper &&
        in_.integrator.photons.volume.count > 0)
      throw SceneError(m.where,
                       "photons cannot be gathered in a medium of microflakes (expected a phase function other than "
                       "'sggx', or no photons in media)");
    std::vector<GridBox> boxes;
    for (const MediumShape& shape : medium_shapes_[i]) boxes.push_back(shape.box);
    placed.push_back({&m, row_of_phase_.at(phase), flakes, std::move(boxes), {lower_, upper_}});
    if (m.temperature && !spectra_ && !out_->media_.blackbodies) out_->media_.blackbodies.emplace();
  }
  // Compile and check them
  CompiledMedia media = compile_media(placed, spectra(), in_.integrator.step_size, out_->media_);
  out_->spectra_.media = std::move(media.spectra);
  if (spectra_) out_->spectra_.samples = spectra_->samples();
  out_->warnings_.insert(out_->warnings_.end(), media.warnings.begin(), media.warnings.end());
  places_of_grids_ = std::move(media.places);
  move_media();
  check_media(out_->make_view(), in_.media, out_->media_);
  if (in_.camera.medium) out_->media_.camera_medium = static_cast<std::uint32_t>(*in_.camera.medium) + 1;
}

void SceneCompiler::end_media() {
  if (in_.media.empty() || out_->lights_.bounded_count == out_->lights_.rows.size()) return;
  for (std::uint32_t i = 0; i < out_->lights_.bounded_count; ++i) {
    const LightRow& light = out_->lights_.rows[i];
    if (const auto position = light_compiler_of(light).position; position != nullptr)
      out_->radius_ = std::max(out_->radius_, length(position(light) - out_->center_));
  }
  // Slightly larger than necessary, so that rounding does not shorten rays between two points of the scene. Less than
  // half the length of shadow rays to lights at infinity.
  out_->media_.outer_radius = 1.01f * out_->radius_;
}

void SceneCompiler::probe_media() {
  const std::uint32_t default_value = out_->media_.camera_medium;
  out_->media_.outer_medium = default_value;
  if (!out_->media_.boundaries.empty()) probe_boundaries(default_value);
  const IntegratorKind kind = in_.integrator.kind;
  const bool by_photons = kind == IntegratorKind::kLightTracer || kind == IntegratorKind::kPhotonMapper;
  const std::uint32_t outer = out_->media_.outer_medium;
  if (by_photons && outer != 0 && (out_->media_.rows[outer - 1].flags & kMediumEmits) != 0)
    out_->warnings_.push_back(SceneError(in_.media[outer - 1].where,
                                         "photons do not carry the emission of an unbounded medium: its scattered "
                                         "light is missing")
                                  .what());
}

void SceneCompiler::probe_boundaries(std::uint32_t default_value) {
  for (const std::uint32_t shape : surrounded_shapes_) {
    const SceneView view = out_->make_view();
    out_->media_.boundaries[out_->geometry_.shapes[shape].boundary].exterior =
        medium_around(view, shape, default_value);
  }
  out_->media_.outer_medium = medium_outside(out_->make_view(), default_value);
  if (!in_.camera.medium) probe_camera();
}

void SceneCompiler::probe_camera() {
  const Camera& camera = out_->sensor_.camera;
  const auto width = static_cast<float>(in_.film.width), height = static_cast<float>(in_.film.height);
  const SceneView view = out_->make_view();
  const Vec3f middle = camera.ray<Scalar>(0.5f * width, 0.5f * height, 0, 0).origin;
  out_->media_.camera_medium = medium_at(view, middle, kNone, 0);
  constexpr Vec2<Scalar> kLens[] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  for (int place = 0; place < 9; ++place)
    for (const Vec2<Scalar> lens : std::span(kLens).first(camera.has_lens() ? 5 : 1)) {
      const int column = place % 3, row = place / 3;
      const float x = 0.5f * width * static_cast<float>(column), y = 0.5f * height * static_cast<float>(row);
      const Vec3f start = camera.ray<Scalar>(x, y, lens.x, lens.y).origin;
      if (start == middle || medium_at(view, start, kNone, 0) == out_->media_.camera_medium) continue;
      out_->warnings_.push_back(SceneError(in_.camera.where,
                                           "the camera's rays start in more than one medium: all are "
                                           "assumed to start in that of the middle one")
                                    .what());
      return;
    }
}

}  // namespace sheaf
