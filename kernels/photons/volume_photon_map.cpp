// Construction of maps of photons in media.
#include "kernels/photons/volume_photon_map.h"

#include "kernels/photons/photon_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace sheaf {

VolumePhotonMap::VolumePhotonMap(const std::vector<std::vector<Photon>>& tasks, std::uint64_t emitted, float radius,
                                 PhotonKernel kernel)
    : radius_(radius), kernel_(kernel) {
  const PhotonOrder photons(tasks, 0.125f * radius);
  const float scale = 1.0f / static_cast<float>(emitted);
  std::vector<AccelPoint> points(photons.size());
  records_.resize(photons.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, photons.size(), 1 << 12),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const Photon& photon = photons[i];
                        points[i] = {photon.p.x, photon.p.y, photon.p.z, radius};
                        records_[i] = {photon.power * scale, photon.direction, photon.surface};
                      }
                    });
  points_ = PointAccel(std::move(points));
}

}  // namespace sheaf
