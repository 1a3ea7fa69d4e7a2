// Main program: dispatches to subcommands and reports errors.
#include "core/io/error.h"
#include "core/io/version.h"
#include "core/simd/simd.h"
#include "tools/cli/build_details.h"
#include "tools/cli/commands.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <new>
#include <string>

namespace sheaf {

namespace {

/// Opens /dev/null for each closed standard stream. Otherwise the next opened file would take its number, and messages
/// would end up in that file. Writing to these descriptors fails.
void fill_closed_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (fcntl(stream, F_GETFD) == -1) static_cast<void>(open("/dev/null", O_RDONLY));
}

/// Makes the standard output wait for finish_output(), which knows the cause if writing fails. Longer outputs than the
/// buffer are written earlier.
void buffer_output() {
  static char buffer[1 << 18];
  std::setvbuf(stdout, buffer, _IOFBF, sizeof buffer);
}

/// Flushes standard output. Returns the exit code; if writing failed and it was 0, returns 4. Prints the error unless
/// an unwritable output has been reported.
int finish_output(int exit_code) {
  errno = 0;
  const bool written = std::cout.flush().good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (written || exit_code == static_cast<int>(ExitCode::kOutput)) return exit_code;
  print_message(std::string("cannot write to the standard output") +
                (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
  return exit_code != 0 ? exit_code : static_cast<int>(ExitCode::kOutput);
}

/// Parses the command line and calls the command. Returns the exit code.
int run(int argc, char** argv) {
  int exit_code = static_cast<int>(ExitCode::kDone);
  Program program("sheaf", "Sheaf, a data-oriented wavefront path tracer for the CPU.");
  // Describe the program
  program.set_footer(
      "Exit codes: 0 success, 1 runtime error, 2 usage error, 3 scene or asset error, 4 output not writable, "
      "5 checkpoint mismatch; 129, 130, 143: stopped by SIGHUP, SIGINT or SIGTERM after saving the image so far "
      "(a second SIGINT or SIGTERM terminates immediately).");
  program.set_version(fmt::format("sheaf {} {}", kSheafVersion, kIsaName), build_details);
  program.require_command();
  // Add the commands, and run the one on the command line
  try {
    add_render_command(program, exit_code);
    add_watch_command(program, exit_code);
    add_info_command(program, exit_code);
    add_compare_command(program, exit_code);
    add_denoise_command(program, exit_code);
    add_convert_command(program, exit_code);
    add_merge_command(program, exit_code);
    add_farm_command(program, exit_code);
    add_completion_command(program, exit_code);
    add_help_command(program, exit_code);
    return program.parse(argc, argv).value_or(exit_code);
  } catch (const Error& error) {
    print_error(error);
    return static_cast<int>(error.exit_code());
  } catch (const std::bad_alloc&) {
    print_message("out of memory");
    return static_cast<int>(ExitCode::kRuntime);
  } catch (const std::exception& error) {
    print_message(error.what());
    return static_cast<int>(ExitCode::kRuntime);
  }
}

}  // namespace

}  // namespace sheaf

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // exceeding the file size limit becomes a write error, like a full disk
  sheaf::fill_closed_streams();
  sheaf::buffer_output();
  return sheaf::finish_output(sheaf::run(argc, argv));
}
