#include "service/daemon/scenes/sculpt_thread.h"

#include <algorithm>
#include <charconv>
#include <exception>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "service/base/sealed_memory.h"
#include "service/haptics/sculpt/sculpted_scene.h"
#include "service/scene/glb_save.h"

namespace omni::daemon {
namespace {

bool HasSculptSession(const haptics::Scene& scene) {
  return scene.live() != nullptr && scene.live()->sculpt_session_count() > 0;
}

SculptAnswer AnswerTo(const SculptRequest& request) {
  SculptAnswer answer;
  answer.asker = request.asker;
  answer.number = request.number;
  return answer;
}

scene::RecordKind KindOf(haptics::sculpt::EditKind kind) {
  switch (kind) {
    case haptics::sculpt::EditKind::kUndo:
      return scene::RecordKind::kUndo;
    case haptics::sculpt::EditKind::kRedo:
      return scene::RecordKind::kRedo;
    case haptics::sculpt::EditKind::kStroke:
      break;
  }
  return scene::RecordKind::kStroke;
}

constexpr const char* kOpenStroke = "a stroke is open; lift the pen first";

void WriteFile(const haptics::SceneInput& saved, SculptAnswer& answer) {
  const base::Result<std::string> bytes = scene::GlbBytes(saved);
  base::Result<base::UniqueFd> memory =
      bytes.ok() ? base::SealedCopy("omni-scene", *bytes) : base::Error{bytes.error()};
  answer.ok = memory.ok();
  if (!memory.ok()) {
    answer.text = memory.error();
    return;
  }
  std::size_t triangles = 0;
  for (const haptics::InputObject& object : saved.objects) triangles += object.triangles.size();
  answer.text = std::to_string(saved.objects.size()) + (saved.objects.size() == 1 ? " object, " : " objects, ") +
                std::to_string(triangles) + " triangles";
  answer.file = std::move(*memory);
  answer.file_bytes = bytes->size();
}

}  // namespace

SculptThread::~SculptThread() {
  {
    const std::lock_guard lock(mutex_);
    for (Sculpted& sculpted : scenes_) {
      // The tick has ended before: an open stroke ends as it is.
      for (std::size_t n = 0; n < sculpted.benches.size() && sculpted.read && !sculpted.broken; ++n) {
        sculpted.sculpt_session(n).SetReader(false);
      }
      CloseJournals(sculpted);
    }
    scenes_.clear();
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void SculptThread::Add(std::uint64_t client, const std::string& file,
                       const std::shared_ptr<const haptics::Scene>& scene,
                       const std::vector<JournalWriter::Journal>& journals) {
  if (!HasSculptSession(*scene)) return;
  std::thread ended;
  {
    const std::lock_guard lock(mutex_);
    scenes_.push_back({.client = client, .file = file, .scene = scene, .benches = {}});
    Sculpted& sculpted = scenes_.back();
    sculpted.benches.resize(scene->live()->sculpt_session_count());
    for (std::size_t n = 0; n < std::min(journals.size(), sculpted.benches.size()); ++n) {
      sculpted.benches[n].journal = journals[n];
      sculpted.sculpt_session(n).editor().SetLog(
          [this, journal = journals[n]](haptics::sculpt::EditKind kind, const haptics::sculpt::UndoStep& step) {
            journal->Append(KindOf(kind), step);
            writer_.Write(journal);
          });
      writer_.Write(journals[n]);
    }
    if (std::exchange(ended_, false)) std::swap(ended, thread_);
    if (!thread_.joinable()) thread_ = std::thread([this] { Run(); });
  }
  if (ended.joinable()) ended.join();
}

void SculptThread::EnterScene(const haptics::Scene& scene) {
  if (!HasSculptSession(scene)) return;
  {
    const std::lock_guard lock(mutex_);
    Sculpted* sculpted = Find(scene);
    if (sculpted == nullptr || sculpted->read) return;
    for (std::size_t n = 0; n < sculpted->benches.size(); ++n) sculpted->sculpt_session(n).SetReader(true);
    sculpted->read = true;
  }
  wake_.notify_one();
}

void SculptThread::LeaveScene(const haptics::Scene& scene) {
  if (!HasSculptSession(scene)) return;
  const std::lock_guard lock(mutex_);
  Sculpted* sculpted = Find(scene);
  if (sculpted == nullptr || !sculpted->read) return;
  Poll(*sculpted);  // the last messages of the tick
  for (std::size_t n = 0; n < sculpted->benches.size(); ++n) {
    haptics::sculpt::SculptSession& sculpt_session = sculpted->sculpt_session(n);
    if (sculpted->broken) {
      sculpt_session.editor().publisher().SetReader(false);
      continue;
    }
    if (sculpt_session.editor().in_stroke()) sculpted->benches[n].edited = ++edits_;
    sculpt_session.SetReader(false);
    sculpt_session.editor().Publish();
  }
  sculpted->read = false;
}

void SculptThread::Remove(const haptics::Scene& scene) {
  if (!HasSculptSession(scene)) return;
  {
    const std::lock_guard lock(mutex_);
    if (Sculpted* sculpted = Find(scene)) CloseJournals(*sculpted);
    std::erase_if(scenes_, [&](const Sculpted& sculpted) { return sculpted.scene.get() == &scene; });
  }
  wake_.notify_one();
}

void SculptThread::Request(const SculptRequest& request, std::uint64_t owner) {
  {
    const std::lock_guard lock(mutex_);
    std::string why;
    const Sculpted* sculpted = Choose(request.client, owner, why);
    if (sculpted != nullptr && work_.size() >= kMaxWaiting) {
      why = std::to_string(kMaxWaiting) + " requests are already waiting; try again";
      sculpted = nullptr;
    }
    if (sculpted == nullptr) {
      answers_.push_back(AnswerTo(request));
      answers_.back().text = why;
      return;
    }
    work_.push_back({request, sculpted->scene});
  }
  wake_.notify_one();
}

// An edit may take some milliseconds: the control thread polls again a period later.
std::optional<SculptAnswer> SculptThread::PopAnswer() {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return std::nullopt;
  if (ended_ && thread_.joinable()) thread_.join();  // it has let go of the lock for good
  if (answers_.empty()) return std::nullopt;
  SculptAnswer answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

std::optional<SculptProblem> SculptThread::PopProblem() {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock() || problems_.empty()) return std::nullopt;
  SculptProblem problem = std::move(problems_.front());
  problems_.pop_front();
  return problem;
}

std::optional<SculptProblem> SculptThread::PopJournalNote() {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return std::nullopt;
  for (const Sculpted& sculpted : scenes_) {
    for (const Bench& bench : sculpted.benches) {
      std::optional<scene::JournalNote> note = bench.journal == nullptr ? std::nullopt : bench.journal->PopNote();
      if (note) return SculptProblem{sculpted.client, std::move(note->text), note->level};
    }
  }
  return std::nullopt;
}

void SculptThread::ConfirmSaved(const SculptAnswer& answer) {
  for (const auto& [journal, edits] : answer.saved) {
    journal->MarkSaved(edits);
    writer_.Write(journal);
  }
}

bool SculptThread::running() const {
  const std::lock_guard lock(mutex_);
  return thread_.joinable() && !ended_;
}

void SculptThread::Run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!scenes_.empty()) {
    for (Sculpted& sculpted : scenes_) {
      if (sculpted.read) Poll(sculpted);
    }
    const auto awake = [this] { return scenes_.empty() || !work_.empty(); };
    const bool read = std::any_of(scenes_.begin(), scenes_.end(), [](const Sculpted& s) { return s.read; });
    if (read) {
      wake_.wait_for(lock, kPeriod, awake);
    } else {
      const auto entered = [&] {
        return awake() || std::any_of(scenes_.begin(), scenes_.end(), [](const Sculpted& s) { return s.read; });
      };
      wake_.wait(lock, entered);
    }
    while (!work_.empty()) {
      const Work work = std::move(work_.front());
      work_.pop_front();
      Execute(work, lock);
    }
  }
  ended_ = true;
}

void SculptThread::Poll(Sculpted& sculpted) {
  for (std::size_t n = 0; n < sculpted.benches.size() && !sculpted.broken; ++n) {
    try {
      const haptics::sculpt::ServeReport served = sculpted.sculpt_session(n).Poll();
      if (served.ended > 0) sculpted.benches[n].edited = ++edits_;
      KeepOpenStroke(sculpted, n, served);
      if (!served.problem.empty()) Report(sculpted, n, served.problem);
    } catch (
        const std::exception& caught) {  // out of memory: the tick's surface stays, the one in progress may be torn
      sculpted.broken = true;
      Report(sculpted, n, std::string("cannot be sculpted any more (") + caught.what() + "); restart the application");
    }
  }
}

void SculptThread::KeepOpenStroke(Sculpted& sculpted, std::size_t n, const haptics::sculpt::ServeReport& served) {
  Bench& bench = sculpted.benches[n];
  if (served.messages > 0) bench.moved = true;
  if (bench.journal == nullptr || !bench.moved) return;
  const Clock::time_point now = Clock::now();
  if (served.begun > 0) bench.kept = now;
  if (now - bench.kept < kKeepOpenEvery) return;
  bench.kept = now;
  bench.moved = false;
  haptics::sculpt::SculptEditor& editor = sculpted.sculpt_session(n).editor();
  if (!editor.in_stroke()) return;
  bench.journal->Append(scene::RecordKind::kOpen, editor.OpenStep());
  writer_.Write(bench.journal);
}

void SculptThread::CloseJournals(Sculpted& sculpted) {
  for (std::size_t n = 0; n < sculpted.benches.size(); ++n) {
    JournalWriter::Journal journal = std::move(sculpted.benches[n].journal);
    if (journal == nullptr) continue;
    sculpted.sculpt_session(n).editor().SetLog({});
    writer_.Close(journal);
  }
}

void SculptThread::Report(Sculpted& sculpted, std::size_t n, const std::string& problem) {
  Bench& bench = sculpted.benches[n];
  const Clock::time_point now = Clock::now();
  if (problem == bench.problem && now - bench.reported < kSameProblemAfter) return;
  bench.problem = problem;
  bench.reported = now;
  if (problems_.size() == kMaxWaiting) problems_.pop_front();
  problems_.push_back({sculpted.client, sculpted.file + ": " + sculpted.name(n) + ": " + problem});
}

void SculptThread::Execute(const Work& work, std::unique_lock<std::mutex>& lock) {
  SculptAnswer answer = AnswerTo(work.request);
  Sculpted* sculpted = Find(*work.scene);
  try {
    if (sculpted == nullptr) {
      answer.text = "the application is gone";
    } else if (sculpted->broken) {
      answer.text = "an edit ran out of memory; restart the application";
    } else if (work.request.action == SculptAction::kEdits) {
      answer.text = Edits(*sculpted);
      answer.ok = true;
    } else if (work.request.action == SculptAction::kSave) {
      Save(*sculpted, lock, answer);
    } else if (work.request.action == SculptAction::kRelease) {
      Release(*sculpted, answer);
    } else {
      Step(*sculpted, work.request, answer);
    }
  } catch (const std::exception& caught) {
    if (!lock.owns_lock()) lock.lock();
    answer = AnswerTo(work.request);
    answer.text = caught.what();
  }
  answers_.push_back(std::move(answer));
}

// The surface is copied under the lock, written without it: the tick's strokes go on meanwhile.
void SculptThread::Save(const Sculpted& sculpted, std::unique_lock<std::mutex>& lock, SculptAnswer& answer) {
  const haptics::SceneInput saved = haptics::sculpt::SculptedScene(*sculpted.scene, *sculpted.scene->live());
  for (const Bench& bench : sculpted.benches) {
    if (bench.journal != nullptr) answer.saved.emplace_back(bench.journal, bench.journal->edits());
  }
  lock.unlock();
  WriteFile(saved, answer);
  lock.lock();
}

void SculptThread::Step(Sculpted& sculpted, const SculptRequest& request, SculptAnswer& answer) {
  const std::optional<std::size_t> n = Named(sculpted, request.object, answer.text);
  if (!n) return;
  haptics::sculpt::SculptEditor& editor = sculpted.sculpt_session(*n).editor();
  const bool undo = request.action == SculptAction::kUndo;
  const std::string who = std::string(sculpted.name(*n)) + ": ";
  if (editor.in_stroke()) {
    answer.text = who + kOpenStroke;
  } else if (!(undo ? editor.Undo() : editor.Redo())) {
    answer.text = who + (undo ? "nothing to undo" : "nothing to redo");
  } else {
    editor.Publish();
    sculpted.benches[*n].edited = ++edits_;
    answer.ok = true;
    answer.text = who + (undo ? "undone, " : "redone, ") + std::to_string(editor.undo_steps()) + " to undo, " +
                  std::to_string(editor.redo_steps()) + " to redo";
  }
}

// Of whatever is held: there is one pen.
void SculptThread::Release(const Sculpted& sculpted, SculptAnswer& answer) {
  for (std::size_t n = 0; n < sculpted.benches.size(); ++n) {
    haptics::sculpt::SculptSession& session = sculpted.sculpt_session(n);
    if (!session.editor().in_stroke()) continue;
    session.Release();
    answer.ok = true;
    answer.text += (answer.text.empty() ? "" : ", ") + std::string(sculpted.name(n)) + ": released";
  }
  if (!answer.ok) answer.text = "nothing is held";
}

std::string SculptThread::Edits(const Sculpted& sculpted) {
  nlohmann::json objects = nlohmann::json::array();
  for (std::size_t n = 0; n < sculpted.benches.size(); ++n) {
    haptics::sculpt::SculptEditor& editor = sculpted.sculpt_session(n).editor();
    const JournalWriter::Journal& journal = sculpted.benches[n].journal;
    const scene::JournalState kept = journal == nullptr ? scene::JournalState() : journal->state();
    objects.push_back({{"object", sculpted.object(n)},
                       {"name", sculpted.name(n)},
                       {"triangles", editor.mesh().triangle_count()},
                       {"strokes", editor.undo_steps()},
                       {"undone", editor.redo_steps()},
                       {"undo_bytes", editor.undo_bytes()},
                       {"page_bytes", editor.mesh().page_bytes()},
                       {"journal", kept.file},
                       {"journal_problem", kept.problem},
                       {"saved", kept.saved},
                       {"stroke_open", editor.in_stroke()}});
  }
  const nlohmann::json edits = {{"client", sculpted.client}, {"scene", sculpted.file}, {"objects", objects}};
  return edits.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::optional<std::size_t> SculptThread::Named(const Sculpted& sculpted, const std::string& object, std::string& why) {
  const auto& benches = sculpted.benches;
  if (object.empty()) {
    const auto last = std::max_element(benches.begin(), benches.end(),
                                       [](const Bench& a, const Bench& b) { return a.edited < b.edited; });
    return static_cast<std::size_t>(last - benches.begin());
  }
  std::vector<std::size_t> named, numbered;
  std::uint32_t index = 0;
  const auto [end, error] = std::from_chars(object.data(), object.data() + object.size(), index);
  const bool is_number = error == std::errc() && end == object.data() + object.size();
  std::string names;
  for (std::size_t n = 0; n < benches.size(); ++n) {
    if (object == sculpted.name(n)) named.push_back(n);
    if (is_number && index == sculpted.object(n)) numbered.push_back(n);
    names +=
        (n == 0 ? "\"" : ", \"") + std::string(sculpted.name(n)) + "\" (" + std::to_string(sculpted.object(n)) + ")";
  }
  if (named.size() == 1) return named[0];
  if (named.empty() && numbered.size() == 1) return numbered[0];
  why = named.empty()
            ? "no object \"" + object + "\" is sculpted; there are " + names
            : std::to_string(named.size()) + " objects are called \"" + object + "\"; give a number: " + names;
  return std::nullopt;
}

SculptThread::Sculpted* SculptThread::Find(const haptics::Scene& scene) {
  for (Sculpted& sculpted : scenes_) {
    if (sculpted.scene.get() == &scene) return &sculpted;
  }
  return nullptr;
}

// Of a client's scenes, the one it got last.
SculptThread::Sculpted* SculptThread::Choose(std::uint64_t client, std::uint64_t owner, std::string& why) {
  std::set<std::uint64_t> clients;
  for (const Sculpted& sculpted : scenes_) clients.insert(sculpted.client);
  if (client == 0) client = clients.count(owner) != 0 ? owner : (clients.size() == 1 ? *clients.begin() : 0);
  for (auto at = scenes_.rbegin(); at != scenes_.rend(); ++at) {
    if (at->client == client) return &*at;
  }
  if (clients.empty()) {
    why =
        "no application has a scene with a sculptable object; start one, or tag an object \"sculptable\" "
        "(docs/scenes.md)";
    return nullptr;
  }
  std::string names;
  for (const std::uint64_t id : clients) names += (names.empty() ? "" : ", ") + std::to_string(id);
  why = client == 0 ? "several applications have sculpted scenes; choose a client: " + names
                    : "client " + std::to_string(client) + " has no sculpted scene; these have: " + names;
  return nullptr;
}

}  // namespace omni::daemon
