// Animations of COLLADA: channels move single numbers of the elements of a node's transform, which is their product at
// each time. Each animated element gets a node of its own, because keys of the product could not be interpolated.
#include "tools/importer/collada_curve.h"
#include "tools/importer/glb.h"

#include <assimp/types.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string_view>

namespace sheaf::importer {

namespace {

/// A channel: the numbers from `first` on of an element follow a curve.
struct Track {
  ColladaCurve curve;
  std::size_t first, count;
};

/// An element of a transform and what moves it.
struct MovingElement {
  pugi::xml_node element;
  std::vector<Track> tracks;
};

/// Number of values of an element of a transform; 0 for others, and for those that cannot be animated.
std::size_t size_of(const pugi::xml_node& element) {
  const std::string_view name = element.name();
  if (name == "translate" || name == "scale") return 3;
  if (name == "rotate") return 4;
  return name == "matrix" ? 16 : 0;
}

bool is_transform(const pugi::xml_node& element) {
  const std::string_view name = element.name();
  return size_of(element) > 0 || name == "lookat" || name == "skew";
}

/// The index of a number that follows the sid in an address: .X, .ANGLE, (2), (1)(3). Returns kWhole for an empty text
/// and kUnknown for others.
constexpr std::size_t kWhole = 100, kUnknown = 101;
std::size_t member_index(std::string_view text) {
  if (text.empty()) return kWhole;
  constexpr std::array<std::string_view, 4> kMembers = {".X", ".Y", ".Z", ".ANGLE"};
  for (std::size_t i = 0; i < kMembers.size(); ++i)
    if (text == kMembers[i]) return i;
  const auto is_digit = [&](std::size_t at) { return text[at] >= '0' && text[at] <= '9'; };
  if (text.size() != 3 && text.size() != 6) return kUnknown;
  std::size_t index = 0;
  for (std::size_t at = 0; at < text.size(); at += 3) {
    if (text[at] != '(' || !is_digit(at + 1) || text[at + 2] != ')') return kUnknown;
    // The column of a matrix precedes its row
    index += static_cast<std::size_t>(text[at + 1] - '0') * (at == 0 ? 1 : 4);
  }
  return index;
}

/// The transform at one time, as keys of glTF.
class KeyBuilder {
 public:
  KeyBuilder(const MovingElement& moving, const std::string& node)
      : moving_(moving), base_(numbers_of(moving.element)) {
    base_.resize(size_of(moving.element));
    const std::string_view name = moving.element.name();
    if (name == "translate") out_ = {{node, "translation", {}, {}}};
    if (name == "scale") out_ = {{node, "scale", {}, {}}};
    if (name == "rotate") out_ = {{node, "rotation", {}, {}}};
    if (name == "matrix") out_ = {{node, "translation", {}, {}}, {node, "rotation", {}, {}}, {node, "scale", {}, {}}};
  }

  std::vector<Keys> build() {
    const std::vector<double> times = key_times();
    find_tolerances(times);
    add(times.front(), values(times.front(), false));
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
      // Add both limits at the end of a segment if they differ, after a step
      const Values before = values(times[i + 1], true), after = values(times[i + 1], false);
      add_pieces({times[i], values(times[i], false)}, {times[i + 1], before}, 0);
      add(times[i + 1], before);
      if (after != before) add(times[i + 1], after);
    }
    return std::move(out_);
  }

 private:
  using Values = std::vector<double>;
  struct Key {
    double time;
    Values values;
  };

