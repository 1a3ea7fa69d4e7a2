// Integrators: the list of their names with the settings that each name selects, and what the passes of each kind do.
// Readers of scenes, renders, reports, --help and tests derive from it.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// The quantity computed at each pixel. Radiance along paths from the camera, along paths from the lights, or along
/// both with photon maps in between; or normals, depth or ambient visibility of the first surface.
enum class IntegratorKind { kPath, kLightTracer, kPhotonMapper, kNormals, kDepth, kVisibility };

/// Estimator of direct light: by sampling lights, by sampling BSDFs, or both combined by MIS.
enum class LightStrategy { kMis, kBsdfOnly, kLightOnly };

/// Start of the paths that carry light.
enum class PathSource {
  kNoLight,  ///< no light is transported: pixels show properties of the first surface
  kCamera,   ///< at the camera
  kLights,   ///< at the lights; each vertex is connected to the camera
  kBoth,     ///< at the lights, which fills photon maps, and at the camera, which gathers from them
};

/// Default depths at which Russian roulette starts; see bench/README.md.
inline constexpr int kPathRouletteDepth = 2, kDefaultRouletteDepth = 5;

/// The passes of an integrator and the features that it supports.
struct IntegratorTraits {
  const char* name;  ///< of the integrator with the default settings of this kind
  PathSource source = PathSource::kNoLight;
  int roulette_depth = kDefaultRouletteDepth;  ///< IntegratorSettings::rr_depth by default
  bool supports_adaptive = false;              ///< noise targets and time limits
  bool supports_guiding = false;               ///< path guiding and manifold next-event estimation
  bool supports_spectral_bins = false;
  bool measures_visibility = false;  ///< traces shadow rays instead of transporting light

  constexpr bool uses_lights() const { return source != PathSource::kNoLight; }
  constexpr bool emits_photons() const { return source == PathSource::kLights || source == PathSource::kBoth; }
  constexpr bool has_photon_maps() const { return source == PathSource::kBoth; }
  /// Whether the image consists of photons that are connected to the camera. They are not samples of a pixel.
  constexpr bool connects_photons() const { return source == PathSource::kLights; }
  /// Whether light is estimated along paths from the camera, as layers of the first surface and light groups need.
  constexpr bool follows_camera_paths() const { return source == PathSource::kCamera || source == PathSource::kBoth; }
};

/// The traits of all kinds, in the order of IntegratorKind.
inline constexpr IntegratorTraits kIntegratorTraits[] = {
    {.name = "path",
     .source = PathSource::kCamera,
     .roulette_depth = kPathRouletteDepth,
     .supports_adaptive = true,
     .supports_guiding = true,
     .supports_spectral_bins = true},
    {.name = "ptracer", .source = PathSource::kLights},
    {.name = "photonmapper", .source = PathSource::kBoth},
    {.name = "normals"},
    {.name = "depth"},
    {.name = "av", .measures_visibility = true},
};

constexpr const IntegratorTraits& traits_of(IntegratorKind kind) {
  return kIntegratorTraits[static_cast<std::size_t>(kind)];
}

/// Names; the rest is null.
using IntegratorNames = std::array<const char*, 24>;

/// An integrator: its names, and the settings that they select.
struct IntegratorEntry {
  IntegratorNames names{};        ///< its own name, then synonyms; in all dialects and on the command line
  IntegratorNames pbrt_names{};   ///< names that mean this integrator in pbrt scenes only
  IntegratorNames substituted{};  ///< integrators of other renderers with the same expected image; noted
  /// Likewise, but these find caustics and light through small openings that this one finds with far more noise. An
  /// error on the command line, a warning in scene files.
  IntegratorNames unsupported{};
  const char* help = nullptr;  ///< description in --help, which lists no integrators without one
  IntegratorKind kind = IntegratorKind::kPath;
  LightStrategy strategy = LightStrategy::kMis;
  bool is_direct = false;                  ///< direct light only: max_depth is 2
  int candidates = 1;                      ///< sets IntegratorSettings::candidates if above 1
  bool thin_dielectrics_are_free = false;  ///< IntegratorSettings::thin_dielectrics_are_free
  bool ends_at_diffuse = false;            ///< IntegratorSettings::ends_at_diffuse
  bool is_progressive = false;             ///< PhotonMappingSettings::progressive
  bool whitens_scene = false;              ///< all shapes are white; materials and lights are ignored
};

