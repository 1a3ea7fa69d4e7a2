// Makes the rows of media, with their grids and majorants.

#include "core/color/color.h"
#include "scene/compile/media/compile_media.h"
#include "scene/compile/media/flakes.h"
#include "scene/compile/media/load_volume.h"
#include "scene/compile/media/make_majorants.h"
#include "scene/spectra/spectrum_rgb.h"
#include "scene/tables/spectral_grid.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

void set_words(float (&words)[4], Vec3f rgb, float factor) {
  words[0] = rgb.x * factor;
  words[1] = rgb.y * factor;
  words[2] = rgb.z * factor;
  words[3] = 0;
}

/// Transform that maps one box to the other. Axes along which either box is flat are not scaled.
Transform stretch(const Bounds3f& from, const Bounds3f& to) {
  const Vec3f a = from.max - from.min, b = to.max - to.min;
  const auto factor = [](float x, float y) { return x > 0.0f && y > 0.0f ? y / x : 1.0f; };
  return Transform::translate(to.min) * Transform::scale({factor(a.x, b.x), factor(a.y, b.y), factor(a.z, b.z)}) *
         Transform::translate(-from.min);
}

/// Builds the tables, medium by medium.
class MediumRowBuilder {
 public:
  MediumRowBuilder(SpectrumSet* set, float step_size, CompiledMedia& out)
      : set_(set), step_size_(step_size), out_(out), tables_(out.tables) {}

  /// `scene`: bounds of the scene.
  void add(const MediumInput& medium, const Bounds3f& scene) {
    const MediumDescription& m = *medium.description;
    Bounds3f box = medium.shapes.empty() ? scene : Bounds3f::empty();
    for (const MediumShape& shape : medium.shapes) box.grow(shape.box);
    if (m.temperature && set_ == nullptr && !tables_.blackbodies) tables_.blackbodies.emplace();
    MediumRow row;
    row.phase = medium.phase_row;
    // Set the step size of ray marching
    const float diagonal = length(box.max - box.min);
    row.step_size = step_size_ > 0.0f ? step_size_ : std::max(0.01f * diagonal, 1e-6f);
    // Set coefficients and emission
    SpectrumRow spectra[kMediumSpectra] = {};
    if (const auto* by_albedo = std::get_if<ExtinctionAlbedoDescription>(&m.coefficients)) {
      row.first_grid = input(by_albedo->sigma_t, SpectrumUse::kUnbounded, m.scale, box, m.where, row.first, spectra[0]);
      row.second_grid = input(by_albedo->albedo, SpectrumUse::kReflectance, 1, box, m.where, row.second, spectra[1]);
    } else {
      const auto& both = std::get<AbsorptionScatteringDescription>(m.coefficients);
      row.flags |= kMediumAbsorptionScattering;
      row.first_grid = input(both.sigma_a, SpectrumUse::kUnbounded, m.scale, box, m.where, row.first, spectra[0]);
      row.second_grid = input(both.sigma_s, SpectrumUse::kUnbounded, m.scale, box, m.where, row.second, spectra[1]);
    }
    if (m.density) row.density = grid(*m.density, box, m.where, 1);
    add_emission(m, box, row, spectra[2]);
    if (medium.phase != nullptr)
      if (const auto* flakes = std::get_if<SggxDescription>(&medium.phase->model)) add_flakes(*flakes, m.where, row);
    // Bound the extinction
    set_flags(row, spectra);
    for (int i = 0; i < 3; ++i)
      row.mean_extinction +=
          (row.first[i] + ((row.flags & kMediumAbsorptionScattering) != 0 ? row.second[i] : 0.0f)) / 3;
    if ((row.flags & kMediumHomogeneous) == 0) {
      row.majorants = add_majorants(row, m.where);
      row.mean_extinction *= tables_.majorants.back().mean_value();
    }
    tables_.rows.push_back(row);
    if (set_ != nullptr) out_.spectra.insert(out_.spectra.end(), std::begin(spectra), std::end(spectra));
  }

