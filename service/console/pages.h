// Manual pages and shell completions of a program, from its command line itself.
#pragma once

#include <string>

#include "service/console/command.h"

namespace omni::console {

// A page in scdoc(5) format, section 1. `path`: the words of the command, "omni scene". `body`: sections of the page in
// the same format; a line "@OPTIONS@" in it becomes the options of the command and of those below it. `version`: "Omni
// 0.2.0".
std::string ManPage(const CommandText& command, const std::string& path, const std::string& body,
                    const std::string& version);

// Scripts for the folders in which the shells look for completions of `program`: names of commands and options,
// choices, files where a value or a word may be one.
std::string BashCompletion(const CommandText& program);
std::string ZshCompletion(const CommandText& program);
std::string FishCompletion(const CommandText& program);

}  // namespace omni::console
