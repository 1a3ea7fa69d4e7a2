// Reading and processing of the meshes of shapes, which all threads do ahead of the compiler.
#pragma once

#include "core/io/read_ahead.h"
#include "scene/compile/geometry/open_boundaries.h"
#include "scene/description/shapes.h"

#include <string>
#include <vector>

namespace sheaf {

/// The vertices of a mesh at one time.
struct MeshStep {
  std::vector<Vec3f> positions, normals;   ///< as long as those of the mesh
  std::vector<MeshTangent> tangents = {};  ///< likewise
};

/// A mesh that is ready for the tables of the scene.
struct PreparedMesh {
  Mesh mesh;                              ///< world space; without degenerate triangles
  std::vector<std::string> warnings;      ///< from reading its file, with the file's name
  std::size_t dropped = 0;                ///< degenerate or non-finite triangles
  OpenBoundaries::Boundary open_edges{};  ///< if the shape bounds a medium
  /// Of meshes that deform: vertices at the later ones of equidistant times over the shutter.
  std::vector<MeshStep> later_steps = {};
};

/// Whether prepare_mesh(shape) makes a mesh of the shape: of files, in memory, a rectangle or a cube.
bool has_prepared_mesh(const ShapeDescription& shape);

/// Reads the mesh of a shape and processes it in the order that scene/formats/mesh.h lists. Throws SceneError like
/// read_mesh() and check_mesh(). Safe to call from any thread. `shutter`: for meshes that deform.
PreparedMesh prepare_mesh(const ShapeDescription& shape, const ShutterDescription& shutter);

/// The same for a mesh that deforms. Throws SceneError if its keys have different triangles.
PreparedMesh prepare_deforming_mesh(const ShapeDescription& shape, const DeformingMesh& from,
                                    const ShutterDescription& shutter);

/// The same for a mesh of the shape in its local space. `is_split`: see MeshFile.
PreparedMesh prepare_mesh(const ShapeDescription& shape, Mesh mesh, bool face_normals, bool is_split = false);

/// The jobs of prepare_mesh() for all shapes that have such meshes, in order. Both arguments must outlive them.
std::vector<ReadAhead<PreparedMesh>::Job> mesh_jobs(const std::vector<const ShapeDescription*>& shapes,
                                                    const ShutterDescription& shutter);

}  // namespace sheaf