  std::vector<double> key_times() const {
    std::vector<double> out;
    for (const Track& track : moving_.tracks)
      out.insert(out.end(), track.curve.times().begin(), track.curve.times().end());
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  /// Finds out which elements are not linear between keys, and how exactly lines must follow them: relative to the
  /// range of each number over the animation.
  void find_tolerances(const std::vector<double>& times) {
    constexpr double kRelative = 2e-5;
    for (const Track& track : moving_.tracks) {
      is_curved_ = is_curved_ || track.curve.is_curved();
      moves_axis_ = moves_axis_ || (base_.size() == 4 && track.first < 3);
    }
    Values low = values(times.front(), false), high = low;
    for (std::size_t i = 0; i + 1 < times.size() && is_curved_; ++i)
      for (const double t : {0.25, 0.5, 0.75, 1.0}) {
        const Values v = values(times[i] + t * (times[i + 1] - times[i]), true);
        for (std::size_t k = 0; k < v.size(); ++k) low[k] = std::min(low[k], v[k]), high[k] = std::max(high[k], v[k]);
      }
    for (std::size_t k = 0; k < low.size(); ++k) tolerances_.push_back(kRelative * (high[k] - low[k]));
  }

  /// Adds keys between two others until linear interpolation follows the curves, and rotations have at most a right
  /// angle.
  void add_pieces(const Key& first, const Key& last, int depth) {
    constexpr int kMaxDepth = 10, kAxisDepth = 5;
    if (depth == kMaxDepth || !(last.time > first.time)) return;
    const bool is_too_coarse = moves_axis_ && depth < kAxisDepth;
    if (!is_too_coarse && is_linear(first, last)) return;
    const double middle = first.time + (last.time - first.time) / 2;
    const Key between{middle, values(middle, false)};
    add_pieces(first, between, depth + 1);
    add(middle, between.values);
    add_pieces(between, last, depth + 1);
  }

  bool is_linear(const Key& first, const Key& last) const {
    constexpr double kRightAngle = 90;
    if (base_.size() == 4 && std::abs(last.values[3] - first.values[3]) > kRightAngle) return false;
    if (!is_curved_) return true;
    for (const double t : {0.25, 0.5, 0.75}) {
      const Values v = values(first.time + t * (last.time - first.time), false);
      for (std::size_t k = 0; k < v.size(); ++k)
        if (std::abs(v[k] - (first.values[k] + t * (last.values[k] - first.values[k]))) > tolerances_[k]) return false;
    }
    return true;
  }

  Values values(double time, bool from_before) const {
    Values out = base_;
    for (const Track& track : moving_.tracks)
      for (std::size_t k = 0; k < track.count; ++k) out[track.first + k] = track.curve.at(time, from_before, k);
    return out;
  }

  void add(double time, const Values& v) {
    const auto add_key = [&](Keys& to, std::initializer_list<double> numbers) {
      to.times.push_back(static_cast<float>(finite(time)));
      for (const double number : numbers) to.values.push_back(static_cast<float>(finite(number)));
    };
    if (v.size() == 3) add_key(out_[0], {v[0], v[1], v[2]});
    if (v.size() == 4) {
      const double length = std::hypot(v[0], v[1], v[2]), half = v[3] * std::numbers::pi / 360;
      const double s = length > 0 ? std::sin(half) / length : 0;
      add_key(out_[0], {s * v[0], s * v[1], s * v[2], length > 0 ? std::cos(half) : 1});
    }
    if (v.size() == 16) {
      aiMatrix4x4 matrix;
      for (unsigned i = 0; i < 16; ++i) matrix[i / 4][i % 4] = static_cast<float>(finite(v[i]));
      aiVector3D scale, position;
      aiQuaternion rotation;
      matrix.Decompose(scale, rotation, position);
      add_key(out_[0], {position.x, position.y, position.z});
      add_key(out_[1], {rotation.x, rotation.y, rotation.z, rotation.w});
      add_key(out_[2], {scale.x, scale.y, scale.z});
    }
  }

  const MovingElement& moving_;
  Values base_;
  Values tolerances_;  ///< largest deviation of each number
  bool is_curved_ = false, moves_axis_ = false;
  std::vector<Keys> out_;
};

/// All channels of some animations, by the node that they move.
class Channels {
 public:
  explicit Channels(ColladaDocument& document) : document_(document) {}

  /// Adds the channels of an animation and of those inside it.
  void add(const pugi::xml_node& animation) {
    std::vector<pugi::xml_node> open = {animation};
    while (!open.empty()) {
      const pugi::xml_node next = open.back();
      open.pop_back();
      for (const pugi::xml_node& channel : next.children("channel")) add_channel(channel);
      for (const pugi::xml_node& inner : next.children("animation")) open.push_back(inner);
    }
  }

  /// The moving elements of a node, in its order.
  std::vector<MovingElement> of(const pugi::xml_node& node) const {
    std::vector<MovingElement> out;
    for (const pugi::xml_node& element : node.children())
      if (const auto found = tracks_.find(element.internal_object()); found != tracks_.end())
        out.push_back({element, found->second});
    return out;
  }
  std::size_t ignored() const { return ignored_; }

 private:
  void add_channel(const pugi::xml_node& channel) {
    const std::string_view target = channel.attribute("target").value();
    const std::size_t slash = target.find('/'), sid_end = target.find_first_of(".(", std::min(slash, target.size()));
    const auto node = document_.by_id.find(std::string(target.substr(0, slash)));
    ++ignored_;
    if (slash == target.npos || node == document_.by_id.end()) return;
    const std::string sid(target.substr(slash + 1, std::min(sid_end, target.size()) - slash - 1));
    const pugi::xml_node element = node->second.find_child_by_attribute("sid", sid.c_str());
    const std::size_t size = size_of(element), member = member_index(target.substr(std::min(sid_end, target.size())));
    auto curve = ColladaCurve::read(document_, document_.target(channel.attribute("source")));
    if (size == 0 || !curve) return;
    const std::size_t count = member == kWhole ? std::min(size, curve->size()) : 1;
    const std::size_t first = member == kWhole ? 0 : member;
    if (first + count > size) return;
    tracks_[element.internal_object()].push_back({std::move(*curve), first, count});
    --ignored_;
  }

