#include "service/scene/journal/journal_format.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>

#include "service/base/sealed_memory.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/glb_save.h"
#include "service/scene/scene_file.h"

namespace omni::scene {
namespace {

using base::Error;
using haptics::kNoIndex;
using haptics::sculpt::Page;
using haptics::sculpt::PageContent;
using haptics::sculpt::UndoStep;

static_assert(std::endian::native == std::endian::little);
// Other pages, another meaning of every step: raise kJournalVersion.
static_assert(kJournalVersion == 1 && sizeof(PageContent) == 12744);

constexpr std::string_view kJournalMagic = "OMNICLAY";
constexpr std::size_t kMaxName = 4096;
constexpr std::size_t kMaxMaterials = 4096;
constexpr std::size_t kMaxMaterialsGlb = 4u << 20;
constexpr double kSpacing_m = 1e-3;  // of the triangles in MaterialsGlb

struct RecordHeader {
  RecordKind kind;
  std::uint32_t number;  // in the file, from 0
  std::uint64_t bytes;   // of the payload
  std::int64_t time_s;
  std::uint64_t checksum;  // of the record with 0 here
};
static_assert(sizeof(RecordHeader) == kRecordHeaderBytes);

std::uint64_t ChecksumOfText(std::string_view text) {
  return ChecksumOfBlock(std::as_bytes(std::span(text.data(), text.size())));
}

// Of the record at the beginning of `bytes`; none: it is not there as a whole, or it was changed.
std::optional<RecordHeader> ReadHeader(std::string_view bytes) {
  RecordHeader header{};
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.bytes > bytes.size() - sizeof header) return std::nullopt;
  std::string record(bytes.substr(0, sizeof header + header.bytes));
  const std::uint64_t none = 0;
  std::memcpy(record.data() + offsetof(RecordHeader, checksum), &none, sizeof none);
  if (ChecksumOfText(record) != header.checksum) return std::nullopt;
  return header;
}

template <class T>
void PutValue(const T& value, std::string& to) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void PutText(std::string_view text, std::size_t most, std::string& to) {
  text = text.substr(0, most);
  PutValue(static_cast<std::uint32_t>(text.size()), to);
  to += text;
}

// Takes values from the front of bytes; after the first that is not there, nothing.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : bytes_(bytes) {}
  bool ok() const { return ok_; }
  bool AtEnd() const { return ok_ && bytes_.empty(); }

  std::string_view Take(std::size_t count) {
    ok_ = ok_ && count <= bytes_.size();
    if (!ok_) return {};
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  template <class T>
  T Value() {
    T value{};
    if (const std::string_view taken = Take(sizeof(T)); ok_) std::memcpy(&value, taken.data(), sizeof(T));
    return value;
  }
  std::string Text(std::size_t most) {
    const auto size = Value<std::uint32_t>();
    ok_ = ok_ && size <= most;
    return std::string(Take(ok_ ? size : 0));
  }

 private:
  std::string_view bytes_;
  bool ok_ = true;
};

// Empty: not of whole words.
UndoStep StepFrom(std::string_view payload) {
  UndoStep step;
  if (payload.size() % sizeof(std::uint64_t) != 0) return step;
  step.words.resize(payload.size() / sizeof(std::uint64_t));
  if (!payload.empty()) std::memcpy(step.words.data(), payload.data(), payload.size());
  return step;
}

std::optional<JournalHead> HeadFrom(std::string_view payload) {
  FieldReader reader(payload);
  if (reader.Take(kJournalMagic.size()) != kJournalMagic || reader.Value<std::uint32_t>() != kJournalVersion)
    return std::nullopt;
  JournalHead head;
  head.identity = reader.Value<std::uint64_t>();
  head.car_wall = reader.Value<std::uint8_t>() != 0;
  for (std::string* text : {&head.application, &head.scene, &head.object}) *text = reader.Text(kMaxName);
  const auto count = reader.Value<std::uint32_t>();
  if (count > kMaxMaterials) return std::nullopt;
  for (std::uint32_t k = 0; k < count; ++k) head.materials.push_back(reader.Value<std::uint16_t>());
  head.materials_glb = reader.Text(kMaxMaterialsGlb);
  if (!reader.AtEnd()) return std::nullopt;
  return head;
}

// One record after another; `damage` says what ends it.
class Parser {
 public:
  explicit Parser(std::string_view bytes) : bytes_(bytes) {}

  base::Result<JournalContent> Run() {
    for (std::string_view rest = bytes_; !rest.empty() && content_.damage.empty();) {
      const std::optional<RecordHeader> header = ReadHeader(rest);
      if (!header || header->number != content_.records) {
        content_.damage = "torn or damaged after " + std::to_string(content_.good_bytes) + " bytes";
        break;
      }
      const std::string_view payload = rest.substr(kRecordHeaderBytes, header->bytes);
      if (const char* problem = TakeRecord(*header, payload); problem != nullptr) {
        content_.damage = "record " + std::to_string(content_.records) + ": " + problem;
        break;
      }
      if (content_.records++ == 0) content_.begun_s = header->time_s;
      content_.time_s = header->time_s;
      content_.good_bytes += kRecordHeaderBytes + header->bytes;
      rest.remove_prefix(kRecordHeaderBytes + header->bytes);
    }
    if (content_.records >= 2) return std::move(content_);
    return Error{content_.damage.empty() ? "is empty" : content_.damage};
  }

