#include "core/error.h"

#include <algorithm>
#include <numeric>

namespace sheaf {

namespace {

std::string with_place(const SourceLocation& where, const std::string& message) {
  if (where.file.empty()) return message;
  if (where.line <= 0) return where.file + ": " + message;
  return where.file + ":" + std::to_string(where.line) + ": " + message;
}

/// Levenshtein distance: insertions, deletions and replacements cost one each.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

}  // namespace

Error::Error(ExitCode code, const SourceLocation& where, const std::string& message)
    : std::runtime_error(with_place(where, message)), code_(code) {}

SceneError at_place(const SourceLocation& where, const SceneError& error) {
  const std::string message = error.what();
  return message.starts_with(with_place(where, "")) ? error : SceneError(where, message);
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  constexpr std::size_t kLongestCompared = 256;  // hostile files may hold names of any length
  if (name.size() > kLongestCompared) return {};
  std::size_t best = std::max<std::size_t>(2, name.size() / 2) + 1;
  std::string nearest;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < best) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_name(name, candidates);
  return nearest.empty() ? std::string() : ", did you mean '" + nearest + "'?";
}

}  // namespace sheaf
