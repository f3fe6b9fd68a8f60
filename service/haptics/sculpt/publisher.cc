#include "service/haptics/sculpt/publisher.h"

namespace omni::haptics::sculpt {

SculptTable* SculptPublisher::Spare() {
  const SculptTable* newest = current_.load(std::memory_order_relaxed);
  for (const std::unique_ptr<SculptTable>& table : tables_) {
    if (table.get() != newest && table->generation < OldestInUse()) return table.get();
  }
  if (tables_.size() == kMaxTables) return nullptr;
  tables_.push_back(std::make_unique<SculptTable>());
  return tables_.back().get();
}

}  // namespace omni::haptics::sculpt
