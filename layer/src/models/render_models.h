// Models of the devices in the user's hands, which an application draws: while the pen owns a hand, its own model
// (pen_model.h) is there instead of the runtime's controller of that hand, which lies on the desk. Works on runtimes
// without render models too: then every function below is answered here.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "layer/src/instance/runtime.h"
#include "layer/src/instance/session.h"

namespace omni::layer {

// A handle of the application's. Retired: made from an id that is no longer enumerated; such a model is never shown
// again [xrEnumerateInteractionRenderModelIdsEXT].
struct RenderModel {
  std::shared_ptr<Session> session;
  XrRenderModelIdEXT id_below = 0;  // 0: the pen's; the handle is then this record's address, and unknown below
  bool pens() const { return id_below == XR_NULL_RENDER_MODEL_ID_EXT; }
  std::vector<std::weak_ptr<Space>> spaces;
  bool retired = false;
};

// The pen's model as a file. The runtime's have no record.
struct RenderModelAsset {
  std::shared_ptr<Session> session;
};

class RenderModels {
 public:
  RenderModels(const Runtime& runtime, Records& records, ServiceLink& link)
      : runtime_(runtime), records_(records), link_(link) {}

  bool Contains(XrRenderModelEXT model) const { return handles_.Contains(model); }
  bool Contains(XrRenderModelAssetEXT asset) const { return assets_.Contains(asset); }

  // XR_EXT_render_model, XR_EXT_interaction_render_model
  XrResult CreateRenderModelEXT(XrSession session, const XrRenderModelCreateInfoEXT* info, XrRenderModelEXT* model);
  XrResult DestroyRenderModelEXT(XrRenderModelEXT model);
  XrResult GetRenderModelPropertiesEXT(XrRenderModelEXT model, const XrRenderModelPropertiesGetInfoEXT* info,
                                       XrRenderModelPropertiesEXT* properties);
  XrResult GetRenderModelStateEXT(XrRenderModelEXT model, const XrRenderModelStateGetInfoEXT* info,
                                  XrRenderModelStateEXT* state);
  XrResult CreateRenderModelAssetEXT(XrSession session, const XrRenderModelAssetCreateInfoEXT* info,
                                     XrRenderModelAssetEXT* asset);
  XrResult DestroyRenderModelAssetEXT(XrRenderModelAssetEXT asset);
  XrResult GetRenderModelAssetDataEXT(XrRenderModelAssetEXT asset, const XrRenderModelAssetDataGetInfoEXT* info,
                                      XrRenderModelAssetDataEXT* data);
  XrResult GetRenderModelAssetPropertiesEXT(XrRenderModelAssetEXT asset,
                                            const XrRenderModelAssetPropertiesGetInfoEXT* info,
                                            XrRenderModelAssetPropertiesEXT* properties);
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
  void UpdateAfterSync(const std::shared_ptr<Session>& session);
  void EndOf(XrSession session);

  // XrEventDataInteractionRenderModelsChangedEXT: due by our own changes. The runtime's event says the same.
  bool PopChange() { return change_due_.exchange(false); }

 private:
  struct Known {                   // an id of the runtime's
    XrRenderModelIdEXT shown = 0;  // the id that the application knows; another one each time that the model returns
    XrRenderModelEXT probe = XR_NULL_HANDLE;  // ours, to ask for its hand
    bool hidden = false;
  };
  struct Models {                               // of one session
    std::map<XrRenderModelIdEXT, Known> below;  // by the runtime's id; of the last sync
    bool followed = false;                      // the pen was there once: until then the runtime alone answers
    XrRenderModelIdEXT pen = 0;                 // 0: not enumerated
    bool pen_identified = false;                // the application has the pen's cacheId from this session
    std::set<XrRenderModelIdEXT> made;          // by us: the pen's, and those that stand for one of the runtime's
    std::set<XrRenderModelIdEXT> seen_below;    // the runtime's, all so far
  };

  XrPath PensHand(const Session& session) const;
  bool IsPensModelFB(XrSession session, XrPath path) const;
  XrResult IdsBelow(XrSession session, const XrInteractionRenderModelIdsEnumerateInfoEXT* info,
                    std::vector<XrRenderModelIdEXT>& ids) const;
  XrPath HandOf(XrSession session, XrRenderModelIdEXT id, Known& known) const;
  XrRenderModelIdEXT NewId(Models& models);
  void FollowBelow(XrSession session, const std::vector<XrRenderModelIdEXT>& below, XrPath pens_hand, Models& models);
  void FollowPen(XrSession session, bool owns_hand, Models& models);
  void Retire(XrSession session, XrRenderModelIdEXT id_below);
  std::optional<XrRenderModelIdEXT> Translate(XrSession session, XrRenderModelIdEXT id) const;
  XrRenderModelEXT CreatePen(const std::shared_ptr<Session>& session);
  XrResult CreatePenSpace(const RenderModel& model, XrSpace* space) const;
  std::shared_ptr<RenderModel> FindPen(XrRenderModelEXT model) const;
  XrResult CheckUserPaths(const XrInteractionRenderModelTopLevelUserPathGetInfoEXT* info, const XrPath* path) const;

  const Runtime& runtime_;
  Records& records_;
  ServiceLink& link_;
  HandleMap<XrRenderModelEXT, RenderModel> handles_;
  HandleMap<XrRenderModelAssetEXT, RenderModelAsset> assets_;
  mutable std::mutex mutex_;  // guards what follows, and RenderModel's members
  std::map<XrSession, Models> sessions_;
  XrRenderModelIdEXT last_id_ = 0x4F4D'4E49'0000'0000;  // far from any counter or address of a runtime's
  std::atomic<bool> change_due_{false};
};

}  // namespace omni::layer
