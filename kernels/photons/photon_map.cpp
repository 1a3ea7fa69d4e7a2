// Construction of photon maps: sorts the photons into buckets and columns, in parallel.
#include "kernels/photons/photon_map.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace sheaf {

namespace {

constexpr std::size_t kGrain = 1 << 14;

template <class F> void in_parallel(std::size_t count, F&& f) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) f(i);
                    });
}

}  // namespace

PhotonMap::PhotonMap(std::vector<std::vector<Photon>> tasks, std::uint64_t emitted, float radius, PhotonKernel kernel,
                     int lookup_size, bool four_lanes)
    : radius_(radius), kernel_(kernel), lookup_size_(lookup_size), four_lanes_(four_lanes) {
  std::vector<std::size_t> first;
  for (const std::vector<Photon>& task : tasks) {
    first.push_back(size_);
    size_ += task.size();
  }
  const auto photon_of = [&](std::size_t i) -> const Photon& {
    const auto task = static_cast<std::size_t>(std::upper_bound(first.begin(), first.end(), i) - first.begin()) - 1;
    return tasks[task][i - first[task]];
  };
  const std::vector<std::uint32_t> order = sort_into_buckets(photon_of);

  // Columns begin at register boundaries, and a register may be read past the last photon.
  constexpr std::size_t kLine = kSimdAlignment / sizeof(float);
  stride_ = (size_ / kLine + 2) * kLine;
  memory_.assign(columns() * stride_ + kLine, 0.0f);
  const auto misaligned = reinterpret_cast<std::uintptr_t>(memory_.data()) % kSimdAlignment;
  first_ = memory_.data() + (misaligned == 0 ? 0 : (kSimdAlignment - misaligned) / sizeof(float));
  // Fill the columns.
  const float scale = 1.0f / static_cast<float>(emitted);
  in_parallel(size_, [&](std::size_t i) {
    const Photon& photon = photon_of(order[i]);
    const float words[kMaxColumns] = {photon.p.x,
                                      photon.p.y,
                                      photon.p.z,
                                      bits_float(photon.direction),
                                      bits_float(photon.surface),
                                      photon.power.c0 * scale,
                                      photon.power.c1 * scale,
                                      photon.power.c2 * scale,
                                      photon.power.c3 * scale};
    for (std::size_t c = 0; c < columns(); ++c) std::memcpy(first_ + c * stride_ + i, &words[c], sizeof(float));
  });
}

template <class F> std::vector<std::uint32_t> PhotonMap::sort_into_buckets(F&& photon_of) {
  PhotonMapView grid;
  grid.inverse_cell = 0.5f / radius_;
  grid.bucket_mask = std::bit_ceil(static_cast<std::uint32_t>(size_ / 2 + 1)) - 1;
  // The bucket is in the high bits and the index in the low ones. All keys differ, so the sorted order is unique.
  std::vector<std::uint64_t> keys(size_);
  in_parallel(size_, [&](std::size_t i) {
    const Vec3f p = photon_of(i).p * grid.inverse_cell;
    const std::uint32_t bucket =
        grid.bucket(PhotonMapView::cell(p.x), PhotonMapView::cell(p.y), PhotonMapView::cell(p.z));
    keys[i] = std::uint64_t{bucket} << 32 | i;
  });
  tbb::parallel_sort(keys.begin(), keys.end());
  // Find the beginning of each bucket.
  bucket_begin_.resize(std::size_t{grid.bucket_mask} + 2);
  std::size_t i = 0;
  for (std::size_t bucket = 0; bucket < bucket_begin_.size(); ++bucket) {
    while (i < size_ && (keys[i] >> 32) < bucket) ++i;
    bucket_begin_[bucket] = static_cast<std::uint32_t>(i);
  }
  // The order takes half the memory of the keys while the columns are filled.
  std::vector<std::uint32_t> order(size_);
  in_parallel(size_, [&](std::size_t k) { order[k] = static_cast<std::uint32_t>(keys[k]); });
  return order;
}

PhotonMapView PhotonMap::view() const {
  PhotonMapView v;
  if (size_ == 0) return v;
  v.x = column(0), v.y = column(1), v.z = column(2);
  v.direction = reinterpret_cast<const std::uint32_t*>(column(3));
  v.surface = reinterpret_cast<const std::uint32_t*>(column(4));
  // Without a fourth lane, paths ignore its value.
  for (std::size_t k = 0; k < 4; ++k) v.power[k] = column(std::min(5 + k, columns() - 1));
  v.bucket_begin = bucket_begin_.data();
  v.bucket_mask = static_cast<std::uint32_t>(bucket_begin_.size() - 2);
  v.radius = radius_;
  v.inverse_cell = 0.5f / radius_;
  v.kernel = kernel_;
  v.lookup_size = lookup_size_;
  return v;
}

}  // namespace sheaf
