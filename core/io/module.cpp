#include "core/io/module.h"

#include "core/io/error.h"
#include "core/io/program_file.h"

#include <fmt/format.h>

#include <dlfcn.h>

namespace sheaf {

namespace fs = std::filesystem;

fs::path shipped_file(const std::string& name) {
  std::error_code error;
  const fs::path folder = program_file().parent_path();
  for (const fs::path& file : {folder / name, folder.parent_path() / "lib/sheaf" / name})
    if (fs::exists(file, error)) return file;
  return {};
}

void* load_module(const std::string& name, const char* function, const std::string& failure) {
  const auto fail = [&](const std::string& why) {
    return Error(ExitCode::kRuntime,
                 fmt::format("{}: {} (expected {} next to the program or in ../lib/sheaf)", failure, why, name));
  };
  const fs::path file = shipped_file(name);
  if (file.empty()) throw fail(fmt::format("'{}' does not exist", (program_file().parent_path() / name).string()));
  void* const handle = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (handle == nullptr) throw fail(dlerror());
  void* const found = dlsym(handle, function);
  if (found == nullptr) throw fail(fmt::format("'{}' is not of this version of Sheaf", file.string()));
  return found;
}

}  // namespace sheaf
