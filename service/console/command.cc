#include "service/console/command.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <memory>
#include <utility>

#include <CLI/CLI.hpp>

#include "service/base/files/nearest_word.h"
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
  return "there is no command '" + word + "'" + (nearest.empty() ? "; there are " + Joined(commands, ", ") : nearest);
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
  if (no_command) return path + ": a command is missing; there are " + Joined(CommandsOf(*app), ", ");
  std::string what = error.what();
  if (what.size() > 1 && std::islower(static_cast<unsigned char>(what[1])) != 0) {
    what[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(what[0])));
  }
  const bool says_it_all = dynamic_cast<const CLI::ValidationError*>(&error) != nullptr;
  return path + ": " + what + (says_it_all ? "" : "; see '" + path + " --help'");
}

// The words of a kind "{a, b}", as OneOf names them.
std::vector<std::string> ChoicesIn(const std::string& kind) {
  const std::size_t begin = kind.find('{');
  const std::size_t end = kind.find('}');
  std::vector<std::string> words;
  if (begin == std::string::npos || end == std::string::npos) return words;
  for (std::size_t at = begin + 1; at < end;) {
    const std::size_t comma = std::min(kind.find(", ", at), end);
    words.push_back(kind.substr(at, comma - at));
    at = comma + 2;
  }
  return words;
}

OptionText TextOf(const CLI::Option& option) {
  OptionText text{.about = option.get_description(),
                  .default_text = option.get_default_str(),
                  .required = option.get_required(),
                  .repeats = option.get_expected_max() > 1};
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  const bool flag = option.get_type_size_max() == 0;
  if (text.names.empty()) {
    text.value = option.get_name(true);
  } else if (!flag) {
    text.value = option.get_type_name();
  }
  text.choices = ChoicesIn(option.get_type_name());
  return text;
}

CommandText TextOf(const CLI::App& app) {
  CommandText text{.name = app.get_name(), .about = app.get_description(), .options = {}, .commands = {}};
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty()) text.options.push_back(TextOf(*option));
  }
  for (const CLI::App* command : app.get_subcommands({})) {
    if (!command->get_group().empty()) text.commands.push_back(TextOf(*command));
  }
  return text;
}

}  // namespace

Option Option::Required() { return Option(option_->required()); }

Option Option::ShowDefault() { return Option(option_->capture_default_str()); }

Option Option::ExpectValues(int n) { return Option(option_->expected(n)); }

Option Option::Range(int min, int max) { return Option(option_->check(CLI::Range(min, max))); }

Option Option::Range(std::uint64_t min, std::uint64_t max) { return Option(option_->check(CLI::Range(min, max))); }

Option Option::Range(double min, double max) { return Option(option_->check(CLI::Range(min, max))); }

Option Option::Positive() { return Option(option_->check(CLI::PositiveNumber)); }

Option Option::OneOf(std::vector<std::string> words) {
  const std::string listed = Joined(words, ", ");
  return Check("{" + listed + "}", [words = std::move(words), listed](const std::string& value) {
    if (std::find(words.begin(), words.end(), value) != words.end()) return std::string();
    return "'" + value + "' is none of " + listed + base::DidYouMean(value, words);
  });
}

Option Option::ExistingFile() { return Option(option_->check(CLI::ExistingFile)); }

Option Option::ExistingFolder() { return Option(option_->check(CLI::ExistingDirectory)); }

Option Option::WritesOnly(const std::string& extension, const std::string& kind) {
  return Check("NAME" + extension, [extension, kind](const std::string& value) {
    const std::filesystem::path path(value);
    if (path.extension() == extension) return std::string();
    const std::string better = std::filesystem::path(path).replace_extension(extension).string();
    return "'" + value + "' does not end in " + extension + ", and " + kind + " is all that is written; take " + better;
  });
}

Option Option::Check(const std::string& kind, std::function<std::string(const std::string&)> problem) {
  return Option(option_->check(std::move(problem), kind));
}

