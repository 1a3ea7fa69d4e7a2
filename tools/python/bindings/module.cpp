// The Python module sheaf._sheaf: scenes and images for the package sheaf, which is written in Python. Wraps pybind11.
#include "core/io/error.h"
#include "core/io/version.h"
#include "core/simd/simd.h"
#include "scene/xml/xml_values.h"
#include "tools/python/bindings/module_images.h"
#include "tools/python/bindings/module_queries.h"
#include "tools/python/bindings/session.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <span>
#include <thread>

namespace py = pybind11;

namespace sheaf {

namespace {

/// Keeps a Python object alive; released with the interpreter's lock.
std::shared_ptr<const void> owner_of(py::object object) {
  return {new py::object(std::move(object)), [](const void* owned) {
            const py::gil_scoped_acquire lock;
            delete static_cast<const py::object*>(owned);
          }};
}

std::shared_ptr<const ArrayValue> array_from(const py::array& given) {
  ArrayValue array;
  if (py::isinstance<py::array_t<float>>(given))
    array.type = ArrayValue::Type::kFloat;
  else if (py::isinstance<py::array_t<std::uint32_t>>(given))
    array.type = ArrayValue::Type::kIndex;
  else if (py::isinstance<py::array_t<std::uint8_t>>(given))
    array.type = ArrayValue::Type::kByte;
  else
    throw Error(ExitCode::kUsage, "arrays must have the type float32, uint32 or uint8");
  if ((given.flags() & py::array::c_style) == 0) throw Error(ExitCode::kUsage, "arrays must be contiguous");
  for (py::ssize_t axis = 0; axis < given.ndim(); ++axis)
    array.shape.push_back(static_cast<std::size_t>(given.shape(axis)));
  array.data = given.data();
  array.owner = owner_of(given);
  return std::make_shared<const ArrayValue>(std::move(array));
}

/// Maximum depth of trees, as in files.
constexpr int kMaxTreeDepth = 100;

/// Converts (name, attributes, children, location[, array]).
XmlElement element_from(const py::tuple& given, int depth = 0) {
  if (depth > kMaxTreeDepth) throw Error(ExitCode::kUsage, "objects are nested deeper than 100 levels");
  XmlElement element;
  element.name = given[0].cast<std::string>();
  for (const auto& [name, value] : given[1].cast<py::dict>())
    element.attributes.push_back({name.cast<std::string>(), value.cast<std::string>()});
  for (const py::handle child : given[2].cast<py::list>())
    element.children.push_back(element_from(child.cast<py::tuple>(), depth + 1));
  element.where.file = given[3].cast<std::string>();
  if (given.size() > 4 && !given[4].is_none()) element.array = array_from(given[4].cast<py::array>());
  return element;
}

const XmlElement& at(const XmlElement& root, const TreePath& path) {
  const XmlElement* element = &root;
  for (const std::size_t index : path) {
    if (index >= element->children.size()) throw Error(ExitCode::kUsage, "the object is no longer part of the scene");
    element = &element->children[index];
  }
  return *element;
}

XmlElement& at(XmlElement& root, const TreePath& path) {
  return const_cast<XmlElement&>(at(static_cast<const XmlElement&>(root), path));
}

std::string text_of(const SourceLocation& where) {
  return where.line > 0 ? fmt::format("{}:{}", where.file.string(), where.line) : where.file.string();
}

/// An element without its grandchildren: (name, attributes, [(name, attributes)], location).
py::tuple shallow(const XmlElement& element) {
  const auto attributes = [](const XmlElement& of) {
    py::dict out;
    for (const XmlAttribute& attribute : of.attributes) out[py::str(attribute.name)] = attribute.value;
    return out;
  };
  py::list children;
  for (const XmlElement& child : element.children) children.append(py::make_tuple(child.name, attributes(child)));
  return py::make_tuple(element.name, attributes(element), children, text_of(element.where));
}

/// Appends (path, name, id, type, location) of all elements with one of the names, in order of the file.
void list_elements(const XmlElement& element, const std::vector<std::string>& names, TreePath& path, py::list& out) {
  for (std::size_t i = 0; i < element.children.size(); ++i) {
    const XmlElement& child = element.children[i];
    path.push_back(i);
    if (std::find(names.begin(), names.end(), child.name) != names.end()) {
      const std::string *const id = child.find_attribute("id"), *const type = child.find_attribute("type");
      out.append(py::make_tuple(path, child.name, id != nullptr ? *id : "", type != nullptr ? *type : "",
                                text_of(child.where)));
    }
    list_elements(child, names, path, out);
    path.pop_back();
  }
}

/// Sets children of elements, at once: tuples (path, index, child). Replaces the child at `index`, or appends it if
/// that is None.
void set_children(Session& session, const py::list& changes) {
  struct Change {
    TreePath path;
    std::optional<std::size_t> index;
    XmlElement child;
  };
  std::vector<Change> all;
  for (const py::handle each : changes) {
    const auto change = each.cast<py::tuple>();
    all.push_back({change[0].cast<TreePath>(), change[1].cast<std::optional<std::size_t>>(),
                   element_from(change[2].cast<py::tuple>())});
  }
  const py::gil_scoped_release unlocked;
  session.edit([&](XmlElement& root) {
    for (Change& change : all) {
      XmlElement& element = at(root, change.path);
      if (change.child.where.file.empty()) change.child.where = element.where;
      if (!change.index) {
        element.children.push_back(std::move(change.child));
      } else if (*change.index < element.children.size()) {
        element.children[*change.index] = std::move(change.child);
      }
    }
  });
}

void remove_child(Session& session, const TreePath& path, std::size_t index) {
  const py::gil_scoped_release unlocked;
  session.edit([&](XmlElement& root) {
    std::vector<XmlElement>& children = at(root, path).children;
    if (index < children.size()) children.erase(children.begin() + static_cast<std::ptrdiff_t>(index));
  });
}

/// The matrix of a <transform>, row by row.
std::vector<double> matrix_of(const Session& session, const TreePath& path) {
  const Transform transform = parse_transform(at(*session.tree(), path));
  std::vector<double> out;
  for (const auto& row : transform.matrix().m) out.insert(out.end(), row.begin(), row.end());
  return out;
}

/// A copy of the array of an <array>.
py::array array_parameter(const Session& session, const TreePath& path) {
  const auto root = session.tree();
  const XmlElement& element = at(*root, path);
  if (element.array == nullptr) throw Error(ExitCode::kUsage, "the parameter is not an array");
  const ArrayValue& array = *element.array;
  const auto copy = [&]<class T>(std::span<const T> values) -> py::array {
    return py::array_t<T>({array.shape.begin(), array.shape.end()}, values.data());
  };
  switch (array.type) {
    case ArrayValue::Type::kIndex:
      return copy(array.indices());
    case ArrayValue::Type::kByte:
      return copy(array.bytes());
    default:
      return copy(array.floats());
  }
}

/// The arrays of the shape's mesh by their names in scenes, without attributes; empty for shapes that have no mesh.
py::dict mesh_arrays(const Session& session, std::size_t shape) {
  std::optional<Mesh> mesh;
  {
    const py::gil_scoped_release unlocked;
    mesh = session.mesh(shape);
  }
  py::dict out;
  const auto add = [&out](const char* name, const auto& rows, py::ssize_t columns, const auto* values) {
    using Number = std::remove_cvref_t<decltype(*values)>;
    if (!rows.empty()) out[name] = py::array_t<Number>({static_cast<py::ssize_t>(rows.size()), columns}, values);
  };
  if (!mesh) return out;
  add("vertices", mesh->positions, 3, reinterpret_cast<const float*>(mesh->positions.data()));
  add("faces", mesh->triangles, 3, reinterpret_cast<const std::uint32_t*>(mesh->triangles.data()));
  add("normals", mesh->normals, 3, reinterpret_cast<const float*>(mesh->normals.data()));
  add("uv", mesh->uvs, 2, reinterpret_cast<const float*>(mesh->uvs.data()));
  return out;
}

/// Calls run() in another thread. Meanwhile handles signals and calls the functions of the user. A signal that raises
/// KeyboardInterrupt requests a stop. Other exceptions do so as well and are raised at the end.
template <class Run>
void run_watched(RenderWatch& watch, const py::object& progress, const py::object& stop, Run&& run) {
  constexpr std::chrono::milliseconds kInterval(100);
  std::mutex mutex;
  std::condition_variable ended;
  bool is_done = false;
  std::exception_ptr problem;
  std::thread worker([&] {
    try {
      run();
    } catch (...) { problem = std::current_exception(); }
    const std::lock_guard lock(mutex);
    is_done = true;
    ended.notify_one();
  });
  std::optional<py::error_already_set> raised;
  const auto call_user = [&] {
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!stop.is_none() && stop().cast<bool>()) watch.stop = true;
      const std::uint64_t total = watch.total.load();
      if (!progress.is_none() && total > 0) progress(watch.done.load(), total);
    } catch (py::error_already_set& error) {
      watch.stop = true;
      if (!error.matches(PyExc_KeyboardInterrupt)) raised.emplace(error);
    }
  };
  for (;;) {
    bool finished;
    {
      const py::gil_scoped_release unlocked;
      std::unique_lock lock(mutex);
      finished = ended.wait_for(lock, kInterval, [&] { return is_done; });
    }
    if (finished) break;
    if (!raised) call_user();
  }
  worker.join();
  if (problem) std::rethrow_exception(problem);
  if (!raised) call_user();  // the last progress
  if (raised) throw *raised;
}

