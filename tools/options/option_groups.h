// Titles of the groups of options in the help; see Command::begin_group().
#pragma once

namespace sheaf {

inline constexpr const char* kSceneOptions = "Scene";
inline constexpr const char* kImageOptions = "Image";
inline constexpr const char* kSamplingOptions = "Sampling";
inline constexpr const char* kTransportOptions = "Light transport";
inline constexpr const char* kOutputOptions = "Output";
inline constexpr const char* kPreviewOptions = "Preview";
inline constexpr const char* kResourceOptions = "Resources";
inline constexpr const char* kAdvancedOptions = "Advanced";

}  // namespace sheaf
