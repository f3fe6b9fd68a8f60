#include "tests/support/touch/fresh_scene.h"

#include "service/haptics/live/make_live.h"

namespace omni::test {

FreshScene::FreshScene(const haptics::Scene& original) : original_(original), scene_(&original) { Renew(); }

FreshScene::~FreshScene() { Drop(); }

void FreshScene::Renew() {
  if (original_.live() == nullptr || original_.live()->sculpt_session_count() == 0) return;
  Drop();
  copy_ = std::make_shared<const haptics::Scene>(haptics::FreshCopy(original_));
  scene_ = copy_.get();
  editor_.Add(1, "the scene", copy_);
  editor_.Enter(*copy_);
}

void FreshScene::Drop() {
  if (copy_ == nullptr) return;
  editor_.Leave(*copy_);
  editor_.Remove(*copy_);
  copy_ = nullptr;
}

}  // namespace omni::test
