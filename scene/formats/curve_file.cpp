// Parser of Mitsuba 3's curve files.
#include "scene/formats/curve_file.h"

#include "scene/formats/mesh_io.h"
#include "scene/formats/number_lines.h"

namespace sheaf {

namespace {

/// Throws unless the curve that ends before this line has enough points.
void end_curve(const Curves& curves, const NumberLines& lines) {
  const std::size_t count = curves.points.size() - curves.starts.back();
  if (count < curves.order())
    lines.fail(fmt::format("the curve that ends here has {} points (expected at least {})", count, curves.order()));
}

}  // namespace

Curves read_curve_file(const std::filesystem::path& file, Curves::Basis basis) {
  const std::string name = file.string(), text = read_mesh_text(file, "curve file");
  NumberLines lines(text, name);
  Curves curves;
  curves.basis = basis;
  bool inside = false;
  while (lines.next()) {
    // Empty lines end a curve
    if (lines.line().empty()) {
      if (inside) end_curve(curves, lines);
      inside = false;
      continue;
    }
    // Read a control point
    float numbers[4];
    lines.read(numbers, "x y z radius");
    if (numbers[3] < 0) lines.fail(fmt::format("the radius {} is negative", numbers[3]));
    if (!inside) curves.starts.push_back(static_cast<std::uint32_t>(curves.points.size()));
    inside = true;
    curves.points.push_back({{numbers[0], numbers[1], numbers[2]}, numbers[3]});
  }
  if (inside) end_curve(curves, lines);
  if (curves.points.empty()) throw SceneError(SourceLocation{name}, "the file holds no curve");
  return curves;
}

}  // namespace sheaf
