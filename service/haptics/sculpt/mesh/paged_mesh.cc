#include "service/haptics/sculpt/mesh/paged_mesh.h"

#include <bit>

#include "service/haptics/sculpt/mesh/trees.h"

namespace omni::haptics::sculpt {
namespace {

template <std::size_t N>
std::uint32_t TakeSlot(std::uint64_t (&used)[N]) noexcept {
  std::size_t word = 0;
  while (~used[word] == 0) ++word;
  const int bit = std::countr_one(used[word]);
  used[word] |= std::uint64_t{1} << bit;
  return static_cast<std::uint32_t>(64 * word + static_cast<std::size_t>(bit));
}

template <std::size_t N>
void GiveSlot(std::uint64_t (&used)[N], std::uint32_t slot) noexcept {
  used[slot / 64] &= ~(std::uint64_t{1} << (slot % 64));
}

}  // namespace

void PagedMesh::MakeWritable(std::uint32_t page) {
  Slot& slot = slots_[page];
  Page* old = pages_[page];
  pages_[page] = pool_.Take();
  std::memcpy(static_cast<void*>(pages_[page]), old, sizeof(Page));
  if (recording_ && slot.before == nullptr) {
    slot.before = old;
    slot.before_seen = !slot.writable;
    touched_.push_back(page);
  } else {
    pool_.Retire(old, publisher_.generation() + 1);
  }
  if (!slot.writable) dirty_.push_back(page);
  slot.writable = true;
}

std::uint32_t PagedMesh::NewPage(std::uint32_t near_page) {
  const auto page = static_cast<std::uint32_t>(pages_.size());
  pages_.push_back(pool_.Take());
  std::memcpy(static_cast<void*>(pages_.back()), &EmptyPage(), sizeof(Page));
  slots_.push_back({});
  slots_.back().writable = true;
  dirty_.push_back(page);
  unfitted_.push_back(page);
  if (page > 0) top_.Insert(near_page, FloatBox{});
  return page;
}

std::uint32_t PagedMesh::EmptyPageFor(std::uint32_t near_page) {
  while (!empty_.empty()) {
    const std::uint32_t page = empty_.back();
    empty_.pop_back();
    const PageContent& content = pages_[page]->content;
    if (content.triangle_count == 0 && content.vertex_count == 0) return page;
  }
  return NewPage(near_page);
}

// Follows the spill links; the last full page gets a new link.
template <class Full>
std::uint32_t PagedMesh::PageWithRoom(std::uint32_t page, Full full) {
  while (full(pages_[page]->content)) {
    std::uint32_t next = pages_[page]->content.spill;
    if (next == kNoIndex) {
      next = EmptyPageFor(page);
      Write(page).spill = next;
    }
    page = next;
  }
  return page;
}

std::uint32_t PagedMesh::AddTriangle(std::uint32_t near, const Triangle& triangle) {
  const std::uint32_t page =
      PageWithRoom(PageOf(near), [](const PageContent& c) { return c.triangle_count == kPageTriangles; });
  PageContent& content = Write(page);
  const std::uint32_t slot = TakeSlot(content.triangle_used);
  content.triangle[slot] = triangle;
  ++content.triangle_count;
  ++triangle_count_;
  slots_[page].keep_order = false;
  return IndexOf(page, slot);
}

std::uint32_t PagedMesh::AddVertex(std::uint32_t near, const Vec3& position) {
  const std::uint32_t page =
      PageWithRoom(PageOf(near), [](const PageContent& c) { return c.vertex_count == kPageVertices; });
  PageContent& content = Write(page);
  const std::uint32_t slot = TakeSlot(content.vertex_used);
  content.vertex[slot] = AsStored(position);
  ++content.vertex_count;
  ++vertex_count_;
  return IndexOf(page, slot);
}

void PagedMesh::RemoveTriangle(std::uint32_t t) {
  PageContent& content = Write(PageOf(t));
  GiveSlot(content.triangle_used, SlotOf(t));
  content.triangle[SlotOf(t)] = EmptyPage().content.triangle[0];
  --content.triangle_count;
  --triangle_count_;
  slots_[PageOf(t)].keep_order = false;
}

void PagedMesh::RemoveVertex(std::uint32_t v) {
  PageContent& content = Write(PageOf(v));
  GiveSlot(content.vertex_used, SlotOf(v));
  content.vertex[SlotOf(v)] = {};
  content.first_triangle[SlotOf(v)] = kNoIndex;
  --content.vertex_count;
  --vertex_count_;
}

void PagedMesh::BeginStep() { recording_ = true; }

UndoStep PagedMesh::StepSoFar() const {
  UndoStep step;
  for (const std::uint32_t page : touched_) {
    AppendRuns(page, slots_[page].before->content, pages_[page]->content, step);
  }
  return step;
}

UndoStep PagedMesh::EndStep() {
  UndoStep step = StepSoFar();
  for (const std::uint32_t page : touched_) {
    Slot& slot = slots_[page];
    if (slot.before_seen) {
      pool_.Retire(slot.before, publisher_.generation() + 1);
    } else {
      pool_.Give(slot.before);
    }
    slot.before = nullptr;
  }
  touched_.clear();
  recording_ = false;
  step.words.shrink_to_fit();
  return step;
}

void PagedMesh::CountAgain(std::uint32_t page, int sign) noexcept {
  triangle_count_ += static_cast<std::uint32_t>(sign) * pages_[page]->content.triangle_count;
  vertex_count_ += static_cast<std::uint32_t>(sign) * pages_[page]->content.vertex_count;
}

void PagedMesh::Apply(const UndoStep& step) {
  for (std::size_t i = 0; i < step.words.size();) {
    const StepRun run = RunOf(step.words[i++]);
    const std::uint32_t page = run.page;
    while (page >= pages_.size()) empty_.push_back(NewPage(page_count() - 1));  // those that were skipped stay empty
    PageContent& content = Write(page);
    CountAgain(page, -1);
    for (std::size_t k = 0; k < run.count; ++k) FlipWord(content, run.first + k, step.words[i++]);
    CountAgain(page, 1);
    if (run.count > 0) slots_[page].keep_order = false;
    if (content.triangle_count == 0 && content.vertex_count == 0) empty_.push_back(page);
  }
}

void PagedMesh::FitTree(std::uint32_t page) {
  Slot& slot = slots_[page];
  PageTree& tree = pages_[page]->tree;
  BuildPageTree(pages_.data(), page, slot.keep_order, tree);
  slot.keep_order = slot.fitted = true;
  top_.SetPageBox(page, BoxOf(tree));
}

void PagedMesh::FitTrees() {
  for (const std::uint32_t page : unfitted_) FitTree(page);
  unfitted_.clear();
}

void PagedMesh::FitChangedTrees() {
  std::erase_if(unfitted_, [this](std::uint32_t page) {
    if (slots_[page].keep_order) return false;
    FitTree(page);
    return true;
  });
}

PublishReport PagedMesh::Publish() {
  PublishReport report;
  if (dirty_.empty()) return report;
  SculptTable* table = publisher_.SpareTable();
  if (table == nullptr) return report;
  FitTrees();
  for (const std::uint32_t page : dirty_) slots_[page].writable = false;
  report.pages = static_cast<std::uint32_t>(dirty_.size());
  dirty_.clear();
  table->pages.assign(pages_.begin(), pages_.end());
  table->nodes.assign(top_.nodes().begin(), top_.nodes().end());
  const FloatBox bounds = top_.bounds();
  table->extent_m = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double largest_m = std::max(std::abs(bounds.lower[axis]), std::abs(bounds.upper[axis]));
    table->extent_m = std::max(table->extent_m, largest_m);
  }
  publisher_.Publish(table);
  pool_.Release(publisher_.OldestInUse());
  report.published = true;
  return report;
}

std::uint64_t PagedMesh::Hash() const noexcept {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  const auto mix = [&hash](std::uint64_t value) { hash = std::rotl((hash ^ value) * 0x9e3779b97f4a7c15ULL, 29); };
  for (std::uint32_t page = 0; page < page_count(); ++page) {
    const PageContent& content = pages_[page]->content;
    if (content.triangle_count == 0 && content.vertex_count == 0) continue;
    mix(page);
    for (std::size_t word = 0; word < kContentWords; ++word) mix(WordOf(content, word));
  }
  return hash;
}

}  // namespace omni::haptics::sculpt
