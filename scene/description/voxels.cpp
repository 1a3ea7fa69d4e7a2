#include "scene/description/voxels.h"

#include <algorithm>

namespace sheaf {

std::span<float> VoxelBlocks::add(std::array<int, 3> position) {
  blocks_.push_back({position, 1, false, values_.size()});
  const auto channels = static_cast<std::size_t>(channels_);
  values_.resize(values_.size() + kVoxels * channels);
  const std::span<float> added = std::span(values_).last(kVoxels * channels);
  for (std::size_t i = 0; i < added.size(); ++i) added[i] = background_[i % channels];
  return added;
}

void VoxelBlocks::add_constant(std::array<int, 3> position, std::span<const float> value, int edge) {
  const auto channels = static_cast<std::size_t>(channels_);
  const bool is_as_last = !blocks_.empty() && blocks_.back().is_constant &&
                          std::equal(value.begin(), value.begin() + channels_, values_.end() - channels_);
  if (!is_as_last) values_.insert(values_.end(), value.begin(), value.begin() + channels_);
  blocks_.push_back({position, edge, true, values_.size() - channels});
}

}  // namespace sheaf
