#include "service/console/pages.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <vector>

#include "service/console/wrap.h"

namespace omni::console {
namespace {

constexpr std::string_view kOptionsMark = "@OPTIONS@\n";

using Visit = std::function<void(const CommandText& command, const std::string& path)>;

// The command, then those below it. `path`: its words.
void Walk(const CommandText& command, const std::string& path, const Visit& visit) {
  visit(command, path);
  for (const CommandText& below : command.commands) Walk(below, path + " " + below.name, visit);
}

std::string Replaced(std::string_view text, std::string_view characters, std::string_view before) {
  std::string out;
  for (const char c : text) {
    if (characters.find(c) != std::string_view::npos) out += before;
    out += c;
  }
  return out;
}

// Some characters begin a list, a heading or a table at the start of a line.
std::string ForScdoc(std::string_view text) {
  const bool begins = !text.empty() && std::string_view("-.#|[]:;`").find(text.front()) != std::string_view::npos;
  return (begins ? "\\" : "") + Replaced(text, "\\_*", "\\");
}

// In single quotes of every shell here. A quote in the text becomes a typographic one: it is only read.
std::string Quoted(std::string text) {
  for (std::size_t at = text.find('\''); at != std::string::npos; at = text.find('\'', at)) text.replace(at, 1, "’");
  return "'" + text + "'";
}

bool IsPositional(const OptionText& option) { return option.names.empty(); }

// Numbers cannot be listed, and everything else may be a file.
bool MayBeFile(const OptionText& option) {
  if (!option.choices.empty()) return false;
  constexpr std::string_view kNumbers[] = {"INT", "UINT", "FLOAT"};
  return std::none_of(std::begin(kNumbers), std::end(kNumbers),
                      [&](std::string_view kind) { return option.value.starts_with(kind); });
}

bool TakesFile(const CommandText& command) {
  return std::any_of(command.options.begin(), command.options.end(),
                     [](const OptionText& option) { return IsPositional(option) && MayBeFile(option); });
}

std::vector<std::string> ChoicesOfWords(const CommandText& command) {
  std::vector<std::string> words;
  for (const CommandText& below : command.commands) words.push_back(below.name);
  for (const OptionText& option : command.options) {
    if (IsPositional(option)) words.insert(words.end(), option.choices.begin(), option.choices.end());
  }
  return words;
}

// "*--port* _INT_", as the page shows it.
std::string ScdocName(const OptionText& option) {
  std::string text;
  for (const std::string& name : option.names) text += (text.empty() ? "*" : ", *") + ForScdoc(name) + "*";
  if (option.value.empty()) return text;
  return text + (text.empty() ? "_" : " _") + ForScdoc(option.value) + "_";
}

std::string ScdocOptions(const CommandText& command, const std::string& path) {
  std::string text;
  for (const OptionText& option : command.options) {
    text += ScdocName(option) + "\n\t" + ForScdoc(option.about.empty() ? "see above" : option.about);
    if (!option.default_text.empty()) text += " (default: " + ForScdoc(option.default_text) + ")";
    text += "\n\n";
  }
  for (const CommandText& below : command.commands) {
    const std::string words = path + " " + below.name;
    text += "## " + words + "\n\n" + ForScdoc(below.about) + "\n\n" + ScdocOptions(below, words);
  }
  return text;
}

// "*omni try* [_options_] [_scene_]"
std::string Synopsis(const CommandText& command, const std::string& path) {
  std::string text = "*" + path + "* [_options_]";
  if (!command.commands.empty()) return text + " _command_";
  for (const OptionText& option : command.options) {
    if (!IsPositional(option)) continue;
    const std::string word = "_" + ForScdoc(option.value) + "_" + (option.repeats ? "..." : "");
    text += option.required ? " " + word : " [" + word + "]";
  }
  return text;
}

std::string Replace(std::string text, char from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, 1, to);
  }
  return text;
}

// Patterns "'omni scene' | 'omni scene explain'" of every command below the program.
std::string CommandPatterns(const CommandText& program, const std::string& between) {
  std::vector<std::string> patterns;
  Walk(program, program.name, [&](const CommandText& command, const std::string& path) {
    if (&command != &program) patterns.push_back("'" + path + "'");
  });
  return Joined(patterns, between);
}

// What follows an option that takes a value; the shells differ in how they offer words and files.
std::string ValueCases(const CommandText& program, const std::string& words_before, const std::string& words_after,
                       const std::string& files) {
  std::string text;
  Walk(program, program.name, [&](const CommandText& command, const std::string& path) {
    for (const OptionText& option : command.options) {
      if (IsPositional(option) || option.value.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names) patterns.push_back("'" + path + " " + name + "'");
      const std::string action = !option.choices.empty()
                                     ? words_before + Joined(option.choices, " ") + words_after + "; "
                                 : MayBeFile(option) ? files + "; "
                                                     : "";
      text += "    " + Joined(patterns, " | ") + ") " + action + "return ;;\n";
    }
  });
  return text;
}

std::vector<std::string> NamesOfOptions(const CommandText& command) {
  std::vector<std::string> names;
  for (const OptionText& option : command.options) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

}  // namespace

