// Internal declarations of the pbrt dialect: reader state and the functions that its files share.
#pragma once

#include "core/image/image.h"
#include "scene/description/placement.h"
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/pbrt/coat.h"
#include "scene/dialects/pbrt/parameters.h"
#include "scene/dialects/xml/read_spectrum.h"

#include <filesystem>
#include <map>
#include <memory>
#include <set>

namespace sheaf::pbrt {

/// Arguments of a directive: plugin name and parameters.
struct DirectiveArguments {
  std::string type;
  std::vector<Parameter> parameters;
  SourceLocation where;
};

/// A material, and whether it uses textures.
struct Material {
  std::optional<MaterialId> id;  ///< absent before the first Material directive
  bool textured = false;
  bool is_interface = false;
  std::optional<MediumId> interior = {};  ///< medium inside shapes with this material
};

/// Parameters of an AreaLightSource.
struct AreaLight {
  SpectrumInput radiance;
  std::optional<float> power;  ///< of each shape (W); the radiance is then relative
  bool two_sided = false;
  SourceLocation where;
};

/// The current transformation matrices at the start and at the end of the motion.
struct TransformPair {
  Transform start, end;

  bool moves() const { return start.matrix().m != end.matrix().m; }
  TransformPair inverse() const { return {start.inverse(), end.inverse()}; }
};

/// Graphics state that AttributeBegin saves and AttributeEnd restores.
struct Attributes {
  TransformPair transform;
  bool reverse_orientation = false;
  bool start_is_active = true, end_is_active = true;  ///< which matrices transforms apply to
  Material material;
  std::optional<AreaLight> area_light;
  std::string inside, outside;  ///< names of media
  std::size_t color_space = 0;  ///< of rgb parameters: index into color_space_names()
  /// Default parameters from the directive Attribute, by target.
  std::map<std::string, std::shared_ptr<const std::vector<Parameter>>, std::less<>> defaults;
};

/// Shapes between ObjectBegin and ObjectEnd, and their instances, whose groups are set at the end.
struct Object {
  ShapeGroup group;
  std::vector<InstanceDescription> instances;
  bool defined = false;
  SourceLocation where;  ///< of ObjectBegin, else of the first ObjectInstance
};

/// State while a pbrt scene is read.
struct Reader {
  Description& description;
  ErrorSink& errors;
  std::filesystem::path folder;  ///< of the scene file; base of relative names

  Attributes attributes;
  double start_time = 0, end_time = 1;  ///< of motions
  /// An integrator for which the scene is made white after the world is read, and its maximum distance (m).
  struct VisibilityIntegrator {
    IntegratorMatch found;
    float length;
  };
  std::optional<VisibilityIntegrator> visibility = {};
  float exposure = 1;  ///< film value for a radiance of 1, set when the world begins
  std::map<std::string, ScalarInput, std::less<>> float_textures = {};
  std::map<std::string, SpectrumInput, std::less<>> spectrum_textures = {};
  std::map<std::string, Material, std::less<>> materials = {};
  std::map<std::string, MediumId, std::less<>> media = {};
  std::map<std::string, Object, std::less<>> objects = {};
  std::optional<Material> standard_material = {};  ///< of shapes without one, after first use
  /// Base albedo images below coats, shared among materials.
  std::map<std::tuple<std::filesystem::path, bool, BitmapDescription::ColorTransform, LayeredBase>,
           std::shared_ptr<const Image>>
      base_images = {};
  /// The last motion of a shape: matrices at start and end, the transform before them.
  struct LastMotion {
    std::array<Matrix4, 3> matrices;
    std::optional<MotionId> motion;
  };
  std::optional<LastMotion> last_motion = {};
  Object* object = nullptr;                       ///< being defined
  bool used_texture = false;                      ///< since the last reset
  std::set<std::string, std::less<>> noted = {};  ///< messages of note_once()
  bool noted_gamut = false;                       ///< whether the note on clamped colors was given

