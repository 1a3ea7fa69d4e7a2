#include "core/io/program_file.h"

#include <dlfcn.h>
#include <link.h>

namespace sheaf {

namespace fs = std::filesystem;

fs::path program_file() {
  // The dynamic linker knows the name of each library. That of the program is empty.
  Dl_info info{};
  void* found = nullptr;
  std::error_code error;
  if (dladdr1(reinterpret_cast<const void*>(&program_file), &info, &found, RTLD_DL_LINKMAP) != 0 && found != nullptr) {
    const auto* const library = static_cast<const link_map*>(found);
    if (library->l_name != nullptr && *library->l_name != '\0') return fs::absolute(library->l_name, error);
  }
  return fs::read_symlink("/proc/self/exe", error);
}

}  // namespace sheaf
