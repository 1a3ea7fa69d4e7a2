// Messages to the user, on the standard error stream, and the options that select them.
#pragma once

#include "core/io/error.h"

#include <functional>
#include <string>
#include <string_view>

namespace sheaf {

/// The messages that a command prints, from fewest to most.
enum class Verbosity {
  kErrors,    ///< -qq
  kWarnings,  ///< -q
  kNormal,    ///< also notes and the result, in one line if possible
  kVerbose    ///< -v: also details
};

/// Sets the verbosity of the program. Initially Verbosity::kNormal.
void set_verbosity(Verbosity verbosity);
Verbosity verbosity();

/// Replaces control characters by '?': names from files and file names may contain terminal escape sequences.
std::string printable(std::string_view text);
/// Prints a line to standard error, prefixed with "sheaf: ". For errors and other messages that are never suppressed.
/// On terminals it replaces the progress bar. Thread-safe, as all functions below.
void print_message(std::string_view message);
/// Prints an error. Errors of a scene that lenient reading accepts are printed one by one, with a line on --lenient.
void print_error(const Error& error);
/// Prints "warning: " and the message, unless only errors are wanted.
void print_warning(std::string_view message);
/// Prints the message at normal verbosity.
void print_note(std::string_view message);
/// Prints the message with -v.
void print_detail(std::string_view message);
/// Replaces a text in all further messages, such as the name of a temporary file.
void replace_in_messages(const std::string& text, const std::string& displayed);
/// Passes each further message to `listener` too, whether it is printed or not, from one thread at a time. An empty
/// function removes the listener.
void listen_to_messages(std::function<void(std::string_view)> listener);

}  // namespace sheaf
