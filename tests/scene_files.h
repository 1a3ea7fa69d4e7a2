// For tests of scene reading: temporary scene files, the message that a scene causes, and a Description as text.
#pragma once

#include "scene/read_scene.h"
#include "tests/temporary_folder.h"

#include <filesystem>
#include <sstream>
#include <string>

namespace sheaf::test {

/// Writes a file below a folder, with the folders it needs; returns its path.
inline std::filesystem::path write_below(const TemporaryFolder& folder, const std::string& name,
                                         const std::string& text) {
  const std::filesystem::path file = folder / name;
  std::filesystem::create_directories(file.parent_path());
  write_bytes(file, text);
  return file;
}

/// Reads `text` as scene.xml in a folder that also holds a mesh.obj and a mesh.ply (which are never opened).
inline Description read_text(const std::string& text, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  write_below(folder, "mesh.obj", "");
  write_below(folder, "mesh.ply", "");
  return read_scene(write_below(folder, "scene.xml", text), options);
}

/// The message of the SceneError that reading `file` throws, folder names removed; empty if it throws none.
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
  write_below(folder, "mesh.obj", "");
  return error_of(write_below(folder, "scene.xml", text), options);
}

/// A Mitsuba scene: the sensor stands in line 2, the integrator in line 3, `inside` begins in line 4.
inline std::string mitsuba_scene(const std::string& inside, const std::string& sensor = "<sensor type='perspective'/>",
                                 const std::string& integrator = "<integrator type='path'/>",
                                 const std::string& version = "3.0.0") {
  return "<scene version='" + version + "'>\n" + sensor + "\n" + integrator + "\n" + inside + "\n</scene>\n";
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

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

inline std::string dump(const MaterialDescription& m) {
  std::ostringstream out;
  out << std::hexfloat;
  std::visit(Overloaded{[&](const DiffuseDescription& v) { out << "diffuse " << dump(v.reflectance); },
                        [&](const ConductorDescription& v) {
                          out << "conductor " << dump(v.specular_reflectance);
                          if (v.ior) out << " eta " << dump(v.ior->eta) << " k " << dump(v.ior->k);
                        },
                        [&](const DielectricDescription& v) {
                          out << "dielectric " << v.int_ior << ' ' << v.ext_ior << ' ' << dump(v.specular_reflectance)
                              << ' ' << dump(v.specular_transmittance);
                        },
                        [&](const TwoSidedDescription& v) {
                          out << "twosided " << static_cast<unsigned>(v.front) << ' ' << static_cast<unsigned>(v.back);
                        }},
             m.model);
  return out.str();
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

inline std::string dump(const LightDescription& light) {
  std::ostringstream out;
  out << std::hexfloat;
  std::visit(Overloaded{[&](const PointLightDescription& v) {
                          out << "point " << v.position.x << ' ' << v.position.y << ' ' << v.position.z << ' '
                              << dump(v.intensity);
                        },
                        [&](const ConstantLightDescription& v) { out << "constant " << dump(v.radiance); }},
             light.model);
  return out.str();
}

/// Everything that a Description says about the picture, bit for bit; no places, ids, notes.
inline std::string dump(const Description& d) {
  std::ostringstream out;
  out << std::hexfloat << "camera " << dump(d.camera.to_world) << d.camera.fov << ' '
      << static_cast<int>(d.camera.fov_axis) << '\n';
  out << "film " << d.film.width << 'x' << d.film.height;
  if (d.film.crop)
    out << " crop " << d.film.crop->x0 << ',' << d.film.crop->y0 << ',' << d.film.crop->x1 << ',' << d.film.crop->y1;
  const FilterDescription& f = d.film.filter;
  out << "\nfilter " << static_cast<int>(f.kind) << ' ' << f.radius << ' ' << f.stddev << ' ' << f.b << ' ' << f.c
      << ' ' << f.lobes << '\n';
  out << "sampler " << d.sampler.sample_count << ' ' << d.sampler.seed << '\n';
  out << "integrator " << static_cast<int>(d.integrator.kind) << ' ' << static_cast<int>(d.integrator.strategy) << ' '
      << d.integrator.max_depth << ' ' << d.integrator.rr_depth << ' ' << d.integrator.hide_emitters << '\n';
  for (const auto& material : d.materials) out << dump(material) << '\n';
  for (const auto& shape : d.shapes) out << dump(shape) << '\n';
  for (const auto& light : d.lights) out << dump(light) << '\n';
  return out.str();
}

}  // namespace sheaf::test
