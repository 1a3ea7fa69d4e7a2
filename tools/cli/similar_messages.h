// Similar messages, of which a command prints only the first.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sheaf {

/// Number of similar messages that are printed.
inline constexpr std::size_t kSimilarMessages = 3;

/// The messages in their order, with at most `limit` of those that are similar: equal except for file, line and
/// numbers. A line that counts the others follows the last of each kind, if there are at least two others.
std::vector<std::string> without_similar(const std::vector<std::string>& messages,
                                         std::size_t limit = kSimilarMessages);

}  // namespace sheaf
