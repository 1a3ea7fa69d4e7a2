// sheaf completion: prints the script that completes command lines in a shell.
#include "core/io/error.h"
#include "tools/cli/commands.h"
#include "tools/cli/completion.h"

#include <cstdio>
#include <memory>

namespace sheaf {

void add_completion_command(Program& program, int& exit_code) {
  const auto shell = std::make_shared<std::string>();
  Command command = program.add_command(
      "completion",
      "Print the script that completes command lines of Sheaf in a shell. The installation includes all scripts.");
  command.add_option("shell", *shell, "Shell: bash, zsh or fish").required().one_of({"bash", "zsh", "fish"});
  command.on_call([&program, shell, &exit_code] {
    const CommandHelp& help = program.help();
    const std::string script = *shell == "bash"  ? bash_completion(help)
                               : *shell == "zsh" ? zsh_completion(help)
                                                 : fish_completion(help);
    std::fputs(script.c_str(), stdout);
    exit_code = static_cast<int>(ExitCode::kDone);
  });
}

}  // namespace sheaf
