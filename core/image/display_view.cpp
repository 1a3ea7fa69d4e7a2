#include "core/image/display_view.h"

#include "core/io/module.h"

namespace sheaf {

std::unique_ptr<ColorProcessor> open_display_view(const DisplayView& view, std::string& problem) {
#ifdef SHEAF_HAS_OPENCOLORIO
  static const auto open = reinterpret_cast<DisplayViewFunction*>(
      load_module(kColorLibrary, kDisplayViewFunction, "cannot use OpenColorIO configurations"));
  return std::unique_ptr<ColorProcessor>(open(view, problem));
#else
  static_cast<void>(view);
  problem = "this build of Sheaf lacks OpenColorIO (install libopencolorio-dev and build again)";
  return nullptr;
#endif
}

}  // namespace sheaf