 private:
  // Null: taken.
  const char* TakeRecord(const RecordHeader& header, std::string_view payload) {
    haptics::sculpt::EditHistory& edits = content_.edits;
    if ((content_.records < 2) != (header.kind == RecordKind::kHead || header.kind == RecordKind::kRest)) {
      return "not where it belongs";
    }
    if (header.kind != RecordKind::kHead && payload.size() % sizeof(std::uint64_t) != 0) return "not of whole words";
    if (header.kind != RecordKind::kSaved && header.kind != RecordKind::kClose) content_.saved = content_.records < 2;
    switch (header.kind) {
      case RecordKind::kHead: {
        std::optional<JournalHead> head = HeadFrom(payload);
        if (content_.records != 0 || !head) return "not the head of a journal of this version";
        content_.head = std::move(*head);
        return nullptr;
      }
      case RecordKind::kRest:
        content_.rest = StepFrom(payload);
        return content_.records == 1 ? nullptr : "not where it belongs";
      case RecordKind::kBase: {
        const UndoStep step = StepFrom(payload);
        if (step.words.empty()) return "empty";
        content_.merged += static_cast<std::int32_t>(step.words[0]);
        if (content_.merged < 0) return "an undo too many";
        edits.base.words.insert(edits.base.words.end(), step.words.begin() + 1, step.words.end());
        return nullptr;
      }
      case RecordKind::kStroke:
        content_.open.reset();
        edits.Push(StepFrom(payload));
        return nullptr;
      case RecordKind::kOpen:
        content_.open = StepFrom(payload);
        return nullptr;
      case RecordKind::kClose:
        if (!content_.open) return "no stroke to close";
        edits.Push(std::move(*content_.open));
        content_.open.reset();
        return nullptr;
      case RecordKind::kUndo:
        if (edits.done == 0) return "an undo too many";
        --edits.done;
        return nullptr;
      case RecordKind::kRedo:
        if (edits.done == edits.steps.size()) return "a redo too many";
        ++edits.done;
        return nullptr;
      case RecordKind::kSaved:
        content_.saved = true;
        return nullptr;
    }
    return "of an unknown kind";
  }

  std::string_view bytes_;
  JournalContent content_;
};

void ApplyTo(std::vector<std::unique_ptr<Page>>& pages, const UndoStep& step) {
  for (std::size_t i = 0; i < step.words.size();) {
    const haptics::sculpt::StepRun run = haptics::sculpt::RunOf(step.words[i++]);
    while (run.page >= pages.size()) pages.push_back(std::make_unique<Page>(haptics::sculpt::EmptyPage()));
    for (std::size_t k = 0; k < run.count; ++k) FlipWord(pages[run.page]->content, run.first + k, step.words[i++]);
  }
}

std::vector<const Page*> TableOf(const std::vector<std::unique_ptr<Page>>& pages) {
  std::vector<const Page*> table;
  table.reserve(pages.size());
  for (const std::unique_ptr<Page>& page : pages) table.push_back(page.get());
  return table;
}

}  // namespace

std::string MaterialsGlb(const std::vector<haptics::Material>& materials) {
  haptics::SceneInput scene;
  haptics::InputObject& object = scene.objects.emplace_back();
  object.name = "materials";
  for (std::size_t k = 0; k < std::min(materials.size(), kMaxMaterials); ++k) {
    const double x_m = kSpacing_m * static_cast<double>(k), z_m = 0.05;
    const auto first = static_cast<std::uint32_t>(object.vertices_base_m.size());
    object.vertices_base_m.insert(object.vertices_base_m.end(),
                                  {{x_m, 0, z_m}, {x_m + kSpacing_m / 2, 0, z_m}, {x_m, kSpacing_m / 2, z_m}});
    object.triangles.push_back({first, first + 1, first + 2});
    object.triangle_material.push_back(static_cast<std::uint16_t>(k));
    scene.materials.emplace_back(materials[k]).ForgetImages();
  }
  const base::Result<std::string> glb = GlbBytes(scene);
  return glb.ok() ? *glb : std::string();
}

