// cli_pages BODIES OUT: manual pages (scdoc) and completions of omni and omnid, for packages and installed trees.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "service/console/pages.h"
#include "service/daemon/run.h"
#include "service/tools/common/command_line.h"

namespace {

namespace fs = std::filesystem;
using namespace omni::console;

constexpr const char* kVersion = "Omni " OMNI_VERSION;

// Empty: there is none.
std::string TextOf(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

void Write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw fs::filesystem_error("cannot be written", file, std::make_error_code(std::errc::io_error));
}

// "omni scene": omni-scene.1.scd, with the sections of BODIES/omni-scene.scd.
void WritePage(const CommandText& command, const std::string& path, const fs::path& bodies, const fs::path& out) {
  std::string name = path;
  for (char& c : name) c = c == ' ' ? '-' : c;
  Write(out / "man" / (name + ".1.scd"), ManPage(command, path, TextOf(bodies / (name + ".scd")), kVersion));
}

void WriteCompletions(const CommandText& program, const fs::path& out) {
  Write(out / "bash-completion/completions" / program.name, BashCompletion(program));
  Write(out / "zsh/vendor-completions" / ("_" + program.name), ZshCompletion(program));
  Write(out / "fish/vendor_completions.d" / (program.name + ".fish"), FishCompletion(program));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: cli_pages BODIES OUT\n");
    return 2;
  }
  try {
    const fs::path bodies = argv[1], out = argv[2];
    Program omni("omni", omni::tools::kOmniAbout, OMNI_VERSION);
    omni::tools::AddCommands(omni);
    Program omnid("omnid", omni::daemon::kOmnidAbout, OMNI_VERSION);
    omni::daemon::RunOptions options;
    omni::daemon::AddOptions(omnid, options);
    for (const CommandText& program : {omni.Describe(), omnid.Describe()}) {
      CommandText top = program;
      for (CommandText& command : top.commands) {
        WritePage(command, program.name + " " + command.name, bodies, out);
        command.options.clear();  // they have pages of their own
        command.commands.clear();
      }
      WritePage(top, program.name, bodies, out);
      WriteCompletions(program, out);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cli_pages: %s\n", error.what());
    return 1;
  }
}
