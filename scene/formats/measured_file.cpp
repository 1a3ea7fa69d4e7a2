// Reader of measured BRDFs from tensor files.
#include "scene/formats/measured_file.h"

#include "scene/formats/tensor_file.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace sheaf {

namespace {

/// Maximum grid side and list length; single precision represents such counts exactly.
constexpr std::uint64_t kMaxSide = 1u << 16;

class MeasuredReader {
 public:
  explicit MeasuredReader(const std::filesystem::path& path) : file_(path) {}

  MeasuredBrdf read(bool prefer_spectra) const {
    MeasuredBrdf out;
    // Read the incident angles
    out.phi = list("phi_i");
    out.theta = list("theta_i");
    check_phi(out);
    // Read the tables for sampling
    out.ndf = grids("ndf", {});
    out.sigma = grids("sigma", {});
    const TensorFile::Shape incident = {out.phi.size(), out.theta.size()};
    out.vndf = grids("vndf", incident);
    out.luminance = grids("luminance", incident);
    // Read the values, as spectra or as colors
    const bool spectra = file_.has("spectra") && (prefer_spectra || !file_.has("rgb"));
    if (!spectra && !file_.has("rgb")) file_.fail("has neither a field 'rgb' nor a field 'spectra'");
    if (spectra) out.wavelengths = list("wavelengths");
    out.channels = spectra ? out.wavelengths.size() : 3;
    const char* name = spectra ? "spectra" : "rgb";
    out.values = grids(name, {out.phi.size(), out.theta.size(), out.channels});
    if (out.values.width != out.luminance.width || out.values.height != out.luminance.height)
      file_.fail(fmt::format("field '{}' has grids of {}, expected {} as of field 'luminance'", name, sides(out.values),
                             sides(out.luminance)));
    const auto jacobian = file_.bytes("jacobian");
    out.jacobian = jacobian[0] != 0;
    return out;
  }

 private:
  static std::string sides(const MeasuredBrdf::Grids& g) { return fmt::format("{} x {}", g.height, g.width); }

  /// Reads a list of increasing numbers.
  std::vector<float> list(const char* name) const {
    const std::uint64_t size = file_.shape(name, 1)[0];
    if (size > kMaxSide)
      file_.fail(fmt::format("field '{}' has {} numbers, expected at most {}", name, size, kMaxSide));
    std::vector<float> numbers = file_.floats(name);
    if (std::adjacent_find(numbers.begin(), numbers.end(), [](float a, float b) { return !(a < b); }) != numbers.end())
      file_.fail(fmt::format("field '{}': its numbers do not increase", name));
    return numbers;
  }

  void check_phi(const MeasuredBrdf& brdf) const {
    if (brdf.isotropic()) return;
    const double revolutions = 6.283185307179586 / (double(brdf.phi.back()) - double(brdf.phi.front()));
    const double whole = std::rint(revolutions);
    if (whole != 1 && whole != 2 && whole != 4)
      file_.fail(fmt::format("field 'phi_i' goes from {} to {} (expected a full, half or quarter turn, in radians)",
                             brdf.phi.front(), brdf.phi.back()));
  }

  /// Reads grids in the last two dimensions; the leading dimensions must equal `outer`.
  MeasuredBrdf::Grids grids(const char* name, const TensorFile::Shape& outer) const {
    const TensorFile::Shape& shape = file_.shape(name, outer.size() + 2);
    if (!std::equal(outer.begin(), outer.end(), shape.begin()))
      file_.fail(fmt::format("field '{}' has {} numbers, expected {} grids", name, to_string(shape), to_string(outer)));
    MeasuredBrdf::Grids out;
    for (const std::uint64_t side : {shape[outer.size()], shape[outer.size() + 1]})
      if (side < 2 || side > kMaxSide)
        file_.fail(
            fmt::format("field '{}' has grids with a side of {} points, expected 2 to {}", name, side, kMaxSide));
    out.height = shape[outer.size()], out.width = shape[outer.size() + 1];
    out.values = file_.floats(name);
    for (float& value : out.values) value = std::max(value, 0.0f);
    return out;
  }

  TensorFile file_;
};

}  // namespace

MeasuredBrdf read_measured(const std::filesystem::path& file, bool prefer_spectra) {
  return MeasuredReader(file).read(prefer_spectra);
}

}  // namespace sheaf
