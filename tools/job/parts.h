// Parts of an image: the attributes with which `sheaf render` describes them in file headers, and their reader for
// `sheaf merge`.
#pragma once

#include "core/image/exr.h"
#include "kernels/film/merge.h"
#include "kernels/render/render_state.h"

#include <filesystem>

namespace sheaf {

/// Parses "FIRST:COUNT". Throws Error (exit code 2) for malformed text.
SampleRange parse_samples(const std::string& text);

/// The settings (see recorded_settings()) that all parts of an image share, as lines of text. Omits the version, the
/// instruction set, --samples and --crop. Replaces a long list of files by one checksum.
std::string part_settings(const RecordedSettings& settings);

/// Adds the attributes of a part to a file's header. `samples`: set if the part holds a range of samples; then all
/// layers are stored as 32-bit floats.
void add_part_attributes(ExrMetadata& metadata, const std::string& settings, const std::optional<SampleRange>& samples);

/// The header of a part.
struct PartFile {
  ImagePart part;
  int frame_width = 0, frame_height = 0;
  std::uint32_t samples_per_pixel = 0;  ///< of the whole image, as planned
  bool interrupted = false;
  bool some_samples = false;          ///< rendered with --samples, even if the range covers all samples
  std::vector<std::string> channels;  ///< in the file's order; without the channels that the merged image omits
  bool has_denoised = false;
  ExrMetadata metadata;

  /// Value of an attribute as text, or an empty string.
  std::string text(std::string_view name) const;
  /// Value of an attribute with a number; see number_of().
  std::optional<double> number(std::string_view name) const;
};

/// Reads the header of a part. Throws SceneError if the file is not a part of an image.
PartFile read_part_header(const std::filesystem::path& file);

/// The same for a part in memory. `name`: for messages.
PartFile part_in_memory(const std::string& name, const Image& image, const ExrMetadata& metadata);

/// Throws SceneError, which names the difference, unless both files are parts of one image.
void check_same_image(const PartFile& first, const PartFile& other);

/// Header of the merged image: the attributes that the parts share, and the sums of dropped rays and samples and of the
/// render times. Omits the command line and the attributes of interrupted renders.
ExrMetadata whole_metadata(const std::vector<PartFile>& parts);

}  // namespace sheaf
