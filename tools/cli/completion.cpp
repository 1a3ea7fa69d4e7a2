// Each script consists of a fixed part and of entries per command and option. Values of options are completed from
// their words, or from the names of files or folders; numbers and other text are not completed.
#include "tools/cli/completion.h"

#include <fmt/format.h>

#include <algorithm>

namespace sheaf {

namespace {

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

std::string joined_names(const std::list<CommandHelp>& commands, const std::string& separator) {
  std::vector<std::string> names;
  for (const CommandHelp& command : commands) names.push_back(command.name);
  return joined(names, separator);
}

/// Replaces each of the characters by a backslash and itself.
std::string escaped(const std::string& text, const std::string& characters) {
  std::string out;
  for (const char c : text) {
    if (characters.find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

/// A word of a shell in single quotes.
std::string quoted(const std::string& text, const std::string& quote) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? quote : std::string(1, c);
  return out + "'";
}

bool takes_files(const OptionHelp& option) {
  return option.kind == ValueKind::kFile || option.kind == ValueKind::kFolder;
}

/// A description of one line for menus.
std::string short_text(const OptionHelp& option) {
  constexpr std::size_t kMaxLength = 80;
  std::string text = first_sentence(option.text);
  if (text.size() <= kMaxLength) return text;
  return text.substr(0, text.rfind(' ', kMaxLength)) + " ...";
}

/// The command in bash that completes the value of an option; empty if it has no value.
std::string bash_value(const OptionHelp& option) {
  if (option.kind == ValueKind::kFlag) return "";
  if (!option.words.empty())
    return fmt::format("{} \"{}\"", option.is_list ? "_sheaf_list" : "_sheaf_words", joined(option.words, " "));
  if (option.kind == ValueKind::kFolder) return "_sheaf_folders";
  return option.kind == ValueKind::kFile ? "_sheaf_files" : "return";
}

/// The branch of a command in bash: values by the previous word, then options or arguments.
std::string bash_command(const CommandHelp& command) {
  std::string text = fmt::format("    {})\n      case $before in\n", command.name), options, argument = "return";
  for (const OptionHelp& option : command.options) {
    if (option.is_argument) {
      argument = bash_value(option);
      continue;
    }
    options += (options.empty() ? "" : " ") + joined(option.names, " ");
    const std::string value = bash_value(option);
    if (!value.empty()) text += fmt::format("        {}) {}; return ;;\n", joined(option.names, "|"), value);
  }
  return text + fmt::format("      esac\n      if [[ $word == -* ]]; then _sheaf_words \"{}\"\n      else {}; fi ;;\n",
                            options, argument);
}

/// The part of a specification of _arguments after the description: ":value:action"; empty if there is no value.
std::string zsh_value(const OptionHelp& option) {
  if (option.kind == ValueKind::kFlag) return "";
  std::string action;
  if (!option.words.empty())
    action = option.is_list ? "_sequence compadd - " + joined(option.words, " ")
                            : fmt::format("({})", joined(option.words, " "));
  else if (takes_files(option))
    action = option.kind == ValueKind::kFolder ? "_files -/" : "_files";
  const std::string what = option.is_argument ? option.names.front() : option.only_words ? "" : placeholder_of(option);
  return fmt::format(":{}:{}", escaped(what.empty() ? "value" : what, ":\\"), action.empty() ? " " : action);
}

/// The specifications of an option for _arguments, one per name.
std::string zsh_option(const OptionHelp& option) {
  if (option.is_argument)
    return fmt::format("            {} \\\n", quoted((option.repeats ? "*" : "") + zsh_value(option), "'\\''"));
  const std::string others = option.repeats ? "*" : fmt::format("({})", joined(option.names, " "));
  std::string text;
  for (const std::string& name : option.names) {
    const char* const separator = option.kind == ValueKind::kFlag ? "" : name.size() == 2 ? "+" : "=";
    text += fmt::format(
        "            {} \\\n",
        quoted(others + name + separator + "[" + escaped(short_text(option), "[]:\\") + "]" + zsh_value(option),
               "'\\''"));
  }
  return text;
}

/// The arguments of `complete` in fish for the value of an option; empty if it has no value.
std::string fish_value(const OptionHelp& option) {
  if (option.kind == ValueKind::kFlag) return "";
  if (!option.words.empty()) {
    const std::string words = joined(option.words, " ");
    return " -x -a " + quoted(option.is_list ? fmt::format("(__fish_append , {})", words) : words, "\\'");
  }
  if (option.kind == ValueKind::kFolder) return " -x -a '(__fish_complete_directories)'";
  return option.kind == ValueKind::kFile ? " -r -F" : " -x";
}

std::string fish_option(const CommandHelp& command, const OptionHelp& option) {
  std::string text = fmt::format("complete -c sheaf -n '__fish_seen_subcommand_from {}'", command.name);
  if (option.is_argument) return text + (option.words.empty() ? " -F" : fish_value(option)) + "\n";
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return text + fish_value(option) + " -d " + quoted(escaped(short_text(option), "\\"), "\\'") + "\n";
}

}  // namespace

std::string bash_completion(const CommandHelp& program) {
  std::vector<std::string> first{joined_names(program.commands, " ")};
  for (const OptionHelp& option : program.options) first.push_back(joined(option.names, " "));
  std::string text = R"(# bash completion for sheaf, written by 'sheaf completion bash'.
_sheaf_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$word"); }
_sheaf_files() { mapfile -t COMPREPLY < <(compgen -f -- "$word"); compopt -o filenames 2>/dev/null; }
_sheaf_folders() { mapfile -t COMPREPLY < <(compgen -d -- "$word"); compopt -o filenames 2>/dev/null; }
_sheaf_list() {
  local begin=""
  if [[ $word == *,* ]]; then begin=${word%,*},; fi
  mapfile -t COMPREPLY < <(compgen -P "$begin" -W "$1" -- "${word##*,}")
  compopt -o nospace 2>/dev/null
}
_sheaf() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command="" i
  COMPREPLY=()
  if [[ $word == "=" ]]; then word=""
  elif [[ $before == "=" ]]; then before=${COMP_WORDS[COMP_CWORD-2]}; fi
  for ((i = 1; i < COMP_CWORD; i++)); do
)";
  text += fmt::format("    case ${{COMP_WORDS[i]}} in {}) command=${{COMP_WORDS[i]}}; break ;; esac\n  done\n",
                      joined_names(program.commands, "|"));
  text += "  case $command in\n";
  for (const CommandHelp& command : program.commands) text += bash_command(command);
  return text +
         fmt::format("    *) _sheaf_words \"{}\" ;;\n  esac\n}}\ncomplete -F _sheaf sheaf\n", joined(first, " "));
}

std::string zsh_completion(const CommandHelp& program) {
  std::string text = R"(#compdef sheaf
# zsh completion for sheaf, written by 'sheaf completion zsh'.
_sheaf() {
  local context state state_descr line
  typeset -A opt_args
  _arguments -C \
)";
  for (const OptionHelp& option : program.options) text += zsh_option(option);
  text += "            '1:command:->command' '*::argument:->argument'\n  case $state in\n    command)\n";
  text += "      local -a commands=(\n";
  for (const CommandHelp& command : program.commands)
    text +=
        fmt::format("        {}\n", quoted(fmt::format("{}:{}", command.name, first_sentence(command.text)), "'\\''"));
  text += "      )\n      _describe command commands ;;\n    argument)\n      case $line[1] in\n";
  for (const CommandHelp& command : program.commands) {
    text += fmt::format("        {})\n          _arguments -s \\\n", command.name);
    for (const OptionHelp& option : command.options) text += zsh_option(option);
    text.resize(text.size() - 3);  // no line follows: remove the last " \\\n"
    text += " ;;\n";
  }
  return text +
         "      esac ;;\n  esac\n}\nif [[ $funcstack[1] == _sheaf ]]; then _sheaf \"$@\"; else compdef _sheaf sheaf; "
         "fi\n";
}

std::string fish_completion(const CommandHelp& program) {
  std::string text = "# fish completion for sheaf, written by 'sheaf completion fish'.\ncomplete -c sheaf -f\n";
  for (const OptionHelp& option : program.options) {
    text += "complete -c sheaf -n __fish_use_subcommand";
    for (const std::string& name : option.names)
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    text += fmt::format(" -d {}\n", quoted(short_text(option), "\\'"));
  }
  for (const CommandHelp& command : program.commands) {
    text += fmt::format("complete -c sheaf -n __fish_use_subcommand -a {} -d {}\n", command.name,
                        quoted(first_sentence(command.text), "\\'"));
    for (const OptionHelp& option : command.options) text += fish_option(command, option);
  }
  return text;
}

}  // namespace sheaf
