// Embree's devices and scenes, with errors as exceptions. The only file that includes Embree; only the sources of
// accel.h include it.
#pragma once

#if SHEAF_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace sheaf {

/// Options of an Embree scene.
struct EmbreeOptions {
  bool watertight = false;  ///< see CompileOptions::watertight
  bool compact = false;     ///< see BvhLayout::kCompact
  bool updatable = false;   ///< see AccelInput::updatable
};

/// An Embree device with one scene.
struct EmbreeScene {
  std::atomic<std::ptrdiff_t> bytes{0};
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  EmbreeScene() = default;
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  /// Creates the device and an empty scene. Throws Error (exit code 1) if that fails.
  void start(EmbreeOptions options);
  /// Throws Error (exit code 1) or std::bad_alloc if an earlier call of Embree failed.
  void check() const;
  /// Bytes that Embree has allocated.
  std::size_t allocated() const;
};

/// An empty scene.
RTCScene make_embree_scene(RTCDevice device, EmbreeOptions options);

/// Lets commit_scene() build a structure for each mesh, with the quality of its geometry, and one over these. Embree
/// calls it the low quality of a scene.
void build_meshes_apart(RTCScene scene);

/// Commits the geometry, attaches it to the scene under this id, and releases it.
void attach_geometry(RTCScene scene, RTCGeometry geometry, std::uint32_t id);

/// Builds the scene's structure, the same on every machine.
void commit_scene(RTCScene scene);

}  // namespace sheaf
