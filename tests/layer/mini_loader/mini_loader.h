// A minimal OpenXR loader in this process: negotiates with layers and runtime, and chains them. For what
// Debian's loader 1.0.20 cannot do: applications of OpenXR 1.1, several instances at once, and calls that reach the
// layer unchecked, where that loader would reject null handles and names itself.
#pragma once

#include <string>
#include <vector>

#include "layer/src/entry/loader_interface.h"
#include "tests/runtime/entry_points.h"

namespace omni::test {

struct LayerFile {
  std::string name;
  std::string library;
};
// This build's layer, as the manifest in XR_API_LAYER_PATH names it.
LayerFile OmniLayer();
// tests/layer/other_layer.
LayerFile OtherLayer();

// What an application gets of an instance; nullptr where the chain has no such function.
struct Functions {
#define OMNI_FUNCTION(name) PFN_xr##name name = nullptr;
  OMNI_RUNTIME_FUNCTIONS(OMNI_FUNCTION)
#undef OMNI_FUNCTION
};

class MiniLoader {
 public:
  // The first layer is the closest to the application; none: the bare runtime. Throws std::runtime_error with the
  // library's name where a layer cannot be opened or does not negotiate.
  explicit MiniLoader(const std::vector<LayerFile>& layers);
  ~MiniLoader();  // closes the libraries: destroy all instances first
  MiniLoader(const MiniLoader&) = delete;
  MiniLoader& operator=(const MiniLoader&) = delete;

  XrResult CreateInstance(const XrInstanceCreateInfo& info, XrInstance* instance) const;
  PFN_xrVoidFunction Get(XrInstance instance, const char* name) const;
  Functions Load(XrInstance instance) const;

 private:
  struct Link {
    std::string name;
    void* library = nullptr;
    PFN_xrGetInstanceProcAddr get = nullptr;
    PFN_xrCreateApiLayerInstance create = nullptr;
  };
  static Link Open(const LayerFile& layer);
  std::vector<Link> links_;
};

}  // namespace omni::test
