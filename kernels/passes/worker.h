// What every thread of a render has for itself.
#pragma once

#include "kernels/film/camera_task.h"
#include "kernels/film/film_tile.h"
#include "kernels/film/light_task.h"
#include "kernels/guiding/guide_record.h"
#include "kernels/wave/wave.h"

#include <tbb/enumerable_thread_specific.h>

namespace sheaf {

/// A wave, and the task that is being worked on with what its samples add up to. Constructed by its thread.
struct Worker {
  Worker(int wave_size, const WaveNeeds& needs, RayRecorder* recorder = nullptr) : wave(wave_size, needs) {
    wave.recorder = recorder;
  }
  Wave wave;
  CameraTask camera;
  FilmTile tile;
  LightTask photons;
  TrainingSamples guide;
};
using Workers = tbb::enumerable_thread_specific<Worker>;

}  // namespace sheaf
