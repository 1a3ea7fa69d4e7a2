// Construction of photon beam maps.
#include "kernels/photons/photon_beam_map.h"

namespace sheaf {

PhotonBeamMap::PhotonBeamMap(const std::vector<std::vector<PhotonBeam>>& tasks, std::uint64_t emitted, float radius,
                             float piece, PhotonKernel kernel)
    : radius_(radius), kernel_(kernel) {
  std::vector<AccelLine> lines;
  const float scale = 1.0f / static_cast<float>(emitted);
  for (const std::vector<PhotonBeam>& task : tasks)
    for (const PhotonBeam& beam : task) {
      lines.push_back({beam.start, beam.direction, beam.length});
      records_.push_back({beam.power * scale, beam.pdf_ratio, beam.medium_key});
    }
  lines_ = LineAccel(lines, radius, piece);
}

}  // namespace sheaf
