// Polygons with holes (COLLADA 1.4.1, <ph>): each hole is joined to the outline by a bridge, two coinciding edges in
// opposite directions between visible corners (Eberly, "Triangulation by Ear Clipping", section 5).
#include "tools/importer/collada_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

namespace sheaf::importer {

namespace {

struct Point {
  double x, y;

  friend bool operator==(const Point&, const Point&) = default;
};

/// A corner with its position in the list of indices.
struct Corner {
  Point point;
  std::size_t index;  ///< number of the corner, in the order of the file
};
using Ring = std::vector<Corner>;

/// Twice the signed area of the triangle a b c, positive if counter-clockwise.
double cross(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

double area(const Ring& ring) {
  double sum = 0;
  for (std::size_t i = 0; i < ring.size(); ++i)
    sum += cross(ring[0].point, ring[i].point, ring[(i + 1) % ring.size()].point);
  return sum;
}

/// Whether p lies strictly between the ends of the segment a b.
bool is_between(Point p, Point a, Point b) {
  if (p == a || p == b || cross(a, b, p) != 0) return false;
  return (p.x - a.x) * (p.x - b.x) + (p.y - a.y) * (p.y - b.y) < 0;
}

/// Whether the inner points of two segments meet, or an end of one lies inside the other.
bool meets(Point a, Point b, Point c, Point d) {
  if (is_between(c, a, b) || is_between(d, a, b) || is_between(a, c, d) || is_between(b, c, d)) return true;
  const auto opposite = [](double s, double t) { return (s > 0 && t < 0) || (s < 0 && t > 0); };
  return opposite(cross(a, b, c), cross(a, b, d)) && opposite(cross(c, d, a), cross(c, d, b));
}

/// Whether the direction to p points into a counter-clockwise ring at its corner i.
bool points_inside(const Ring& ring, std::size_t i, Point p) {
  const Point before = ring[(i + ring.size() - 1) % ring.size()].point, corner = ring[i].point,
              after = ring[(i + 1) % ring.size()].point;
  const bool left_of_next = cross(corner, after, p) > 0, left_of_last = cross(before, corner, p) > 0;
  return cross(before, corner, after) >= 0 ? left_of_next && left_of_last : left_of_next || left_of_last;
}

/// Joins holes to the outline of one polygon.
class HoleJoiner {
 public:
  /// `rings`: the outline and the holes, projected. `work` counts comparisons of edges over a whole file.
  HoleJoiner(std::vector<Ring> rings, std::size_t& work) : rings_(std::move(rings)), work_(work) {}

  /// Returns the outline with all holes that can be joined, and adds the number of others to `left_out`.
  Ring join(std::size_t& left_out) {
    outline_ = std::move(rings_.front());
    rings_.erase(rings_.begin());
    if (area(outline_) < 0) std::reverse(outline_.begin(), outline_.end()), is_reversed_ = true;
    for (Ring& hole : rings_) {
      if (area(hole) > 0) std::reverse(hole.begin(), hole.end());
      std::rotate(hole.begin(), std::max_element(hole.begin(), hole.end(), is_left), hole.end());
    }
    // From right to left, so that nothing but the outline and joined holes is to the right of a hole
    std::sort(rings_.begin(), rings_.end(), [](const Ring& a, const Ring& b) { return is_left(b[0], a[0]); });
    for (std::size_t i = 0; i < rings_.size(); ++i)
      if (!join_hole(i)) ++left_out;
    if (is_reversed_) std::reverse(outline_.begin(), outline_.end());
    return std::move(outline_);
  }

 private:
  static bool is_left(const Corner& a, const Corner& b) { return a.point.x < b.point.x; }

  bool crosses(const Ring& ring, Point a, Point b) {
    work_ += ring.size();
    for (std::size_t i = 0; i < ring.size(); ++i)
      if (meets(a, b, ring[i].point, ring[(i + 1) % ring.size()].point)) return true;
    return false;
  }

  /// Joins a hole at its rightmost corner to the nearest corner of the outline that it sees.
  bool join_hole(std::size_t hole) {
    constexpr std::size_t kMaxWork = 300'000'000;  // about 1 s
    const Point from = rings_[hole][0].point;
    const auto distance = [&](std::size_t i) {
      return std::hypot(outline_[i].point.x - from.x, outline_[i].point.y - from.y);
    };
    std::vector<std::size_t> order(outline_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return distance(a) < distance(b); });
    for (const std::size_t i : order) {
      if (work_ > kMaxWork) return false;
      const Point to = outline_[i].point;
      if (to == from || !points_inside(outline_, i, from) || crosses(outline_, from, to)) continue;
      bool is_free = true;
      for (std::size_t k = hole; k < rings_.size() && is_free; ++k) is_free = !crosses(rings_[k], from, to);
      if (!is_free) continue;
      Ring bridge(rings_[hole]);
      bridge.push_back(rings_[hole][0]);
      bridge.push_back(outline_[i]);
      outline_.insert(outline_.begin() + static_cast<std::ptrdiff_t>(i) + 1, bridge.begin(), bridge.end());
      return true;
    }
    return false;
  }

  std::vector<Ring> rings_;
  Ring outline_;
  std::size_t& work_;
  bool is_reversed_ = false;
};

/// The indices of one <p> or <h>: `stride` numbers per corner.
std::vector<std::string> words_of(const pugi::xml_node& element) {
  std::vector<std::string> out;
  std::string_view text = element.child_value();
  constexpr std::string_view kSpace = " \t\r\n";
  for (;;) {
    const std::size_t begin = std::min(text.find_first_not_of(kSpace), text.size());
    text.remove_prefix(begin);
    if (text.empty()) return out;
    const std::size_t end = std::min(text.find_first_of(kSpace), text.size());
    out.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

/// The inputs of <polygons>.
struct Inputs {
  ColladaSource positions;
  std::size_t stride = 1, vertex = 0;  ///< numbers per corner, and which of them is that of the position

  Inputs(const ColladaDocument& document, const pugi::xml_node& polygons) {
    constexpr unsigned kMaxOffset = 1000;
    for (const pugi::xml_node& input : polygons.children("input")) {
      const std::size_t at = std::min(input.attribute("offset").as_uint(0), kMaxOffset);
      stride = std::max(stride, at + 1);
      if (std::string_view(input.attribute("semantic").value()) != "VERTEX") continue;
      vertex = at;
      const pugi::xml_node vertices = document.target(input.attribute("source"));
      const pugi::xml_node position = vertices.find_child_by_attribute("input", "semantic", "POSITION");
      positions = read_source(document, document.target(position.attribute("source")));
    }
  }
};

/// The corners of a polygon and its holes, and how they are projected.
class PolygonWithHoles {
 public:
  PolygonWithHoles(const pugi::xml_node& ph, const Inputs& inputs) {
    add(ph.child("p"), inputs);
    for (const pugi::xml_node& hole : ph.children("h")) add(hole, inputs);
  }

  /// The indices of the outline with its holes; without them if they cannot be joined.
  std::string joined(std::size_t& work, std::size_t& left_out) const {
    Ring ring;
    if (const auto axis = projection_axis()) {
      std::vector<Ring> rings;
      for (std::size_t i = 0, begin = 0; i < ends_.size(); begin = ends_[i++]) {
        Ring projected;
        for (std::size_t k = begin; k < ends_[i]; ++k)
          projected.push_back({{points_[k][(*axis + 1) % 3], points_[k][(*axis + 2) % 3]}, k});
        if (projected.size() >= 3) rings.push_back(std::move(projected));
      }
      ring = HoleJoiner(std::move(rings), work).join(left_out);
    } else {
      left_out += ends_.size() - 1;
      for (std::size_t k = 0; k < ends_.front(); ++k) ring.push_back({{}, k});
    }
    std::string out;
    for (const Corner& corner : ring) out += indices_[corner.index] + " ";
    return out;
  }

 private:
  void add(const pugi::xml_node& element, const Inputs& inputs) {
    const std::vector<std::string> words = words_of(element);
    for (std::size_t at = 0; at + inputs.stride <= words.size(); at += inputs.stride) {
      std::string indices;
      for (std::size_t k = 0; k < inputs.stride; ++k) indices += (k > 0 ? " " : "") + words[at + k];
      indices_.push_back(std::move(indices));
      const auto vertex = static_cast<std::size_t>(std::max(std::atoll(words[at + inputs.vertex].c_str()), 0ll));
      const bool exists = vertex < inputs.positions.count;
      std::array<double, 3> point{};
      for (std::size_t k = 0; k < 3 && exists; ++k) point[k] = inputs.positions.number(vertex, k);
      points_.push_back(point);
    }
    ends_.push_back(indices_.size());
  }

  /// The axis along which the outline has the largest area. Nothing if it has none.
  std::optional<std::size_t> projection_axis() const {
    const std::size_t count = ends_.front();
    std::array<double, 3> normal{};
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
        const auto &a = points_[i], &b = points_[(i + 1) % count], &origin = points_[0];
        normal[k] += (a[u] - origin[u]) * (b[v] - origin[v]) - (a[v] - origin[v]) * (b[u] - origin[u]);
      }
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
    if (count < 3 || normal[axis] == 0 || !std::isfinite(normal[0] + normal[1] + normal[2])) return std::nullopt;
    return axis;
  }

  std::vector<std::string> indices_;           ///< of each corner
  std::vector<std::array<double, 3>> points_;  ///< of each corner
  std::vector<std::size_t> ends_;              ///< of the outline and of each hole
};

}  // namespace

void join_holes(ColladaDocument& document, FileParts& out) {
  std::size_t work = 0, left_out = 0;
  const auto join_all = [&](pugi::xml_node& polygons) {
    std::optional<Inputs> inputs;
    for (pugi::xml_node ph = polygons.child("ph"); ph; ph = ph.next_sibling("ph")) {
      if (!ph.child("h")) continue;
      if (!inputs) inputs.emplace(document, polygons);
      const std::string joined = PolygonWithHoles(ph, *inputs).joined(work, left_out);
      while (ph.remove_child("h")) {}
      ph.child("p").text() = joined.c_str();
    }
  };
  for (const pugi::xml_node& library : document.xml.document_element().children("library_geometries"))
    for (const pugi::xml_node& geometry : library.children("geometry"))
      for (pugi::xml_node polygons : geometry.child("mesh").children("polygons")) join_all(polygons);
  if (left_out > 0)
    out.notes.push_back(fmt::format("{} holes of polygons are left out, because their outlines intersect", left_out));
}

}  // namespace sheaf::importer