/// `replacements`: elements as tuples.
RenderedImage render(Session& session, const OptionValues& options, const py::list& replacements,
                     const py::object& progress, const py::object& stop) {
  RenderWatch watch;
  RenderedImage out;
  std::vector<XmlElement> elements;
  for (const py::handle each : replacements) elements.push_back(element_from(each.cast<py::tuple>()));
  run_watched(watch, progress, stop, [&] { out = session.render(options, elements, watch); });
  return out;
}

/// The parameters of an option: (name, help, kind, values, repeats).
py::list option_list(const std::vector<OptionHelp>& options) {
  constexpr const char* kKinds[] = {"flag", "integer", "number", "time", "text", "file", "folder"};
  py::list out;
  for (const OptionHelp& option : options) {
    std::string name = option.names.back();
    name.erase(0, name.find_first_not_of('-'));
    out.append(
        py::make_tuple(name, option.text, kKinds[static_cast<std::size_t>(option.kind)], option.words, option.repeats));
  }
  return out;
}

void add_scene(py::module_& m) {
  py::class_<Session>(m, "Session")
      .def(py::init<const std::string&, OptionValues>(), py::call_guard<py::gil_scoped_release>())
      .def(
          py::init([](const py::tuple& root, const std::string& name, const std::string& folder, OptionValues options) {
            XmlElement tree = element_from(root);
            const py::gil_scoped_release unlocked;
            return std::make_unique<Session>(std::move(tree), name, folder, std::move(options));
          }))
      .def_property_readonly("has_tree", &Session::has_tree)
      .def_property_readonly("name", &Session::name)
      .def_property_readonly("notes", [](const Session& s) { return s.summary().notes; })
      .def_property_readonly("substitutions", [](const Session& s) { return s.summary().substitutions; })
      .def_property_readonly("size",
                             [](const Session& s) {
                               const Session::Summary summary = s.summary();
                               return py::make_tuple(summary.width, summary.height);
                             })
      .def_property_readonly("materials",
                             [](const Session& s) {
                               std::vector<std::string> out;
                               for (const SourceLocation& where : s.summary().materials) out.push_back(text_of(where));
                               return out;
                             })
      .def("list",
           [](const Session& s, const std::vector<std::string>& names) {
             py::list out;
             TreePath path;
             list_elements(*s.tree(), names, path, out);
             return out;
           })
      .def("get", [](const Session& s, const TreePath& path) { return shallow(at(*s.tree(), path)); })
      .def("set", set_children)
      .def("remove", remove_child)
      .def("matrix", matrix_of)
      .def("array", array_parameter)
      .def("mesh", mesh_arrays)
      .def("find_file",
           [](const Session& s, const std::string& name, const std::string& where) {
             return s.find_file(name, {where.substr(0, where.rfind(':'))}).string();
           })
      .def("render", render);
}

