// The program: subcommands, and what becomes of errors.
#include "core/error.h"
#include "tools/commands.h"

#include <cstdio>
#include <new>

namespace sheaf {

void print_message(std::string_view message) {
  std::fprintf(stderr, "sheaf: %.*s\n", static_cast<int>(message.size()), message.data());
}

}  // namespace sheaf

int main(int argc, char** argv) {
  int exit_code = static_cast<int>(sheaf::ExitCode::kDone);
  CLI::App program("Sheaf, a data-oriented wavefront path tracer for the CPU.", "sheaf");
  program.footer("Exit codes: 0 done, 1 runtime error, 2 usage, 3 scene or asset, 4 output not writable,\n"
                 "5 checkpoint mismatch, 130/143 interrupted (after saving).");
  program.set_version_flag("--version", "sheaf " SHEAF_VERSION);
  program.require_subcommand(1);
  try {
    sheaf::add_render_command(program, exit_code);
    sheaf::add_info_command(program, exit_code);
    sheaf::add_compare_command(program, exit_code);
    program.parse(argc, argv);
  } catch (const CLI::ParseError& problem) {
    return program.exit(problem) == 0 ? 0 : static_cast<int>(sheaf::ExitCode::kUsage);
  } catch (const sheaf::Error& error) {
    sheaf::print_message(error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    sheaf::print_message("there is not enough memory");
    return static_cast<int>(sheaf::ExitCode::kRuntime);
  } catch (const std::exception& error) {
    sheaf::print_message(error.what());
    return static_cast<int>(sheaf::ExitCode::kRuntime);
  }
  return exit_code;
}
