// A program's command line: its commands and options, help as wide as the terminal, wrong words named with the nearest
// right one, and the exit statuses. CLI11 does the work, in command.cc and nowhere else: its headers
// take long to compile.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace omni::console {

// What every program of ours means by its exit status; docs/howto/install.md has the table.
enum ExitStatus : int {
  kExitOk = 0,
  kExitFailed = 1,     // something did not work; stderr has one line that says what to do
  kExitUsage = 2,      // wrong arguments
  kExitNoService = 3,  // omnid does not run, or does not answer
};

// For --help.
inline constexpr const char* kExitStatusHelp =
    "Exit status: 0 it worked; 1 something did not, stderr says what to do; 2 wrong arguments; 3 omnid does not run.";

// An option, flag or positional argument of a command: a handle that is valid as long as its program.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option Required();
  Option ShowDefault();        // in --help: the value that it has by now
  Option ExpectValues(int n);  // of a list: so many values, neither more nor less

  // Values that are not so are refused, and --help says how they have to be.
  Option Range(int min, int max);  // both inclusive, of the type of the value
  Option Range(std::uint64_t min, std::uint64_t max);
  Option Range(double min, double max);
  Option Positive();
  Option OneOf(std::vector<std::string> words);
  Option ExistingFile();
  Option ExistingFolder();
  // A file to write, which can only be what its name has to say: extension ".glb", kind "binary glTF".
  Option WritesOnly(const std::string& extension, const std::string& kind);
  // kind: for --help, "DEVICE". problem: what is wrong with a value; empty: nothing.
  Option Check(const std::string& kind, std::function<std::string(const std::string&)> problem);

  Option Needs(const Option& other);     // other has to be given too
  Option Excludes(const Option& other);  // not both

  bool given() const;  // after Parse

 private:
  CLI::Option* option_;
};

// A program or one of its commands: a handle that is valid as long as the program.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  Command AddCommand(const std::string& name, const std::string& about);
  // Not in --help; takes whatever follows, and has no --help of its own.
  Command AddHidden(const std::string& name);
  void RequireCommand();  // exactly one of those that were added has to be named

  // Parse writes into `value`; it stays as it is where nothing is given. Options have names with dashes, all of them in
  // one: "-o,--output". A name without is positional. A bool is a flag; "!--no-x" sets it to false.
  Option Add(const std::string& name, bool& value, const std::string& about = "");
  Option Add(const std::string& name, std::string& value, const std::string& about = "");
  Option Add(const std::string& name, int& value, const std::string& about = "");
  Option Add(const std::string& name, std::uint64_t& value, const std::string& about = "");
  Option Add(const std::string& name, double& value, const std::string& about = "");
  Option Add(const std::string& name, std::vector<std::string>& value, const std::string& about = "");
  Option Add(const std::string& name, std::vector<double>& value, const std::string& about = "");
  // A flag that is short for a value of another option.
  Option AddShort(const std::string& name, std::string& value, const std::string& word, const std::string& about);

  // What the command does, once all words are right. Its result is the program's exit status.
  void SetAction(std::function<int()> action);
  // The same for a function of the arguments, which live as long as the program.
  template <class Arguments>
  void SetAction(std::shared_ptr<Arguments> arguments, int (*action)(const std::type_identity_t<Arguments>&)) {
    SetAction([arguments, action] { return action(*arguments); });
  }

 protected:
  CLI::App* app_;
};

// A command as its manual page and its completion describe it, hidden ones left out.
struct OptionText {
  std::vector<std::string> names;    // "--port", "-h"; empty: positional
  std::string value;                 // "INT:INT in [1 - 65535]", as in --help; the name of a positional; empty: a flag
  std::vector<std::string> choices;  // all there are; empty: any value
  std::string about;
  std::string default_text;  // empty: not shown
  bool required = false;
  bool repeats = false;  // takes several values
};
struct CommandText {
  std::string name, about;
  std::vector<OptionText> options;
  std::vector<CommandText> commands;
};

class Program : public Command {
 public:
  // about: the first line of --help; its last ones are the exit statuses. version: empty: there is no --version.
  Program(const std::string& name, const std::string& about, const std::string& version = "");
  ~Program();

  // Nothing: go on. Else the exit status: help or version was printed (0), a command has run (what it says), or the
  // words are wrong (2, with one line on stderr).
  std::optional<int> Parse(int argc, const char* const* argv);
  // The same; `words` follow the program's name.
  std::optional<int> Parse(std::vector<std::string> words);

  CommandText Describe() const;

 private:
  std::unique_ptr<CLI::App> owned_;
};

// Write "COMMAND: MESSAGE" to stderr. command: "omni calibrate".
int Fail(const std::string& command, const std::string& message);       // it did not work: kExitFailed
int FailUsage(const std::string& command, const std::string& message);  // wrong arguments: kExitUsage

}  // namespace omni::console
