#include "kernels/film/film_layout.h"

#include <algorithm>

namespace sheaf {

FilmLayout FilmLayout::beauty(bool with_variances) {
  return FilmLayout({{"R", with_variances}, {"G", with_variances}, {"B", with_variances}, {"A", false}});
}

int FilmLayout::variance_count() const {
  return static_cast<int>(std::count_if(channels_.begin(), channels_.end(), [](auto& c) { return c.has_variance; }));
}

int FilmLayout::half_count() const {
  return static_cast<int>(std::count_if(channels_.begin(), channels_.end(), [](auto& c) { return c.has_half; }));
}

int FilmLayout::find(std::string_view name) const {
  const auto found = std::find_if(channels_.begin(), channels_.end(), [name](auto& c) { return c.name == name; });
  return found == channels_.end() ? -1 : static_cast<int>(found - channels_.begin());
}

}  // namespace sheaf
