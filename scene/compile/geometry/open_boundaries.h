// Open edges of meshes around media.
#pragma once

#include "core/io/error.h"
#include "scene/formats/mesh.h"

#include <array>
#include <vector>

namespace sheaf {

/// Finds meshes around media that do not enclose them. Several meshes may enclose a medium together if they have the
/// same vertices where they meet.
class OpenBoundaries {
 public:
  using Edge = std::array<float, 6>;  ///< positions of both ends, the smaller first
  /// The open edges of a mesh.
  struct Boundary {
    SourceLocation where;
    std::vector<Edge> edges;
  };

  /// The open edges of a mesh in world space, which the element at `where` describes.
  static Boundary find(const Mesh& mesh, const SourceLocation& where);
  /// Adds a mesh.
  void add(Boundary boundary);

  struct Gap {
    SourceLocation where;
    std::size_t edges;  ///< number of open edges at which no other mesh continues the boundary
  };
  /// The meshes with gaps, in the order of add().
  std::vector<Gap> gaps() const;

 private:
  std::vector<Boundary> boundaries_;  ///< with open edges
};

}  // namespace sheaf
