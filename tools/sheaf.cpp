// The program: subcommands, and what becomes of errors.
#include "core/error.h"
#include "core/simd.h"
#include "tools/commands.h"

#include <csignal>
#include <cstdio>
#include <mutex>
#include <new>
#include <string>

namespace sheaf {

namespace {

std::mutex listening;
std::function<void(std::string_view)> message_listener;  ///< guarded by `listening`

}  // namespace

std::string printable(std::string_view text) {
  std::string shown(text);
  for (char& c : shown)
    if ((static_cast<unsigned char>(c) < 32 && c != '\n' && c != '\t') || c == 127) c = '?';
  return shown;
}

void print_message(std::string_view message) {
  const std::string shown = printable(message);
  std::fprintf(stderr, "sheaf: %s\n", shown.c_str());
  const std::lock_guard lock(listening);
  if (message_listener) message_listener(shown);
}

void listen_to_messages(std::function<void(std::string_view)> listener) {
  const std::lock_guard lock(listening);
  message_listener = std::move(listener);
}

}  // namespace sheaf

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // files beyond the limit on their size are errors like a full disk
  int exit_code = static_cast<int>(sheaf::ExitCode::kDone);
  sheaf::Program program("sheaf", "Sheaf, a data-oriented wavefront path tracer for the CPU.");
  program.set_footer(
      "Exit codes: 0 done, 1 runtime error, 2 usage, 3 scene or asset, 4 output not writable,\n"
      "5 checkpoint mismatch; 129, 130, 143: stopped by SIGHUP, SIGINT, SIGTERM, after saving what there is\n"
      "(a second SIGINT or SIGTERM ends the program at once).");
  program.set_version(std::string("sheaf " SHEAF_VERSION " ") + sheaf::kIsaName);
  program.require_command();
  try {
    sheaf::add_render_command(program, exit_code);
    sheaf::add_info_command(program, exit_code);
    sheaf::add_compare_command(program, exit_code);
    sheaf::add_denoise_command(program, exit_code);
    sheaf::add_merge_command(program, exit_code);
    sheaf::add_farm_command(program, exit_code);
    return program.parse(argc, argv).value_or(exit_code);
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
