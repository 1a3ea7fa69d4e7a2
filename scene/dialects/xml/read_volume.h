// Volumes shared by the Nori and Mitsuba dialects: constants, and grids in files.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Placement of grids without `to_world` in this dialect.
struct VolumeDialect {
  bool bbox_of_file = false;  ///< Mitsuba before 2: a .vol file fills its own bounding box
  bool fits_shapes = false;   ///< Nori: grids may stretch over the enclosing shapes, and do by default
  bool in_shape = true;       ///< a shape encloses the medium
  bool may_move = false;      ///< `to_world` may be an <animation>
};

/// Reads a grid: `filename` (.vol, .nvdb or .vdb, otherwise recognized by its first bytes), `grid_name`, `to_world`,
/// `use_grid_bbox`, `filter_type`, `wrap_mode`, `raw`, in Nori `fit_to_shape`. The caller finishes `p`. Throws
/// SceneError, also for a format other than `format`.
GridVolumeDescription read_grid(Properties& p, const VolumeDialect& dialect,
                                std::optional<GridVolumeDescription::Format> format = std::nullopt);

/// Reads a nested <volume> of this name, or a color or number; nullopt if the object has neither. Throws SceneError if
/// both are present and for values outside the role's range. Grid values are not read here.
std::optional<VolumeInput> find_volume_input(Properties& p, const char* name, SpectrumRole role,
                                             const VolumeDialect& dialect);

/// find_volume_input() with a default value.
VolumeInput volume_input(Properties& p, const char* name, const SpectrumDescription& default_value, SpectrumRole role,
                         const VolumeDialect& dialect);
/// Whether the object has a nested <volume>, a color or a number of this name.
bool has_volume_input(Properties& p, const char* name);

/// Returns a grid with one voxel of value 1 over the axis-aligned world-space bounds of the transformed unit cube. Used
/// as density, it confines a medium to this box.
GridVolumeDescription world_box(const Transform& to_world);

/// Returns the axis-aligned box in which Mitsuba 2 and later evaluate a `heterogeneous` medium: the world bounds of the
/// volume `name`, already read as `volume`, at the first key of its motion. They move with it. Returns nullopt if the
/// volume already ends there, as axis-aligned grids do. Reads the bounding box of a .vol file if `use_grid_bbox` is
/// set. Throws SceneError.
std::optional<GridVolumeDescription> find_volume_bounds(Properties& p, const char* name, const VolumeInput& volume);

/// find_volume_input() for a constant volume. Throws SceneError for a grid.
std::optional<SpectrumDescription> find_constant_volume(Properties& p, const char* name, SpectrumRole role,
                                                        const VolumeDialect& dialect);

/// Reads a <volume> of symmetric matrices: a constant with a string `value` of six numbers, xx yy zz xy xz yz, or a
/// grid.
std::variant<std::array<float, 6>, GridVolumeDescription> read_matrix_volume(const XmlElement& element,
                                                                             ReadContext& context,
                                                                             const VolumeDialect& dialect);

/// Returns the number that a constant volume holds. Throws SceneError at property `name` if it is a color.
float number_of(Properties& p, const char* name, const SpectrumDescription& spectrum);

}  // namespace sheaf
