// omni-builder: builds one scene or one soft body for omnid, which starts it, and ends. It is there to read foreign
// files: what is wrong with them, or with the code that reads them, stays in it (docs/decisions/0028).
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "service/base/clock.h"
#include "service/base/files/whole_file.h"
#include "service/base/free_memory.h"
#include "service/base/unique_fd.h"
#include "service/builder/confine.h"
#include "service/builder/messages.h"
#include "service/protocol/packet_socket.h"
#include "service/scene/cache/cached_scene.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/load_scene.h"

namespace omni::builder {
namespace {

constexpr int kExitFailed = 1;
constexpr std::int64_t kBetweenProgress_ns = 100'000'000;

// omnid has ended, or is of another build: no answer would be read.
struct Unanswered {};

void Wait(short event) {
  pollfd wait{kSocket, event, 0};
  while (poll(&wait, 1, -1) < 0) {
    if (errno != EINTR) throw Unanswered{};
  }
}

template <class M>
void Send(const M& message, std::string_view text = {}) {
  std::string bytes(reinterpret_cast<const char*>(&message), sizeof message);
  bytes += text;
  for (;;) {
    const protocol::SendResult result = protocol::SendPacket(kSocket, bytes.data(), bytes.size());
    if (result == protocol::SendResult::kSent) return;
    if (result == protocol::SendResult::kGone) throw Unanswered{};
    Wait(POLLOUT);
  }
}

struct Message {
  std::vector<char> bytes = std::vector<char>(kMaxMessage);
  std::size_t size = 0;
  base::UniqueFd fds[2];

  template <class M>
  M As() const {
    M message;
    if (size < sizeof message) throw Unanswered{};
    std::memcpy(&message, bytes.data(), sizeof message);
    if (message.kind != M{}.kind) throw Unanswered{};
    return message;
  }
  std::string TextAfter(std::size_t at, std::size_t length) const {
    if (at > size || length != size - at) throw Unanswered{};
    return {bytes.data() + at, length};
  }
};

Message Receive() {
  Message message;
  for (;;) {
    const protocol::Received received =
        protocol::ReceivePacket(kSocket, message.bytes.data(), message.bytes.size(), message.fds, 2);
    message.size = received.size;
    if (received.result == protocol::ReceiveResult::kPacket) return message;
    if (received.result != protocol::ReceiveResult::kNothing) throw Unanswered{};
    Wait(POLLIN);
  }
}

// omnid opens it, if it is one that may be.
class OpenedByOmnid final : public scene::FilesBeside {
 public:
  int OpenBeside(const std::string& name) override {
    if (name.size() > kMaxName) throw scene::LoadError("", "has a name that is too long");
    Send(Open{.text_bytes = static_cast<std::uint32_t>(name.size())}, name);
    Message message = Receive();
    const auto opened = message.As<Opened>();
    if (opened.text_bytes > 0) throw scene::LoadError("", message.TextAfter(sizeof opened, opened.text_bytes));
    return message.fds[0].Release();
  }
};

// The memory for the result, whose size is fixed.
class Result {
 public:
  Result(base::UniqueFd memory, std::uint64_t bytes) : memory_(std::move(memory)), bytes_(bytes) {}

  // After what was written before. False: it does not fit.
  bool Append(std::span<const std::byte> part) {
    if (part.size() > bytes_ - written_) return false;
    if (base::WriteAt(memory_.get(), written_, part.data(), part.size()) != 0) throw std::bad_alloc();
    written_ += part.size();
    return true;
  }
  std::uint64_t written() const { return written_; }

