#include "tests/runtime/script.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/runtime/commands.h"
#include "tests/runtime/spaces/clock.h"

namespace omni::runtime {
namespace {

using Words = std::vector<std::string>;

bool ParseNumber(const std::string& word, float* number) {
  char* end = nullptr;
  *number = std::strtof(word.c_str(), &end);
  return !word.empty() && *end == '\0' && std::isfinite(*number);
}

float Number(const std::string& word) { return std::strtof(word.c_str(), nullptr); }
bool Truth(const std::string& word) { return Number(word) != 0; }

// words[first..]: x y z qx qy qz qw [vx vy vz wx wy wz]
Motion ReadMotion(const Words& words, size_t first) {
  float n[13] = {};
  for (size_t i = first; i < words.size(); ++i) n[i - first] = Number(words[i]);
  return {{{n[3], n[4], n[5], n[6]}, {n[0], n[1], n[2]}}, {n[7], n[8], n[9]}, {n[10], n[11], n[12]}};
}

// args: 'h' hand, 'p' path, 'n' number, 's' any word; `optional` numbers may follow.
struct Command {
  std::string_view name;
  std::string_view args;
  size_t optional;
  bool (*run)(State& state, const Words& words);
};

constexpr Command kCommands[] = {
    {"reset", "", 0, [](State& state, const Words&) { return ResetWorld(state); }},
    {"present", "hn", 0,
     [](State& state, const Words& w) { return state.world.SetDevice(HandIndex(w[1]), Truth(w[2]), {}); }},
    {"profile", "hp", 0,
     [](State& state, const Words& w) {
       const int hand = HandIndex(w[1]);
       return state.world.SetDevice(hand, state.world.devices[hand].present, w[2]);
     }},
    {"tracking", "hnn", 0,
     [](State& state, const Words& w) { return SetTracking(state, HandIndex(w[1]), Truth(w[2]), Truth(w[3])); }},
    {"bool", "pn", 0, [](State& state, const Words& w) { return state.world.SetBool(w[1], Truth(w[2])); }},
    {"float", "pn", 0, [](State& state, const Words& w) { return state.world.SetFloat(w[1], Number(w[2])); }},
    {"vector2", "pnn", 0,
     [](State& state, const Words& w) { return state.world.SetVector2(w[1], Number(w[2]), Number(w[3])); }},
    {"pose", "pnnnnnnn", 6, [](State& state, const Words& w) { return state.world.SetPose(w[1], ReadMotion(w, 2)); }},
    {"head", "nnnnnnn", 6, [](State& state, const Words& w) { return SetHead(state, ReadMotion(w, 1)); }},
    {"focus", "n", 0, [](State& state, const Words& w) { return SetFocus(state, Truth(w[1])); }},
    {"user_presence", "n", 0, [](State& state, const Words& w) { return SetUserPresence(state, Truth(w[1])); }},
    {"recenter", "nnnnnnn", 0,
     [](State& state, const Words& w) {
       return Recenter(state, XR_REFERENCE_SPACE_TYPE_LOCAL, ReadMotion(w, 1).pose, 0, true);
     }},
    {"exit", "", 0, [](State& state, const Words&) { return RequestExit(state); }},
    {"lose_session", "", 0, [](State& state, const Words&) { return LoseSessions(state); }},
    {"lose_instance", "", 0, [](State& state, const Words&) { return LoseInstances(state); }},
    {"kill_runtime", "", 0, [](State& state, const Words&) { return KillRuntime(state); }},
};

const Command* FindCommand(std::string_view name) {
  const auto* const found = std::find_if(std::begin(kCommands), std::end(kCommands),
                                         [name](const Command& command) { return command.name == name; });
  return found == std::end(kCommands) ? nullptr : found;
}

bool FitsArgument(char kind, const std::string& word) {
  float number = 0;
  switch (kind) {
    case 'h':
      return HandIndex(word) >= 0;
    case 'p':
      return word.starts_with('/');
    default:
      return ParseNumber(word, &number);
  }
}

// Empty, or the error in words = {command, args...}.
std::string CheckCommand(const Words& words) {
  const Command* const command = FindCommand(words[0]);
  if (command == nullptr) return "unknown command '" + words[0] + "'";
  const size_t given = words.size() - 1;
  const size_t required = command->args.size();
  if (given != required && given != required + command->optional) {
    return "'" + words[0] + "' takes " + std::to_string(required) + " arguments, not " + std::to_string(given);
  }
  for (size_t i = 0; i < given; ++i) {
    const char kind = i < required ? command->args[i] : 'n';
    if (!FitsArgument(kind, words[i + 1])) {
      return "'" + words[i + 1] + "' is not a " + (kind == 'h' ? "hand" : kind == 'p' ? "path" : "number");
    }
  }
  return {};
}

Words Split(const std::string& line) {
  std::istringstream stream(line.substr(0, line.find('#')));
  Words words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

std::string LoadScript(const std::string& file, XrTime start, Script* script) {
  std::ifstream in(file);
  if (!in) return file + ": cannot be read; OMNI_TEST_RUNTIME_SCRIPT must name a readable file or be unset";
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    Words words = Split(line);
    if (words.empty()) continue;
    const std::string where = file + ":" + std::to_string(number);
    float seconds = 0;
    if (!ParseNumber(words[0], &seconds) || !(seconds >= 0 && seconds <= 1e6f)) {
      return where + ": '" + words[0] + "' is not a time in seconds";
    }
    words.erase(words.begin());
    if (words.empty()) return where + ": a command is missing after the time";
    if (const std::string error = CheckCommand(words); !error.empty()) return where + ": " + error;
    script->events.push_back({start + static_cast<XrTime>(double{seconds} * 1e9), where, std::move(words)});
  }
  std::stable_sort(script->events.begin(), script->events.end(),
                   [](const ScriptEvent& a, const ScriptEvent& b) { return a.at < b.at; });
  return {};
}

void RunScript(Script& script, XrTime now) {
  for (; script.next < script.events.size() && script.events[script.next].at <= now; ++script.next) {
    const ScriptEvent& event = script.events[script.next];
    if (!FindCommand(event.words[0])->run(TheState(), event.words)) {
      std::fprintf(
          stderr,
          "omni_test_runtime: %s: '%s' was rejected: the device has no such input, or a value is out of range\n",
          event.line.c_str(), event.words[0].c_str());
    }
  }
}

}  // namespace omni::runtime
