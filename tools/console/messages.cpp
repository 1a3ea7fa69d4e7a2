// The verbosity and the listener are global, because messages come from all commands and from several threads.
#include "tools/console/messages.h"

#include "scene/description/error_sink.h"

#include <fmt/format.h>

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <mutex>
#include <utility>
#include <vector>

namespace sheaf {

namespace {

std::atomic<Verbosity> program_verbosity{Verbosity::kNormal};
std::mutex listening;
std::function<void(std::string_view)> message_listener;           ///< guarded by `listening`, as is the next
std::vector<std::pair<std::string, std::string>> replaced_texts;  ///< and the texts shown instead

std::string with_replaced_texts(std::string message) {
  for (const auto& [text, displayed] : replaced_texts)
    for (std::size_t at = 0; (at = message.find(text, at)) != std::string::npos; at += displayed.size())
      message.replace(at, text.size(), displayed);
  return message;
}

void print_from(Verbosity least, std::string_view message) {
  const std::lock_guard lock(listening);
  const std::string displayed = with_replaced_texts(printable(message));
  // The cursor of a terminal is at the end of the progress bar, if there is one.
  const char* const erase = isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "";
  if (verbosity() >= least) std::fprintf(stderr, "%ssheaf: %s\n", erase, displayed.c_str());
  if (message_listener) message_listener(displayed);
}

}  // namespace

void set_verbosity(Verbosity verbosity) { program_verbosity = verbosity; }

Verbosity verbosity() { return program_verbosity; }

std::string printable(std::string_view text) {
  std::string displayed(text);
  for (char& c : displayed)
    if ((static_cast<unsigned char>(c) < 32 && c != '\n' && c != '\t') || c == 127) c = '?';
  return displayed;
}

void print_message(std::string_view message) { print_from(Verbosity::kErrors, message); }

void print_error(const Error& error) {
  const auto* several = dynamic_cast<const SceneErrors*>(&error);
  if (several == nullptr) return print_message(error.what());
  const std::size_t count = several->all().size();
  for (const SceneError& each : several->all()) print_message(each.what());
  print_message(fmt::format("{}{} error{}; --lenient substitutes or drops what cannot be read",
                            count == ErrorSink::kMaxErrors ? "stopped after " : "", count, count == 1 ? "" : "s"));
}

void print_warning(std::string_view message) { print_from(Verbosity::kWarnings, "warning: " + std::string(message)); }

void print_note(std::string_view message) { print_from(Verbosity::kNormal, message); }

void print_detail(std::string_view message) { print_from(Verbosity::kVerbose, message); }

void replace_in_messages(const std::string& text, const std::string& displayed) {
  const std::lock_guard lock(listening);
  replaced_texts.emplace_back(text, displayed);
}

void listen_to_messages(std::function<void(std::string_view)> listener) {
  const std::lock_guard lock(listening);
  message_listener = std::move(listener);
}

}  // namespace sheaf
