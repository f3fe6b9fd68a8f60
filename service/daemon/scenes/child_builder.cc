#include "service/daemon/scenes/child_builder.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "service/base/files/whole_file.h"
#include "service/base/sealed_memory.h"
#include "service/builder/messages.h"
#include "service/config/files/app_file.h"
#include "service/daemon/scenes/builder_process.h"
#include "service/protocol/text.h"
#include "service/scene/cache/cached_scene.h"
#include "service/scene/gltf/file_bytes.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::daemon {
namespace {

constexpr std::size_t kCopied = 64u << 20;  // between two looks at whether the build is still wanted
// Reports go beside the block: rows and names of nodes.
constexpr std::uint64_t kReports = 8u << 20, kReportsPerJsonByte = 8, kMostJson = 64u << 20;

static_assert(config::kMaxTagBytes <= builder::kMaxTags, "what a file may say is taken");

constexpr const char* kBroken = "the builder broke its protocol; its result is not used";

// Memory for a result. It cannot grow: what the builder writes to it counts for nothing else.
base::UniqueFd MakeMemory(std::uint64_t bytes) {
  base::UniqueFd memory(memfd_create("omni-builder", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory || ftruncate(memory.get(), static_cast<off_t>(bytes)) != 0 ||
      fcntl(memory.get(), F_ADD_SEALS, base::kSealsFixedSize) != 0) {
    throw BuilderEnded{std::string("no memory for a result: ") + std::strerror(errno)};
  }
  return memory;
}

template <class Block>
Block CopyOf(int memory, std::uint64_t bytes, const CancelEvent& cancel) {
  Block block(bytes);
  for (std::size_t done = 0; done < bytes;) {
    if (cancel.is_set()) throw BuilderEnded{};
    const std::size_t now = std::min(kCopied, block.size() - done);
    if (base::ReadAt(memory, done, block.data() + done, now) != 0) {
      throw BuilderEnded{"the builder's result cannot be read"};
    }
    done += now;
  }
  return block;
}

// How it went, in words for people; only of the text that is known by now.
std::string TextOf(const builder::Finished& finished, const std::string& text, const std::string& file,
                   std::uint64_t granted) {
  const std::string what = file.empty() ? "" : file + ": ";
  const std::string granted_MB = std::to_string(granted / 1'000'000) + " MB";
  switch (finished.outcome) {
    case builder::Outcome::kNoMemory:
      return what + "does not fit into the " + granted_MB + " of memory that it was granted; simplify the model";
    case builder::Outcome::kTooLarge:
      return what + "becomes larger than its triangles are granted memory for; simplify the model";
    case builder::Outcome::kRefused:
      return text.empty() ? what + kBroken : scene::Printable(text);
    case builder::Outcome::kBuilt:
      return {};
  }
  return what + kBroken;
}

builder::Finished FinishedOf(const BuilderProcess::Message& message, std::uint64_t memory_bytes, std::string& text) {
  if (message.kind != builder::Kind::kFinished) throw BuilderEnded{kBroken};
  const auto finished = message.ReadAs<builder::Finished>(&text);
  if (finished.text_bytes != text.size() || text.size() > builder::kMaxText) BuilderProcess::Message::ThrowMisshapen();
  const bool said = finished.outcome == builder::Outcome::kNoMemory || finished.outcome == builder::Outcome::kTooLarge;
  if (!said && finished.bytes > memory_bytes) throw BuilderEnded{kBroken};
  return finished;
}

// A scene, from the first message to the last.
class SceneTalk {
 public:
  SceneTalk(BuilderProcess& process, const std::string& file, const scene::LoadOptions& options,
            const scene::LoadSteps& steps, const CancelEvent& cancel)
      : process_(process), file_(file), options_(options), steps_(steps), cancel_(cancel) {}

  base::Result<haptics::Scene> Run(scene::LoadReport& load, haptics::BuildReport& report) {
    json_bytes_ = scene::JsonBytesOf(options_.memory);
    granted_ = scene::NeedToRead(json_bytes_, scene::FileBytesOf(options_.memory)).peak_bytes;
    process_.Limit(granted_);
    SendJob();
    for (;;) {
      const BuilderProcess::Message message = Next();
      switch (message.kind) {
        case builder::Kind::kNeed:
          if (!Admit(message.ReadAs<builder::Need>())) return base::Error{};  // the caller has the answer
          break;
        case builder::Kind::kDigest:
          if (!memory_ || std::exchange(digested_, true)) throw BuilderEnded{kBroken};
          if (!steps_.build(message.ReadAs<builder::Digest>().bytes))
            return base::Error{};  // the caller has the answer
          process_.Send(builder::Build{});
          break;
        default:
          return Take(message, load, report);
      }
    }
  }

 private:
  // The next message that is no request for a file.
  BuilderProcess::Message Next() {
    for (;;) {
      BuilderProcess::Message message = process_.Receive();
      if (message.kind != builder::Kind::kOpen) return message;
      std::string name;
      const auto open = message.ReadAs<builder::Open>(&name);
      if (open.text_bytes != name.size() || ++opened_ > builder::kMaxOpened) throw BuilderEnded{kBroken};
      OpenBeside(name);
    }
  }

  // The name comes from a file that may be hostile, by a process that may be: it is checked here.
  void OpenBeside(const std::string& name) {
    std::string why = "is no file beside the document";
    if (options_.beside != nullptr && name.size() <= builder::kMaxName && scene::IsPathBeneath(name)) {
      try {
        const base::UniqueFd file(options_.beside->OpenBeside(name));
        struct stat status {};
        if (fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode)) {
          return process_.Send(builder::Opened{}, {}, {file.get()});
        }
        why = "is not a regular file; name a .glb or .gltf file";
      } catch (const scene::LoadError& error) {
        why = error.what();
      }
    }
    process_.Send(builder::Opened{.text_bytes = static_cast<std::uint32_t>(why.size())}, why);
  }

  void SendJob() {
    const std::string name = file_.substr(0, builder::kMaxText);
    const std::string& tags = options_.tags_by_name;
    if (tags.size() > builder::kMaxTags) throw BuilderEnded{"its tags by name are too long"};
    process_.Send(builder::SceneJob{.text_bytes = static_cast<std::uint32_t>(name.size()),
                                    .tags_bytes = static_cast<std::uint32_t>(tags.size()),
                                    .all_kinematic = options_.all_kinematic,
                                    .touch_untagged = options_.touch_untagged,
                                    .z_up = options_.z_up,
                                    .fit = options_.fit,
                                    .has_beside = options_.beside != nullptr ? 1U : 0U,
                                    .offset_base_m = {options_.offset_base_m.x, options_.offset_base_m.y,
                                                      options_.offset_base_m.z},
                                    .scale = options_.scale,
                                    .hull_radius_m = options_.hull_radius_m,
                                    .tip_radius_m = options_.tip_radius_m,
                                    .max_file_bytes = options_.max_file_bytes,
                                    .max_nodes = options_.max_nodes,
                                    .max_depth = options_.max_depth},
                  name + tags, {options_.memory});
  }

  bool Admit(const builder::Need& said) {
    if (memory_) throw BuilderEnded{kBroken};
    const scene::BuildNeed need{said.kept_bytes, said.peak_bytes};
    if (!steps_.admit(need)) return false;
    granted_ = need.peak_bytes;
    memory_bytes_ = need.kept_bytes + kReports + kReportsPerJsonByte * std::min(json_bytes_, kMostJson);
    memory_ = MakeMemory(memory_bytes_);
    process_.Limit(granted_);
    process_.Send(builder::Grant{.memory_bytes = memory_bytes_}, {}, {memory_.get()});
    return true;
  }

  base::Result<haptics::Scene> Take(const BuilderProcess::Message& message, scene::LoadReport& load,
                                    haptics::BuildReport& report) {
    std::string text;
    const builder::Finished finished = FinishedOf(message, memory_bytes_, text);
    process_.End();
    const bool built = finished.outcome == builder::Outcome::kBuilt;
    scene::CachedScene result;
    if (finished.bytes > 0 && (built || finished.outcome == builder::Outcome::kRefused)) {
      const std::string wrong =
          scene::Unpack(CopyOf<scene::CacheBlock>(memory_.get(), finished.bytes, cancel_), result);
      if (!wrong.empty()) throw BuilderEnded{"the builder's result " + wrong + "; it is not used"};
      std::string before = std::move(load.cache);
      load = std::move(result.load);
      report = std::move(result.build);
      load.cached = false;
      load.cache = std::move(before);
    }
    memory_.Reset();
    if (!built) return base::Error{TextOf(finished, text, file_, granted_)};
    load.skipped = finished.skipped != 0;
    // Only a file that is skipped gives nothing; and its scene has been admitted by now.
    if (result.scene.empty() != load.skipped || (!load.skipped && !digested_)) throw BuilderEnded{kBroken};
    if (!load.skipped && load.objects.size() < result.scene.objects().size()) throw BuilderEnded{kBroken};
    return std::move(result.scene);
  }

  BuilderProcess& process_;
  const std::string& file_;
  const scene::LoadOptions& options_;
  const scene::LoadSteps& steps_;
  const CancelEvent& cancel_;
  base::UniqueFd memory_;
  std::uint64_t json_bytes_ = 0, memory_bytes_ = 0, granted_ = 0;
  std::uint32_t opened_ = 0;
  bool digested_ = false;
};

// The mesh as messages.h lays it out.
base::UniqueFd MemoryOf(const haptics::Mesh& mesh) {
  base::UniqueFd memory(memfd_create("omni-mesh", MFD_CLOEXEC));
  if (!memory) throw BuilderEnded{std::string("no memory for a mesh: ") + std::strerror(errno)};
  std::uint64_t size = 0;
  for (const auto part : {std::as_bytes(std::span(mesh.vertices)), std::as_bytes(std::span(mesh.triangles))}) {
    const int error = base::WriteAt(memory.get(), size, part.data(), part.size());
    if (error != 0) throw BuilderEnded{std::string("no memory for a mesh: ") + std::strerror(error)};
    size += part.size();
  }
  return memory;
}

}  // namespace