Option Option::Needs(const Option& other) { return Option(option_->needs(other.option_)); }

Option Option::Excludes(const Option& other) { return Option(option_->excludes(other.option_)); }

bool Option::given() const { return option_->count() > 0; }

Option Command::AddShort(const std::string& name, std::string& value, const std::string& word,
                         const std::string& about) {
  return Option(app_->add_flag_callback(
      name, [&value, word] { value = word; }, about));
}

Command Command::AddCommand(const std::string& name, const std::string& about) {
  return Command(app_->add_subcommand(name, about));
}

Command Command::AddHidden(const std::string& name) {
  CLI::App* const hidden = app_->add_subcommand(name)->group("")->allow_extras();
  hidden->set_help_flag();
  return Command(hidden);
}

void Command::RequireCommand() { app_->require_subcommand(1); }

Option Command::Add(const std::string& name, bool& value, const std::string& about) {
  return Option(app_->add_flag(name, value, about));
}

Option Command::Add(const std::string& name, std::string& value, const std::string& about) {
  return Option(app_->add_option(name, value, about));
}

Option Command::Add(const std::string& name, int& value, const std::string& about) {
  return Option(app_->add_option(name, value, about));
}

Option Command::Add(const std::string& name, std::uint64_t& value, const std::string& about) {
  return Option(app_->add_option(name, value, about));
}

Option Command::Add(const std::string& name, double& value, const std::string& about) {
  return Option(app_->add_option(name, value, about));
}

Option Command::Add(const std::string& name, std::vector<std::string>& value, const std::string& about) {
  return Option(app_->add_option(name, value, about));
}

Option Command::Add(const std::string& name, std::vector<double>& value, const std::string& about) {
  return Option(app_->add_option(name, value, about));
}

void Command::SetAction(std::function<int()> action) {
  app_->callback([action = std::move(action)] { throw CLI::RuntimeError(action()); });
}

Program::Program(const std::string& name, const std::string& about, const std::string& version)
    : Command(new CLI::App(about, name)), owned_(app_) {
  app_->footer(kExitStatusHelp);
  if (!version.empty()) app_->set_version_flag("--version", name + " " + version, "print the version");
}

Program::~Program() = default;

CommandText Program::Describe() const { return TextOf(*app_); }

std::optional<int> Program::Parse(int argc, const char* const* argv) {
  return Parse(std::vector<std::string>(argv + std::min(argc, 1), argv + argc));
}

std::optional<int> Program::Parse(std::vector<std::string> words) {
  const int columns = TextColumns(STDOUT_FILENO) == 0 ? kHelpColumns : TextColumns(STDOUT_FILENO);
  const auto formatter = std::make_shared<HelpFormatter>();
  formatter->column_width(static_cast<std::size_t>(std::min(30, columns / 3)));
  FormatHelp(*app_, formatter);
  try {
    std::reverse(words.begin(), words.end());  // CLI11 takes them from the end
    app_->parse(std::move(words));
  } catch (const CLI::RuntimeError& done) {  // how Run hands its status over
    return done.get_exit_code();
  } catch (const CLI::CallForHelp&) {
    std::cout << Wrap(app_->help(), columns);
    return kExitOk;
  } catch (const CLI::CallForVersion& version) {
    std::cout << version.what() << "\n";
    return kExitOk;
  } catch (const CLI::ParseError& error) {
    std::cerr << ForPeople(Problem(*app_, error) + "\n", STDERR_FILENO);
    return kExitUsage;
  }
  return std::nullopt;
}

int Fail(const std::string& command, const std::string& message) {
  std::cerr << ForPeople(command + ": " + message + "\n", STDERR_FILENO);
  return kExitFailed;
}

int FailUsage(const std::string& command, const std::string& message) {
  Fail(command, message);
  return kExitUsage;
}

}  // namespace omni::console
