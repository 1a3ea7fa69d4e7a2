#include "tools/python/bindings/module_queries.h"

#include "core/io/error.h"
#include "tools/python/bindings/bsdf.h"
#include "tools/python/bindings/session.h"
#include "tools/python/bindings/trace.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstring>

namespace py = pybind11;

namespace sheaf {

namespace {

static_assert(sizeof(Vec3f) == 3 * sizeof(float) && sizeof(Vec3d) == 3 * sizeof(double));
template <class Number> using VectorsOf = py::array_t<Number, py::array::c_style | py::array::forcecast>;
using Vectors = VectorsOf<float>;
using Points = VectorsOf<double>;

/// The package has checked the shape.
template <class Vector, class Number> std::vector<Vector> rows_of(const VectorsOf<Number>& values) {
  if (values.ndim() != 2 || values.shape(1) != 3) throw Error(ExitCode::kUsage, "expected an array N x 3");
  std::vector<Vector> out(static_cast<std::size_t>(values.shape(0)));
  if (!out.empty()) std::memcpy(static_cast<void*>(out.data()), values.data(), out.size() * sizeof(Vector));
  return out;
}
std::vector<Vec3f> vectors_of(const Vectors& values) { return rows_of<Vec3f>(values); }
std::vector<Vec3d> points_of(const Points& values) { return rows_of<Vec3d>(values); }

py::array array_of(const std::vector<Vec3f>& values) {
  return py::array_t<float>({static_cast<py::ssize_t>(values.size()), py::ssize_t{3}},
                            reinterpret_cast<const float*>(values.data()));
}

py::array array_of(const std::vector<Vec3d>& values) {
  return py::array_t<double>({static_cast<py::ssize_t>(values.size()), py::ssize_t{3}},
                             reinterpret_cast<const double*>(values.data()));
}

py::array pairs_of(const std::vector<float>& values) {
  return py::array_t<float>({static_cast<py::ssize_t>(values.size() / 2), py::ssize_t{2}}, values.data());
}

template <class T> py::array array_of(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// The number for each row in `rows`; -1 for kNone.
py::array numbers_of(const std::vector<std::uint32_t>& rows, const std::vector<std::uint32_t>& number_of_row) {
  std::vector<std::int32_t> out;
  out.reserve(rows.size());
  for (const std::uint32_t row : rows) out.push_back(row == kNone ? -1 : static_cast<std::int32_t>(number_of_row[row]));
  return array_of(out);
}

py::dict trace_arrays(Session& session, const Points& origins, const Vectors& directions) {
  const std::vector<Vec3d> from = points_of(origins);
  const std::vector<Vec3f> along = vectors_of(directions);
  if (from.size() != along.size()) throw Error(ExitCode::kUsage, "origins and directions differ in length");
  RayHits hits;
  SceneNames names;
  {
    const py::gil_scoped_release unlocked;
    session.with_scene({}, [&](const LoadedScene& loaded) {
      hits = trace_rays(loaded.scene->view(), from, along);
      names = loaded.scene->names();
    });
  }
  py::dict out;
  out["distance"] = array_of(hits.distance);
  out["position"] = array_of(hits.position);
  out["normal"] = array_of(hits.normal);
  out["shading_normal"] = array_of(hits.shading_normal);
  out["uv"] = pairs_of(hits.uv);
  out["barycentric"] = pairs_of(hits.barycentric);
  out["primitive"] = array_of(hits.primitive);
  out["object"] = numbers_of(hits.shape, names.object_of_shape);
  out["material"] = numbers_of(hits.shape, names.material_of_shape);
  std::vector<std::int32_t> instance;
  for (const std::uint32_t row : hits.instance) instance.push_back(row == kNone ? -1 : static_cast<std::int32_t>(row));
  out["instance"] = array_of(instance);
  out["object_names"] = names.objects;
  out["material_names"] = names.materials;
  return out;
}

/// Options of the compiled scene for BSDFs: parameters are spectra in spectral mode.
const OptionValues& rgb_options() {
  static const OptionValues options{{"color", std::string("rgb")}};
  return options;
}

py::tuple evaluate_arrays(Session& session, const std::string& material, const Vectors& wo, const Vectors& wi) {
  const std::vector<Vec3f> outgoing = vectors_of(wo), incoming = vectors_of(wi);
  if (outgoing.size() != incoming.size()) throw Error(ExitCode::kUsage, "wo and wi differ in length");
  BsdfValues values;
  {
    const py::gil_scoped_release unlocked;
    session.with_scene(rgb_options(), [&](const LoadedScene& loaded) {
      values = evaluate_bsdf(*loaded.scene, material_row(*loaded.scene, material), outgoing, incoming);
    });
  }
  return py::make_tuple(array_of(values.f_cos), array_of(values.pdf));
}

py::tuple sample_arrays(Session& session, const std::string& material, const Vectors& wo, const Vectors& u) {
  const std::vector<Vec3f> outgoing = vectors_of(wo), numbers = vectors_of(u);
  if (outgoing.size() != numbers.size()) throw Error(ExitCode::kUsage, "wo and u differ in length");
  BsdfSamples samples;
  {
    const py::gil_scoped_release unlocked;
    session.with_scene(rgb_options(), [&](const LoadedScene& loaded) {
      samples = sample_bsdf(*loaded.scene, material_row(*loaded.scene, material), outgoing, numbers);
    });
  }
  return py::make_tuple(array_of(samples.wi), array_of(samples.weight), array_of(samples.pdf),
                        array_of(samples.eta_scale), array_of(samples.valid).attr("astype")("bool"));
}

}  // namespace

void add_queries(py::module_& m) {
  m.def("trace", trace_arrays);
  m.def("evaluate_bsdf", evaluate_arrays);
  m.def("sample_bsdf", sample_arrays);
}

}  // namespace sheaf
