// Placement of media: on the sides of shapes, around the scene, and around the camera.
#include "scene/compile/media/compile_media.h"
#include "scene/compile/media/medium_probe.h"
#include "scene/compile/scene_compiler.h"
#include "scene/tables/motion_sample.h"

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
    if (flakes != nullptr && in_.integrator.traits().has_photon_maps() && in_.integrator.photons.volume.count > 0)
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
    const auto position = light_compiler_of(light).position;
    if (position == nullptr) continue;
    const MotionRow motion = i < out_->motion_.lights.size() ? out_->motion_.lights[i] : MotionRow{};
    for (const Vec3f p : places_along(motion, position(light)))
      out_->radius_ = std::max(out_->radius_, length(p - out_->center_));
  }
  // Slightly larger than necessary, so that rounding does not shorten rays between two points of the scene. Less than
  // half the length of shadow rays to lights at infinity.
  out_->media_.outer_radius = 1.01f * out_->radius_;
}

void SceneCompiler::probe_media() {
  const std::uint32_t default_value = out_->media_.camera_medium;
  out_->media_.outer_medium = default_value;
  if (!out_->media_.boundaries.empty()) probe_boundaries(default_value);
  const std::uint32_t outer = out_->media_.outer_medium;
  if (in_.integrator.traits().emits_photons() && outer != 0 && (out_->media_.rows[outer - 1].flags & kMediumEmits) != 0)
    out_->warnings_.push_back(SceneError(in_.media[outer - 1].where,
                                         "photons do not carry the emission of an unbounded medium: its scattered "
                                         "light is missing")
                                  .what());
}

bool SceneCompiler::boundaries_move() const {
  const std::vector<ShapeRow>& shapes = out_->geometry_.shapes;
  const auto bounds = [](const ShapeRow& shape) { return shape.boundary != kNone; };
  const auto deforms = [](const ShapeRow& shape) { return shape.flags >> kDeformationShift != 0; };
  for (const ShapeRow& shape : shapes)
    if (bounds(shape) && deforms(shape)) return true;
  const std::vector<MotionRow>& motions = out_->motion_.instances;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (motions[i].segment_count == 0) continue;
    const ShapeRange& range = group_ranges_[out_->geometry_.instances[i].group];
    const auto first = shapes.begin() + range.first_shape;
    if (std::any_of(first, first + range.shape_count, bounds)) return true;
  }
  return false;
}

void SceneCompiler::probe_boundaries(std::uint32_t default_value) {
  probe_surroundings(default_value);
  out_->media_.outer_medium = medium_outside(out_->make_view(), default_value);
  probe_cameras(default_value);
}

void SceneCompiler::probe_surroundings(std::uint32_t default_value) {
  if (surrounded_shapes_.empty()) return;
  // Probes of all shapes, instances and times, and limits for each
  constexpr std::size_t kMaxProbes = 1 << 14, kMaxInstances = 1024;
  constexpr std::size_t kMinParts = 8, kMaxParts = 256;
  // Find the instances of each shape, or some of them
  std::vector<std::vector<std::uint32_t>> instances(group_ranges_.size());
  for (std::uint32_t i = 0; i < out_->geometry_.instances.size(); ++i)
    instances[out_->geometry_.instances[i].group].push_back(i);
  const std::size_t share = std::clamp<std::size_t>(kMaxProbes / surrounded_shapes_.size(), 1, kMaxInstances);
  std::vector<PlacedShape> placed;
  for (const std::uint32_t shape : surrounded_shapes_) {
    if (shape < ungrouped_shapes_) {
      placed.push_back({shape, kNone});
      continue;
    }
    const auto starts_behind = [](std::uint32_t index, const ShapeRange& range) { return index < range.first_shape; };
    const auto group = std::upper_bound(group_ranges_.begin(), group_ranges_.end(), shape, starts_behind) - 1;
    const std::vector<std::uint32_t>& all = instances[static_cast<std::size_t>(group - group_ranges_.begin())];
    const std::size_t count = std::min(all.size(), share);
    for (std::size_t k = 0; k < count; ++k) placed.push_back({shape, all[k * all.size() / count]});
  }
  const std::size_t parts =
      boundaries_move() ? std::clamp(kMaxProbes / std::max<std::size_t>(placed.size(), 1), kMinParts, kMaxParts) : 0;
  // Probe them
  const SceneView view = out_->make_view();
  std::vector<std::vector<TimedMedium>> media;
  for (const PlacedShape& at : placed)
    media.push_back(media_over_time(static_cast<int>(parts),
                                    [&](float time) { return medium_around(view, at, time, default_value); }));
  for (std::size_t first = 0, last = 0; first < placed.size(); first = last) {
    while (last < placed.size() && placed[last].shape == placed[first].shape) ++last;
    BoundaryRow& row = out_->media_.boundaries[out_->geometry_.shapes[placed[first].shape].boundary];
    row.exterior = media[first][0].medium;
    const auto is_same = [&](const std::vector<TimedMedium>& m) {
      return m.size() == 1 && m[0].medium == row.exterior;
    };
    if (std::all_of(media.begin() + std::ptrdiff_t(first), media.begin() + std::ptrdiff_t(last), is_same)) continue;
    row.first_surrounding = static_cast<std::uint32_t>(out_->media_.surroundings.size());
    for (std::size_t i = first; i < last; ++i)
      for (const TimedMedium& from : media[i])
        out_->media_.surroundings.push_back({placed[i].instance, from.time, from.medium});
    row.surrounding_count = static_cast<std::uint32_t>(out_->media_.surroundings.size()) - row.first_surrounding;
  }
}

