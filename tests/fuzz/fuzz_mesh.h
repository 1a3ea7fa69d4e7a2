// All operations on a mesh between its file and the scene.
#pragma once

#include "core/math/transform.h"
#include "scene/formats/loop_subdivision.h"
#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/smooth_normals.h"
#include "tests/fuzz/fuzz.h"

namespace sheaf::fuzz {

inline void try_mesh(const MeshFile& file) {
  for (const std::string& warning : file.warnings) check_message(warning);
  check_mesh(file.mesh, {"mesh"});
  Mesh mesh = file.mesh;
  transform_mesh(mesh, Transform::scale({1, -2, 0.5f}));
  drop_degenerate_triangles(mesh);
  if (mesh.normals.empty()) {
    Mesh creased = mesh;
    compute_creased_normals(creased, {});
    check_mesh(creased, {"mesh"});
    compute_vertex_normals(mesh);
  }
  flip_mesh(mesh);
  check_mesh(mesh, {"mesh"});
  (void)open_edges(mesh);
  if (!mesh.triangles.empty()) (void)edge_distances(mesh, true);
  Mesh control;
  control.positions = mesh.positions;
  control.triangles = mesh.triangles;
  reads([&] { (void)subdivide(control, 1); });
}

}  // namespace sheaf::fuzz
