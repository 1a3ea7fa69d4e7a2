// What the header of an image says of a render that was interrupted.
#pragma once

#include "core/exr.h"

#include <cstdint>
#include <span>
#include <string>

namespace sheaf {

/// Attributes of pictures whose render was interrupted, see add_interrupted_attributes().
inline constexpr const char* kInterruptedAttribute = "sheaf/interrupted";
inline constexpr const char* kSamplesTakenAttribute = "sheaf/samplesTaken";
inline constexpr const char* kSamplesPlannedAttribute = "sheaf/samplesPlanned";

/// Notes in a picture's header that its render was interrupted, with how many samples per pixel there are of how many
/// that were planned: "sheaf/interrupted" = 1, "sheaf/samplesTaken" and "sheaf/samplesPlanned".
void add_interrupted_attributes(ExrMetadata& metadata, double taken, std::uint32_t planned);

/// What to tell the user of a picture whose header says that its render was interrupted; empty for other pictures.
std::string interruption(std::span<const ExrMetadata::Attribute> attributes);

}  // namespace sheaf
