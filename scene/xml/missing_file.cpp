#include "scene/xml/missing_file.h"

#include "scene/xml/xml.h"

#include <fstream>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// The first line of a text file, at most 200 bytes; empty if it cannot be read.
std::string first_line(const fs::path& file) {
  constexpr std::size_t kLongest = 200;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  std::ifstream stream(file);
  std::string line(kLongest, '\0');
  stream.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(static_cast<std::size_t>(stream.gcount()));
  if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // UTF-8 byte order mark
  return line.substr(0, line.find_first_of("\r\n"));
}

/// First line of a text file next to one of the folders in the path `name`, formatted for the message; empty if none.
std::string origin_of(const fs::path& base, const std::string& name) {
  for (fs::path parent = fs::path(name).parent_path(); parent.has_filename(); parent = parent.parent_path()) {
    const fs::path file = base / (parent.string() + ".txt");
    if (const std::string line = first_line(file); !line.empty()) return fmt::format(" ({}: {})", file.string(), line);
    if (parent == parent.parent_path()) break;
  }
  return {};
}

}  // namespace

std::string missing_file(const std::string& name, const std::vector<fs::path>& folders) {
  std::string message = fmt::format("file {} not found", in_quotes(name)), origin;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    message += (i == 0 ? " in " : ", ") + in_quotes(folders[i].empty() ? "." : folders[i].string());
    if (origin.empty()) origin = origin_of(folders[i], name);
  }
  return message + origin;
}

}  // namespace sheaf
