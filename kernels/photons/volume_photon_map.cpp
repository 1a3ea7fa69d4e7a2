// Construction of maps of photons in media.
#include "kernels/photons/volume_photon_map.h"

#include "kernels/photons/photon_order.h"

namespace sheaf {

VolumePhotonMap::VolumePhotonMap(std::vector<std::vector<Photon>> tasks, std::uint64_t emitted, float radius,
                                 PhotonKernel kernel)
    : radius_(radius), kernel_(kernel) {
  const PhotonOrder photons(tasks, 0.125f * radius);
  std::vector<AccelPoint> points;
  points.reserve(photons.size());
  records_.reserve(photons.size());
  const float scale = 1.0f / static_cast<float>(emitted);
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const Photon& photon = photons[i];
    points.push_back({photon.p.x, photon.p.y, photon.p.z, radius});
    records_.push_back({photon.power * scale, photon.direction, photon.surface});
  }
  points_ = PointAccel(std::move(points));
}

}  // namespace sheaf
