#include "service/console/parse.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <memory>
#include <utility>

#include <CLI/CLI.hpp>

#include "service/base/nearest_word.h"
#include "service/console/wrap.h"

namespace omni::console {
namespace {

constexpr int kHelpColumns = 100;  // where help goes into a file or a pipe

// Two spaces at least between the two columns, so that Wrap knows them.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool positional) const override {
    return Row(make_option_name(option, positional) + make_option_opts(option), make_option_desc(option));
  }
  std::string make_subcommand(const CLI::App* command) const override {
    return Row(command->get_display_name(true), command->get_description());
  }

 private:
  std::string Row(const std::string& name, const std::string& about) const {
    std::string row = "  " + name;
    if (about.empty()) return row + "\n";
    if (row.size() + 2 > column_width_) {
      row += "\n" + std::string(column_width_, ' ');
    } else {
      row.resize(column_width_, ' ');
    }
    return row + about + "\n";
  }
};

void FormatHelp(CLI::App& app, const std::shared_ptr<HelpFormatter>& formatter) {
  app.formatter(formatter);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) FormatHelp(*command, formatter);
}

std::string Listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::vector<std::string> CommandsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> OptionsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

// A word that `app` has no use for.
std::string ProblemWith(const CLI::App& app, const std::string& path, const std::string& word) {
  const std::string help = "'" + path + " --help'";
  if (word.size() > 1 && word[0] == '-') {
    const std::string name = word.substr(0, word.find('='));
    const std::string nearest = base::DidYouMean(name, OptionsOf(app));
    return "there is no option '" + name + "'" + (nearest.empty() ? "; " + help + " lists them" : nearest);
  }
  const std::vector<std::string> commands = CommandsOf(app);
  if (commands.empty()) return "'" + word + "' is a word too many; see " + help;
  const std::string nearest = base::DidYouMean(word, commands);
  return "there is no command '" + word + "'" + (nearest.empty() ? "; there are " + Listed(commands) : nearest);
}

// What is wrong, in the words of the command that was reached.
std::string Problem(const CLI::App& root, const CLI::ParseError& error) {
  std::string path = root.get_name();
  const CLI::App* app = &root;
  for (;;) {
    if (const std::vector<std::string> unused = app->remaining(); !unused.empty()) {
      return path + ": " + ProblemWith(*app, path, unused.front());
    }
    const std::vector<CLI::App*> reached = app->get_subcommands();
    if (reached.empty()) break;
    app = reached.front();
    path += " " + app->get_name();
  }
  const bool no_command = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && !CommandsOf(*app).empty();
  if (no_command) return path + ": a command is missing; there are " + Listed(CommandsOf(*app));
  std::string what = error.what();
  if (what.size() > 1 && std::islower(static_cast<unsigned char>(what[1])) != 0) {
    what[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(what[0])));
  }
  const bool says_it_all = dynamic_cast<const CLI::ValidationError*>(&error) != nullptr;
  return path + ": " + what + (says_it_all ? "" : "; see '" + path + " --help'");
}

template <class Words>
std::optional<int> ParseWith(CLI::App& app, Words parse) {
  const int columns = TextColumns(STDOUT_FILENO) == 0 ? kHelpColumns : TextColumns(STDOUT_FILENO);
  const auto formatter = std::make_shared<HelpFormatter>();
  formatter->column_width(static_cast<std::size_t>(std::min(30, columns / 3)));
  FormatHelp(app, formatter);
  try {
    parse();
  } catch (const CLI::RuntimeError& done) {  // how a command hands its status over
    return done.get_exit_code();
  } catch (const CLI::CallForHelp&) {
    std::cout << Wrap(app.help(), columns);
    return kExitOk;
  } catch (const CLI::CallForVersion& version) {
    std::cout << version.what() << "\n";
    return kExitOk;
  } catch (const CLI::ParseError& error) {
    std::cerr << ForPeople(Problem(app, error) + "\n", STDERR_FILENO);
    return kExitUsage;
  }
  return std::nullopt;
}

}  // namespace

void AddVersion(CLI::App& app, const std::string& version) {
  app.set_version_flag("--version", app.get_name() + " " + version, "print the version");
}

std::optional<int> Parse(CLI::App& app, int argc, const char* const* argv) {
  return ParseWith(app, [&] { app.parse(argc, argv); });
}

std::optional<int> Parse(CLI::App& app, std::vector<std::string> words) {
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the end
  return ParseWith(app, [&] { app.parse(std::move(words)); });
}

CLI::Validator OneOf(std::vector<std::string> words) {
  const std::string listed = Listed(words);
  CLI::Validator check("{" + listed + "}");
  check.operation([words = std::move(words), listed](std::string& value) {
    if (std::find(words.begin(), words.end(), value) != words.end()) return std::string();
    return "'" + value + "' is none of " + listed + base::DidYouMean(value, words);
  });
  return check;
}

CLI::Validator WritesOnly(const std::string& extension, const std::string& kind) {
  CLI::Validator check("NAME" + extension);
  check.operation([extension, kind](std::string& value) {
    const std::filesystem::path path(value);
    if (path.extension() == extension) return std::string();
    const std::string better = std::filesystem::path(path).replace_extension(extension).string();
    return "'" + value + "' does not end in " + extension + ", and " + kind + " is all that is written; take " + better;
  });
  return check;
}

int Fail(const std::string& command, const std::string& message) {
  std::cerr << ForPeople(command + ": " + message + "\n", STDERR_FILENO);
  return kExitFailed;
}

}  // namespace omni::console
