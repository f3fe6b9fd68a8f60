// Models of the devices in the user's hands, which an application draws: the runtime's controller in the pen's hand has
// none while the pen owns that hand, since it lies on the desk. The pen itself has none yet.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/instance/records.h"

namespace omni::layer {

class Instance;

// A handle of the application's. Retired: made from an id that is no longer enumerated; such a model is never shown
// again [xrEnumerateInteractionRenderModelIdsEXT].
struct RenderModel {
  std::shared_ptr<Session> session;
  XrRenderModelIdEXT id_below = 0;
  std::vector<std::weak_ptr<Space>> spaces;
  bool retired = false;
};

class RenderModels {
 public:
  explicit RenderModels(Instance& instance) : instance_(instance) {}

  // XR_EXT_render_model, XR_EXT_interaction_render_model
  XrResult CreateRenderModelEXT(XrSession session, const XrRenderModelCreateInfoEXT* info, XrRenderModelEXT* model);
  XrResult DestroyRenderModelEXT(XrRenderModelEXT model);
  XrResult CreateRenderModelSpaceEXT(XrSession session, const XrRenderModelSpaceCreateInfoEXT* info, XrSpace* space);
  XrResult EnumerateInteractionRenderModelIdsEXT(XrSession session,
                                                 const XrInteractionRenderModelIdsEnumerateInfoEXT* info,
                                                 uint32_t capacity, uint32_t* count, XrRenderModelIdEXT* ids);
  XrResult EnumerateRenderModelSubactionPathsEXT(XrRenderModelEXT model,
                                                 const XrInteractionRenderModelSubactionPathInfoEXT* info,
                                                 uint32_t capacity, uint32_t* count, XrPath* paths);
  XrResult GetRenderModelPoseTopLevelUserPathEXT(XrRenderModelEXT model,
                                                 const XrInteractionRenderModelTopLevelUserPathGetInfoEXT* info,
                                                 XrPath* path);
  // XR_MSFT_controller_model
  XrResult GetControllerModelKeyMSFT(XrSession session, XrPath user_path, XrControllerModelKeyStateMSFT* state);
  // XR_FB_render_model
  XrResult EnumerateRenderModelPathsFB(XrSession session, uint32_t capacity, uint32_t* count,
                                       XrRenderModelPathInfoFB* paths);
  XrResult GetRenderModelPropertiesFB(XrSession session, XrPath path, XrRenderModelPropertiesFB* properties);

  // After each sync, the only moment at which the models change.
  void Follow(const std::shared_ptr<Session>& session);
  void EndOf(XrSession session);

  // XrEventDataInteractionRenderModelsChangedEXT: due by our own changes. The runtime's event says the same.
  bool PopChange() { return change_due_.exchange(false); }

 private:
  struct Known {                   // an id of the runtime's
    XrRenderModelIdEXT shown = 0;  // the id that the application knows; another one each time that the model returns
    XrRenderModelEXT probe = XR_NULL_HANDLE;  // ours, to ask for its hand
    bool hidden = false;
  };
  using Ids = std::map<XrRenderModelIdEXT, Known>;  // by the runtime's id

  XrPath PensHand(const Session& session) const;
  bool IsPensModelFB(XrSession session, XrPath path) const;
  XrResult IdsBelow(XrSession session, const XrInteractionRenderModelIdsEnumerateInfoEXT* info,
                    std::vector<XrRenderModelIdEXT>& ids) const;
  XrPath HandOf(XrSession session, XrRenderModelIdEXT id, Known& known) const;
  XrRenderModelIdEXT NewId();
  void Retire(XrSession session, XrRenderModelIdEXT id);
  std::optional<XrRenderModelIdEXT> Translate(XrSession session, XrRenderModelIdEXT id) const;

  Instance& instance_;
  mutable std::mutex mutex_;  // guards what follows, and RenderModel's members
  std::map<XrSession, Ids> ids_;
  XrRenderModelIdEXT last_id_ = 0x4F4D'4E49'0000'0000;  // far from any counter or address of a runtime's
  std::atomic<bool> change_due_{false};
};

}  // namespace omni::layer
