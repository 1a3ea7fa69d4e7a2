// The only file that uses the library's C interface, versions 1.4 to 2. It declares the functions that it calls.
#include "kernels/denoise/oidn.h"

#include "core/io/error.h"
#include "core/io/program_file.h"
#include "kernels/denoise/features.h"
#include "kernels/denoise/find_oidn.h"

#include <fmt/format.h>

#include <dlfcn.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

struct DeviceHandle;
struct FilterHandle;
using Device = DeviceHandle*;
using Filter = FilterHandle*;

/// Values of the library's enumerations.
constexpr int kCpuDevice = 1, kFloat3 = 3;

/// Entry points of the library.
struct Library {
  Device (*new_device)(int type);
  void (*commit_device)(Device);
  void (*release_device)(Device);
  int (*get_device_error)(Device, const char** message);
  Filter (*new_filter)(Device, const char* type);
  void (*set_shared_filter_image)(Filter, const char* name, void* values, int format, std::size_t width,
                                  std::size_t height, std::size_t offset, std::size_t pixel_bytes,
                                  std::size_t row_bytes);
  void (*set_filter_bool)(Filter, const char* name, bool value);
  void (*commit_filter)(Filter);
  void (*execute_filter)(Filter);
  void (*release_filter)(Filter);
};

Error no_library(const std::string& why) {
  return Error(ExitCode::kRuntime,
               fmt::format("Open Image Denoise is not available: {}; install it (pip install oidn), put "
                           "libOpenImageDenoise.so next to the program, set LD_LIBRARY_PATH to its folder, or use the "
                           "built-in denoiser nlm",
                           why));
}

std::string environment_variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// Loads the library from the first location that works. Throws Error, which lists the searched locations.
void* open_library() {
  const OidnFolders folders = oidn_folders(program_file(), environment_variable);
  std::string looked, refused;
  const auto try_folders = [&](const std::vector<fs::path>& list) -> void* {
    for (const fs::path& folder : list) {
      looked += (looked.empty() ? "" : ", ") + folder.string();
      for (const fs::path& file : oidn_files(folder)) {
        if (void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) return handle;
        refused += fmt::format("; {}", dlerror());
      }
    }
    return nullptr;
  };
  // Search the folders next to the program
  if (void* const handle = try_folders(folders.before)) return handle;
  // Search with the dynamic linker
  const std::vector<std::string> names = oidn_names();
  for (const std::string& name : names)
    if (void* const handle = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)) return handle;
  looked += fmt::format("{}the dynamic linker's folders ({})", looked.empty() ? "" : ", ", fmt::join(names, ", "));
  // Search the folders of Python packages and of Blender
  if (void* const handle = try_folders(folders.behind)) return handle;
  throw no_library((refused.empty() ? "libOpenImageDenoise.so was not found in " : "looked in ") + looked + refused);
}

template <class Function> void find_function(void* handle, const char* name, const char* older, Function& function) {
  void* symbol = dlsym(handle, name);
  if (symbol == nullptr && older != nullptr) symbol = dlsym(handle, older);
  if (symbol == nullptr) throw no_library(std::string("it lacks the function ") + name);
  function = reinterpret_cast<Function>(symbol);
}

/// The library, loaded on the first call and kept. Throws Error.
const Library& library() {
  static const Library loaded = [] {
    void* const handle = open_library();
    Library found{};
    find_function(handle, "oidnNewDevice", nullptr, found.new_device);
    find_function(handle, "oidnCommitDevice", nullptr, found.commit_device);
    find_function(handle, "oidnReleaseDevice", nullptr, found.release_device);
    find_function(handle, "oidnGetDeviceError", nullptr, found.get_device_error);
    find_function(handle, "oidnNewFilter", nullptr, found.new_filter);
    find_function(handle, "oidnSetSharedFilterImage", nullptr, found.set_shared_filter_image);
    find_function(handle, "oidnSetFilterBool", "oidnSetFilter1b", found.set_filter_bool);
    find_function(handle, "oidnCommitFilter", nullptr, found.commit_filter);
    find_function(handle, "oidnExecuteFilter", nullptr, found.execute_filter);
    find_function(handle, "oidnReleaseFilter", nullptr, found.release_filter);
    return found;
  }();
  return loaded;
}

/// Interleaves three planes pixel by pixel.
std::vector<float> interleave(const std::vector<Plane>& planes) {
  std::vector<float> values;
  for (int y = 0; y < planes[0].height(); ++y)
    for (int x = 0; x < planes[0].width(); ++x)
      for (const Plane& plane : planes) values.push_back(plane.at(x, y));
  return values;
}

/// Runs the library's filter for path-traced HDR images in linear color. Features may be empty.
void run_filter(int width, int height, std::vector<float>& color, std::vector<float>& albedo,
                std::vector<float>& normal, std::vector<float>& output) {
  const Library& oidn = library();
  const auto check = [&oidn](Device device) {
    const char* message = nullptr;
    if (oidn.get_device_error(device, &message) != 0)
      throw Error(ExitCode::kRuntime, std::string("Open Image Denoise: ") + (message != nullptr ? message : "failed"));
  };
  // Create the device.
  const std::unique_ptr<DeviceHandle, void (*)(Device)> device(oidn.new_device(kCpuDevice), oidn.release_device);
  if (!device) check(nullptr);
  oidn.commit_device(device.get());
  check(device.get());
  // Set up the filter.
  const std::unique_ptr<FilterHandle, void (*)(Filter)> filter(oidn.new_filter(device.get(), "RT"),
                                                               oidn.release_filter);
  check(device.get());
  const auto set_image = [&](const char* name, std::vector<float>& values) {
    if (values.empty()) return;
    oidn.set_shared_filter_image(filter.get(), name, values.data(), kFloat3, static_cast<std::size_t>(width),
                                 static_cast<std::size_t>(height), 0, 0, 0);
  };
  set_image("color", color);
  set_image("albedo", albedo);
  set_image("normal", normal);
  set_image("output", output);
  // Run it.
  oidn.set_filter_bool(filter.get(), "hdr", true);
  oidn.commit_filter(filter.get());
  check(device.get());
  oidn.execute_filter(filter.get());
  check(device.get());
}

}  // namespace

void check_oidn() { library(); }

Planes3 denoise_oidn(const Image& image, std::string& description) {
  const std::vector<Plane> albedo = find_planes(image, {"albedo.R", "albedo.G", "albedo.B"});
  const std::vector<Plane> normal = find_planes(image, {"N.X", "N.Y", "N.Z"});
  std::vector<float> color_values = interleave(find_planes(image, {"R", "G", "B"})), output(color_values.size());
  std::vector<float> albedo_values, normal_values;
  if (!albedo.empty()) albedo_values = interleave(albedo);
  // the library requires albedo with normals
  if (!albedo.empty() && !normal.empty()) normal_values = interleave(normal);
  run_filter(image.width, image.height, color_values, albedo_values, normal_values, output);
  description = std::string("oidn: ") + (albedo.empty()   ? "no features"
                                         : normal.empty() ? "features albedo"
                                                          : "features albedo N");
  Planes3 planes;
  std::size_t i = 0;
  for (Plane& plane : planes) plane = Plane(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (Plane& plane : planes) plane.at(x, y) = output[i++];
  return planes;
}

}  // namespace sheaf
