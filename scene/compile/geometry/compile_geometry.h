// Compiles shapes, shape groups and instances.
#pragma once

#include "scene/compile/compile_materials.h"
#include "scene/compile/geometry/compiled_geometry.h"
#include "scene/description/error_sink.h"

namespace sheaf {

/// Reads the meshes of all shapes by all threads, from its construction on.
class MeshReader {
 public:
  /// `description` must outlive the object.
  explicit MeshReader(const Description& description);
  /// The mesh of the next shape that has_prepared_mesh(): of shapes without motion, of groups, of shapes with motion.
  PreparedMesh next() { return meshes_->take(taken_++); }
  /// Frees the memory of the reader. Call after the last mesh.
  void finish() { meshes_.reset(); }

 private:
  std::optional<ReadAhead<PreparedMesh>> meshes_;
  std::size_t taken_ = 0;
};

/// Adds all shapes, those of groups last, and instances. Shapes with a motion become groups with one instance. Reports
/// shapes that cannot be compiled, and leaves them out.
CompiledGeometry compile_geometry(const Description& description, MeshReader& meshes, const TextureTables& textures,
                                  const CompiledMaterials& materials, MotionCompiler& motion, ErrorSink& errors);

/// Reports textures that use an attribute that no mesh with their material has, and makes them gray. Returns warnings
/// about meshes that lack one. `scene`: with textures, materials and geometry.
std::vector<std::string> check_attributes(const Description& description, const CompiledGeometry& geometry,
                                          ErrorSink& errors, SceneTables& scene);

/// Builds the acceleration structure, or takes that of CompileOptions::kept. `scene` has all other tables.
void build_accel(const CompiledGeometry& geometry, const CompileOptions& options, SceneTables& scene);

}  // namespace sheaf
