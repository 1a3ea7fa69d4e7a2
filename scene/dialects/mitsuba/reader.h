// Internal declarations of the Mitsuba dialect: reader state and the functions that its files share.
#pragma once

#include "scene/data/measured_media.h"
#include "scene/dialects/xml/read_volume.h"

#include <map>
#include <optional>

namespace sheaf::mitsuba {

/// A sensor attached to a shape, with the type and placement of that shape.
struct ShapeSensor {
  const XmlElement* element;
  std::string shape_type;
  Placement placement;
};

/// The medium inside a boundary with subsurface scattering, and the boundary's indices of refraction.
struct Subsurface {
  MediumId medium{};
  float int_ior = 1, ext_ior = 1;
};

/// State while a Mitsuba scene is read.
struct Reader {
  ReadContext& context;
  bool before_version_2 = false;
  std::map<const XmlElement*, MaterialId> materials = {};    ///< read so far, by element
  std::map<const XmlElement*, Subsurface> subsurfaces = {};  ///< read so far, by element
  std::vector<ShapeSensor> shape_sensors = {};               ///< in file order
  std::optional<MaterialId> null = std::nullopt;             ///< material of null interfaces, after first use
  /// black material of light sources without a BSDF, after first use
  std::optional<MaterialId> black = std::nullopt;
};

/// Returns the material of a <bsdf>. Reads each element once.
MaterialId material_of(const XmlElement& bsdf, Reader& reader);
/// Returns the medium of a <medium>. Reads each element once.
MediumId medium_of(const XmlElement& element, Reader& reader);
/// Returns the preset named by `material`, by default skin1 (Mitsuba 0.6). Throws SceneError for unknown names.
const MeasuredMedium& read_measured_medium(Properties& p);
/// Reads the coefficients of a Mitsuba 0.6 medium: explicit values, or those of the preset. Throws SceneError if both
/// are present.
void read_measured_coefficients(Properties& p, const VolumeDialect& dialect, MediumDescription& medium);
/// Reads <subsurface type="dipole"> of Mitsuba 0.6. Turns the shape into a dielectric around a scattering medium, with
/// the roughness of its BSDF. Throws SceneError.
void read_subsurface(const XmlElement& element, Reader& reader, ShapeDescription& shape);
/// Implements TextureReader.
SpectrumInput texture_of(const XmlElement& element, ReadContext& context);
/// Appends a shape with its material, area light and media.
void read_shape(const XmlElement& element, Reader& reader);
/// Appends a light that is not attached to a shape.
void read_emitter(const XmlElement& element, Reader& reader);
/// Reads the field of view: `fov` and `fov_axis`, or `focal_length`.
void read_fov(Properties& p, CameraDescription& camera);
/// Reads camera, film and sampler.
void read_sensor(const XmlElement& element, Reader& reader);
/// Reads camera, film and sampler of a sensor attached to a shape.
void read_shape_sensor(const ShapeSensor& sensor, Reader& reader);
/// Reads the integrator, and unwraps `moment`, `aov` and other wrappers.
void read_integrator(const XmlElement& element, Reader& reader);

}  // namespace sheaf::mitsuba
