#include "tools/python/bindings/module_images.h"

#include "core/image/image_compare.h"
#include "core/io/error.h"
#include "tools/python/bindings/session.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstring>
#include <string_view>

namespace py = pybind11;

namespace sheaf {

namespace {

/// A view of channels of the image, without a copy if they follow each other: H x W, or H x W x C.
py::object channels_of(const py::object& self, const std::vector<std::string>& names) {
  const auto& image = self.cast<const RenderedImage&>().image;
  std::vector<int> indices;
  for (const std::string& name : names) {
    indices.push_back(image.find_channel(name));
    if (indices.back() < 0) return py::none();
  }
  const auto stride = static_cast<py::ssize_t>(image.channels.size() * sizeof(float));
  const py::ssize_t size = sizeof(float), height = image.height, width = image.width;
  bool follow = true;
  for (std::size_t i = 1; i < indices.size(); ++i) follow &= indices[i] == indices[0] + static_cast<int>(i);
  if (!follow) {
    py::array_t<float> copy({height, width, static_cast<py::ssize_t>(indices.size())});
    float* out = copy.mutable_data();
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (const int c : indices) *out++ = image.at(x, y, c);
    return copy;
  }
  std::vector<py::ssize_t> shape{height, width}, strides{width * stride, stride};
  if (indices.size() > 1) {
    shape.push_back(static_cast<py::ssize_t>(indices.size()));
    strides.push_back(size);
  }
  return py::array_t<float>(shape, strides, image.data.data() + indices[0], self);
}

py::dict attributes_of(const RenderedImage& result) {
  py::dict out;
  for (const ExrMetadata::Attribute& attribute : result.metadata.attributes)
    out[py::str(attribute.name)] = std::visit([](const auto& value) { return py::cast(value); }, attribute.value);
  return out;
}

using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// An image H x W x C of 1 channel (Y), 3 (R, G, B) or 4 (and A).
RenderedImage image_from(const FloatArray& values) {
  const py::ssize_t channels = values.ndim() == 3 ? values.shape(2) : 0;
  if ((channels != 1 && channels != 3 && channels != 4) || values.size() == 0 || values.shape(0) > kMaxImageSide ||
      values.shape(1) > kMaxImageSide)
    throw Error(ExitCode::kUsage, "expected an image as an array H x W x C with 1, 3 or 4 channels");
  std::vector<std::string> names{"Y"};
  if (channels >= 3) names = {"R", "G", "B"};
  if (channels == 4) names.emplace_back("A");
  RenderedImage result;
  result.image = Image(static_cast<int>(values.shape(1)), static_cast<int>(values.shape(0)), std::move(names));
  std::copy_n(values.data(), values.size(), result.image.data.data());
  return result;
}

/// The whole content of an image as values that pickle; see image_from_state().
py::tuple image_state(const RenderedImage& r) {
  const Image& image = r.image;
  const ExrMetadata& metadata = r.metadata;
  py::list attributes;
  for (const ExrMetadata::Attribute& attribute : metadata.attributes)
    attributes.append(py::make_tuple(attribute.name, attribute.value.index(), attribute.value));
  std::optional<std::array<std::array<double, 4>, 4>> camera;
  if (metadata.world_to_camera) camera = metadata.world_to_camera->m;
  return py::make_tuple(
      py::make_tuple(image.width, image.height, image.x0, image.y0, image.frame_width, image.frame_height),
      image.channels, py::bytes(reinterpret_cast<const char*>(image.data.data()), image.data.size() * sizeof(float)),
      attributes,
      py::make_tuple(metadata.software, camera, metadata.half_channels, metadata.capture_date,
                     static_cast<int>(metadata.compression), metadata.dwa_level),
      py::make_tuple(r.stats, r.warnings, r.notes, r.interrupted, r.kept_scene, r.kept_accel, r.has_studio));
}

/// An attribute of the type with this index, which numbers of Python do not tell apart.
decltype(ExrMetadata::Attribute::value) attribute_value(std::size_t index, const py::handle& value) {
  if (index == 0) return value.cast<int>();
  if (index == 1) return value.cast<float>();
  if (index == 2) return value.cast<double>();
  return value.cast<std::string>();
}

RenderedImage image_from_state(const py::tuple& state) {
  RenderedImage r;
  const auto size = state[0].cast<std::array<int, 6>>();
  r.image = Image(size[0], size[1], state[1].cast<std::vector<std::string>>());
  r.image.x0 = size[2], r.image.y0 = size[3], r.image.frame_width = size[4], r.image.frame_height = size[5];
  const auto bytes = state[2].cast<std::string_view>();
  if (bytes.size() != r.image.data.size() * sizeof(float)) throw Error(ExitCode::kUsage, "a pickled image is broken");
  std::memcpy(r.image.data.data(), bytes.data(), bytes.size());
  for (const py::handle each : state[3]) {
    const auto attribute = each.cast<py::tuple>();
    r.metadata.attributes.push_back(
        {attribute[0].cast<std::string>(), attribute_value(attribute[1].cast<std::size_t>(), attribute[2])});
  }
  const auto header = state[4].cast<py::tuple>();
  r.metadata.software = header[0].cast<std::string>();
  if (!header[1].is_none())
    r.metadata.world_to_camera = Matrix4{header[1].cast<std::array<std::array<double, 4>, 4>>()};
  r.metadata.half_channels = header[2].cast<std::vector<std::string>>();
  r.metadata.capture_date = header[3].cast<std::optional<std::string>>();
  r.metadata.compression = static_cast<ExrCompression>(header[4].cast<int>());
  r.metadata.dwa_level = header[5].cast<float>();
  const auto about = state[5].cast<py::tuple>();
  r.stats = about[0].cast<std::string>();
  r.warnings = about[1].cast<std::vector<std::string>>();
  r.notes = about[2].cast<std::vector<std::string>>();
  r.interrupted = about[3].cast<bool>(), r.kept_scene = about[4].cast<bool>(), r.kept_accel = about[5].cast<bool>();
  r.has_studio = about[6].cast<bool>();
  return r;
}

py::dict compare(const RenderedImage& a, const RenderedImage& b, double significance) {
  CompareOptions options;
  options.significance = significance;
  options.variance_a = variance_layers(a.image);
  options.variance_b = variance_layers(b.image);
  ImageComparison result;
  {
    const py::gil_scoped_release unlocked;
    result = compare_images(a.image, b.image, options);
  }
  py::dict out;
  out["width"] = result.width;
  out["height"] = result.height;
  out["channels"] = result.channels;
  out["mse"] = result.mse;
  out["relative_mse"] = result.relative_mse;
  out["mean_a"] = result.mean_a;
  out["mean_b"] = result.mean_b;
  out["mean_ratio"] = result.mean_ratio;
  out["non_finite"] = result.non_finite;
  if (result.z_test) {
    out["accepted"] = result.z_test->accepted_fraction();
    out["mean_z_squared"] = result.z_test->mean_z_squared;
    out["mean_p"] = result.z_test->corrected_mean_p();
  }
  return out;
}

}  // namespace

void add_images(py::module_& m) {
  py::class_<RenderedImage>(m, "Image")
      .def_static("from_array", image_from)
      .def_static("from_state", image_from_state)
      .def("state", image_state)
      .def_property_readonly("width", [](const RenderedImage& r) { return r.image.width; })
      .def_property_readonly("height", [](const RenderedImage& r) { return r.image.height; })
      .def_property_readonly("channels", [](const RenderedImage& r) { return r.image.channels; })
      .def_property_readonly("offset", [](const RenderedImage& r) { return py::make_tuple(r.image.x0, r.image.y0); })
      .def_property_readonly(
          "frame", [](const RenderedImage& r) { return py::make_tuple(r.image.frame_width, r.image.frame_height); })
      .def_property_readonly("attributes", attributes_of)
      .def_readonly("stats", &RenderedImage::stats)
      .def_readonly("warnings", &RenderedImage::warnings)
      .def_readonly("notes", &RenderedImage::notes)
      .def_readonly("interrupted", &RenderedImage::interrupted)
      .def_readonly("kept_scene", &RenderedImage::kept_scene)
      .def_readonly("kept_accel", &RenderedImage::kept_accel)
      .def("array", channels_of)
      .def("write", write_result, py::call_guard<py::gil_scoped_release>())
      .def("png",
           [](const RenderedImage& r, const OptionValues& options) {
             const std::vector<unsigned char> bytes = encode_png(r, options);
             return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
           })
      .def("denoise", denoise_result, py::call_guard<py::gil_scoped_release>())
      .def("compare", compare);
}

}  // namespace sheaf
