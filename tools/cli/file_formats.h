// The formats of files that this build reads and writes, for `sheaf info --formats`.
#pragma once

#include <string>
#include <vector>

namespace sheaf {

/// A format of files.
struct ListedFormat {
  std::string kind;  ///< scene, model, image or asset
  std::string name;
  std::vector<std::string> extensions;
  bool is_written = false;   ///< also written
  std::string reader = {};   ///< library or program that reads it; empty: Sheaf itself
  bool is_available = true;  ///< false if `reader` is missing
};

/// All formats, from the tables of scenes, models, images and assets.
std::vector<ListedFormat> file_formats();

/// A line per format.
std::string describe(const std::vector<ListedFormat>& formats);

}  // namespace sheaf
