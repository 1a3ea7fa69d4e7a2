// The subcommands of the command line. Each function adds one subcommand with its options to the program.
#pragma once

#include "tools/options.h"

#include <functional>
#include <string>
#include <string_view>

namespace sheaf {

/// sheaf render: renders a scene file to images.
void add_render_command(Command& program, int& exit_code);
/// sheaf info: prints the contents of a scene file or an image.
void add_info_command(Command& program, int& exit_code);
/// sheaf compare: measures the differences between two images.
void add_compare_command(Command& program, int& exit_code);
/// sheaf denoise: denoises a rendered image.
void add_denoise_command(Command& program, int& exit_code);
/// sheaf convert: writes an image in other formats.
void add_convert_command(Command& program, int& exit_code);
/// sheaf merge: merges parts of an image.
void add_merge_command(Command& program, int& exit_code);
/// sheaf farm: renders parts of images in the jobs of a cluster.
void add_farm_command(Command& program, int& exit_code);

/// Replaces control characters by '?': names from files and file names may contain terminal escape sequences.
std::string printable(std::string_view text);
/// Prints a line to standard error, prefixed with "sheaf: ". Thread-safe.
void print_message(std::string_view message);
/// Passes each further message to `listener` too, from one thread at a time. An empty function removes the listener.
void listen_to_messages(std::function<void(std::string_view)> listener);

}  // namespace sheaf
