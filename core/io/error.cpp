// Messages with locations, and the search for similar names.
#include "core/io/error.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace sheaf {

namespace {

std::string with_location(const SourceLocation& where, const std::string& message) {
  if (where.file.empty()) return message;
  if (where.line <= 0) return fmt::format("{}: {}", where.file.string(), message);
  return fmt::format("{}:{}: {}", where.file.string(), where.line, message);
}

/// The form of a name for comparisons: lower case, without leading dashes.
std::string comparable(std::string_view name) {
  name.remove_prefix(std::min(name.find_first_not_of('-'), name.size()));
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

/// Optimal string alignment distance: insertions, deletions, substitutions and transpositions of neighbors cost 1
/// each.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        next[j] = std::min(next[j], before[j - 2] + 1);
    }
    before.swap(row);
    row.swap(next);
  }
  return row[b.size()];
}

/// Maximum number of edits at which a name of this length counts as similar: a third of its letters, but at least 1 for
/// two letters or more.
std::size_t max_edits(std::size_t length) { return length < 2 ? 0 : std::max<std::size_t>(1, length / 3); }

}  // namespace

const std::string& FileName::string() const {
  static const std::string empty;
  return name_ != nullptr ? *name_ : empty;
}

Error::Error(ExitCode code, const SourceLocation& where, const std::string& message)
    : std::runtime_error(with_location(where, message)), exit_code_(code), where_(where) {}

SceneError SceneError::about(const std::string& element) const {
  SceneError error = *this;
  if (error.element_.empty()) error.element_ = element;
  return error;
}

SceneError at_location(const SourceLocation& where, const SceneError& error) {
  return error.where() == where ? error : SceneError(where, error);
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  constexpr std::size_t kMaxComparedLength = 256;  // malicious files may hold names of any length
  constexpr std::size_t kMinPrefixLength = 3;
  if (name.size() > kMaxComparedLength) return {};
  const std::string requested = comparable(name);
  std::size_t best = max_edits(requested.size()) + 1;
  std::string nearest, continued;
  for (const std::string& candidate : candidates) {
    const std::string known = comparable(candidate);
    const std::size_t distance = edit_distance(requested, known);
    if (distance < best) {
      best = distance;
      nearest = candidate;
    }
    if (continued.empty() && requested.size() >= kMinPrefixLength && known.starts_with(requested))
      continued = candidate;
  }
  return nearest.empty() ? continued : nearest;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string displayed(text.substr(0, kLongest));
  for (char& c : displayed)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  if (text.size() > kLongest) displayed += "...";
  return fmt::format("'{}'", displayed);
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_name(name, candidates);
  return nearest.empty() ? std::string() : fmt::format(", did you mean '{}'?", nearest);
}

}  // namespace sheaf
