// sheaf help: prints the help of the program or of a command.
#include "core/io/error.h"
#include "tools/cli/commands.h"
#include "tools/console/terminal.h"

#include <cstdio>
#include <memory>

namespace sheaf {

namespace {

struct HelpArguments {
  std::string command;
  bool json = false;
};

}  // namespace

void add_help_command(Program& program, int& exit_code) {
  const auto arguments = std::make_shared<HelpArguments>();
  Command command = program.add_command("help", "Print the help of Sheaf or of a command.");
  command.add_option("command", arguments->command, "Command. Default: none, for a list of all commands")
      .one_of(program.command_names());
  command.add_flag("--json", arguments->json, "Print all commands and options as JSON instead");
  command.on_call([&program, arguments, &exit_code] {
    const CommandHelp& help = program.help();
    const CommandHelp* const found = help.find(arguments->command);
    const std::string text = arguments->json    ? to_json(help, program.version())
                             : found != nullptr ? help_text(*found, help.name, text_columns())
                                                : help_text(help, "", text_columns());
    std::fputs(text.c_str(), stdout);
    exit_code = static_cast<int>(ExitCode::kDone);
  });
}

}  // namespace sheaf
