#include "scene/formats/blosc.h"

#ifdef NANOVDB_USE_BLOSC
#include <blosc.h>

#include <limits>
#endif

namespace sheaf {

#ifdef NANOVDB_USE_BLOSC
bool has_blosc() { return true; }

bool decompress_blosc(std::string_view stored, std::span<char> out) {
  std::size_t claimed = 0;
  if (out.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()) ||
      blosc_cbuffer_validate(stored.data(), stored.size(), &claimed) != 0 || claimed != out.size()) {
    return false;
  }
  return blosc_decompress_ctx(stored.data(), out.data(), out.size(), 1) == static_cast<int>(out.size());
}
#else
bool has_blosc() { return false; }
bool decompress_blosc(std::string_view, std::span<char>) { return false; }
#endif

}  // namespace sheaf
