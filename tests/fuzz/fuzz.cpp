#include "tests/fuzz/fuzz.h"

#include "tests/support/temporary_folder.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace sheaf::fuzz {

namespace fs = std::filesystem;

const fs::path& folder() {
  static const TemporaryFolder instance;
  return instance.path();
}

fs::path make_file(std::string_view name, std::string_view bytes) {
  fs::path path = folder() / name;
  write_bytes(path, std::string(bytes));
  return path;
}

void copy_files(std::string_view repository_folder, std::string_view but_for) {
  const fs::path from = fs::path(SHEAF_SOURCE_DIR) / repository_folder;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(from)) {
    if (!entry.is_regular_file() || entry.path().extension() == but_for) continue;
    const fs::path to = folder() / fs::relative(entry.path(), from);
    fs::create_directories(to.parent_path());
    fs::copy_file(entry.path(), to, fs::copy_options::overwrite_existing);
  }
}

unsigned take_choice(std::string_view& input) {
  if (input.empty()) return 0;
  const auto choice = static_cast<unsigned char>(input.front());
  input.remove_prefix(1);
  return choice;
}

bool leads_out(std::string_view text) {
  // Beginnings of file names in all text formats. "&#" may encode any letter.
  constexpr std::string_view kSigns[] = {"..", "\"/", "'/", " /", "\t/", "=/", "\\", "&#"};
  return std::any_of(std::begin(kSigns), std::end(kSigns), [&](std::string_view sign) {
    for (auto at = text.find(sign); at != std::string_view::npos; at = text.find(sign, at + 1))
      if (text.substr(at + 1, 2) != "/>") return true;  // end of an XML element
    return false;
  });
}

void check_message(std::string_view message) {
  constexpr std::size_t kLongest = 4096;
  if (!message.empty() && message.size() <= kLongest) return;
  std::fprintf(stderr, "a message of %zu bytes: %.300s\n", message.size(), std::string(message).c_str());
  std::abort();
}

}  // namespace sheaf::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sheaf::fuzz::try_input({reinterpret_cast<const char*>(data), size});
  return 0;
}
