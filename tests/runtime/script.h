#pragma once
// OMNI_TEST_RUNTIME_SCRIPT: what happens to the simulated world while an application in another process runs. One event
// per line: "at_seconds command args", counted from the creation of the instance; see docs/howto/test-runtime.md.

#include <openxr/openxr.h>

#include <string>
#include <vector>

namespace omni::runtime {

struct ScriptEvent {
  XrTime at = 0;
  std::string line;  // "FILE:12", for messages
  std::vector<std::string> words;
};

struct Script {
  std::vector<ScriptEvent> events;
  size_t next = 0;
};

// Empty on success, else the line and its error. Arguments are checked here, before anything runs.
std::string LoadScript(const std::string& file, XrTime start, Script* script);

// Applies the events that are due. The caller holds the world exclusively.
void RunScript(Script& script, XrTime now);

}  // namespace omni::runtime