  /// Adds a note for the user.
  void note(const SourceLocation& where, const std::string& message);
  /// Adds a note, each message once.
  void note_once(const SourceLocation& where, const std::string& message);
  /// Adds a warning about an error that is corrected.
  void warn(const SourceLocation& where, const std::string& message);
  /// Reports that `what` is not supported, and the replacement `instead`.
  void unsupported(const SourceLocation& where, const std::string& what, const std::string& instead);
  /// The placement that a pair of matrices describes. Motions between a transform and a mirrored one are errors.
  Placement placement(const TransformPair& transform, const SourceLocation& where);
  /// Appends a motion unless the last one is equal.
  std::optional<MotionId> motion_of(const TransformPair& transform, const Transform& local,
                                    const SourceLocation& where);
  /// Adds a note if the current transform moves, but `what` does not.
  void note_rest(const SourceLocation& where, const std::string& what);
  /// Resolves the name of a regular file. Throws SceneError if it does not exist.
  std::filesystem::path find_file(const std::string& name, const SourceLocation& where);
};

/// Returns the value of a plugin in a table, mostly the function that reads it. Throws SceneError for an unknown
/// plugin; `kind` names its kind in the message, such as "shape".
template <class Value>
const Value& plugin(const NameTable<Value>& table, const char* kind, const std::string& type,
                    const SourceLocation& where) {
  if (const Value* found = table.find(type)) return *found;
  const std::vector<std::string> known = table.names();
  throw SceneError(where, fmt::format("unknown {} '{}'{}{}", kind, type, did_you_mean(type, known), known_names(known)),
                   SceneErrorCode::kUnknownName);
}

// spectrum.cpp
/// Purpose of a spectrum; determines range and scaling.
enum class Use {
  kReflectance,  ///< within [0, 1]
  kLight,        ///< emitted; scaled to unit luminance unless rgb
  kUnbounded,    ///< not negative
};
std::optional<SpectrumDescription> find_spectrum(Parameters& p, const char* name, Use use);
/// Reads a color or a texture.
std::optional<SpectrumInput> find_spectrum_input(Parameters& p, const char* name, Use use);
std::optional<ScalarInput> find_scalar_input(Parameters& p, const char* name);
/// An index of refraction, with its dispersion for named glasses.
struct Index {
  float value;
  std::optional<Dispersion> dispersion;
};
Index read_index(Parameters& p, const char* name, float default_value);

// color_space.cpp
/// Names that ColorSpace accepts. The first one is Rec.709.
const std::vector<std::string>& color_space_names();
/// Converts a color from the current color space to Rec.709, clamped to the range of `use`; reflectances keep white.
/// Adds a note for the first clamped color.
Vec3f to_rec709(Parameters& p, Vec3f rgb, Use use);

// named_spectrum.cpp
/// Returns the spectrum of a name ("metal-Au-eta", "stdillum-D65") or of a file. For lights, it is scaled to unit
/// luminance.
SpectrumDescription named_spectrum(Parameters& p, const char* parameter, const std::string& name, Use use);
/// Scales a spectrum to unit luminance. Throws SceneError if it is black.
SpectrumDescription with_unit_luminance(SpectrumDescription spectrum, const Parameters& p);

// texture.cpp
/// Directive Texture: appends the texture to the description and registers its name.
void read_texture(Reader& reader, const std::string& name, const std::string& kind, DirectiveArguments entity);
/// Returns the texture with all values scaled by `by`; nullopt if the texture description cannot express it.
std::optional<SpectrumInput> scaled_input(Reader& reader, const SpectrumInput& input, float by);
/// Returns the albedo texture of the base below a coat; nullopt if the texture description cannot express it.
std::optional<SpectrumInput> base_input(Reader& reader, const SpectrumInput& input, const LayeredBase& base);
/// Returns the texture with the square roots of its values; nullopt if the texture description cannot express it.
std::optional<ScalarInput> root_of(Reader& reader, const ScalarInput& input);
/// Appends a texture of any kind.
TextureId append(Reader& reader, TextureDescription texture);
/// Appends a bitmap texture that appears upright in the unit square.
TextureId add_bitmap(Reader& reader, BitmapDescription bitmap, const SourceLocation& where);

// image.cpp
/// Whether pbrt reads the file with its PNG reader, by file extension. Only PNG files may specify an encoding.
bool is_png(const std::filesystem::path& file);
/// Whether the file may hold integers, by file extension: false for OpenEXR, PFM and Radiance files.
bool may_hold_integers(const std::filesystem::path& file);
/// Returns the image, after its color transform, as albedos of the base below a coat. Null if the file cannot be read;
/// compiling textures then reports the error.
std::shared_ptr<const Image> base_image(const BitmapDescription& bitmap, const LayeredBase& base);
/// Returns the values that pbrt uses for a scalar texture with a color image. These are the alpha of PNG and OpenEXR
/// files unless it is 1 everywhere, else the decoded mean of red, green and blue. Null for images with one channel and
/// for unreadable files.
std::shared_ptr<const Image> scalar_image(const BitmapDescription& bitmap);
/// Reads an image file as linear R, G and B, decoded unless `raw`. Throws SceneError at `where`.
Image read_linear_image(const std::filesystem::path& file, bool raw, const SourceLocation& where);
/// Returns the mean over pixels of weight(about, x, y) times the luminance. x and y in [0, 1] are the pixel center; y
/// points down.
double mean_luminance(const Image& image, double (*weight)(const double* about, double x, double y),
                      const double* about);
double mean_luminance(const Image& image);

// material.cpp
Material make_material(Reader& reader, const std::string& name, DirectiveArguments entity);
MaterialId add(Reader& reader, decltype(MaterialDescription::model) model, const SourceLocation& where);

// subsurface.cpp
/// Appends the medium inside a surface with the material "subsurface" and index of refraction `eta`.
MediumId read_subsurface(Parameters& p, float eta);

// light.cpp
void read_light(Reader& reader, DirectiveArguments entity);
AreaLight read_area_light(Reader& reader, DirectiveArguments entity);

// medium.cpp
/// Reads sigma_a and sigma_s, or a preset of both.
AbsorptionScatteringDescription read_coefficients(Parameters& p);
/// Sets blackbody emission from a temperature grid.
void set_temperature(Parameters& p, MediumDescription& medium, GridVolumeDescription temperature, float scale);
void read_medium(Reader& reader, const std::string& name, DirectiveArguments entity);
/// Returns the medium of a name; nullopt for the empty name.
std::optional<MediumId> medium_of(const Reader& reader, const std::string& name, const SourceLocation& where);

// medium_grid.cpp
/// The integral of the CIE 1931 y-bar function over wavelengths, in nm. Where pbrt does not scale emission to unit
/// luminance, its emission is brighter by this factor.
inline constexpr float kLuminanceIntegral = 106.856895f;
void read_uniform_grid(Parameters& p, MediumDescription& medium);
void read_rgb_grid(Parameters& p, MediumDescription& medium);
void read_cloud(Parameters& p, MediumDescription& medium);

// shape.cpp
void read_shape(Reader& reader, DirectiveArguments entity);

// mesh.cpp
/// A patch of a surface of revolution or a bilinear patch, tessellated into `steps_u` x `steps_v` quads of two
/// triangles. `point` and `normal` take (u, v) in the unit square, which also become the texture coordinates.
struct Patch {
  Vec3f (*point)(const float* shape, float u, float v);
  Vec3f (*normal)(const float* shape, float u, float v);
  float shape[12];
  int steps_u, steps_v;
};
void append(Mesh& mesh, const Patch& patch);
/// Reads the shape "trianglemesh". `textured`: triangles without texture coordinates get pbrt's default ones.
Mesh read_triangle_mesh(Parameters& p, bool textured);
/// Reads the shape "loopsubdiv".
Mesh read_subdivision(Parameters& p, bool textured);
/// Reads the shape "bilinearmesh". Flat patches become two triangles, curved ones a grid of quads.
Mesh read_bilinear_mesh(Parameters& p);

// curve.cpp
/// Reads the shape "curve", transformed by `to_world`.
Curves read_curve(Parameters& p, const Transform& to_world);
/// Merges a curve into the last of `shapes` if that also holds curves with the same material. Returns whether it did.
bool append_curve(std::vector<ShapeDescription>& shapes, const ShapeDescription& shape);

// camera.cpp
/// `world_from_camera` is the inverse of the current transformation matrices at the Camera directive.
void read_camera(Reader& reader, DirectiveArguments entity, const TransformPair& world_from_camera,
                 const std::string& outside);
/// The shutter of a camera, whose times default to 0 and 1. Exchanges them if it closes before it opens, with a
/// warning.
ShutterDescription read_shutter(Reader& reader, const DirectiveArguments& camera);
/// The exposure time of a shutter. A still, whose shutter opens and closes at one time, has the exposure of 1 s.
double exposure_time(const ShutterDescription& shutter);

/// Reads Film and PixelFilter. Call these before read_camera(), which needs the frame's size. `shutter` is the exposure
/// time (s).
void read_film(Reader& reader, DirectiveArguments entity, float shutter);
void read_filter(Reader& reader, DirectiveArguments entity);

// integrator.cpp
void read_integrator(Reader& reader, DirectiveArguments entity);
void read_sampler(Reader& reader, DirectiveArguments entity);

}  // namespace sheaf::pbrt
