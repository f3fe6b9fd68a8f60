#include "tests/support/touch/fresh_scene.h"

#include "service/haptics/live/make_live.h"

namespace omni::test {

haptics::Scene FreshCopy(const haptics::Scene& scene) {
  haptics::Scene fresh = scene;
  if (scene.live() == nullptr || scene.live()->sculpt_session_count() == 0) return fresh;
  fresh.SetLive(nullptr);
  for (const std::uint32_t object : MakeLive(fresh).soft) {
    if (const haptics::SoftBody* body = scene.live()->soft_body(object)) {
      fresh.live()->SetSoftBody(object, std::make_unique<const haptics::SoftBody>(*body));
    }
  }
  return fresh;
}

FreshScene::FreshScene(const haptics::Scene& original) : original_(original), scene_(&original) { Renew(); }

FreshScene::~FreshScene() { Drop(); }

void FreshScene::Renew() {
  if (original_.live() == nullptr || original_.live()->sculpt_session_count() == 0) return;
  Drop();
  copy_ = std::make_shared<const haptics::Scene>(FreshCopy(original_));
  scene_ = copy_.get();
  editor_.Add(1, "the scene", copy_);
  editor_.EnterScene(*copy_);
}

void FreshScene::Drop() {
  if (copy_ == nullptr) return;
  editor_.LeaveScene(*copy_);
  editor_.Remove(*copy_);
  copy_ = nullptr;
}

}  // namespace omni::test
