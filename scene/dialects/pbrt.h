// Inside the pbrt dialect: the state of reading, and what its readers call of each other.
#pragma once

#include "core/image.h"
#include "core/transform.h"
#include "scene/dialects/pbrt_coat.h"
#include "scene/dialects/pbrt_parameters.h"
#include "scene/dialects/read_spectrum.h"

#include <filesystem>
#include <map>
#include <memory>
#include <set>

namespace sheaf::pbrt {

/// What a directive makes: the plugin's name and its parameters.
struct Entity {
  std::string type;
  std::vector<Parameter> parameters;
  SourceLocation where;
};

/// A material, and whether textures have a part in it.
struct Material {
  std::optional<MaterialId> id;  ///< none: there was no Material so far
  bool textured = false;
  bool is_interface = false;
  std::optional<MediumId> interior = {};  ///< what shapes of it are filled with
};

/// What an AreaLightSource says.
struct AreaLight {
  SpectrumInput radiance;
  std::optional<float> power;  ///< of each shape, where the radiance is taken relative
  bool two_sided = false;
  SourceLocation where;
};

/// What AttributeBegin saves and AttributeEnd restores.
struct Attributes {
  Transform transform;  ///< the current one
  bool reverse_orientation = false;
  bool start_is_active = true;  ///< transforms change the one at the start of a motion
  Material material;
  std::optional<AreaLight> area_light;
  std::string inside, outside;  ///< names of media
  std::size_t color_space = 0;  ///< of rgb parameters: into color_space_names()
  /// Parameters that Attribute gives, by what they are for.
  std::map<std::string, std::shared_ptr<const std::vector<Parameter>>, std::less<>> defaults;
};

/// Shapes between ObjectBegin and ObjectEnd, and the places that ObjectInstance gives them.
struct Object {
  ShapeGroup group;
  std::vector<std::array<float, 12>> places;
  bool defined = false;
  SourceLocation where;  ///< of the first of either
};

/// A pbrt scene while it is read.
struct Reader {
  Description& description;
  bool lenient = false;
  std::filesystem::path folder;  ///< of the scene file, where relative names begin

  Attributes attributes;
  /// An integrator that looks at shapes alone, and its reach in metres: applied once the world is read.
  struct Visibility {
    std::string name;
    float length = 0;
  };
  std::optional<Visibility> visibility = {};
  float exposure = 1;  ///< what the film makes of a radiance of 1; once the world begins
  std::map<std::string, ScalarInput, std::less<>> float_textures = {};
  std::map<std::string, SpectrumInput, std::less<>> spectrum_textures = {};
  std::map<std::string, Material, std::less<>> materials = {};
  std::map<std::string, MediumId, std::less<>> media = {};
  std::map<std::string, Object, std::less<>> objects = {};
  std::optional<Material> standard_material = {};  ///< of shapes without one, once there was such a shape
  /// Pictures below coats, so that materials share them.
  std::map<std::tuple<std::filesystem::path, bool, BitmapDescription::ColorTransform, LayeredBase>,
           std::shared_ptr<const Image>>
      base_pictures = {};
  Object* object = nullptr;                       ///< that is being defined
  bool used_texture = false;                      ///< since it was last reset
  std::set<std::string, std::less<>> noted = {};  ///< by note_once()
  bool noted_gamut = false;                       ///< that colours were clamped

