// Frame numbers of animations: ranges, and file names that contain them.
#pragma once

#include <string>
#include <vector>

namespace sheaf {

/// A range of frames, inclusive. All numbers are from 0 to 9,999,999; step is positive.
struct FrameRange {
  int first = 0, last = 0, step = 1;

  std::vector<int> frames() const;
};

/// Parses "FIRST:LAST" or "FIRST:LAST:STEP". Throws Error (exit code 2).
FrameRange parse_frames(const std::string& text);

/// A file name with places for the frame number.
struct FrameName {
  std::vector<std::string> texts;  ///< between the placeholders; one more than `digits`
  std::vector<int> digits;         ///< of each placeholder; shorter numbers get leading zeros

  /// The name for a frame.
  std::string at(int frame) const;
};

/// Finds the placeholders: `####` is a number of 4 digits, `$frame` a number without leading zeros, `$frame4` a number
/// of 4 digits (1 to 9). A name without any place gets `_####` before its file extension.
FrameName frame_name(const std::string& file);

}  // namespace sheaf