/// Light candidates per vertex of the `_ris` integrators.
inline constexpr int kRisCandidates = 8;

/// All integrators, in the order of --help.
inline constexpr IntegratorEntry kIntegrators[] = {
    {.names = {"path", "path_mis", "vol_path", "vol_path_mis", "volpath_mis", "path_vol", "path_vol_mis",
               "path_mis_vol", "medium_path", "medium_path_mis", "simplepath", "simplevolpath"},
     .pbrt_names = {"volpath"},
     .substituted = {"adaptive", "guided_path", "irrcache", "path_guiding_integrator", "path_tracer_recursive", "prb",
                     "prb_basic", "prb_projective", "prb_reparam", "randomwalk", "singlescatter", "vpl", "vrl"},
     .unsupported = {"bdpt", "erpt", "mlt", "pssmlt", "upbp", "vcm"},
     .help = "path tracing, with multiple importance sampling of lights and BSDFs"},
    {.names = {"direct", "direct_mis"},
     .substituted = {"direct_projective", "direct_reparam", "emission_reparam"},
     .help = "direct light only",
     .is_direct = true},
    {.names = {"path_mats", "vol_path_mats", "volpath_mats", "path_vol_mats", "medium_path_mats"},
     .help = "path tracing with BSDF sampling only",
     .strategy = LightStrategy::kBsdfOnly},
    {.names = {"path_ems"}, .help = "path tracing with light sampling only", .strategy = LightStrategy::kLightOnly},
    {.names = {"path_ris"}, .help = "path tracing with 8 light candidates per vertex", .candidates = kRisCandidates},
    {.names = {"direct_mats"}, .strategy = LightStrategy::kBsdfOnly, .is_direct = true},
    {.names = {"direct_ems"}, .strategy = LightStrategy::kLightOnly, .is_direct = true},
    {.names = {"direct_ris"}, .is_direct = true, .candidates = kRisCandidates},
    {.names = {"volpath", "volpathmis", "volpath_simple"},
     .substituted = {"prbvolpath"},
     .thin_dielectrics_are_free = true},
    {.names = {"whitted"},
     .help = "paths that continue only at mirrors and smooth glass",
     .strategy = LightStrategy::kLightOnly,
     .ends_at_diffuse = true},
    {.names = {"ptracer", "lightpath"},
     .help = "light tracing: paths from the lights",
     .kind = IntegratorKind::kLightTracer},
    {.names = {"photonmapper", "photonmap", "volumetricphotonmapper"},
     .help = "photon mapping",
     .kind = IntegratorKind::kPhotonMapper},
    {.names = {"sppm", "ppm"},
     .help = "progressive photon mapping",
     .kind = IntegratorKind::kPhotonMapper,
     .is_progressive = true},
    {.names = {"ao", "ambientocclusion"},
     .help = "ambient occlusion",
     .strategy = LightStrategy::kBsdfOnly,
     .whitens_scene = true},
    {.names = {"av"}, .help = "average visibility", .kind = IntegratorKind::kVisibility, .whitens_scene = true},
    {.names = {"normals"}, .help = "shading normals", .kind = IntegratorKind::kNormals},
    {.names = {"depth"}, .help = "depth of the first surface", .kind = IntegratorKind::kDepth},
};

/// How an integrator replaces the named one of another renderer; see IntegratorEntry.
enum class Substitution { kNone, kEquivalent, kNoisier };

/// An integrator found by a name.
struct IntegratorMatch {
  const IntegratorEntry* entry;
  /// The name that was searched for, or the entry's own name if the entry replaces another integrator.
  const char* name;
  Substitution substitution = Substitution::kNone;

  bool is_substitute() const { return substitution != Substitution::kNone; }
};

/// Finds an integrator by any of its names, or the one that replaces another renderer's integrator. `in_pbrt`: the name
/// is from a pbrt scene.
std::optional<IntegratorMatch> find_integrator(std::string_view name, bool in_pbrt = false);

/// The names that find_integrator() knows, sorted.
std::vector<std::string> integrator_names();

/// The integrators that --help lists: their names, and a text with a line for each.
std::vector<std::string> suggested_integrators();
std::string integrator_descriptions();

}  // namespace sheaf