  /// Makes the grids' rows, which point into the grids. Call after all grids have been added.
  void finish() {
    if (set_ != nullptr)
      for (std::size_t i = 0; i < tables_.grids.size(); ++i)
        if (tables_.grids[i].channels > 1 && !placements_[i].matrices) uplift_grid(tables_.grids[i]);
    for (std::size_t i = 0; i < tables_.grids.size(); ++i) {
      const GridPlacement& at = placements_[i];
      tables_.grid_rows.push_back(place_grid(tables_.grids[i], at.to_world, *at.description, at.where));
      out_.grids.push_back(describe_grid(tables_.grids[i], at.to_world, *at.description, at.where));
    }
    for (std::size_t i = 0; i < tables_.majorants.size(); ++i) {
      const std::size_t of = majorant_of_[i];
      if (of == kConstant) {
        tables_.majorant_rows.emplace_back().outside = 1;
      } else {
        tables_.majorant_rows.push_back(make_majorant_grid_row(
            tables_.majorants[i], tables_.grids[of], placements_[of].to_world, placements_[of].description->filter));
      }
    }
  }

 private:
  static constexpr std::size_t kConstant = static_cast<std::size_t>(-1);
  /// Maximum number of values for lookups with vector gathers.
  static constexpr std::size_t kMaxGathered = std::size_t{1} << 31;

  /// A grid's transform and origin.
  struct GridPlacement {
    Transform to_world;
    const GridVolumeDescription* description;
    SourceLocation where;
    bool matrices = false;  ///< SGGX matrices, not colors
  };

  void spectrum(const SpectrumDescription& s, SpectrumUse use, float factor, const SourceLocation& where,
                float (&words)[4], SpectrumRow& row) {
    const Vec3f rgb = use == SpectrumUse::kReflectance  ? reflectance_rgb(s)
                      : use == SpectrumUse::kIlluminant ? emission_rgb(s)
                                                        : unbounded_rgb(s);
    set_words(words, rgb, factor);
    if (set_ == nullptr) return;
    try {
      row = set_->row(s, use);
    } catch (const SceneError& error) { throw SceneError(where, error); }
    row.scale *= factor;
  }

  /// Sets a spectrum, or for a grid the constant 1. Returns the grid's row or kNone.
  std::uint32_t input(const VolumeInput& volume, SpectrumUse use, float factor, const Bounds3f& box,
                      const SourceLocation& where, float (&words)[4], SpectrumRow& row) {
    const auto* s = std::get_if<SpectrumDescription>(&volume);
    spectrum(s != nullptr ? *s : SpectrumDescription::constant(1), use, factor, where, words, row);
    return s != nullptr ? kNone : grid(std::get<GridVolumeDescription>(volume), box, where, 0);
  }

  /// Reads a grid and returns its index. `channels`: the required number of channels, 0 for any.
  std::uint32_t grid(const GridVolumeDescription& description, const Bounds3f& box, const SourceLocation& where,
                     int channels) {
    BrickGrid loaded = load_volume(description, where);
    if (channels != 0 && loaded.channels != channels)
      throw SceneError(where, fmt::format("{}: the grid has {} channels (expected {})", description.file.string(),
                                          loaded.channels, channels));
    if (loaded.is_empty()) out_.warnings.push_back(description.file.string() + ": the grid is empty");
    const Transform to_world =
        description.fit_to_shape && !loaded.is_empty() ? stretch(loaded.voxel_box(), box) : description.to_world;
    placements_.push_back({to_world, &description, where});
    tables_.grids.push_back(std::move(loaded));
    return static_cast<std::uint32_t>(tables_.grids.size() - 1);
  }

