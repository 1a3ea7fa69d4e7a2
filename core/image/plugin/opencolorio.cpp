// Views of OpenColorIO configurations: the only file that includes OpenColorIO, which is optional when building.
// Defines the entry point of sheaf_color_io.so.
#include "core/image/display_view.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <stdexcept>

namespace sheaf {

namespace {

namespace ocio = OCIO_NAMESPACE;

/// First version with built-in configurations, as in OCIO_VERSION_HEX.
constexpr unsigned kBuiltinConfigs = 0x02020000;

class Processor final : public ColorProcessor {
 public:
  explicit Processor(ocio::ConstCPUProcessorRcPtr processor) : processor_(std::move(processor)) {}

  void apply(float* rgb, std::size_t count) const override {
    ocio::PackedImageDesc pixels(rgb, static_cast<long>(count), 1, 3);
    processor_->apply(pixels);
  }

 private:
  ocio::ConstCPUProcessorRcPtr processor_;
};

ocio::ConstConfigRcPtr open_config(const std::string& name) {
  if (name == "raw") return ocio::Config::CreateRaw();
  if (name.empty()) {
    if (const char* const file = std::getenv("OCIO"); file == nullptr || *file == '\0')
      throw std::runtime_error("no configuration is given (expected --ocio-config, or the environment variable OCIO)");
    return ocio::Config::CreateFromEnv();
  }
  if (name.starts_with("ocio://") && OCIO_VERSION_HEX < kBuiltinConfigs)
    throw std::runtime_error("OpenColorIO " OCIO_VERSION
                             " has no built-in configurations (expected version 2.2 or newer, a file, or raw)");
  return ocio::Config::CreateFromFile(name.c_str());
}

/// Names of linear Rec.709 in common configurations.
constexpr std::array kRec709Names{"Linear Rec.709 (sRGB)",   "lin_rec709",     "lin_srgb",
                                  "Utility - Linear - sRGB", "Linear Rec.709", "Linear BT.709"};

/// Linear Rec.709 (D65) to ACES2065-1 (D60), adapted by the Bradford transform; rows of four values.
constexpr std::array<double, 16> kRec709ToAces{0.4396329819,
                                               0.3829886982,
                                               0.1773783200,
                                               0,  //
                                               0.0897764430,
                                               0.8134394286,
                                               0.0967841284,
                                               0,  //
                                               0.0175411704,
                                               0.1115465533,
                                               0.8709122796,
                                               0,  //
                                               0,
                                               0,
                                               0,
                                               1};

/// Finds linear Rec.709 in the configuration: by name, from the interchange space ACES2065-1, or as scene_linear.
/// Appends the conversion to `transform` and returns the space in which it results.
std::string source_space(const ocio::Config& config, ocio::GroupTransform& transform) {
  for (const char* const name : kRec709Names)
    if (config.getColorSpace(name)) return name;
  if (config.hasRole("aces_interchange")) {
    const ocio::MatrixTransformRcPtr matrix = ocio::MatrixTransform::Create();
    matrix->setMatrix(kRec709ToAces.data());
    transform.appendTransform(matrix);
    return "aces_interchange";
  }
  for (const char* const role : {ocio::ROLE_SCENE_LINEAR, ocio::ROLE_DEFAULT})
    if (config.getColorSpace(role)) return role;
  throw std::runtime_error("the configuration has no linear color space (expected the role scene_linear)");
}

/// The name `requested` in any case, or the default if it is empty. Throws std::runtime_error.
template <class NameAt>
std::string find_name(const std::string& what, const std::string& requested, const char* standard, int count,
                      NameAt name_at) {
  if (requested.empty()) return standard;
  std::string known;
  const auto lower = [](unsigned char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : int{c}; };
  for (int i = 0; i < count; ++i) {
    std::string name = name_at(i);
    if (std::equal(name.begin(), name.end(), requested.begin(), requested.end(), [&](char a, char b) {
          return lower(static_cast<unsigned char>(a)) == lower(static_cast<unsigned char>(b));
        }))
      return name;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw std::runtime_error("unknown " + what + " '" + requested + "' (known: " + known + ")");
}

std::unique_ptr<ColorProcessor> open_view(const DisplayView& requested) {
  const ocio::ConstConfigRcPtr config = open_config(requested.config);
  config->validate();
  // Find the display and the view
  const std::string display = find_name("display", requested.display, config->getDefaultDisplay(),
                                        config->getNumDisplays(), [&](int i) { return config->getDisplay(i); });
  const char* const displayed = display.c_str();
  const std::string view =
      find_name("view", requested.view, config->getDefaultView(displayed), config->getNumViews(displayed),
                [&](int i) { return config->getView(displayed, i); });
  // Build the processor
  const ocio::GroupTransformRcPtr all = ocio::GroupTransform::Create();
  const ocio::DisplayViewTransformRcPtr transform = ocio::DisplayViewTransform::Create();
  transform->setSrc(source_space(*config, *all).c_str());
  transform->setDisplay(displayed);
  transform->setView(view.c_str());
  all->appendTransform(transform);
  return std::make_unique<Processor>(config->getProcessor(all)->getDefaultCPUProcessor());
}

}  // namespace

extern "C" [[gnu::visibility("default")]] ColorProcessor* sheaf_display_view(const DisplayView& view,
                                                                             std::string& problem) {
  ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE);
  try {
    return open_view(view).release();
  } catch (const std::exception& error) {
    problem = error.what();
    return nullptr;
  }
}

}  // namespace sheaf
