#include "core/picture_library.h"

#include "core/error.h"

#include <dlfcn.h>

#include <filesystem>

namespace sheaf {

namespace {

namespace fs = std::filesystem;

const PictureLibrary* load() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  const fs::path beside = folder / "sheaf_pictures.so";
  const fs::path installed = folder.parent_path() / "lib/sheaf/sheaf_pictures.so";
  const fs::path& file = fs::exists(beside, error) ? beside : installed;
  const auto fail = [&](const std::string& why) {
    return Error(ExitCode::kRuntime, "pictures other than OpenEXR can be neither read nor written: " + why +
                                         ". The file sheaf_pictures.so "
                                         "belongs beside the program, or into ../lib/sheaf");
  };
  if (!fs::exists(file, error))
    throw fail("there is neither '" + beside.string() + "' nor '" + installed.string() + "'");
  void* const handle = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (handle == nullptr) throw fail(dlerror());
  void* const function = dlsym(handle, kPictureLibraryFunction);
  if (function == nullptr) throw fail("'" + file.string() + "' is another library");
  return reinterpret_cast<PictureLibraryFunction*>(function)();
}

}  // namespace

const PictureLibrary& picture_library() {
  static const PictureLibrary* const library = load();
  return *library;
}

}  // namespace sheaf
