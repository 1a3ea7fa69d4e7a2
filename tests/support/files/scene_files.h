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
  std::filesystem::path file = folder / name;
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

/// The errors that reading `text` as scene.xml reports, in order.
inline std::vector<SceneError> errors_of_text(const std::string& text, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  for (const char* name : {"mesh.obj", "image.png"}) write_below(folder, name, "");
  try {
    read_scene(write_below(folder, "scene.xml", text), options);
  } catch (const SceneErrors& errors) { return errors.all(); } catch (const SceneError& error) {
    return {error};
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

inline std::string dump(Vec3f v) {
  std::ostringstream out;
  out << std::hexfloat << v.x << ' ' << v.y << ' ' << v.z;
  return out.str();
}

inline std::string dump(Vec3d v) {
  std::ostringstream out;
  out << std::hexfloat << v.x << ' ' << v.y << ' ' << v.z;
  return out.str();
}

inline std::string dump(const RoughnessDescription& r);
inline std::string dump(const NormalOptions& options);

template <class... T> std::string dump_all(const T&... values);

/// A value of a description: members of structs with fields(), files without their folders, enumerators and the
/// alternatives of variants as numbers. Empty for absent values.
template <class Value> std::string text_of(const Value& v) {
  std::ostringstream out;
  out << std::hexfloat;
  if constexpr (requires { dump(v); } && !std::is_arithmetic_v<Value>) {
    out << dump(v);
  } else if constexpr (std::is_enum_v<Value>) {
    out << static_cast<int>(v);
  } else if constexpr (std::is_same_v<Value, std::filesystem::path>) {
    out << v.filename().string();
  } else if constexpr (requires { Value::fields(v); }) {
    out << std::apply([](const auto&... field) { return dump_all(field...); }, Value::fields(v));
  } else if constexpr (requires { v.has_value(); }) {
    if (v) out << text_of(*v);
  } else if constexpr (requires { v.index(); }) {
    out << v.index() << ' ' << std::visit([](const auto& alternative) { return text_of(alternative); }, v);
  } else if constexpr (requires { v.begin(); } && !std::is_convertible_v<Value, std::string_view>) {
    for (const auto& element : v) out << (&element == &*v.begin() ? "" : " ") << text_of(element);
  } else {
    out << v;
  }
  return out.str();
}

/// All arguments as text, separated by spaces.
template <class... T> std::string dump_all(const T&... values) {
  std::string all;
  [[maybe_unused]] const auto add = [&](const std::string& text) {
    if (!text.empty()) all += (all.empty() ? "" : " ") + text;
  };
  (add(text_of(values)), ...);
  return all;
}

inline std::string dump(const NormalOptions& options) {
  return dump_all(options.fix_invalid_normals ? "" : "keep_normals",
                  options.soften_terminator ? "" : "hard_terminator");
}
inline std::string dump(const RoughnessDescription& r) {
  return dump_all(r.is_ggx() ? "ggx" : "beckmann", r.alpha_u, r.alpha_v);
}

/// The first name of a model in files; another name if it has none.
template <class Model> std::string name_of(const char* other) {
  if constexpr (std::size(Model::kPlugins) == 0)
    return other;
  else if constexpr (requires { Model::kPlugins[0].name; })
    return Model::kPlugins[0].name;
  else
    return Model::kPlugins[0];
}

/// A name, and the fields of a model.
template <class Model> std::string dump_model(const std::string& name, const Model& model) {
  const std::string values = std::apply([](const auto&... field) { return dump_all(field...); }, Model::fields(model));
  return values.empty() ? name : name + " " + values;
}

inline std::string dump(const TextureDescription& t) {
  const auto dump_texture = []<class Model>(const Model& model) {
    return dump_model(name_of<Model>("texture"), model);
  };
  return std::visit(dump_texture, t.model) + " to_uv " + dump_all(t.to_uv);
}

template <class Closure, class... More> const char* name_of_closure(ClosureList<Closure, More...>) {
  return Closure::kInfo.name;
}
inline const char* name_of_closure(ClosureList<>) { return "material"; }

inline std::string dump(const MaterialDescription& m) {
  const auto dump_material = []<class Model>(const Model& model) {
    return dump_model(name_of<Model>(name_of_closure(typename Model::Closures{})), model);
  };
  return std::visit(dump_material, m.model);
}

inline std::string dump(const LightDescription& light) {
  const auto dump_light = []<class Model>(const Model& model) {
    const char* label = "light";
    LightKinds::for_each([&]<class Kind>() {
      const auto find = [&]<class... Descriptions>(LightDescriptions<Descriptions...>) {
        if ((std::is_same_v<Model, Descriptions> || ...)) label = Kind::kLabel;
      };
      find(typename Kind::Descriptions{});
    });
    return dump_model(name_of<Model>(label), model);
  };
  return std::visit(dump_light, light.model);
}

inline std::string dump(const ShapeDescription& s) {
  std::ostringstream out;
  out << std::hexfloat << "shape " << s.geometry.index();
  if (const auto* mesh = std::get_if<MeshFileShape>(&s.geometry))
    out << ' ' << mesh->file.filename() << ' ' << mesh->format << ' ' << mesh->flip_tex_coords;
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
