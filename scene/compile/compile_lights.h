// Compiles lights: area lights, volume lights and the description's own lights, and the tables for light selection.
#pragma once

#include "scene/compile/compile_motion.h"
#include "scene/compile/geometry/compiled_geometry.h"
#include "scene/compile/media/compile_media.h"
#include "scene/compile/scene_naming.h"
#include "scene/spectra/spectrum_set.h"

namespace sheaf {

/// The textures that a shape's emission uses: those of its radiance and of the clearcoat over it.
std::vector<TextureId> emission_textures(const ShapeDescription& shape);

/// Tables of lights.
struct CompiledLights {
  LightTables tables;
  std::vector<SpectrumRow> spectra;  ///< by row
  std::vector<std::string> warnings;
};

/// Compiles all lights: those of shapes outside of groups, of instances, the description's bounded ones, those of media
/// and those at infinity. Sets the lights of shapes, instances and media in `scene`, whose other tables are complete,
/// and adds quadrics for instances of quadrics that emit. `set` makes rows of spectra in spectral mode. Reports
/// lights that are left out: a second environment light, and invalid emission. Throws SceneError for too many
/// triangles.
CompiledLights compile_lights(const Description& description, const CompiledGeometry& geometry,
                              const CompiledMedia& media, SpectrumSet* set, MotionCompiler& motion, SceneNaming& naming,
                              ErrorSink& errors, SceneTables& scene);

/// Builds the tables for light selection, from the lights of a scene with all other tables but the acceleration
/// structure.
void select_lights(const MotionCompiler& motion, SceneTables& scene);

}  // namespace sheaf