std::string ManPage(const CommandText& command, const std::string& path, const std::string& body,
                    const std::string& version) {
  const std::string name = Replace(path, ' ', "-");
  const std::size_t colon = command.about.find(": ");
  const bool names_itself = colon != std::string::npos && command.about.substr(0, colon) == path;
  std::string text = name + "(1) \"" + version + "\"\n\n# NAME\n\n" + name + " - " +
                     ForScdoc(names_itself ? command.about.substr(colon + 2) : command.about) + "\n\n# SYNOPSIS\n\n" +
                     Synopsis(command, path) + "\n\n";
  std::string sections = body;
  const std::size_t mark = sections.find(kOptionsMark);
  const std::string options = "# OPTIONS\n\n" + ScdocOptions(command, path);
  if (mark == std::string::npos) {
    sections = options + sections;
  } else {
    sections.replace(mark, kOptionsMark.size(), options);
  }
  std::string statuses = kExitStatusHelp;
  statuses.erase(0, statuses.find(": ") + 2);
  return text + sections + "\n# EXIT STATUS\n\n" + ForScdoc(statuses) + "\n";
}

std::string BashCompletion(const CommandText& program) {
  const std::string function = "_" + Replace(program.name, '-', "_");
  std::string text = "# Completion of " + program.name + " for bash, made from its command line.\n" + function + R"(() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} at=)" +
                     program.name + R"( i words=() files=
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$at ${COMP_WORDS[i]}" in
      )" + (program.commands.empty() ? "''" : CommandPatterns(program, " | ")) +
                     R"() at+=" ${COMP_WORDS[i]}" ;;
    esac
  done
  COMPREPLY=()
  case "$at $prev" in
)" +
                     ValueCases(program, "mapfile -t COMPREPLY < <(compgen -W '", "' -- \"$cur\")",
                                "mapfile -t COMPREPLY < <(compgen -f -- \"$cur\")") +
                     "  esac\n  case \"$at\" in\n";
  Walk(program, program.name, [&](const CommandText& command, const std::string& path) {
    text += "    '" + path + "')\n      [[ $cur == -* ]] && words=(" + Joined(NamesOfOptions(command), " ") +
            ") || words=(" + Joined(ChoicesOfWords(command), " ") + ")" + (TakesFile(command) ? " files=yes" : "") +
            " ;;\n";
  });
  return text + R"(  esac
  mapfile -t COMPREPLY < <(compgen -W "${words[*]}" -- "$cur")
  [[ $cur == -* || -z $files ]] || mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- "$cur")
}
complete -o filenames -F )" +
         function + " " + program.name + "\n";
}

std::string ZshCompletion(const CommandText& program) {
  std::string text = "#compdef " + program.name + "\n# Made from its command line.\nlocal at=" + program.name +
                     R"( word
for word in ${words[2,CURRENT-1]}; do
  case "$at $word" in
    )" + (program.commands.empty() ? "''" : CommandPatterns(program, " | ")) +
                     R"() at="$at $word" ;;
  esac
done
case "$at ${words[CURRENT-1]}" in
)" + ValueCases(program, "compadd -- ", "", "_files") +
                     "esac\nlocal -a options choices\nlocal files=\ncase \"$at\" in\n";
  Walk(program, program.name, [&](const CommandText& command, const std::string& path) {
    text += "  '" + path + "')\n    options=(";
    for (const OptionText& option : command.options) {
      for (const std::string& name : option.names) text += "\n      " + Quoted(name + ":" + option.about);
    }
    text += ")\n    choices=(";
    for (const CommandText& below : command.commands) text += "\n      " + Quoted(below.name + ":" + below.about);
    for (const OptionText& option : command.options) {
      if (!IsPositional(option)) continue;
      for (const std::string& choice : option.choices) text += "\n      " + Quoted(choice + ":" + option.about);
    }
    text += std::string(")\n    ") + (TakesFile(command) ? "files=yes " : "") + ";;\n";
  });
  return text + R"(esac
if [[ $PREFIX == -* ]]; then
  _describe -o option options
else
  (( $#choices )) && _describe word choices
  [[ -z $files ]] || _files
fi
)";
}

std::string FishCompletion(const CommandText& program) {
  const std::string function = "__" + Replace(program.name, '-', "_") + "_at";
  std::string text = "# Completion of " + program.name + " for fish, made from its command line.\nfunction " +
                     function + "\n  set -l at " + program.name + R"(
  for word in (commandline -opc)[2..-1]
    switch "$at $word"
      case )" + (program.commands.empty() ? "''" : CommandPatterns(program, " ")) +
                     "\n        set at \"$at $word\"\n    end\n  end\n  test \"$at\" = \"$argv\"\nend\ncomplete -c " +
                     program.name + " -f\n";
  Walk(program, program.name, [&](const CommandText& command, const std::string& path) {
    const std::string row = "complete -c " + program.name + " -n '" + function + " " + path + "'";
    for (const CommandText& below : command.commands) {
      text += row + " -a " + below.name + " -d " + Quoted(below.about) + "\n";
    }
    for (const OptionText& option : command.options) {
      std::string line = row;
      for (const std::string& name : option.names) {
        line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      if (!IsPositional(option) && !option.value.empty()) line += MayBeFile(option) ? " -r -F" : " -x";
      if (IsPositional(option) && MayBeFile(option)) line += " -F";
      if (!option.choices.empty()) line += " -a '" + Joined(option.choices, " ") + "'";
      text += line + " -d " + Quoted(option.about) + "\n";
    }
  });
  return text;
}

}  // namespace omni::console