base::Status ChildBuilder::CheckProgram() const {
  if (access(program_.c_str(), X_OK) == 0) return base::Ok{};
  return base::Error{program_ + ": " + std::strerror(errno) +
                     "; scenes are refused until omni-builder is installed beside omnid"};
}

base::Result<haptics::Scene> ChildBuilder::BuildScene(const std::string& file, const scene::LoadOptions& options,
                                                      const scene::LoadSteps& steps, const CancelEvent& cancel,
                                                      scene::LoadReport& load, haptics::BuildReport& report) const {
  try {
    BuilderProcess process(program_, cancel);
    return SceneTalk(process, file, options, steps, cancel).Run(load, report);
  } catch (const BuilderEnded& ended) {
    return base::Error{file + ": " + (ended.why.empty() ? "cancelled" : ended.why)};
  }
}

base::Result<haptics::SoftBody> ChildBuilder::BuildSoftBody(const haptics::Mesh& mesh,
                                                            const haptics::SoftBodyOptions& options,
                                                            const CancelEvent& cancel,
                                                            haptics::SoftBuildReport& report) const {
  try {
    const scene::BuildNeed need = scene::NeedOf(mesh, options);
    const base::UniqueFd input = MemoryOf(mesh), memory = MakeMemory(need.kept_bytes);
    BuilderProcess process(program_, cancel);
    process.Limit(need.peak_bytes);
    process.Send(builder::SoftJob{.vertices = mesh.vertices.size(),
                                  .triangles = mesh.triangles.size(),
                                  .memory_bytes = need.kept_bytes,
                                  .moduli = options.moduli,
                                  .fibre = options.fibre,
                                  .lattice = options.lattice,
                                  .clamped_share = options.clamped_share,
                                  .hardening = options.hardening,
                                  .relaxing_share = options.relaxing_share,
                                  .relaxation_time_s = options.relaxation_time_s},
                 {}, {input.get(), memory.get()});
    BuilderProcess::Message message = process.Receive();
    for (; message.kind == builder::Kind::kProgress; message = process.Receive()) {
      const double done = message.ReadAs<builder::Progress>().done;
      if (!(done >= 0 && done <= 1)) throw BuilderEnded{kBroken};
      if (options.progress && !options.progress(done)) return base::Error{"soft body: cancelled"};
    }
    std::string text;
    const builder::Finished finished = FinishedOf(message, need.kept_bytes, text);
    process.End();
    if (finished.outcome != builder::Outcome::kBuilt) {
      return base::Error{TextOf(finished, text, "", need.peak_bytes)};
    }
    base::Result<haptics::SoftBody> body =
        haptics::SoftBody::Load(CopyOf<std::vector<std::byte>>(memory.get(), finished.bytes, cancel));
    if (!body.ok()) throw BuilderEnded{"the builder's result is no soft body (" + body.error() + "); it is not used"};
    if (body->view().header().input_hash != haptics::SoftBodyKey(mesh.vertices, mesh.triangles, options)) {
      throw BuilderEnded{"the builder's result is of another mesh; it is not used"};
    }
    report = finished.soft;
    report.bytes = body->bytes().size();
    report.surface_nodes = body->view().header().node_count;
    return body;
  } catch (const BuilderEnded& ended) {
    return base::Error{ended.why.empty() ? "soft body: cancelled" : ended.why};
  }
}

}  // namespace omni::daemon