/// Errors become sheaf._sheaf.NativeError(message, exit code, file, line), which the package converts. File and line
/// are None if unknown.
void translate_errors(py::module_& m) {
  static PyObject* const native = PyErr_NewException("sheaf._sheaf.NativeError", PyExc_Exception, nullptr);
  m.attr("NativeError") = py::handle(native);
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const Error& error) {
      const SourceLocation& where = error.where();
      const py::object file = where.file.empty() ? py::object(py::none()) : py::object(py::str(where.file.string()));
      const py::object line = where.line == 0 ? py::object(py::none()) : py::object(py::int_(where.line));
      PyErr_SetObject(native, py::make_tuple(error.what(), static_cast<int>(error.exit_code()), file, line).ptr());
    }
  });
}

}  // namespace

}  // namespace sheaf

PYBIND11_MODULE(_sheaf, m) {
  using namespace sheaf;
  m.attr("version") = kSheafVersion;
  m.attr("isa") = kIsaName;
  translate_errors(m);
  add_scene(m);
  add_images(m);
  add_queries(m);
  m.def("render_options", [] { return option_list(render_option_list()); });
  m.def("read_options", [] { return option_list(read_option_list()); });
  m.def("output_options", [] { return option_list(output_option_list()); });
  m.def("plugins", plugin_names);
  m.def("aovs", [] {
    std::vector<std::pair<std::string, std::vector<std::string>>> out;
    for (const AovEntry& entry : kAovList) {
      out.emplace_back(std::string(entry.name), std::vector<std::string>());
      for (const std::string_view channel : entry.channels)
        if (!channel.empty()) out.back().second.emplace_back(channel);
    }
    return out;
  });
  m.def("read", read_result, py::call_guard<py::gil_scoped_release>());
  m.def("merge", [](const std::vector<const RenderedImage*>& parts, std::vector<int> crop, bool incomplete) {
    const py::gil_scoped_release unlocked;
    return merge_results(parts, {std::move(crop), incomplete, false});
  });
}