  void add_emission(const MediumDescription& m, const Bounds3f& box, MediumRow& row, SpectrumRow& spectrum_row) {
    if (!(m.emission_scale > 0.0f)) return;
    if (m.temperature) {
      row.temperature = grid(*m.temperature, box, m.where, 1);
      row.temperature_scale = m.temperature_scale;
      row.temperature_offset = m.temperature_offset;
      if (m.unit_blackbodies) row.flags |= kMediumUnitBlackbodies;
      // Planck's law is absolute, so the factor is the same at all wavelengths.
      spectrum(SpectrumDescription::constant(1), SpectrumUse::kRaw, m.emission_scale, m.where, row.emission,
               spectrum_row);
      row.flags |= kMediumEmits;
    } else if (m.emission) {
      row.emission_grid =
          input(*m.emission, SpectrumUse::kIlluminant, m.emission_scale, box, m.where, row.emission, spectrum_row);
      if (std::max({row.emission[0], row.emission[1], row.emission[2]}) > 0.0f) row.flags |= kMediumEmits;
    }
    if (m.emission_factor && (row.flags & kMediumEmits) != 0)
      row.emission_factor = grid(*m.emission_factor, box, m.where, 1);
  }

  void add_flakes(const SggxDescription& flakes, const SourceLocation& where, MediumRow& row) {
    if ((row.flags & kMediumEmits) != 0)
      throw SceneError(where,
                       "a medium of microflakes cannot emit (expected a phase function other than 'sggx', or no "
                       "'emission')");
    row.flags |= kMediumFlakes;
    if (const auto* matrix = std::get_if<std::array<float, 6>>(&flakes.matrix)) {
      std::copy(matrix->begin(), matrix->end(), row.flakes);
      row.max_flakes = largest_flake_area(*matrix);
      return;
    }
    const auto& volume = std::get<GridVolumeDescription>(flakes.matrix);
    FlakeGrids grids = load_flakes(volume, where);
    row.flake_grids = static_cast<std::uint32_t>(tables_.grids.size());
    row.max_flakes = grids.largest;
    placements_.insert(placements_.end(), 2, {volume.to_world, &volume, where, true});
    tables_.grids.push_back(std::move(grids.diagonal));
    tables_.grids.push_back(std::move(grids.others));
  }

  void set_flags(MediumRow& row, const SpectrumRow (&spectra)[kMediumSpectra]) const {
    const bool varies =
        row.density != kNone || row.first_grid != kNone || row.second_grid != kNone || row.flake_grids != kNone;
    const bool glow_varies = row.emission_grid != kNone || row.temperature != kNone || row.emission_factor != kNone;
    if (!varies && !glow_varies) row.flags |= kMediumHomogeneous;
    if (std::max({row.second[0], row.second[1], row.second[2]}) > 0.0f) row.flags |= kMediumScatters;
    const bool both = (row.flags & kMediumAbsorptionScattering) != 0;
    for (const std::uint32_t grid : {row.first_grid, both ? row.second_grid : kNone})
      if (grid != kNone && tables_.grids[grid].channels > 1) row.flags |= kMediumColored;
    const auto is_gray = [&](const float(&words)[4], const SpectrumRow& spectrum_row) {
      return words[0] == words[1] && words[1] == words[2] && (set_ == nullptr || spectrum_row.is_flat());
    };
    const std::uint32_t of = row.density != kNone ? row.density : row.first_grid;
    if (of != kNone && tables_.grids[of].border != GridBorder::kBackground) row.flags |= kMediumBoxed;
    if (is_single_grid(row, of)) row.flags |= kMediumSingleGrid;
    if (is_gray(row.first, spectra[0]) && (!both || is_gray(row.second, spectra[1])) &&
        (row.flags & kMediumColored) == 0)
      row.flags |= kMediumGray;
  }

  /// Whether the extinction is the row's spectra times the grid `of`; see kMediumSingleGrid.
  bool is_single_grid(const MediumRow& row, std::uint32_t of) const {
    if (of == kNone || row.flake_grids != kNone) return false;
    const BrickGrid& grid = tables_.grids[of];
    if (grid.channels != 1 || grid.values.size() > kMaxGathered) return false;
    if (grid.border != GridBorder::kBackground && grid.border != GridBorder::kClamp) return false;
    const bool both = (row.flags & kMediumAbsorptionScattering) != 0;
    return (of == row.first_grid || row.first_grid == kNone) &&
           (!both || (of == row.density && row.second_grid == kNone));
  }

