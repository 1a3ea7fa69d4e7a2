// Choice of a camera by name or number.
#include "scene/dialects/common/choose_camera.h"

#include "core/io/error.h"

#include <algorithm>

namespace sheaf {

std::size_t choose_camera(const std::string& requested, const std::vector<std::string>& names,
                          const std::filesystem::path& file) {
  if (requested.empty()) return 0;
  const auto found = std::find(names.begin(), names.end(), requested);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::to_string(i) == requested) return i;
  const SourceLocation where{file.string(), 0};
  if (names.empty()) throw SceneError(where, "has no camera");
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i)
    list += (i == 0 ? "" : ", ") + (names[i].empty() ? std::to_string(i) : in_quotes(names[i]));
  throw SceneError(where, fmt::format("has no camera {}{} (cameras: {})", in_quotes(requested),
                                      did_you_mean(requested, names), list));
}

}  // namespace sheaf
