// State that each thread of a render owns.
#pragma once

#include "kernels/film/camera_task.h"
#include "kernels/film/film_tile.h"
#include "kernels/guiding/guide_record.h"
#include "kernels/photons/light_task.h"
#include "kernels/wave/wave.h"

#include <tbb/enumerable_thread_specific.h>

namespace sheaf {

/// A wave, the task in progress, and its results. Constructed by its thread.
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
