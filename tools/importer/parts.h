// Parts of a model that Sheaf reads itself, because Assimp does not pass them on, or not completely.
#pragma once

#include <array>
#include <string>
#include <unordered_map>
#include <vector>

namespace sheaf::importer {

/// A camera in the space of its node. It looks along `forward`.
struct Camera {
  std::string name;
  std::array<double, 3> position = {0, 0, 0}, forward = {0, 0, -1}, up = {0, 1, 0};
  bool is_perspective = true;
  double yfov = 0;            ///< perspective: vertical field of view, radians
  double aspect = 0;          ///< perspective: width over height; 0: that of the image
  double xmag = 1, ymag = 1;  ///< orthographic: half of the width and of the height
};

/// A light in the space of its node. It shines along `direction`.
struct Light {
  enum class Kind { kDirectional, kPoint, kSpot, kOther } kind = Kind::kPoint;
  std::string name;
  std::array<double, 3> position = {0, 0, 0}, direction = {0, 0, -1};
  std::array<double, 3> color = {1, 1, 1};
  std::array<double, 3> attenuation = {1, 0, 0};  ///< constant, linear and quadratic in the distance
  double inner_angle = 0, outer_angle = 0;        ///< spot: angles from the axis, radians
};

/// Parts of one node besides its meshes.
struct NodeParts {
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  bool is_hidden = false;  ///< its meshes and lights are left out; its children are not
};

/// Keys of one part of a node's transform, interpolated linearly.
struct Keys {
  std::string node;                  ///< name
  const char* path;                  ///< of glTF: "translation", "rotation" (a quaternion, w last) or "scale"
  std::vector<float> times, values;  ///< times in s, not decreasing
};

struct Animation {
  std::string name;
  std::vector<Keys> channels;
};

struct FileParts {
  /// By the name that Assimp gives to the node. Nodes that share a name are listed in the order of the hierarchy,
  /// parents first; an instance of a node repeats the last one.
  std::unordered_map<std::string, std::vector<NodeParts>> nodes;
  std::vector<Animation> animations;
  std::vector<std::string> notes;  ///< what could not be converted
};

}  // namespace sheaf::importer
