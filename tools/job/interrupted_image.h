// Attributes in the headers of rendered images, and those of interrupted renders.
#pragma once

#include "core/image/exr.h"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace sheaf {

/// Noise of the image as RenderReport::noise; the command line; and the time of rendering, s.
inline constexpr const char* kVersionAttribute = "sheaf/version";
inline constexpr const char* kNoiseAttribute = "sheaf/noise";
inline constexpr const char* kCommandLineAttribute = "sheaf/commandLine";
inline constexpr const char* kRenderSecondsAttribute = "sheaf/renderSeconds";

/// Attributes of images of interrupted renders; see add_interrupted_attributes().
inline constexpr const char* kInterruptedAttribute = "sheaf/interrupted";
inline constexpr const char* kSamplesTakenAttribute = "sheaf/samplesTaken";
inline constexpr const char* kSamplesPlannedAttribute = "sheaf/samplesPlanned";

/// Marks an image as interrupted: sets "sheaf/interrupted" to 1, "sheaf/samplesTaken" to the mean samples per pixel
/// taken, and "sheaf/samplesPlanned" to the number planned.
void add_interrupted_attributes(ExrMetadata& metadata, double taken, std::uint32_t planned);

/// Message for the user if the header marks the image as interrupted; otherwise empty.
std::string interruption(std::span<const ExrMetadata::Attribute> attributes);

/// Whether an image file, of any format, was written by an interrupted render. Files that cannot be read were not.
bool is_interrupted(const std::filesystem::path& file);

}  // namespace sheaf
