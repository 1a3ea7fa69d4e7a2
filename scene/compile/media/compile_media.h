// Compiles the media of a description.
#pragma once

#include "scene/compile/compile.h"
#include "scene/compile/compile_motion.h"
#include "scene/compile/geometry/compiled_geometry.h"
#include "scene/spectra/spectrum_set.h"

#include <span>

namespace sheaf {

/// A shape that contains a medium.
struct MediumShape {
  Bounds3f box;                     ///< world space, meters; of a shape that moves: at the first key
  const AnimatedTransform* motion;  ///< null: the shape is static
};

/// A medium and the shapes that contain it.
struct MediumInput {
  const MediumDescription* description;
  const PhaseDescription* phase = nullptr;  ///< null: isotropic
  std::uint32_t phase_row = 0;              ///< row of its phase function's material
  std::vector<MediumShape> shapes;

  /// Reports an error of the medium, which becomes empty.
  void make_empty(const SceneError& error, ErrorSink& errors);
};

/// What becomes of a medium that cannot be compiled, for messages.
inline constexpr const char* kEmptySubstitute = "the medium is empty";

/// Tables of media, and what the compilers of other subjects need to know about them.
struct CompiledMedia {
  MediumTables tables;
  std::vector<SpectrumRow> spectra;          ///< kMediumSpectra per medium; empty in RGB mode
  std::vector<PlacedGrid> grids;             ///< grids of `tables`, with their positions at the first key
  std::vector<std::vector<Bounds3f>> boxes;  ///< of the shapes that contain each medium, relative to its grids
  std::vector<MotionRow> motions;            ///< of each medium, with or without grids
  std::vector<std::string> warnings;
};

/// Reads grids, makes the tables of media, majorants and boundaries, and refers to boundaries from `shapes`. `set`
/// makes rows of spectra in spectral mode. Reports media that are replaced by empty ones: unreadable files, grids with
/// a wrong number of channels, singular transforms, and media that photons do not support. Reports grids with different
/// motions, which become static, and media that groups of shapes do not support, which are left out.
CompiledMedia compile_media(const Description& description, const IntegratorSettings& integrator,
                            const CompiledGeometry& geometry, const std::vector<std::uint32_t>& row_of_phase,
                            SpectrumSet* set, MotionCompiler& motion, ErrorSink& errors, std::vector<ShapeRow>& shapes);

/// Adds the rows of media, grids and majorants, and describes the grids. `step_size` is that of ray marching, meters;
/// 0: 1/100 of each medium's diagonal. `scene`: bounds of the scene, for media that no shape contains.
void add_medium_rows(std::span<MediumInput> media, const Bounds3f& scene, SpectrumSet* set, float step_size,
                     ErrorSink& errors, CompiledMedia& out);

/// Adds the motions of media, whose rows have been added, and the boxes of the shapes relative to them.
void move_media(std::span<const MediumInput> media, const Bounds3f& scene, MotionCompiler& motion, ErrorSink& errors,
                CompiledMedia& out);

/// Reports media whose coefficients or emission are not finite somewhere, because tracking would then take steps of
/// length zero, and makes them empty.
void check_media(std::span<const MediumDescription> media, ErrorSink& errors, SceneTables& scene);

/// Marks the media whose rays are connected to lights (kernels/stages/segment_lights.cpp); see kMediumConnects.
/// `media`: its tables are those of `scene`, whose lights are complete.
void connect_media(const CompiledMedia& media, SceneTables& scene);

/// Bounds unbounded media by a sphere around the whole scene with its lights, so that lights at infinity reach it.
void bound_outer_medium(const MotionCompiler& motion, SceneTables& scene);

/// Finds the media around shapes and around `cameras`, when the shutter opens, by probe rays. `scene` is complete, with
/// its acceleration structure.
void probe_media(const Description& description, const CompiledGeometry& geometry,
                 std::span<const CameraDescription> cameras, SceneTables& scene);

}  // namespace sheaf
