#include "service/scene/journal/sculpt_journal.h"

#include <utility>

#include "service/haptics/live/live_parts.h"
#include "service/scene/journal/journal_folder.h"

namespace omni::scene {
namespace {

using haptics::sculpt::SculptEditor;

// Of an editor that has not edited.
haptics::sculpt::UndoStep RestOf(const SculptEditor& editor) {
  haptics::sculpt::UndoStep rest;
  for (std::uint32_t page = 0; page < editor.mesh().page_count(); ++page) {
    AppendRuns(page, haptics::sculpt::EmptyPage().content, editor.mesh().GetPage(page).content, rest);
  }
  return rest;
}

JournalHead HeadOf(const haptics::Scene& scene, std::uint32_t index, const SculptEditor& editor,
                   const JournalPlace& place) {
  const haptics::Object& object = scene.objects()[index];
  JournalHead head;
  head.identity = editor.mesh().Hash();
  head.application = place.application;
  head.scene = place.file;
  head.object = object.name;
  head.car_wall = (object.flags & haptics::kCarWall) != 0;
  head.materials = LimitsOf(TableOf(editor.mesh()).data(), editor.mesh().page_count()).materials;
  std::vector<haptics::Material> materials;
  for (const std::uint16_t m : head.materials) materials.push_back(scene.materials()[m]);
  head.materials_glb = MaterialsGlb(materials);
  return head;
}

// Two objects of one name: each has its own journal.
std::string NameWithin(const haptics::Scene& scene, std::uint32_t index) {
  const std::string name = scene.objects()[index].name;
  for (std::uint32_t i = 0; i < scene.objects().size(); ++i) {
    if (i != index && name == scene.objects()[i].name) return name + " (" + std::to_string(index) + ")";
  }
  return name;
}

}  // namespace

std::vector<std::shared_ptr<SculptJournal>> RestoreJournals(const haptics::Scene& scene, const JournalPlace& place,
                                                            std::vector<JournalNote>& notes) {
  std::vector<std::shared_ptr<SculptJournal>> journals;
  if (place.folder.empty() || scene.live() == nullptr) return journals;
  const auto until = std::chrono::steady_clock::now() + place.patience;  // for all of them
  for (std::uint32_t n = 0; n < scene.live()->sculpt_session_count(); ++n) {
    const std::uint32_t index = scene.live()->object_at(n);
    SculptEditor& editor = scene.live()->sculpt_session_at(n).editor();
    JournalHead head = HeadOf(scene, index, editor, place);
    head.object = NameWithin(scene, index);
    const std::string who = place.file + ": " + head.object + ": ";
    journals.push_back(std::make_shared<SculptJournal>(place.folder, std::move(head), RestOf(editor), place.limits));
    SculptJournal& journal = *journals.back();
    const std::optional<JournalContent> content = journal.Find(until, notes);
    if (!content) continue;
    if (const base::Status restored = editor.Restore(content->Closed()); !restored.ok()) {
      journal.PutAside("damaged", restored.error(), notes);
      continue;
    }
    editor.Publish();
    journal.Resume(*content);
    const std::string strokes = std::to_string(content->strokes()) + (content->strokes() == 1 ? " stroke" : " strokes");
    notes.push_back({0, who + "restored " + strokes + " from " + JournalTimeText(content->time_s)});
    if (!content->damage.empty()) {
      notes.push_back({1, who + "the journal of its strokes is " + content->damage + "; what follows there is lost"});
    }
  }
  return journals;
}

}  // namespace omni::scene