void SceneCompiler::probe_cameras(std::uint32_t default_value) {
  constexpr int kParts = 256;
  const SceneView view = out_->make_view();
  const auto columns = static_cast<float>(cameras_.size());
  const auto width = static_cast<float>(in_.film.width) / columns, height = static_cast<float>(in_.film.height);
  const bool all_move = boundaries_move();
  std::vector<CameraMediumRow> rows;
  for (std::uint32_t i = 0; i < cameras_.size(); ++i) {
    if (const auto named = cameras_[i].medium ? cameras_[i].medium : in_.camera.medium) {
      rows.push_back({i, 0, static_cast<std::uint32_t>(*named) + 1});
      continue;
    }
    const Camera& camera = i == 0 ? out_->sensor_.camera : out_->sensor_.more_cameras[i - 1];
    const Vec3f middle = camera.ray<Scalar>(0.5f * width, 0.5f * height, 0, 0).origin;
    const MotionRow motion = i < out_->motion_.cameras.size() ? out_->motion_.cameras[i] : MotionRow{};
    const auto at = [&](float time) {
      const Vec3f p =
          motion.segment_count == 0 ? middle : sample_motion<Scalar>(view.motion, motion, time).placed.point(middle);
      return medium_at(view, p, time, {}, default_value);
    };
    for (const TimedMedium& from : media_over_time(all_move || motion.segment_count > 0 ? kParts : 0, at))
      rows.push_back({i, from.time, from.medium});
    warn_of_camera_media(camera, cameras_[i].where, width, height, middle, default_value);
  }
  out_->media_.camera_medium = rows[0].medium;
  const auto is_same = [&](const CameraMediumRow& row) { return row.medium == rows[0].medium; };
  if (!std::all_of(rows.begin(), rows.end(), is_same)) out_->media_.camera_media = std::move(rows);
}

void SceneCompiler::warn_of_camera_media(const Camera& camera, const SourceLocation& where, float width, float height,
                                         Vec3f middle, std::uint32_t default_value) {
  const SceneView view = out_->make_view();
  const std::uint32_t medium = medium_at(view, middle, 0, {}, default_value);
  constexpr Vec2<Scalar> kLens[] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  for (int place = 0; place < 9; ++place)
    for (const Vec2<Scalar> lens : std::span(kLens).first(camera.has_lens() ? 5 : 1)) {
      const int column = place % 3, row = place / 3;
      const float x = 0.5f * width * static_cast<float>(column), y = 0.5f * height * static_cast<float>(row);
      const Vec3f start = camera.ray<Scalar>(x, y, lens.x, lens.y).origin;
      if (start == middle || medium_at(view, start, 0, {}, default_value) == medium) continue;
      out_->warnings_.push_back(SceneError(where,
                                           "the camera's rays start in more than one medium: all are "
                                           "assumed to start in that of the middle one")
                                    .what());
      return;
    }
}

}  // namespace sheaf
