// Compiles the motions of media: checks that the grids of each medium move alike, tabulates the motion, and bounds the
// shapes around a medium relative to its grids.
#include "scene/compile/scene_compiler.h"
#include "scene/tables/instance.h"

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

/// Where a point that was at p at the first key is at a time, as a map of p. Null: the point stands still.
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

GridBox intersection(const GridBox& a, const GridBox& b) {
  return {{std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y), std::max(a.min.z, b.min.z)},
          {std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y), std::min(a.max.z, b.max.z)}};
}

bool is_empty(const GridBox& box) {
  return !(box.min.x <= box.max.x && box.min.y <= box.max.y && box.min.z <= box.max.z);
}

std::array<float, 12> matrix_rows(const Transform& transform) {
  std::array<float, 12> out;
  for (std::size_t i = 0; i < 12; ++i) out[i] = static_cast<float>(transform.matrix().m[i / 4][i % 4]);
  return out;
}

}  // namespace

const AnimatedTransform* SceneCompiler::motion_of_medium(std::size_t medium) const {
  const MediumDescription& m = in_.media[medium];
  const PhaseDescription* phase = m.phase ? &in_.phases.at(static_cast<std::size_t>(*m.phase)) : nullptr;
  const auto motion_if = [&](const std::optional<MotionId>& id) { return id ? &motion_of(*id) : nullptr; };
  // Without grids, only the emission has a place: the shapes
  const std::vector<NamedGrid> grids = grids_of(m, phase);
  const std::vector<MediumShape>& shapes = medium_shapes_[medium];
  if (grids.empty()) {
    if (!m.emission || shapes.empty()) return nullptr;
    const AnimatedTransform* motion = shapes[0].motion;
    const auto moves_alike = [&](const MediumShape& shape) { return move_alike(shape.motion, motion); };
    return std::all_of(shapes.begin(), shapes.end(), moves_alike) ? motion : nullptr;
  }
  // All grids must move alike
  const AnimatedTransform* motion = motion_if(grids[0].grid->motion);
  for (const NamedGrid& other : grids)
    if (!move_alike(motion_if(other.grid->motion), motion))
      throw SceneError(m.where, "the grids of a medium move together, but '" + std::string(other.name) +
                                    "' moves differently from '" + grids[0].name +
                                    "' (expected the same <animation> for both)");
  if (motion != nullptr && phase != nullptr && std::holds_alternative<SggxDescription>(phase->model) &&
      !is_rigid(*motion))
    throw SceneError(m.where,
                     "a medium of microflakes cannot be stretched (expected an <animation> that turns and shifts it)");
  return motion;
}

GridBox SceneCompiler::box_of_grids(std::size_t medium) const {
  const MediumRow& row = out_->media_.rows[medium];
  GridBox box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const std::uint32_t grid : {row.density, row.first_grid, row.second_grid, row.emission_grid, row.temperature,
                                   row.emission_factor, row.flake_grids})
    if (grid != kNone && places_of_grids_[grid].size[0] > 0)
      grow_box(box.min, box.max, places_of_grids_[grid].box.min, places_of_grids_[grid].box.max);
  if (box.min.x <= box.max.x) return box;
  for (const MediumShape& shape : medium_shapes_[medium]) grow_box(box.min, box.max, shape.box.min, shape.box.max);
  return box.min.x <= box.max.x ? box : GridBox{lower_, upper_};
}

std::optional<GridBox> SceneCompiler::box_of_extinction(std::size_t medium) const {
  const MediumRow& row = out_->media_.rows[medium];
  const std::uint32_t grid = row.density != kNone ? row.density : row.first_grid;
  if (grid == kNone || places_of_grids_[grid].size[0] == 0) return std::nullopt;
  const PlacedGrid& place = places_of_grids_[grid];
  if ((row.flags & kMediumBoxed) != 0) return place.box;
  // Towards a background the outermost voxels are interpolated over less than the diagonal of a voxel
  const auto& size = place.size;
  const float margin =
      length(place.box.max - place.box.min) / static_cast<float>(std::min({size[0], size[1], size[2]}));
  const Vec3f around{margin, margin, margin};
  return GridBox{place.box.min - around, place.box.max + around};
}

std::vector<GridBox> SceneCompiler::boxes_at_rest(std::size_t medium, const AnimatedTransform* motion) const {
  constexpr int kSteps = 64;
  std::vector<GridBox> out;
  const double open = in_.shutter.open, duration = moves() ? in_.shutter.close - open : 0;
  for (const MediumShape& shape : medium_shapes_[medium]) {
    if (move_alike(shape.motion, motion)) {
      out.push_back(shape.box);
      continue;
    }
    GridBox all{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    std::vector<double> times{open};
    for (int i = 1; i <= kSteps && duration > 0; ++i) times.push_back(open + duration * i / kSteps);
    for (const AnimatedTransform* moving : {motion, shape.motion})
      for (const double key : moving != nullptr ? moving->key_times() : std::vector<double>{})
        if (key > open && key < open + duration) times.push_back(key);
    for (const double time : times) {
      const Transform relative = moved(motion, time).inverse() * moved(shape.motion, time);
      const InstanceBounds box =
          instance_bounds(make_instance(matrix_rows(relative), 0, 0), shape.box.min, shape.box.max);
      grow_box(all.min, all.max, box.lower, box.upper);
    }
    out.push_back(all);
  }
  // A grid that moves is often much smaller than the shape in which it does
  const std::optional<GridBox> extent = motion != nullptr ? box_of_extinction(medium) : std::nullopt;
  if (extent) {
    for (GridBox& box : out) box = intersection(box, *extent);
    std::erase_if(out, is_empty);
  }
  return out;
}

void SceneCompiler::move_media() {
  medium_motions_.resize(in_.media.size());
  for (std::size_t i = 0; i < in_.media.size(); ++i) {
    try {
      const AnimatedTransform* motion = motion_of_medium(i);
      medium_boxes_.push_back(boxes_at_rest(i, motion));
      if (motion == nullptr) continue;
      medium_motions_[i] = add_motion_from_rest(*motion, MotionProbes::of_box(box_of_grids(i)));
      if (medium_motions_[i].segment_count == 0 || (out_->media_.rows[i].flags & kMediumHomogeneous) != 0) continue;
      out_->motion_.media.resize(i);
      out_->motion_.media.push_back(medium_motions_[i]);
    } catch (const Error& error) { throw at_place(in_.media[i].where, SceneError(error.what())); }
  }
}

}  // namespace sheaf
