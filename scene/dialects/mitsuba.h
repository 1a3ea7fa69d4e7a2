// Inside the Mitsuba dialect: what its readers call of each other.
#pragma once

#include "scene/data/measured_media.h"
#include "scene/dialects/dialects.h"
#include "scene/dialects/read_volume.h"

#include <map>
#include <optional>

namespace sheaf::mitsuba {

/// A sensor on a shape, of that transform, of the sort of `shape_type`.
struct ShapeSensor {
  const XmlElement* element;
  std::string shape_type;
  Transform to_world;
};

/// The medium behind a boundary with subsurface scattering, and the boundary's indices of refraction.
struct Subsurface {
  MediumId medium{};
  float int_ior = 1, ext_ior = 1;
};

/// A Mitsuba scene while it is read.
struct Reader {
  ReadContext& context;
  bool before_version_2 = false;
  std::map<const XmlElement*, MaterialId> materials = {};    ///< read so far
  std::map<const XmlElement*, Subsurface> subsurfaces = {};  ///< read so far
  std::vector<ShapeSensor> shape_sensors = {};               ///< read so far
  std::optional<MaterialId> null = std::nullopt;             ///< a boundary that is not noticed, once one was read
  std::optional<MaterialId> black = std::nullopt;  ///< the material of light sources that name none, once one was read
};

/// The material of a <bsdf>; each element is read once, however often it is referred to.
MaterialId material_of(const XmlElement& bsdf, Reader& reader);
/// The medium of a <medium>; each element is read once, however often it is referred to.
MediumId medium_of(const XmlElement& element, Reader& reader);
/// The preset that `material` names, skin1 by default (Mitsuba 0.6). Throws SceneError for unknown names.
const MeasuredMedium& read_measured_medium(Properties& p);
/// Coefficients of Mitsuba 0.6: given one by one, or those of the preset. Throws SceneError if both are there.
void read_measured_coefficients(Properties& p, const VolumeDialect& dialect, MediumDescription& medium);
/// <subsurface type="dipole"> of Mitsuba 0.6: turns the shape into a dielectric around a scattering medium, as rough as
/// its bsdf. Throws SceneError.
void read_subsurface(const XmlElement& element, Reader& reader, ShapeDescription& shape);
/// A TextureReader.
SpectrumInput texture_of(const XmlElement& element, ReadContext& context);
/// Appends a shape with its material, area light and media.
void read_shape(const XmlElement& element, Reader& reader);
/// Appends a light that is not on a shape.
void read_emitter(const XmlElement& element, Reader& reader);
/// The field of view: fov and fov_axis, or focal_length.
void read_fov(Properties& p, CameraDescription& camera);
/// Camera, film and sampler.
void read_sensor(const XmlElement& element, Reader& reader);
/// The same of a sensor on a shape.
void read_shape_sensor(const ShapeSensor& sensor, Reader& reader);
/// The integrator, through the wrappers moment and aov.
void read_integrator(const XmlElement& element, Reader& reader);

}  // namespace sheaf::mitsuba