base::Result<std::vector<haptics::Material>> MaterialsOf(const std::string& glb) {
  const base::Result<base::UniqueFd> memory = base::SealedCopy("omni-materials", glb);
  if (!memory.ok()) return Error{memory.error()};
  LoadReport report;
  const auto loaded = LoadSceneFile("materials.glb", {.memory = memory->get()}, report);
  if (!loaded.ok()) return Error{loaded.error()};
  std::vector<haptics::Material> materials;
  for (const haptics::InputObject& object : loaded->objects) {
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
      const double place = std::floor(object.vertices_base_m[object.triangles[t][0]].x / kSpacing_m + 0.1);
      const std::uint16_t material = object.triangle_material[t];
      if (!(place >= 0 && place < static_cast<double>(kMaxMaterials)) || material >= loaded->materials.size()) continue;
      const auto k = static_cast<std::size_t>(place);
      if (materials.size() <= k) materials.resize(k + 1);
      materials[k] = loaded->materials[material];
      materials[k].ForgetImages();
    }
  }
  return materials;
}

std::string RecordBytes(RecordKind kind, std::uint32_t number, std::int64_t time_s, std::string_view payload) {
  RecordHeader header{kind, number, payload.size(), time_s, 0};
  std::string record(reinterpret_cast<const char*>(&header), sizeof header);
  record += payload;
  header.checksum = ChecksumOfText(record);
  std::memcpy(record.data(), &header, sizeof header);
  return record;
}

std::string HeadPayload(const JournalHead& head) {
  std::string payload(kJournalMagic);
  PutValue(kJournalVersion, payload);
  PutValue(head.identity, payload);
  PutValue(static_cast<std::uint8_t>(head.car_wall ? 1 : 0), payload);
  for (const std::string* text : {&head.application, &head.scene, &head.object}) PutText(*text, kMaxName, payload);
  PutValue(static_cast<std::uint32_t>(std::min(head.materials.size(), kMaxMaterials)), payload);
  for (std::size_t k = 0; k < std::min(head.materials.size(), kMaxMaterials); ++k) PutValue(head.materials[k], payload);
  PutText(head.materials_glb, kMaxMaterialsGlb, payload);
  return payload;
}

std::string BasePayload(std::int64_t strokes, const UndoStep& step) {
  std::string payload;
  PutValue(strokes, payload);
  return payload += StepPayload(step);
}

haptics::sculpt::EditHistory JournalContent::Closed() const {
  haptics::sculpt::EditHistory closed = edits;
  if (open) closed.Push(*open);
  return closed;
}

base::Result<JournalContent> ParseJournal(std::string_view bytes) { return Parser(bytes).Run(); }

bool EndsSaved(std::string_view last_bytes) {
  if (last_bytes.size() < kRecordHeaderBytes) return false;
  const std::optional<RecordHeader> header = ReadHeader(last_bytes.substr(last_bytes.size() - kRecordHeaderBytes));
  return header && header->kind == RecordKind::kSaved && header->bytes == 0;
}

base::Result<haptics::SceneInput> SculptedByJournal(const JournalContent& content) {
  const haptics::sculpt::EditHistory edits = content.Closed();
  // A page that is not empty takes more words than this.
  auto pages =
      static_cast<std::uint32_t>(std::min<std::size_t>(haptics::sculpt::kMaxPages, content.rest.words.size() / 16));
  bool well_formed = IsWellFormed(content.rest, pages) && IsWellFormed(edits.base, pages);
  for (std::size_t i = 0; i < edits.done; ++i) well_formed = well_formed && IsWellFormed(edits.steps[i], pages);
  if (!well_formed) return Error{"an edit names pages that there are not"};
  std::vector<std::unique_ptr<Page>> states;
  ApplyTo(states, content.rest);
  std::vector<const Page*> table = TableOf(states);
  const haptics::sculpt::PageLimits limits =
      haptics::sculpt::LimitsOf(table.data(), static_cast<std::uint32_t>(table.size()));
  ApplyTo(states, edits.base);
  for (std::size_t i = 0; i < edits.done; ++i) ApplyTo(states, edits.steps[i]);
  table = TableOf(states);
  const auto count = static_cast<std::uint32_t>(table.size());
  const std::string problem = ProblemWithPages(table.data(), count, limits);
  if (!problem.empty()) return Error{"the edits do not lead to a surface: " + problem};
  haptics::Mesh mesh = SnapshotOf(haptics::sculpt::PageView(table.data()), count);

  base::Result<std::vector<haptics::Material>> materials = MaterialsOf(content.head.materials_glb);
  if (!materials.ok()) return Error{materials.error()};
  haptics::SceneInput scene;
  scene.name = content.head.scene;
  scene.materials = std::move(*materials);
  const auto& names = content.head.materials;
  for (std::uint16_t& material : mesh.material) {
    const auto at = std::find(names.begin(), names.end(), material) - names.begin();
    if (static_cast<std::size_t>(at) >= std::min(names.size(), scene.materials.size())) {
      return Error{"a triangle has a material that is not in the journal"};
    }
    material = static_cast<std::uint16_t>(at);
  }
  haptics::InputObject& object = scene.objects.emplace_back();
  object.name = content.head.object;
  object.vertices_base_m = std::move(mesh.vertices);
  object.triangles = std::move(mesh.triangles);
  object.triangle_material = std::move(mesh.material);
  object.car_wall = content.head.car_wall;
  return scene;
}

}  // namespace omni::scene
