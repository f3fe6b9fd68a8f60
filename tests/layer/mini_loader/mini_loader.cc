#include "tests/layer/mini_loader/mini_loader.h"

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "tests/runtime/negotiation.h"

extern "C" XrResult xrNegotiateLoaderRuntimeInterface(const omni::runtime::NegotiateLoaderInfo* loader,
                                                      omni::runtime::NegotiateRuntimeRequest* request);

namespace omni::test {
namespace {

const XrVersion kNewestApi = XR_MAKE_VERSION(1, 0x3ff, 0xfff);  // as the loaders of today say it

PFN_xrGetInstanceProcAddr NegotiateWithRuntime() {
  const runtime::NegotiateLoaderInfo loader{runtime::kLoaderInfoType, 1,         sizeof(loader), 1, 1,
                                            XR_MAKE_VERSION(1, 0, 0), kNewestApi};
  runtime::NegotiateRuntimeRequest request{};
  request.struct_type = runtime::kRuntimeRequestType;
  request.struct_version = 1;
  request.struct_size = sizeof(request);
  if (xrNegotiateLoaderRuntimeInterface(&loader, &request) != XR_SUCCESS)
    throw std::runtime_error("the test runtime does not negotiate");
  return request.get_instance_proc_addr;
}

PFN_xrGetInstanceProcAddr RuntimeGet() {
  static const PFN_xrGetInstanceProcAddr get = NegotiateWithRuntime();
  return get;
}

// The end of the chain.
XRAPI_ATTR XrResult XRAPI_CALL CreateInRuntime(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo*,
                                               XrInstance* instance) {
  PFN_xrVoidFunction create = nullptr;
  const XrResult result = RuntimeGet()(XR_NULL_HANDLE, "xrCreateInstance", &create);
  return XR_FAILED(result) ? result : reinterpret_cast<PFN_xrCreateInstance>(create)(info, instance);
}

LayerFile FromManifest(const std::string& file) {
  const char* folders = std::getenv("XR_API_LAYER_PATH");
  std::istringstream list(folders ? folders : "");
  for (std::string folder; std::getline(list, folder, ':');) {
    std::ifstream in(folder + "/" + file);
    if (!in) continue;
    const nlohmann::json layer = nlohmann::json::parse(in).at("api_layer");
    return {layer.at("name"), layer.at("library_path")};
  }
  throw std::runtime_error("no " + file + " in XR_API_LAYER_PATH");
}

}  // namespace

LayerFile OmniLayer() { return FromManifest("XrApiLayer_omni.json"); }

LayerFile OtherLayer() { return {"XR_APILAYER_OMNI_other", OMNI_BINARY_DIR "/lib/libXrApiLayer_omni_other.so"}; }

MiniLoader::Link MiniLoader::Open(const LayerFile& layer) {
  Link link{layer.name, dlopen(layer.library.c_str(), RTLD_NOW | RTLD_LOCAL)};
  if (!link.library) throw std::runtime_error(dlerror());
  const auto negotiate =
      reinterpret_cast<XrResult(XRAPI_PTR*)(const XrNegotiateLoaderInfo*, const char*, XrNegotiateApiLayerRequest*)>(
          dlsym(link.library, "xrNegotiateLoaderApiLayerInterface"));
  const XrNegotiateLoaderInfo loader{XR_LOADER_INTERFACE_STRUCT_LOADER_INFO,
                                     kLoaderInfoVersion,
                                     sizeof(XrNegotiateLoaderInfo),
                                     1,
                                     1,
                                     XR_MAKE_VERSION(1, 0, 0),
                                     kNewestApi};
  XrNegotiateApiLayerRequest request{};
  request.structType = XR_LOADER_INTERFACE_STRUCT_API_LAYER_REQUEST;
  request.structVersion = kApiLayerRequestVersion;
  request.structSize = sizeof(request);
  if (!negotiate || negotiate(&loader, layer.name.c_str(), &request) != XR_SUCCESS) {
    dlclose(link.library);
    throw std::runtime_error(layer.library + " does not negotiate");
  }
  link.get = request.getInstanceProcAddr;
  link.create = request.createApiLayerInstance;
  return link;
}

MiniLoader::MiniLoader(const std::vector<LayerFile>& layers) {
  for (const LayerFile& layer : layers) links_.push_back(Open(layer));
}

MiniLoader::~MiniLoader() {
  for (const Link& link : links_) dlclose(link.library);
}

XrResult MiniLoader::CreateInstance(const XrInstanceCreateInfo& info, XrInstance* instance) const {
  if (links_.empty()) return CreateInRuntime(&info, nullptr, instance);
  std::vector<XrApiLayerNextInfo> next(links_.size());
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link* below = i + 1 < links_.size() ? &links_[i + 1] : nullptr;
    next[i].structType = XR_LOADER_INTERFACE_STRUCT_API_LAYER_NEXT_INFO;
    next[i].structVersion = kApiLayerNextInfoVersion;
    next[i].structSize = sizeof(XrApiLayerNextInfo);
    std::snprintf(next[i].layerName, sizeof(next[i].layerName), "%s", links_[i].name.c_str());
    next[i].nextGetInstanceProcAddr = below ? below->get : RuntimeGet();
    next[i].nextCreateApiLayerInstance = below ? below->create : &CreateInRuntime;
    next[i].next = below ? &next[i + 1] : nullptr;
  }
  XrApiLayerCreateInfo create{};
  create.structType = XR_LOADER_INTERFACE_STRUCT_API_LAYER_CREATE_INFO;
  create.structVersion = kApiLayerCreateInfoVersion;
  create.structSize = sizeof(create);
  create.nextInfo = next.data();
  return links_.front().create(&info, &create, instance);
}

PFN_xrVoidFunction MiniLoader::Get(XrInstance instance, const char* name) const {
  PFN_xrVoidFunction function = nullptr;
  const PFN_xrGetInstanceProcAddr get = links_.empty() ? RuntimeGet() : links_.front().get;
  return XR_SUCCEEDED(get(instance, name, &function)) ? function : nullptr;
}

Functions MiniLoader::Load(XrInstance instance) const {
  Functions f;
#define OMNI_LOAD(name) f.name = reinterpret_cast<PFN_xr##name>(Get(instance, "xr" #name));
  OMNI_RUNTIME_FUNCTIONS(OMNI_LOAD)
#undef OMNI_LOAD
  return f;
}

}  // namespace omni::test
