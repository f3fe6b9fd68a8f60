// The bytes of a sculpt journal: what a sculpted object was before the first stroke, and every edit since. A record at
// a time is appended; one that was torn, or damaged since, ends what is read. docs/decisions/0027.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/result.h"
#include "service/haptics/scene/scene_input.h"
#include "service/haptics/sculpt/sculpt_editor.h"

namespace omni::scene {

inline constexpr std::uint32_t kJournalVersion = 1;
inline constexpr std::uint64_t kMaxJournalBytes = 1ull << 30;  // longer files are not read

enum class RecordKind : std::uint32_t {
  kHead = 1,  // JournalHead; the first one
  kRest = 2,  // the second: what turns empty pages into those before the first stroke
  kBase = 3,  // how many strokes (a word), and what they changed, of those that cannot be undone; may come again
  kStroke = 4,
  kOpen = 5,   // what a stroke that goes on has changed so far; instead of an earlier one
  kClose = 6,  // what kOpen said was the whole stroke
  kUndo = 7,
  kRedo = 8,
  kSaved = 9,  // the client got the surface in a file
};

// What a journal applies to.
struct JournalHead {
  std::uint64_t identity = 0;              // PagedMesh::Hash before the first stroke
  std::string application, scene, object;  // names, for people and for finding it again
  bool car_wall = false;
  std::vector<std::uint16_t> materials;  // that triangles name, and ...
  std::string materials_glb;             // ... a .glb in which the n-th node has the n-th of them: MaterialsGlb
};

// One object per material, so that a file can carry haptic materials in the words that every scene file has for them.
std::string MaterialsGlb(const std::vector<haptics::Material>& materials);
base::Result<std::vector<haptics::Material>> MaterialsOf(const std::string& glb);

std::string RecordBytes(RecordKind kind, std::uint32_t number, std::int64_t time_s, std::string_view payload);
std::string HeadPayload(const JournalHead& head);
inline std::string_view StepPayload(const haptics::sculpt::UndoStep& step) {
  return {reinterpret_cast<const char*>(step.words.data()), step.bytes()};
}

std::string BasePayload(std::int64_t strokes, const haptics::sculpt::UndoStep& step);

struct JournalContent {
  JournalHead head;
  haptics::sculpt::UndoStep rest;
  haptics::sculpt::EditHistory edits;
  std::optional<haptics::sculpt::UndoStep> open;  // of the stroke that had not ended
  bool saved = true;                              // nothing has changed since it was saved, or at all
  std::int64_t merged = 0;                        // strokes in the base
  std::int64_t begun_s = 0, time_s = 0;           // first and last record, Unix time
  std::uint32_t records = 0;
  std::uint64_t good_bytes = 0;  // of whole records from the beginning
  std::string damage;            // why reading ended before the file did; empty: it did not

  std::uint64_t strokes() const { return static_cast<std::uint64_t>(merged) + edits.done + (open ? 1 : 0); }
  // With the stroke that had not ended as a whole one.
  haptics::sculpt::EditHistory Closed() const;
};

// Any bytes. Error: not even what the object was can be read.
base::Result<JournalContent> ParseJournal(std::string_view bytes);

// Whether the file's last record says that it was saved; by its last bytes.
inline constexpr std::size_t kRecordHeaderBytes = 32;
bool EndsSaved(std::string_view last_bytes);

// The surface with what the journal holds, and the materials it uses. Error: it does not lead to a sound one.
base::Result<haptics::SceneInput> SculptedByJournal(const JournalContent& content);

}  // namespace omni::scene