  ColladaDocument& document_;
  std::map<const void*, std::vector<Track>> tracks_;
  std::size_t ignored_ = 0;  ///< channels that move something else
};

/// Divides nodes, and remembers their parts.
class NodeDivider {
 public:
  explicit NodeDivider(ColladaDocument& document) : document_(document) {}

  /// Gives each of these elements of a node a node of its own: ancestors of the node, which keeps its last elements and
  /// all else. Returns the name of the node of each element.
  void divide(pugi::xml_node node, const std::set<const void*>& moving) {
    // Group the elements; those that do not move stay together
    std::vector<std::vector<pugi::xml_node>> groups;
    bool last_moves = true;
    for (const pugi::xml_node& element : node.children()) {
      if (!is_transform(element)) continue;
      const bool moves = moving.contains(element.internal_object());
      if (moves || last_moves) groups.emplace_back();
      groups.back().push_back(element);
      last_moves = moves;
    }
    const std::string id = node.attribute("id").value();
    pugi::xml_node outer;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      pugi::xml_node holder = node;
      if (i + 1 < groups.size()) {
        holder = outer ? outer.append_child("node") : node.parent().insert_child_before("node", node);
        holder.append_attribute("id") = document_.unique_id(id + "$").c_str();
        for (const pugi::xml_node& element : groups[i]) holder.append_move(element);
        if (i == 0) outermost_[id] = holder.attribute("id").value();
        outer = holder;
      }
      for (const pugi::xml_node& element : groups[i])
        names_[element.internal_object()] = holder.attribute("id").value();
    }
    if (outer) outer.append_move(node);
  }

  std::string name_of(const pugi::xml_node& element) const { return names_.at(element.internal_object()); }

  /// Makes instances of divided nodes refer to their outermost node.
  void redirect_instances() {
    for (pugi::xml_node& node : document_.nodes)
      for (pugi::xml_node& instance : node.children("instance_node")) {
        pugi::xml_attribute url = instance.attribute("url");
        const std::string_view text = url.value();
        if (!text.starts_with('#')) continue;
        const auto found = outermost_.find(std::string(text.substr(1)));
        if (found != outermost_.end()) url = ("#" + found->second).c_str();
      }
  }

 private:
  ColladaDocument& document_;
  std::map<const void*, std::string> names_;      ///< node of each element
  std::map<std::string, std::string> outermost_;  ///< of divided nodes
};

/// A clip, or all animations.
struct Clip {
  std::string name;
  Channels channels;
};

std::string name_of(const pugi::xml_node& element) {
  const pugi::xml_attribute name = element.attribute("name");
  return name ? name.value() : element.attribute("id").value();
}

/// The animations of a document: its clips, or a single one of everything that moves.
std::vector<Clip> clips_of(ColladaDocument& document) {
  std::vector<Clip> clips;
  const pugi::xml_node root = document.xml.document_element();
  for (const pugi::xml_node& library : root.children("library_animation_clips"))
    for (const pugi::xml_node& clip : library.children("animation_clip")) {
      clips.push_back({name_of(clip), Channels(document)});
      for (const pugi::xml_node& instance : clip.children("instance_animation"))
        if (const pugi::xml_node animation = document.target(instance.attribute("url")))
          clips.back().channels.add(animation);
    }
  if (!clips.empty()) return clips;
  Clip all{{}, Channels(document)};
  for (const pugi::xml_node& library : root.children("library_animations"))
    for (const pugi::xml_node& animation : library.children("animation")) {
      if (all.name.empty()) all.name = name_of(animation);
      all.channels.add(animation);
    }
  clips.push_back(std::move(all));
  return clips;
}

}  // namespace

void take_animations(ColladaDocument& document, FileParts& out) {
  std::vector<Clip> clips = clips_of(document);
  NodeDivider divider(document);
  std::vector<std::vector<MovingElement>> moving(clips.size());
  for (const pugi::xml_node& node : document.nodes) {
    std::set<const void*> elements;
    for (std::size_t i = 0; i < clips.size(); ++i)
      for (MovingElement& element : clips[i].channels.of(node)) {
        elements.insert(element.element.internal_object());
        moving[i].push_back(std::move(element));
      }
    if (!elements.empty()) divider.divide(node, elements);
  }
  divider.redirect_instances();
  std::size_t ignored = 0;
  for (std::size_t i = 0; i < clips.size(); ++i) {
    ignored += clips[i].channels.ignored();
    Animation animation{clips[i].name, {}};
    for (const MovingElement& element : moving[i])
      for (Keys& keys : KeyBuilder(element, divider.name_of(element.element)).build())
        animation.channels.push_back(std::move(keys));
    if (!animation.channels.empty()) out.animations.push_back(std::move(animation));
  }
  if (ignored > 0)
    out.notes.push_back(fmt::format("{} animation channels do not move a node, or are damaged (ignored)", ignored));
  pugi::xml_node root = document.xml.document_element();
  while (root.remove_child("library_animations")) {}
  while (root.remove_child("library_animation_clips")) {}
}

}  // namespace sheaf::importer