  /// Optical thickness of one voxel of a grid, for the largest component of the extinction.
  float voxel_thickness(const MediumRow& row, std::uint32_t of) const {
    const bool both = (row.flags & kMediumAbsorptionScattering) != 0;
    float largest = 0;
    for (int i = 0; i < 3; ++i) largest = std::max(largest, row.first[i] + (both ? row.second[i] : 0.0f));
    if ((row.flags & kMediumFlakes) != 0) largest *= row.max_flakes;
    const Transform to_world = placements_[of].to_world * tables_.grids[of].grid_to_local;
    const auto& m = to_world.matrix().m;
    double side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      side += std::sqrt(m[0][axis] * m[0][axis] + m[1][axis] * m[1][axis] + m[2][axis] * m[2][axis]) / 3;
    return largest * static_cast<float>(side);
  }

  /// Adds bounds on the product of the grids that determine the extinction.
  std::uint32_t add_majorants(const MediumRow& row, const SourceLocation& where) {
    const std::uint32_t of = row.density != kNone ? row.density : row.first_grid;
    MajorantGrid majorants;
    const auto bound = [&](std::uint32_t grid) {
      // Spectra may exceed the largest component of their color by up to this factor.
      const bool uplifted = set_ != nullptr && tables_.grids[grid].channels > 1;
      return uplifted ? 2.0f : 1.0f;
    };
    if (of != kNone) {
      float factor = bound(of);
      if (of != row.first_grid && row.first_grid != kNone)
        factor *= bound(row.first_grid) * std::max(tables_.grids[row.first_grid].max_value(), 0.0f);
      std::vector<MajorantSource> sources{{&tables_.grids[of], factor}};
      // Separate grids of absorption and scattering: the sum is bounded by the larger factor times the sum of the
      // spectra.
      if ((row.flags & kMediumAbsorptionScattering) != 0 && row.second_grid != kNone && of != row.density) {
        if (row.first_grid == kNone || tables_.grids[row.first_grid].cells != tables_.grids[row.second_grid].cells)
          throw SceneError(where, "the grids of absorption and scattering have different voxels");
        sources.push_back({&tables_.grids[row.second_grid], bound(row.second_grid)});
      }
      // Emission is sampled at collisions with the majorant, so emitting media need majorants above zero.
      const bool emits = (row.flags & kMediumEmits) != 0, single = (row.flags & kMediumSingleGrid) != 0;
      majorants = make_majorant_grid(sources, placements_[of].description->filter,
                                     {voxel_thickness(row, of), single && !emits, !emits});
      majorants.outside = 0;  // see kMediumBoxed
      if (!std::isfinite(majorants.max_value())) throw SceneError(where, "the medium's extinction is not finite");
    }
    majorant_of_.push_back(of != kNone ? of : kConstant);
    tables_.majorants.push_back(std::move(majorants));
    return static_cast<std::uint32_t>(tables_.majorants.size() - 1);
  }

  SpectrumSet* set_;
  float step_size_;
  CompiledMedia& out_;
  MediumTables& tables_;
  std::vector<GridPlacement> placements_;  ///< per grid
  std::vector<std::size_t> majorant_of_;   ///< grid of each majorant grid
};

}  // namespace

BlackbodyTable::BlackbodyTable() {
  rgb.emplace_back(Vec3f{0, 0, 0});
  for (int i = 1; i < kEntries; ++i) rgb.push_back(blackbody_to_rgb(kStep * static_cast<float>(i), 1));
}

void add_medium_rows(std::span<MediumInput> media, const Bounds3f& scene, SpectrumSet* set, float step_size,
                     ErrorSink& errors, CompiledMedia& out) {
  MediumRowBuilder builder(set, step_size, out);
  for (MediumInput& medium : media) {
    try {
      builder.add(medium, scene);
    } catch (const SceneError& error) {
      medium.make_empty(error, errors);
      builder.add(medium, scene);
    }
  }
  builder.finish();
}

}  // namespace sheaf
