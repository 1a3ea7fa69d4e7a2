#include "scene/accel/embree.h"

#include "core/io/error.h"
#include "core/io/memory.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <new>

namespace sheaf {

namespace {

/// Number of threads that Embree assumes for builds. Its builders split work by this number, which affects the order of
/// triangles in leaves and so ties between equal distances. A constant makes all builds identical.
constexpr int kBuildConcurrency = 8;

bool count_memory(void* user, ssize_t bytes, bool /*after*/) {
  static_cast<std::atomic<std::ptrdiff_t>*>(user)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

/// Throws Error (exit code 1) if an address-space limit leaves too little for the stacks and heaps of Embree's threads.
/// These would otherwise deadlock.
void check_addresses() {
  constexpr double kEmbreeAddresses = 160e6;
  if (available_addresses() >= kEmbreeAddresses) return;
  const MemoryUse embree{"addresses of Embree and its threads", kEmbreeAddresses, "raise the limit, see `ulimit -v`"};
  throw not_enough_memory("building the acceleration structure", {&embree, 1});
}

}  // namespace

void EmbreeScene::start(EmbreeOptions options) {
  check_addresses();
  device = rtcNewDevice(nullptr);
  if (!device) throw Error(ExitCode::kRuntime, "Embree cannot be started on this machine");
  rtcSetDeviceMemoryMonitorFunction(device, count_memory, &bytes);
  scene = make_embree_scene(device, options);
}

void EmbreeScene::check() const {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE) throw Error(ExitCode::kRuntime, "Embree could not build the acceleration structure");
}

std::size_t EmbreeScene::allocated() const {
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, bytes.load()));
}

RTCScene make_embree_scene(RTCDevice device, EmbreeOptions options) {
  RTCScene scene = rtcNewScene(device);
  const unsigned flags = (options.watertight ? static_cast<unsigned>(RTC_SCENE_FLAG_ROBUST) : 0u) |
                         (options.compact ? static_cast<unsigned>(RTC_SCENE_FLAG_COMPACT) : 0u) |
                         (options.updatable ? static_cast<unsigned>(RTC_SCENE_FLAG_DYNAMIC) : 0u);
  if (flags != 0) rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(flags));
  if (options.updatable) build_meshes_apart(scene);
  return scene;
}

void build_meshes_apart(RTCScene scene) { rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW); }

void attach_geometry(RTCScene scene, RTCGeometry geometry, std::uint32_t id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

void commit_scene(RTCScene scene) {
  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism, kBuildConcurrency);
  tbb::task_arena arena(kBuildConcurrency);
  arena.execute([scene] { rtcJoinCommitScene(scene); });
}

}  // namespace sheaf
