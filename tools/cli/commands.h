// The subcommands of the command line. Each function adds one subcommand with its options to the program.
#pragma once

#include "tools/options/options.h"
#include "tools/options/verbosity_options.h"

namespace sheaf {

/// sheaf render: renders a scene file to images.
void add_render_command(Command& program, int& exit_code);
/// sheaf watch: renders a scene again whenever it changes.
void add_watch_command(Command& program, int& exit_code);
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
/// sheaf help: prints the help of the program or of a command. Must be added after the commands that it knows.
void add_help_command(Program& program, int& exit_code);
/// sheaf completion: prints the script that completes command lines in a shell.
void add_completion_command(Program& program, int& exit_code);

}  // namespace sheaf
