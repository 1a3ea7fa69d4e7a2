// Helpers for tests of scene readers: temporary scene files, error messages of scenes, and a Description as text.
#pragma once

#include "scene/dialects/read_scene.h"
#include "tests/support/contains.h"
#include "tests/support/temporary_folder.h"

#include <filesystem>
#include <sstream>
#include <string>

namespace sheaf::test {

/// Writes a file into a folder, creates its subfolders, and returns its path.
inline std::filesystem::path write_below(const TemporaryFolder& folder, const std::string& name,
                                         const std::string& text) {
  const std::filesystem::path file = folder / name;
  std::filesystem::create_directories(file.parent_path());
  write_bytes(file, text);
  return file;
}

/// Reads `text` as scene.xml in a folder that also has dummy mesh and image files, which are never opened.
inline Description read_text(const std::string& text, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  for (const char* name : {"mesh.obj", "mesh.ply", "mesh.serialized", "image.png"}) write_below(folder, name, "");
  return read_scene(write_below(folder, "scene.xml", text), options);
}

/// The message of the SceneError that reading `file` throws, without folder names; empty if it does not throw.
inline std::string error_of(const std::filesystem::path& file, const ReadOptions& options = {}) {
  try {
    read_scene(file, options);
  } catch (const SceneError& error) {
    std::string message = error.what();
    const std::string folder = file.parent_path().string() + "/";
    for (std::size_t at = message.find(folder); at != std::string::npos; at = message.find(folder))
      message.erase(at, folder.size());
    return message;
  }
  return {};
}

inline std::string error_of_text(const std::string& text, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  for (const char* name : {"mesh.obj", "image.png"}) write_below(folder, name, "");
  return error_of(write_below(folder, "scene.xml", text), options);
}

/// A Mitsuba scene with the sensor in line 2, the integrator in line 3, and `inside` from line 4.
inline std::string mitsuba_scene(const std::string& inside, const std::string& sensor = "<sensor type='perspective'/>",
                                 const std::string& integrator = "<integrator type='path'/>",
                                 const std::string& version = "3.0.0") {
  return "<scene version='" + version + "'>\n" + sensor + "\n" + integrator + "\n" + inside + "\n</scene>\n";
}

template <class... Fs> struct Overloaded : Fs... { using Fs::operator()...; };
template <class... Fs> Overloaded(Fs...) -> Overloaded<Fs...>;

inline std::string dump(const SpectrumDescription& s) {
  std::ostringstream out;
  out << std::hexfloat;
  std::visit(Overloaded{[&](const SpectrumDescription::Constant& v) { out << "constant " << v.value; },
                        [&](const SpectrumDescription::Rgb& v) {
                          out << "rgb " << v.value.x << ' ' << v.value.y << ' ' << v.value.z;
                        },
                        [&](const SpectrumDescription::Table& v) {
                          out << "table";
                          for (std::size_t i = 0; i < v.values.size(); ++i)
                            out << ' ' << v.wavelengths[i] << ':' << v.values[i];
                        },
                        [&](const SpectrumDescription::Blackbody& v) {
                          out << "blackbody " << v.temperature << ' ' << v.scale;
                        }},
             s.value);
  return out.str();
}

inline std::string dump(const Transform& t) {
  std::ostringstream out;
  out << std::hexfloat;
  for (const auto& row : t.matrix().m)
    for (double v : row) out << v << ' ';
  return out.str();
}

inline std::string dump(const SpectrumInput& input) {
  const auto* texture = std::get_if<TextureId>(&input);
  return texture ? "texture " + std::to_string(static_cast<unsigned>(*texture))
                 : dump(std::get<SpectrumDescription>(input));
}

inline std::string dump(const ScalarInput& input) {
  if (const auto* texture = std::get_if<TextureId>(&input))
    return "texture " + std::to_string(static_cast<unsigned>(*texture));
  std::ostringstream out;
  out << std::hexfloat << std::get<float>(input);
  return out.str();
}

inline std::string dump(MaterialId id) { return std::to_string(static_cast<unsigned>(id)); }
inline std::string dump(TextureId id) { return std::to_string(static_cast<unsigned>(id)); }
inline std::string dump(const std::optional<RoughnessDescription>& r);

/// All arguments as text, separated by spaces. Files without their folders, enumerators as numbers.
template <class... T> std::string dump_all(const T&... values) {
  std::ostringstream out;
  out << std::hexfloat;
  const auto one = [&]<class Value>(const Value& v) {
    if constexpr (requires { dump(v); } && !std::is_arithmetic_v<Value>)
      out << ' ' << dump(v);
    else if constexpr (std::is_enum_v<Value>)
      out << ' ' << static_cast<int>(v);
    else if constexpr (std::is_same_v<Value, std::filesystem::path>)
      out << ' ' << v.filename().string();
    else
      out << ' ' << v;
  };
  (one(values), ...);
  return out.str().substr(sizeof...(T) > 0 ? 1 : 0);
}

inline std::string dump(const std::optional<RoughnessDescription>& r) {
  if (!r) return "smooth";
  return dump_all(r->distribution == RoughnessDescription::Distribution::kGgx ? "ggx" : "beckmann", r->alpha_u,
                  r->alpha_v);
}

inline std::string dump(const std::array<float, 6>& m) { return dump_all(m[0], m[1], m[2], m[3], m[4], m[5]); }

/// A model as its first name in files, or its position in `Models`, and the values of its fields().
template <class Models, class Model> std::string dump_model(const Model& model) {
  std::string name = std::to_string(Models(model).index());
  if constexpr (Model::kPlugins.size() > 0) name = Model::kPlugins[0];
  const std::string values = std::apply([](const auto&... field) { return dump_all(field...); }, Model::fields(model));
  return values.empty() ? name : name + " " + values;
}

inline std::string dump(const TextureDescription& t) {
  const auto dump_texture = [](const auto& model) { return dump_model<TextureModel>(model); };
  return std::visit(dump_texture, t.model) + " to_uv " + dump(t.to_uv);
}

template <DeclarativeBsdf Model> std::string dump(const Model& v) {
  return std::apply([](const auto&... input) { return dump_all(Model::kPlugins[0].name, input...); }, Model::fields(v));
}
inline std::string dump(const ConductorDescription& v) {
  std::string text = dump_all("conductor", v.specular_reflectance);
  if (v.ior) text += dump_all(" eta", v.ior->eta, "k", v.ior->k);
  return v.roughness ? text + " " + dump(v.roughness) : text;
}
inline std::string dump(const DielectricDescription& v) {
  return dump_all("dielectric", v.int_ior, v.ext_ior, v.specular_reflectance, v.specular_transmittance, v.thin,
                  v.roughness);
}
inline std::string dump(const PlasticDescription& v) {
  return dump_all("plastic", v.int_ior, v.ext_ior, v.diffuse_reflectance, v.specular_reflectance, v.nonlinear,
                  v.roughness);
}
inline std::string dump(const PrincipledDescription& v) {
  return dump_all("principled", v.base_color, v.roughness, v.anisotropic, v.metallic, v.spec_trans, v.spec_tint,
                  v.sheen, v.sheen_tint, v.flatness, v.clearcoat, v.clearcoat_gloss, v.eta);
}
inline std::string dump(const PrincipledThinDescription& v) {
  return dump_all("principledthin", v.base_color, v.roughness, v.anisotropic, v.spec_trans, v.eta, v.spec_tint, v.sheen,
                  v.sheen_tint, v.flatness, v.diff_trans);
}
inline std::string dump(const DisneyDescription& v) {
  return dump_all("disney", v.base_color, v.metallic, v.subsurface, v.specular, v.specular_tint, v.roughness,
                  v.anisotropic, v.sheen, v.sheen_tint, v.clearcoat, v.clearcoat_gloss);
}
inline std::string dump(const NoriMicrofacetDescription& v) {
  return dump_all("microfacet", v.int_ior, v.ext_ior, v.alpha, v.kd);
}
inline std::string dump(const RoughDiffuseDescription& v) {
  return dump_all("roughdiffuse", v.reflectance, v.alpha, v.fast);
}
inline std::string dump(const WardDescription& v) {
  return dump_all("ward", static_cast<int>(v.variant), v.diffuse_reflectance, v.specular_reflectance, v.alpha_u,
                  v.alpha_v);
}
inline std::string dump(const MeasuredDescription& v) { return "measured " + v.file.filename().string(); }
inline std::string dump(const HanrahanKruegerDescription& v) {
  return dump_all("hk", v.first, v.second, v.by_albedo, v.thickness, v.g);
}
inline std::string dump(const HairDescription& v) {
  const std::string color = std::visit(
      Overloaded{[](const HairDescription::Melanin& c) { return dump_all("melanin", c.eumelanin, c.pheomelanin); },
                 [](const HairDescription::Absorption& c) { return dump_all("absorption", c.sigma_a, c.scale); },
                 [](const HairDescription::Reflectance& c) { return dump_all("reflectance", c.color); }},
      v.color);
  return dump_all("hair", color, v.longitudinal_roughness, v.azimuthal_roughness, v.scale_tilt, v.int_ior, v.ext_ior);
}
inline std::string dump(const CoatDescription& v) {
  return dump_all("coating", v.int_ior, v.ext_ior, v.thickness, v.sigma_a, v.specular_reflectance, v.roughness,
                  v.nested);
}
inline std::string dump(const NullDescription&) { return "null"; }
inline std::string dump(const TwoSidedDescription& v) { return dump_all("twosided", v.front, v.back); }
inline std::string dump(const MaskDescription& v) { return dump_all("mask", v.opacity, v.nested); }
inline std::string dump(const BlendDescription& v) { return dump_all("blend", v.weight, v.nested[0], v.nested[1]); }
inline std::string dump(const NormalOptions& v) {
  return std::string(v.fix_invalid_normals ? "" : " keep_normals") + (v.soften_terminator ? "" : " hard_terminator");
}
inline std::string dump(const BumpMapDescription& v) {
  return dump_all("bumpmap", v.displacement, v.scale, v.nested) + dump(v.options);
}
inline std::string dump(const NormalMapDescription& v) {
  return dump_all("normalmap", v.normals, v.flip_green, v.nested) + dump(v.options);
}

inline std::string dump(const MaterialDescription& m) {
  return std::visit([](const auto& model) { return dump(model); }, m.model);
}

inline std::string dump(const ShapeDescription& s) {
  std::ostringstream out;
  out << std::hexfloat << "shape " << s.geometry.index();
  if (const auto* mesh = std::get_if<MeshFileShape>(&s.geometry))
    out << ' ' << mesh->file.filename() << ' ' << static_cast<int>(mesh->format) << ' ' << mesh->flip_tex_coords;
  if (const auto* sphere = std::get_if<SphereShape>(&s.geometry))
    out << ' ' << sphere->center.x << ' ' << sphere->center.y << ' ' << sphere->center.z << ' ' << sphere->radius;
  if (const auto* c = std::get_if<CylinderShape>(&s.geometry))
    out << ' ' << c->p0.x << ' ' << c->p0.y << ' ' << c->p0.z << ' ' << c->p1.x << ' ' << c->p1.y << ' ' << c->p1.z
        << ' ' << c->radius;
  out << ' ' << dump(s.to_world) << s.flip_normals << s.face_normals;
  if (s.material) out << " material " << static_cast<unsigned>(*s.material);
  if (s.radiance) out << " radiance " << dump(*s.radiance);
  return out.str();
}

inline std::string dump(Vec3f v) {
  std::ostringstream out;
  out << std::hexfloat << v.x << ' ' << v.y << ' ' << v.z << ' ';
  return out.str();
}

inline std::string dump(const LightDescription& light) {
  std::ostringstream out;
  out << std::hexfloat;
  std::visit(Overloaded{[&](const PointLightDescription& v) {
                          out << "point " << v.position.x << ' ' << v.position.y << ' ' << v.position.z << ' '
                              << dump(v.intensity);
                        },
                        [&](const ConstantLightDescription& v) { out << "constant " << dump(v.radiance); },
                        [&](const SpotLightDescription& v) {
                          out << "spot " << static_cast<int>(v.falloff) << ' ' << dump(v.to_world) << dump(v.intensity)
                              << ' ' << v.cutoff_angle << ' ' << v.beam_width;
                          if (v.texture) out << " texture " << static_cast<unsigned>(*v.texture);
                        },
                        [&](const DirectionalLightDescription& v) {
                          out << "directional " << v.direction.x << ' ' << v.direction.y << ' ' << v.direction.z << ' '
                              << dump(v.irradiance);
                        },
                        [&](const GoniometricLightDescription& v) {
                          out << "goniometric " << dump(v.intensity) << " image " << dump(v.image) << ' '
                              << dump(v.to_world);
                        },
                        [&](const ProjectorDescription& v) {
                          out << "projector " << dump(v.to_world) << dump(v.irradiance) << ' ' << v.scale << ' '
                              << v.fov << ' ' << static_cast<int>(v.fov_axis);
                        },
                        [&](const EnvmapDescription& v) {
                          out << "envmap " << v.file.filename() << ' ' << v.scale << ' ' << dump(v.to_world)
                              << v.mis_compensation;
                        },
                        [&](const SkyDescription& v) {
                          out << "sky " << dump(v.up) << v.turbidity << ' ' << dump(v.albedo) << ' ' << v.scale << ' '
                              << v.sun_scale << ' ' << v.stretch << ' ' << v.extend << ' ' << v.resolution;
                          for (const Vec3f& sun : v.suns) out << ' ' << dump(sun);
                        },
                        [&](const SunDescription& v) {
                          out << "sun " << dump(v.up) << dump(v.direction) << v.turbidity << ' ' << v.scale << ' '
                              << v.radius << ' ' << v.stretch;
                        },
                        [&](const BeamDescription& v) { out << "beam " << dump(v.to_world) << dump(v.power); }},
             light.model);
  return out.str();
}

/// Everything in a Description that affects the image, bit for bit; without source locations, ids and notes.
inline std::string dump(const Description& d) {
  std::ostringstream out;
  const CameraDescription& c = d.camera;
  out << std::hexfloat << "camera " << static_cast<int>(c.projection) << ' ' << dump(c.to_world) << c.fov << ' '
      << static_cast<int>(c.fov_axis) << ' ' << c.aperture_radius << ' ' << c.focus_distance << ' '
      << c.principal_point_x << ' ' << c.principal_point_y << ' ' << c.near_clip << ' ' << c.far_clip << ' '
      << c.distortion[0] << ' ' << c.distortion[1] << " of " << d.more_cameras.size() + 1 << '\n';
  out << "film " << d.film.width << 'x' << d.film.height;
  if (d.film.crop)
    out << " crop " << d.film.crop->x0 << ',' << d.film.crop->y0 << ',' << d.film.crop->x1 << ',' << d.film.crop->y1;
  const PixelFilter& f = d.film.filter;
  out << "\nfilter " << static_cast<int>(f.kind) << ' ' << f.radius << ' ' << f.stddev << ' ' << f.b << ' ' << f.c
      << ' ' << f.lobes << '\n';
  out << "sampler " << static_cast<int>(d.sampler.kind) << ' ' << d.sampler.sample_count << ' ' << d.sampler.seed
      << '\n';
  out << "integrator " << static_cast<int>(d.integrator.kind) << ' ' << static_cast<int>(d.integrator.strategy) << ' '
      << d.integrator.max_depth << ' ' << d.integrator.roulette_depth() << ' ' << d.integrator.hide_emitters << '\n';
  for (const auto& texture : d.textures) out << dump(texture) << '\n';
  for (const auto& material : d.materials) out << dump(material) << '\n';
  for (const auto& shape : d.shapes) out << dump(shape) << '\n';
  for (const auto& light : d.lights) out << dump(light) << '\n';
  return out.str();
}

}  // namespace sheaf::test
