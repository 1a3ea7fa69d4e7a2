#include "scene/description/error_sink.h"

#include <fmt/format.h>

namespace sheaf {

namespace {

std::string lines_of(const std::vector<SceneError>& errors) {
  std::string text;
  for (const SceneError& error : errors) text += (text.empty() ? "" : "\n") + std::string(error.what());
  return text;
}

}  // namespace

SceneErrors::SceneErrors(std::vector<SceneError> all) : SceneError(all.at(0), lines_of(all)), all_(std::move(all)) {}

ErrorSink::ErrorSink(bool lenient, std::vector<std::string>& substitutions)
    : lenient_(lenient), substitutions_(substitutions), reported_(substitutions.begin(), substitutions.end()) {}

void ErrorSink::report(const SceneError& error, std::string_view substitute) {
  throw_if_full();
  const std::string text = lenient_ ? fmt::format("{} ({})", error.what(), substitute) : error.what();
  if (!reported_.insert(text).second) return;
  errors_.push_back(error);
  if (lenient_) substitutions_.push_back(text);
  throw_if_full();
}

void ErrorSink::throw_if_full() const {
  if (errors_.size() >= kMaxErrors) throw_errors();
}

void ErrorSink::throw_errors() const {
  if (!lenient_ && !errors_.empty()) throw SceneErrors(errors_);
}

}  // namespace sheaf
