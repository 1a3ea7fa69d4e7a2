// What a scene file says, as plain data: the common ground of all dialects. compile.cpp turns it into a Scene.
#pragma once

#include "core/error.h"
#include "core/transform.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sheaf {

/// Index into Description::materials.
enum class MaterialId : std::uint32_t {};

/// A spectral quantity as a file gives it. Its meaning (reflectance, radiance ...) comes from who holds it.
struct SpectrumDescription {
  /// The same value at every wavelength; for emission relative to D65.
  struct Constant { float value = 0; };
  /// Linear Rec.709; components may exceed 1 where the quantity may.
  struct Rgb { Vec3f value; };
  /// Piecewise linear over wavelength, zero outside. Wavelengths in nanometres, strictly increasing.
  struct Table { std::vector<float> wavelengths, values; };
  /// Planck's law, absolute, W / (m^2 sr nm), times `scale`.
  struct Blackbody { float temperature = 6500; float scale = 1; };

  std::variant<Constant, Rgb, Table, Blackbody> value = Constant{};

  static SpectrumDescription constant(float v) { return {Constant{v}}; }
  static SpectrumDescription rgb(float r, float g, float b) { return {Rgb{{r, g, b}}}; }
};

/// Lambertian reflection.
struct DiffuseDescription { SpectrumDescription reflectance = SpectrumDescription::constant(0.5f); };

/// Specular reflection off a metal. Without eta and k a perfect mirror.
struct ConductorDescription {
  struct Ior { SpectrumDescription eta, k; };
  std::optional<Ior> ior;  ///< relative to the outside medium
  SpectrumDescription specular_reflectance = SpectrumDescription::constant(1.0f);
};

/// Specular reflection and refraction at a smooth boundary.
struct DielectricDescription {
  float int_ior = 1.5046f;    ///< inside: opposite of the geometric normal
  float ext_ior = 1.000277f;  ///< outside
  SpectrumDescription specular_reflectance = SpectrumDescription::constant(1.0f);
  SpectrumDescription specular_transmittance = SpectrumDescription::constant(1.0f);
};

/// Shows `front` on the side of the normal and `back` on the other. Neither may transmit.
struct TwoSidedDescription { MaterialId front{}, back{}; };

struct MaterialDescription {
  std::variant<DiffuseDescription, ConductorDescription, DielectricDescription, TwoSidedDescription> model;
  std::string id;  ///< name for messages; may be empty
  SourceLocation where;
};

/// Triangles. Per-vertex arrays are either empty or as long as `positions`.
struct Mesh {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<Vec2f> uvs;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into the vertex arrays, all in range
};

/// A triangle mesh in a file (.obj, .ply).
struct MeshFileShape {
  std::filesystem::path file;  ///< resolved
  enum class Format { kObj, kPly } format = Format::kObj;
  bool flip_tex_coords = true;  ///< v becomes 1 - v (Mitsuba's default for OBJ)
  bool smooth_normals = true;   ///< vertices without normals get smooth ones
};
/// Centre at `center`, before the shape's transform. Normals point outwards.
struct SphereShape { Vec3f center{0, 0, 0}; float radius = 1; };
/// [-1, 1]^2 in the xy plane, normal +z, uv (0, 0) at (-1, -1).
struct RectangleShape {};
/// [-1, 1]^3, normals outwards, each face with its own uv square.
struct CubeShape {};
/// Unit disk in the xy plane, normal +z; u is the radius, v the angle / 2 pi.
struct DiskShape {};
/// Open cylinder around the segment p0 p1; normals outwards; u is the angle / 2 pi, v runs from p0 to p1.
struct CylinderShape { Vec3f p0{0, 0, 0}, p1{0, 0, 1}; float radius = 1; };

struct ShapeDescription {
  std::variant<MeshFileShape, Mesh, SphereShape, RectangleShape, CubeShape, DiskShape, CylinderShape> geometry;
  Transform to_world;
  bool flip_normals = false;
  bool face_normals = false;  ///< meshes: ignore vertex normals
  std::optional<MaterialId> material;           ///< default: diffuse, reflectance 0.5
  std::optional<SpectrumDescription> radiance;  ///< an area light, emitting on the side of the normal; W / (m^2 sr)
  SourceLocation where;
};

/// Emits `intensity` (W / sr) from `position` in all directions.
struct PointLightDescription { Vec3f position{0, 0, 0}; SpectrumDescription intensity = SpectrumDescription::constant(1); };
/// The same radiance (W / (m^2 sr)) from every direction outside the scene.
struct ConstantLightDescription { SpectrumDescription radiance = SpectrumDescription::constant(1); };

struct LightDescription {
  std::variant<PointLightDescription, ConstantLightDescription> model;
  SourceLocation where;
};

/// A pinhole camera.
struct CameraDescription {
  Transform to_world;  ///< camera space looks along +z, +y is up, +x is to the left of the picture
  float fov = 39.3077f;  ///< degrees, across the axis below; the default is a 50 mm lens on 35 mm film
  enum class FovAxis { kX, kY, kDiagonal, kSmaller, kLarger } fov_axis = FovAxis::kX;
  SourceLocation where;
};

/// A pixel reconstruction filter; sizes in pixels.
struct FilterDescription {
  enum class Kind { kBox, kTent, kGaussian, kMitchell, kCatmullRom, kLanczos } kind = Kind::kBox;
  float radius = 0.5f;   ///< box, tent; the others derive it from what follows
  float stddev = 0.5f;   ///< gaussian; cut off at 4 standard deviations
  float b = 1.0f / 3, c = 1.0f / 3;  ///< mitchell; radius 2
  float lobes = 3;       ///< lanczos; equals the radius
};

/// Half-open pixel rectangle.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
};

struct FilmDescription {
  int width = 768, height = 576;
  std::optional<PixelRect> crop;
  FilterDescription filter;
};

struct SamplerDescription {
  std::uint32_t sample_count = 4;  ///< per pixel
  std::uint32_t seed = 0;
};

/// What is computed at each pixel.
enum class IntegratorKind { kPath, kNormals, kDepth };
/// How direct light is estimated: by sampling lights, by sampling BSDFs, or both weighted by multiple importance
/// sampling.
enum class LightStrategy { kMis, kBsdfOnly, kLightOnly };

struct IntegratorDescription {
  IntegratorKind kind = IntegratorKind::kPath;
  LightStrategy strategy = LightStrategy::kMis;
  int max_depth = -1;  ///< -1 unlimited, 1 emission only, 2 direct light, ...
  int rr_depth = 5;    ///< roulette starts at this depth
  bool hide_emitters = false;  ///< directly visible lights are left out (alpha 0)
};

/// A whole scene. `notes` are remarks for the user about what was mapped or ignored.
struct Description {
  CameraDescription camera;
  FilmDescription film;
  SamplerDescription sampler;
  IntegratorDescription integrator;
  std::vector<MaterialDescription> materials;
  std::vector<ShapeDescription> shapes;
  std::vector<LightDescription> lights;
  std::vector<std::string> notes;
  std::filesystem::path file;
};

}  // namespace sheaf
