// Parts of a picture: what `sheaf render` says of them in the headers of files, and what `sheaf merge` reads there.
#pragma once

#include "core/exr.h"
#include "kernels/film/merge.h"
#include "kernels/passes/render_state.h"

#include <filesystem>

namespace sheaf {

/// The samples "FIRST:COUNT". Throws Error (exit code 2) for what is no such text.
SampleRange parse_samples(const std::string& text);

/// What parts of one picture have in common, of a render's settings (render_settings()), as lines of text: not which
/// part each is of, nor the instruction set, and of many files one check sum.
std::string part_settings(const RenderSettings& settings);

/// Notes in a file's header what it is a part of. `samples`: where these are not all, and then all layers are stored
/// with 32 bits.
void add_part_attributes(ExrMetadata& metadata, const std::string& settings, const std::optional<SampleRange>& samples);

/// The header of a part.
struct PartFile {
  PicturePart part;
  int frame_width = 0, frame_height = 0;
  std::uint32_t samples_per_pixel = 0;  ///< of the whole, whether they were taken or not
  bool interrupted = false;
  bool some_samples = false;          ///< the file is one of --samples, even if these are all
  std::vector<std::string> channels;  ///< without those that the whole is to do without; in the file's order
  bool has_denoised = false;
  ExrMetadata metadata;

  /// The value of a text attribute, or an empty string.
  std::string text(std::string_view name) const;
};

/// Reads one. Throws SceneError for what is no part of a picture.
PartFile read_part_header(const std::filesystem::path& file);

/// Throws SceneError, which says what differs, unless both are parts of one picture.
void check_same_picture(const PartFile& first, const PartFile& other);

/// The header of the whole: what parts have in common, and the sums of what was dropped. Not whether parts were
/// interrupted.
ExrMetadata whole_metadata(const std::vector<PartFile>& parts);

}  // namespace sheaf
