#include "service/tools/align/align.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <utility>
#include <vector>

#include "service/base/clock.h"
#include "service/config/paths.h"
#include "service/protocol/text.h"

extern char** environ;

namespace omni::tools {
namespace {

constexpr const char* kOurLayer = "XR_APILAYER_OMNI_stylus";
constexpr const char* kWithoutUs = "DISABLE_XR_APILAYER_OMNI_stylus_1=1";
constexpr const char* kLayersVariable = "XR_ENABLE_API_LAYERS=";
constexpr std::size_t kMaxLineBytes = 4096;  // longer lines are not from the probe

std::string WithoutOurLayer(const std::string& list) {
  std::string rest;
  std::istringstream names(list);
  for (std::string name; std::getline(names, name, ':');) {
    if (name != kOurLayer && !name.empty()) rest += (rest.empty() ? "" : ":") + name;
  }
  return rest;
}

std::vector<std::string> ChildEnvironment() {
  std::vector<std::string> variables{kWithoutUs};
  for (char** at = environ; *at != nullptr; ++at) {
    const std::string variable = *at;
    if (variable.rfind(kLayersVariable, 0) == 0) {
      const std::string rest = WithoutOurLayer(variable.substr(std::strlen(kLayersVariable)));
      if (!rest.empty()) variables.push_back(kLayersVariable + rest);
    } else {
      variables.push_back(variable);
    }
  }
  return variables;
}

ProbeLine End(const std::string& why) {
  ProbeLine line;
  line.text = why;
  return line;
}

}  // namespace

std::optional<ProbeLine> ParseProbeLine(const std::string& line) {
  const std::size_t space = line.find(' ');
  const std::string word = line.substr(0, space);
  const std::string rest = space == std::string::npos ? std::string() : line.substr(space + 1);
  ProbeLine said;
  if (word == "runtime" || word == "system" || word == "end") {
    said.says = word == "runtime" ? ProbeSays::kRuntime : word == "system" ? ProbeSays::kSystem : ProbeSays::kEnd;
    said.text = protocol::Printable(rest);
    return said;
  }
  if (line == "moved" || line == "lost") {
    said.says = line == "moved" ? ProbeSays::kMoved : ProbeSays::kLost;
    return said;
  }
  std::istringstream values(rest);
  if (word == "space") {
    said.says = ProbeSays::kSpace;
    return values >> said.space && said.space > 0 ? std::optional(said) : std::nullopt;
  }
  if (word != "pose" && word != "motion") return std::nullopt;
  said.says = word == "pose" ? ProbeSays::kPose : ProbeSays::kMotion;
  base::Vec3& p = said.pose.position_m;
  base::Quat& q = said.pose.orientation;
  if (!(values >> said.t_ns) || (word == "pose" && !(values >> said.text))) return std::nullopt;
  if (!(values >> p.x >> p.y >> p.z >> q.x >> q.y >> q.z >> q.w)) return std::nullopt;
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const bool sound = std::abs(norm - 1) < 0.02 && std::abs(p.x) < 1e3 && std::abs(p.y) < 1e3 && std::abs(p.z) < 1e3;
  if (!sound) return std::nullopt;
  q = {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
  base::Vec3& v = said.velocity_m_s;
  base::Vec3& w = said.turn_rate_rad_s;
  said.moves = word == "motion" && values >> v.x >> v.y >> v.z >> w.x >> w.y >> w.z;
  if (!said.moves || !(base::Norm(v) < 1e3 && base::Norm(w) < 1e3)) {
    said.moves = false;
    v = w = {};
  }
  return said;
}

base::Result<std::unique_ptr<AlignProbe>> AlignProbe::Start(const std::string& program,
                                                            const std::vector<std::string>& arguments) {
  std::error_code error;
  if (!std::filesystem::exists(program, error)) {
    return base::Error{program + ": does not exist; build target omni_align_probe, or name it with --probe"};
  }
  int to_child[2] = {-1, -1}, from_child[2] = {-1, -1};
  if (::pipe2(to_child, O_CLOEXEC) != 0 || ::pipe2(from_child, O_CLOEXEC) != 0) {
    return base::Error{"cannot create a pipe; raise the limit on open files (ulimit -n)"};
  }
  base::UniqueFd child_in(to_child[0]), child_out(from_child[1]);
  std::unique_ptr<AlignProbe> probe(new AlignProbe);
  probe->in_.Reset(to_child[1]);
  probe->out_.Reset(from_child[0]);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, child_in.get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, child_out.get(), STDOUT_FILENO);
  std::vector<std::string> variables = ChildEnvironment(), words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> envp, argv;
  for (std::string& variable : variables) envp.push_back(variable.data());
  for (std::string& word : words) argv.push_back(word.data());
  envp.push_back(nullptr);
  argv.push_back(nullptr);
  const int code = ::posix_spawn(&probe->pid_, program.c_str(), &actions, nullptr, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  if (code != 0) {
    probe->pid_ = -1;
    return base::Error{program + ": cannot be started (" + std::strerror(code) + ")"};
  }
  return probe;
}

AlignProbe::~AlignProbe() {
  if (pid_ <= 0) return;
  in_.Reset();  // closing its input ends it
  out_.Reset();
  for (int i = 0; i < 200; ++i) {
    if (::waitpid(pid_, nullptr, WNOHANG) == pid_) return;
    ::usleep(10'000);
  }
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

std::optional<ProbeLine> AlignProbe::NextLine(int timeout_ms) {
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + std::int64_t{timeout_ms} * 1'000'000;
  for (;;) {
    for (std::size_t end; (end = buffer_.find('\n')) != std::string::npos;) {
      const std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      if (auto said = ParseProbeLine(line)) return said;
    }
    if (ended_) return End("omni_align_probe has ended");
    if (buffer_.size() > kMaxLineBytes) buffer_.clear();
    const std::int64_t left_ms = (deadline_ns - base::MonotonicNow_ns()) / 1'000'000;
    pollfd wait{out_.get(), POLLIN, 0};
    if (left_ms < 0 || ::poll(&wait, 1, static_cast<int>(left_ms)) <= 0) return std::nullopt;
    char bytes[4096];
    const ssize_t count = ::read(out_.get(), bytes, sizeof bytes);
    if (count > 0) {
      buffer_.append(bytes, static_cast<std::size_t>(count));
    } else if (count == 0 || errno != EINTR) {
      ended_ = true;
    }
  }
}

std::string DefaultProbe() { return config::ProgramFolder() + "/omni_align_probe"; }

}  // namespace omni::tools