 private:
  base::UniqueFd memory_;
  std::uint64_t bytes_, written_ = 0;
};

// `result`: null when there is no memory yet: a file that was refused before has but its error.
void Finish(Finished finished, std::initializer_list<std::span<const std::byte>> parts, Result* result,
            std::string text) {
  for (const std::span<const std::byte> part : parts) {
    if (result != nullptr && finished.outcome != Outcome::kTooLarge && !result->Append(part)) {
      finished.outcome = Outcome::kTooLarge;
      text.clear();
    }
  }
  finished.bytes = result == nullptr ? 0 : result->written();
  text.resize(std::min(text.size(), kMaxText));
  finished.text_bytes = static_cast<std::uint32_t>(text.size());
  Send(finished, text);
}

void BuildScene(Message& request) {
  const auto job = request.As<SceneJob>();
  const std::string text = request.TextAfter(sizeof job, std::size_t{job.text_bytes} + job.tags_bytes);
  const std::string file = text.substr(0, job.text_bytes);
  OpenedByOmnid beside;
  const scene::LoadOptions options{.all_kinematic = job.all_kinematic != 0,
                                   .memory = request.fds[0].get(),
                                   .touch_untagged = job.touch_untagged != 0,
                                   .z_up = job.z_up != 0,
                                   .fit = job.fit != 0,
                                   .offset_base_m = {job.offset_base_m[0], job.offset_base_m[1], job.offset_base_m[2]},
                                   .scale = job.scale,
                                   .hull_radius_m = job.hull_radius_m,
                                   .tip_radius_m = job.tip_radius_m,
                                   .max_file_bytes = job.max_file_bytes,
                                   .beside = job.has_beside != 0 ? &beside : nullptr,
                                   .max_nodes = job.max_nodes,
                                   .max_depth = job.max_depth,
                                   .tags_by_name = text.substr(job.text_bytes)};
  std::unique_ptr<Result> result;
  const scene::LoadSteps steps{.admit =
                                   [&](const scene::BuildNeed& need) {
                                     Send(Need{.kept_bytes = need.kept_bytes, .peak_bytes = need.peak_bytes});
                                     Message message = Receive();
                                     const auto grant = message.As<Grant>();
                                     result = std::make_unique<Result>(std::move(message.fds[0]), grant.memory_bytes);
                                     return true;
                                   },
                               .build =
                                   [](const scene::Digest& bytes) {
                                     Send(Digest{.bytes = bytes});
                                     (void)Receive().As<Build>();
                                     return true;
                                   }};
  scene::LoadReport load;
  haptics::BuildReport report;
  Finished finished;
  try {
    const base::Result<haptics::Scene> built = scene::LoadInSteps(file, options, steps, load, report);
    finished.outcome = built.ok() ? Outcome::kBuilt : Outcome::kRefused;
    finished.skipped = load.skipped ? 1 : 0;
    const std::string reports = scene::PackReports(load, report);
    Finish(finished, {built.ok() ? built->block() : std::span<const std::byte>(), std::as_bytes(std::span(reports))},
           result.get(), built.ok() ? "" : built.error());
  } catch (const std::bad_alloc&) {
    finished.outcome = Outcome::kNoMemory;
    Finish(finished, {}, nullptr, {});
  }
}

template <class T>
std::vector<T> ReadList(int memory, std::uint64_t count, std::uint64_t at) {
  std::vector<T> list(count);
  if (base::ReadAt(memory, at, list.data(), sizeof(T) * list.size()) != 0) throw Unanswered{};
  return list;
}

void BuildSoftBody(Message& request) {
  const auto job = request.As<SoftJob>();
  Result result(std::move(request.fds[1]), job.memory_bytes);
  Finished finished;
  try {
    const int memory = request.fds[0].get();
    const auto vertices = ReadList<haptics::Vec3>(memory, job.vertices, 0);
    const auto triangles =
        ReadList<std::array<std::uint32_t, 3>>(memory, job.triangles, sizeof(haptics::Vec3) * job.vertices);
    haptics::SoftBodyOptions options;
    options.moduli = job.moduli;
    options.fibre = job.fibre;
    options.lattice = job.lattice;
    options.clamped_share = job.clamped_share;
    options.hardening = job.hardening;
    options.relaxing_share = job.relaxing_share;
    options.relaxation_time_s = job.relaxation_time_s;
    std::int64_t sent_ns = 0;
    options.progress = [&](double done) {
      const std::int64_t now_ns = base::MonotonicNow_ns();
      if (now_ns - sent_ns >= kBetweenProgress_ns) Send(Progress{.done = done});
      if (now_ns - sent_ns >= kBetweenProgress_ns) sent_ns = now_ns;
      return true;
    };
    const base::Result<haptics::SoftBody> body = haptics::BuildSoftBody(vertices, triangles, options, finished.soft);
    finished.outcome = body.ok() ? Outcome::kBuilt : Outcome::kRefused;
    Finish(finished, {body.ok() ? body->bytes() : std::span<const std::byte>()}, &result,
           body.ok() ? "" : body.error());
  } catch (const std::bad_alloc&) {
    finished.outcome = Outcome::kNoMemory;
    Finish(finished, {}, nullptr, {});
  }
}

int Run() {
  for (const auto step : {Retire, ConfineItself}) {
    const base::Status done = step();
    if (done.ok()) continue;
    Send(Finished{.text_bytes = static_cast<std::uint32_t>(done.error().size())}, done.error());
    return kExitFailed;
  }
  Message request = Receive();
  Kind kind{};
  if (request.size < sizeof kind) return kExitFailed;
  std::memcpy(&kind, request.bytes.data(), sizeof kind);
  kind == Kind::kSoftJob ? BuildSoftBody(request) : BuildScene(request);
  return 0;
}

}  // namespace
}  // namespace omni::builder

int main() {
  struct stat status {};
  if (fstat(omni::builder::kSocket, &status) != 0 || !S_ISSOCK(status.st_mode)) {
    std::fputs("omni-builder: is started by omnid, for one scene or soft body each time\n", stderr);
    return 2;
  }
  omni::base::ReturnFreedBlocks();
  // Not through exit(): nothing is left to do, and what exit does is not allowed any more.
  try {
    _exit(omni::builder::Run());
  } catch (const omni::builder::Unanswered&) {
    _exit(omni::builder::kExitFailed);
  }
}