  /// Adds a remark for the user.
  void note(const SourceLocation& where, const std::string& message);
  /// The same, but each message once.
  void note_once(const SourceLocation& where, const std::string& message);
  /// Says that something is read as something else, or not at all.
  void stand_in(const SourceLocation& where, const std::string& message);
  /// Throws SceneError that `what` is not supported; if lenient, notes it and what is done `instead`.
  void unsupported(const SourceLocation& where, const std::string& what, const std::string& instead);
  /// A regular file by its name in a scene. Throws SceneError if there is none.
  std::filesystem::path find_file(const std::string& name, const SourceLocation& where);
};

// pbrt_spectrum.cpp
/// What a spectrum is for.
enum class Use {
  kReflectance,  ///< within [0, 1]
  kLight,        ///< emitted; all but rgb are scaled to a luminance of 1
  kUnbounded,    ///< not negative
};
std::optional<SpectrumDescription> find_spectrum(Parameters& p, const char* name, Use use);
/// A colour or a texture.
std::optional<SpectrumInput> find_spectrum_input(Parameters& p, const char* name, Use use);
std::optional<ScalarInput> find_scalar_input(Parameters& p, const char* name);
/// An index of refraction and, where a glass is named, how it depends on the wavelength.
struct Index {
  float value;
  std::optional<Dispersion> dispersion;
};
Index read_index(Parameters& p, const char* name, float default_value);

// pbrt_color_space.cpp
/// Those that ColorSpace may name, the first of which is Rec.709's.
const std::vector<std::string>& color_space_names();
/// A colour of the current space in Rec.709, and within what it is used for; reflectances keep white. Notes the first
/// colour that is clamped.
Vec3f to_rec709(Parameters& p, Vec3f rgb, Use use);

// pbrt_named_spectrum.cpp
/// The spectrum of a name ("metal-Au-eta", "stdillum-D65") or of a file, its luminance 1 if it is for light.
SpectrumDescription named_spectrum(Parameters& p, const char* parameter, const std::string& name, Use use);
/// The same spectrum with a luminance of 1. Throws SceneError if it is black.
SpectrumDescription with_unit_luminance(SpectrumDescription spectrum, const Parameters& p);

// pbrt_texture.cpp
/// Texture: appends it to the description and remembers it by name.
void read_texture(Reader& reader, const std::string& name, const std::string& kind, Entity entity);
/// The texture with all values multiplied by a number; nothing if tables cannot say that.
std::optional<SpectrumInput> scaled_input(Reader& reader, const SpectrumInput& input, float by);
/// The albedo of the base below a coat; nothing if tables cannot say that.
std::optional<SpectrumInput> base_input(Reader& reader, const SpectrumInput& input, const LayeredBase& base);
/// The texture with the square roots of its values; nothing if tables cannot say that.
std::optional<ScalarInput> root_of(Reader& reader, const ScalarInput& input);
/// A texture by the parameters of its kind.
TextureId append(Reader& reader, TextureDescription texture);
/// A picture as a texture that is seen upright in the unit square.
TextureId add_picture(Reader& reader, BitmapDescription picture, const SourceLocation& where);

// pbrt_picture.cpp
/// Whether pbrt's reader of PNG takes the file, by the name. Only there an encoding may be chosen.
bool is_png(const std::filesystem::path& file);
/// Whether the file may hold integers: not by the names of OpenEXR, PFM and Radiance files.
bool may_hold_integers(const std::filesystem::path& file);
/// The picture, with its changes, as albedos of the base below a coat. Null if its file cannot be read, which is an
/// error when textures are compiled.
std::shared_ptr<const Image> base_picture(const BitmapDescription& picture, const LayeredBase& base);
/// What pbrt takes for the numbers of a coloured picture: the alpha of PNG and OpenEXR files that is not 1 everywhere,
/// else the mean of red, green and blue, decoded. Null for pictures of one channel, and for files that cannot be read.
std::shared_ptr<const Image> number_picture(const BitmapDescription& picture);
/// The file of a picture in linear values, R, G and B, decoded unless `raw`. Throws SceneError at `where`.
Image read_linear_picture(const std::filesystem::path& file, bool raw, const SourceLocation& where);
/// The mean of f(x, y) times the luminance at the middle of each pixel, x to the right and y downwards in [0, 1].
double mean_luminance(const Image& picture, double (*weight)(const double* about, double x, double y),
                      const double* about);
double mean_luminance(const Image& picture);

// pbrt_material.cpp
Material make_material(Reader& reader, const std::string& name, Entity entity);
MaterialId add(Reader& reader, decltype(MaterialDescription::model) model, const SourceLocation& where);

// pbrt_subsurface.cpp
/// The medium behind the surface of a material "subsurface", whose index of refraction is `eta`.
MediumId read_subsurface(Parameters& p, float eta);

// pbrt_light.cpp
void read_light(Reader& reader, Entity entity);
AreaLight read_area_light(Reader& reader, Entity entity);

// pbrt_medium.cpp
/// sigma_a and sigma_s, or a preset of both.
AbsorptionScatteringDescription read_coefficients(Parameters& p);
/// What glows by its temperature.
void set_temperature(Parameters& p, MediumDescription& medium, GridVolumeDescription temperature, float scale);
void read_medium(Reader& reader, const std::string& name, Entity entity);
/// The medium of a name, none for the empty one.
std::optional<MediumId> medium_of(const Reader& reader, const std::string& name, const SourceLocation& where);

// pbrt_medium_grid.cpp
/// The integral over wavelengths (nm) of the y of the CIE's observer of 1931. Where pbrt does not scale what glows to a
/// luminance of 1, it is as many times brighter.
inline constexpr float kLuminanceIntegral = 106.856895f;
void read_uniform_grid(Parameters& p, MediumDescription& medium);
void read_rgb_grid(Parameters& p, MediumDescription& medium);
void read_cloud(Parameters& p, MediumDescription& medium);

// pbrt_shape.cpp
void read_shape(Reader& reader, Entity entity);

// pbrt_mesh.cpp
/// A piece of a surface of revolution or of a bilinear patch, cut into triangles: `steps_u` x `steps_v` squares.
/// `point` and `normal` take (u, v) of the unit square, which become the texture coordinates.
struct Patch {
  Vec3f (*point)(const float* shape, float u, float v);
  Vec3f (*normal)(const float* shape, float u, float v);
  float shape[12];
  int steps_u, steps_v;
};
void append(Mesh& mesh, const Patch& patch);
/// Shape "trianglemesh". `textured`: triangles without coordinates get those of pbrt.
Mesh read_triangle_mesh(Parameters& p, bool textured);
/// Shape "loopsubdiv".
Mesh read_subdivision(Parameters& p, bool textured);
/// Shape "bilinearmesh": flat patches become two triangles, others squares of them.
Mesh read_bilinear_mesh(Parameters& p);

// pbrt_curve.cpp
/// Shape "curve", in the space that `to_world` leads to.
Curves read_curve(Parameters& p, const Transform& to_world);
/// Makes a curve part of the last of `shapes` if that is one of curves, too, and of the same material.
bool append_curve(std::vector<ShapeDescription>& shapes, const ShapeDescription& shape);

// pbrt_camera.cpp
/// `world_from_camera` is the inverse of the transform at Camera.
void read_camera(Reader& reader, Entity entity, const Transform& world_from_camera, const std::string& outside);
/// Film, PixelFilter: before the camera, which asks for the frame's size. `shutter` is how long it is open.
void read_film(Reader& reader, Entity entity, float shutter);
void read_filter(Reader& reader, Entity entity);

// pbrt_integrator.cpp
void read_integrator(Reader& reader, Entity entity);
void read_sampler(Reader& reader, Entity entity);

}  // namespace sheaf::pbrt
