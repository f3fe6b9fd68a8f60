// Is the control socket's folder private to this user, and its path short enough?
#include "service/protocol/socket_path.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {
Finding CheckSocketFolder(const Surroundings& surroundings) {
  const std::string& path = surroundings.socket_path;
  if (const std::string problem = protocol::PathProblem(path); !problem.empty()) {
    return {Verdict::kFail, problem, "set OMNI_SOCKET for omnid and for the applications alike"};
  }
  const std::string folder = protocol::FolderOf(path);
  const protocol::FolderCheck check = protocol::CheckFolder(folder);
  switch (check.state) {
    case protocol::FolderState::kGood:
      return {Verdict::kOk, folder + " is yours alone", {}};
    case protocol::FolderState::kMissing:
      return {Verdict::kOk, folder + " does not exist yet; omnid creates it", {}};
    case protocol::FolderState::kRefused:
      break;
  }
  return {Verdict::kFail, check.problem, "make the folder your own with mode 0700: omnid and the layer use no other"};
}

}  // namespace omni::tools
