// Volumes that both dialects spell alike: constants, and grids in files.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// How the dialect at hand places grids that name no `to_world`.
struct VolumeDialect {
  bool bbox_of_file = false;  ///< Mitsuba before 2: a .vol file fills the box it names
  bool fits_shapes = false;   ///< Nori: grids may be stretched over the shapes that hold them, and are unless told
  bool in_shape = true;       ///< there is a shape around the medium
};

/// A grid: `filename` (.vol or .nvdb, else told by the file's first bytes; `format` forces one), `grid_name`,
/// `to_world`, `use_grid_bbox`, `filter_type`, `wrap_mode`, `raw`, in Nori `fit_to_shape`. The caller finishes `p`.
/// Throws SceneError, also for OpenVDB's own files.
GridVolumeDescription read_grid(Properties& p, const VolumeDialect& dialect,
                                std::optional<GridVolumeDescription::Format> format = std::nullopt);

/// A nested <volume> of this name, or a colour or number; nothing if the object has neither. Throws SceneError for
/// both, and for values not legal for the role; those of grids are not read here.
std::optional<VolumeInput> find_volume_input(Properties& p, const char* name, SpectrumRole role,
                                             const VolumeDialect& dialect);

/// A grid of a single voxel of value 1 over a box along the world's axes: the one around the unit cube that `to_world`
/// places. As the density of a medium it ends the medium there.
GridVolumeDescription world_box(const Transform& to_world);

/// The box along the world's axes in which Mitsuba from version 2 on evaluates a `heterogeneous` medium: around the
/// volume `name`, whose value was read as `volume`. Nothing where the volume already ends there by itself, as grids do
/// whose axes are the world's. A .vol file's own box is read for `use_grid_bbox`. Throws SceneError.
std::optional<GridVolumeDescription> find_volume_bounds(Properties& p, const char* name, const VolumeInput& volume);

/// As find_volume_input(), but the same everywhere. Throws SceneError for a grid.
std::optional<SpectrumDescription> find_constant_volume(Properties& p, const char* name, SpectrumRole role,
                                                        const VolumeDialect& dialect);

/// A <volume> of symmetric matrices: a constant with a string `value` of six numbers, xx yy zz xy xz yz, or a grid.
std::variant<std::array<float, 6>, GridVolumeDescription> read_matrix_volume(const XmlElement& element,
                                                                             ReadContext& context,
                                                                             const VolumeDialect& dialect);

/// The number that a volume means which is the same everywhere. Throws SceneError at property `name` if it is a colour.
float number_of(Properties& p, const char* name, const SpectrumDescription& spectrum);

}  // namespace sheaf
