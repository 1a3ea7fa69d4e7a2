// Adds the motions of media: checks that the grids of each medium move alike, tabulates the motion, and bounds the
// shapes around a medium relative to its grids.
#include "scene/compile/media/compile_media.h"
#include "scene/compile/overloaded.h"
#include "scene/tables/instance.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// A grid of a medium, with the name of its property.
struct NamedGrid {
  const char* name;
  const GridVolumeDescription* grid;
};

std::vector<NamedGrid> grids_of(const MediumDescription& m, const PhaseDescription* phase) {
  std::vector<NamedGrid> out;
  const auto add = [&](const char* name, const auto& input) {
    if (const auto* grid = std::get_if<GridVolumeDescription>(&input)) out.push_back({name, grid});
  };
  std::visit(Overloaded{[&](const ExtinctionAlbedoDescription& c) {
                          add("sigma_t", c.sigma_t);
                          add("albedo", c.albedo);
                        },
                        [&](const AbsorptionScatteringDescription& c) {
                          add("sigma_a", c.sigma_a);
                          add("sigma_s", c.sigma_s);
                        }},
             m.coefficients);
  // Without a grid of the extinction, a voxel in memory holds its bounds
  const bool is_bounds = m.density && m.density->format == GridVolumeDescription::Format::kInMemory;
  if (m.density) out.push_back({is_bounds ? "sigma_t" : "density", &*m.density});
  if (m.emission) add("emission", *m.emission);
  if (m.temperature) out.push_back({"temperature", &*m.temperature});
  if (m.emission_factor) out.push_back({"emission factor", &*m.emission_factor});
  if (phase != nullptr)
    if (const auto* flakes = std::get_if<SggxDescription>(&phase->model)) add("S", flakes->matrix);
  return out;
}

/// Maps a point at the first key to its position at a time. Null: the point is static.
Transform moved(const AnimatedTransform* motion, double time) {
  return motion == nullptr ? Transform() : motion->at(time) * motion->reference().inverse();
}

double largest_linear_difference(const Transform& a, const Transform& b) {
  double largest = 0;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      const double x = a.matrix().m[row][column], y = b.matrix().m[row][column];
      largest = std::max(largest, std::fabs(x - y) / (1 + std::fabs(x)));
    }
  return largest;
}

/// Calls f(time) at the keys of the motions, and at times in between, until it returns false.
template <class F> bool at_times_of(const AnimatedTransform* a, const AnimatedTransform* b, F&& f) {
  std::vector<double> times;
  for (const AnimatedTransform* motion : {a, b})
    if (motion != nullptr)
      for (const double time : motion->key_times()) times.push_back(time);
  std::sort(times.begin(), times.end());
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!f(times[i])) return false;
    if (i + 1 < times.size())
      for (const double t : {0.31, 0.64})
        if (!f(times[i] + t * (times[i + 1] - times[i]))) return false;
  }
  return true;
}

/// Whether two motions are the same map from the first key at all times, up to rounding of files.
bool move_alike(const AnimatedTransform* a, const AnimatedTransform* b) {
  if (a == b) return true;
  // Compare rotations and stretches, and the paths of the first object's origin relative to their lengths
  constexpr double kTolerance = 1e-5, kRounding = 2e-7;
  const Transform rest = a != nullptr ? a->reference() : b->reference();
  const Vec3d start = rest.translation();
  double largest = 0, path = 0, difference = 0;
  for (const AnimatedTransform* motion : {a, b})
    if (motion != nullptr) largest = std::max(largest, length(motion->reference().translation()));
  const bool same_linear = at_times_of(a, b, [&](double time) {
    const Transform by_a = moved(a, time), by_b = moved(b, time);
    const Vec3d at_a = (by_a * rest).translation(), at_b = (by_b * rest).translation();
    path = std::max({path, length(at_a - start), length(at_b - start)});
    difference = std::max(difference, length(at_a - at_b));
    return largest_linear_difference(by_a, by_b) < kTolerance;
  });
  return same_linear && difference <= kTolerance * path + kRounding * largest;
}

/// Whether a motion keeps all distances.
bool is_rigid(const AnimatedTransform& motion) {
  constexpr double kTolerance = 1e-4;
  return at_times_of(&motion, nullptr, [&](double time) {
    const Transform transform = moved(&motion, time);
    const auto& m = transform.matrix().m;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const double product = m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j];
        if (std::fabs(product - (i == j ? 1 : 0)) > kTolerance) return false;
      }
    return true;
  });
}

