// The subcommands of the command line. Each adds itself, with its options, to the program.
#pragma once

#include "tools/options.h"

#include <functional>
#include <string>
#include <string_view>

namespace sheaf {

/// sheaf render: renders a scene file to pictures.
void add_render_command(Command& program, int& exit_code);
/// sheaf info: says what a scene file holds.
void add_info_command(Command& program, int& exit_code);
/// sheaf compare: measures how far two pictures are apart.
void add_compare_command(Command& program, int& exit_code);
/// sheaf denoise: takes the noise out of a rendered picture.
void add_denoise_command(Command& program, int& exit_code);
/// sheaf merge: joins parts of a picture.
void add_merge_command(Command& program, int& exit_code);
/// sheaf farm: has parts of pictures rendered by the jobs of a cluster.
void add_farm_command(Command& program, int& exit_code);

/// A text with '?' for what terminals obey: names in files, and names of files, may hold anything.
std::string printable(std::string_view text);
/// Prints a line to the standard error stream, after "sheaf: ". May be called by several threads at once.
void print_message(std::string_view message);
/// From now on `listener` is told of each message too, by one thread at a time; none if it is empty.
void listen_to_messages(std::function<void(std::string_view)> listener);

}  // namespace sheaf
