// The protection that a process gets, according to the headers of its ELF file. The file is not run.
#pragma once

#include <set>
#include <string>

#include "service/base/result.h"

namespace omni::hardening {

struct Hardening {
  bool position_independent = false;  // at another address each time
  bool is_program = false;            // has an interpreter; else a library
  bool bound_at_start = false;        // BIND_NOW: functions of libraries are looked up before main
  bool relro = false;                 // then the table of their addresses is read-only
  bool stack_executable = true;
  bool probes_stack = false;  // somewhere a large frame is taken page by page, each touched
  std::set<std::string> imports;
};

base::Result<Hardening> ReadHardening(const std::string& path);

}  // namespace omni::hardening