/// The motion of the grids of a medium; null: they are static. A medium without grids that emits moves with its shapes
/// if all of them move alike. Throws SceneError if grids move in different ways.
const AnimatedTransform* motion_of(const MediumInput& medium, const MotionCompiler& motions) {
  const MediumDescription& m = *medium.description;
  const PhaseDescription* phase = medium.phase;
  // Without grids, only the emission has a position: that of the shapes
  const std::vector<NamedGrid> grids = grids_of(m, phase);
  const std::vector<MediumShape>& shapes = medium.shapes;
  if (grids.empty()) {
    if (!m.emission || shapes.empty()) return nullptr;
    const AnimatedTransform* motion = shapes[0].motion;
    const auto moves_alike = [&](const MediumShape& shape) { return move_alike(shape.motion, motion); };
    return std::all_of(shapes.begin(), shapes.end(), moves_alike) ? motion : nullptr;
  }
  // All grids must move alike
  const AnimatedTransform* motion = motions.transform(grids[0].grid->motion);
  for (const NamedGrid& other : grids)
    if (!move_alike(motions.transform(other.grid->motion), motion))
      throw SceneError(m.where, fmt::format("the grids of a medium move together, but '{}' moves differently from '{}' "
                                            "(expected the same <animation> for both)",
                                            other.name, grids[0].name));
  if (motion != nullptr && phase != nullptr && std::holds_alternative<SggxDescription>(phase->model) &&
      !is_rigid(*motion))
    throw SceneError(m.where,
                     "a medium of microflakes cannot be stretched (expected an <animation> that turns and shifts it)");
  return motion;
}

/// World bounds of a medium's grids at the first key; without grids, of its shapes or of the scene.
Bounds3f box_of_grids(const MediumInput& medium, const MediumRow& row, const std::vector<PlacedGrid>& grids,
                      const Bounds3f& scene) {
  Bounds3f box = Bounds3f::empty();
  for (const std::uint32_t grid : {row.density, row.first_grid, row.second_grid, row.emission_grid, row.temperature,
                                   row.emission_factor, row.flake_grids})
    if (grid != kNone && grids[grid].size[0] > 0) box.grow(grids[grid].box);
  if (!box.is_empty()) return box;
  for (const MediumShape& shape : medium.shapes) box.grow(shape.box);
  return box.is_empty() ? scene : box;
}

/// World bounds of the extinction at the first key; nullopt if it has none.
std::optional<Bounds3f> box_of_extinction(const MediumRow& row, const std::vector<PlacedGrid>& grids) {
  const std::uint32_t grid = row.density != kNone ? row.density : row.first_grid;
  if (grid == kNone || grids[grid].size[0] == 0) return std::nullopt;
  const Bounds3f& box = grids[grid].box;
  if ((row.flags & kMediumBoxed) != 0) return box;
  // Towards a background the outermost voxels are interpolated over less than the diagonal of a voxel
  const auto& size = grids[grid].size;
  const float margin = length(box.max - box.min) / static_cast<float>(std::min({size[0], size[1], size[2]}));
  const Vec3f around{margin, margin, margin};
  return Bounds3f{box.min - around, box.max + around};
}

/// Bounds of a shape relative to the grids of a medium with another motion, at any time while the shutter is open.
Bounds3f relative_box(const MediumShape& shape, const AnimatedTransform* motion, const ShutterDescription& shutter) {
  constexpr int kSteps = 64;
  const double open = shutter.open, duration = std::max(shutter.close - open, 0.0);
  std::vector<double> times{open};
  for (int i = 1; i <= kSteps && duration > 0; ++i) times.push_back(open + duration * i / kSteps);
  for (const AnimatedTransform* moving : {motion, shape.motion})
    for (const double key : moving != nullptr ? moving->key_times() : std::vector<double>{})
      if (key > open && key < open + duration) times.push_back(key);
  Bounds3f all = Bounds3f::empty();
  for (const double time : times) {
    const Transform relative = moved(motion, time).inverse() * moved(shape.motion, time);
    all.grow(instance_bounds(make_instance(single_rows(relative), 0, 0), shape.box));
  }
  return all;
}

/// The boxes of a medium's shapes relative to its grids. `extinction`: see box_of_extinction().
std::vector<Bounds3f> boxes_at_rest(const MediumInput& medium, const AnimatedTransform* motion,
                                    const ShutterDescription& shutter, const std::optional<Bounds3f>& extinction) {
  std::vector<Bounds3f> out;
  for (const MediumShape& shape : medium.shapes)
    out.push_back(move_alike(shape.motion, motion) ? shape.box : relative_box(shape, motion, shutter));
  // A grid that moves is often much smaller than the shape in which it does
  if (motion != nullptr && extinction) {
    for (Bounds3f& box : out) box = intersection(box, *extinction);
    std::erase_if(out, [](const Bounds3f& box) { return box.is_empty(); });
  }
  return out;
}

}  // namespace

void move_media(std::span<const MediumInput> media, const Bounds3f& scene, MotionCompiler& motion, ErrorSink& errors,
                CompiledMedia& out) {
  out.motions.resize(media.size());
  for (std::size_t i = 0; i < media.size(); ++i) {
    const MediumInput& medium = media[i];
    const MediumRow& row = out.tables.rows[i];
    out.boxes.emplace_back();
    try {
      const AnimatedTransform* moves = motion_of(medium, motion);
      out.boxes.back() = boxes_at_rest(medium, moves, motion.shutter(), box_of_extinction(row, out.grids));
      if (moves == nullptr) continue;
      out.motions[i] = motion.add_from_rest(*moves, MotionProbes::of_box(box_of_grids(medium, row, out.grids, scene)));
      if (out.motions[i].segment_count > 0 && (row.flags & kMediumHomogeneous) == 0)
        MotionCompiler::set(motion.tables().media, i, out.motions[i]);
    } catch (const SceneError& error) {
      errors.report(at_location(medium.description->where, error), "the medium does not move");
    }
  }
}

}  // namespace sheaf
