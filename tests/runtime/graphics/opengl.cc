#include "tests/runtime/graphics/opengl.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>
#include <dlfcn.h>

#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_PLATFORM_XLIB
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <algorithm>
#include <bit>
#include <mutex>
#include <utility>

#include "tests/runtime/graphics/texels.h"
#include "tests/runtime/state.h"
#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

#define OMNI_GLX_FUNCTIONS(X) X(GetCurrentDisplay) X(GetCurrentDrawable) X(GetCurrentContext) X(MakeCurrent)
#define OMNI_GL_FUNCTIONS(X) \
  X(GenTextures)             \
  X(DeleteTextures)          \
  X(BindTexture)             \
  X(TexStorage2D)            \
  X(TexStorage3D)            \
  X(GetTexImage)             \
  X(GetIntegerv)             \
  X(PixelStorei)             \
  X(BindBuffer)              \
  X(GetError)

// Immutable textures are of OpenGL 4.2.
constexpr int kLeastMajor = 4;
constexpr int kLeastMinor = 2;
constexpr size_t kTexelBytes = 4;

struct Format {
  GLenum format;
  bool depth;
  bool srgb;
};
// The best first.
constexpr Format kFormats[] = {
    {GL_SRGB8_ALPHA8, false, true},       {GL_RGBA8, false, false},
    {GL_DEPTH_COMPONENT32F, true, false}, {GL_DEPTH_COMPONENT24, true, false},
    {GL_DEPTH_COMPONENT16, true, false},
};

const Format* FindFormat(int64_t number) {
  const auto* const found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                         [number](const Format& known) { return known.format == number; });
  return found == std::end(kFormats) ? nullptr : found;
}

// The application's context, and the functions of the library that it uses.
struct GlContext {
  Display* display = nullptr;
  GLXDrawable drawable = 0;
  GLXContext context = nullptr;
#define OMNI_MEMBER(name) decltype(&::glX##name) glX##name = nullptr;
  OMNI_GLX_FUNCTIONS(OMNI_MEMBER)
#undef OMNI_MEMBER
// NOLINTNEXTLINE(bugprone-macro-parentheses): a declaration
#define OMNI_MEMBER(name) decltype(&::gl##name) name = nullptr;
  OMNI_GL_FUNCTIONS(OMNI_MEMBER)
#undef OMNI_MEMBER

  bool Load() {
    void* const library = dlopen("libGLX.so.0", RTLD_NOW);  // never closed: the application has it open too
    if (library == nullptr) return false;
    const auto get = reinterpret_cast<decltype(&::glXGetProcAddress)>(dlsym(library, "glXGetProcAddress"));
    if (get == nullptr) return false;
    const auto load = [get](const char* name) { return get(reinterpret_cast<const GLubyte*>(name)); };
#define OMNI_LOAD(name) glX##name = reinterpret_cast<decltype(&::glX##name)>(load("glX" #name));
    OMNI_GLX_FUNCTIONS(OMNI_LOAD)
#undef OMNI_LOAD
#define OMNI_LOAD(name) name = reinterpret_cast<decltype(&::gl##name)>(load("gl" #name));
    OMNI_GL_FUNCTIONS(OMNI_LOAD)
#undef OMNI_LOAD
#define OMNI_AND(name) &&(name) != nullptr
#define OMNI_GLX_AND(name) &&glX##name != nullptr
    return true OMNI_GLX_FUNCTIONS(OMNI_GLX_AND) OMNI_GL_FUNCTIONS(OMNI_AND);
#undef OMNI_GLX_AND
#undef OMNI_AND
  }

  GLint Get(GLenum name) const {
    GLint value = 0;
    GetIntegerv(name, &value);
    return value;
  }
};

// The context is current in this thread, and afterwards whatever was.
class Current {
 public:
  explicit Current(const GlContext& gl)
      : gl_(gl),
        display_(gl.glXGetCurrentDisplay()),
        drawable_(gl.glXGetCurrentDrawable()),
        context_(gl.glXGetCurrentContext()) {
    ok_ = context_ == gl.context || gl.glXMakeCurrent(gl.display, gl.drawable, gl.context) == True;
  }
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;
  ~Current() {
    if (context_ == gl_.context) return;
    gl_.glXMakeCurrent(display_ == nullptr ? gl_.display : display_, drawable_, context_);
  }
  bool ok() const { return ok_; }

 private:
  const GlContext& gl_;
  Display* display_;
  GLXDrawable drawable_;
  GLXContext context_;
  bool ok_ = false;
};

// What kind of texture a swapchain's images are.
struct Target {
  GLenum target;
  GLenum binding;
  bool layered;
};
Target TargetOf(const XrSwapchainCreateInfo& info) {
  if (info.faceCount == 6) {
    if (info.arraySize > 1) return {GL_TEXTURE_CUBE_MAP_ARRAY, GL_TEXTURE_BINDING_CUBE_MAP_ARRAY, true};
    return {GL_TEXTURE_CUBE_MAP, GL_TEXTURE_BINDING_CUBE_MAP, false};
  }
  if (info.arraySize > 1) return {GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BINDING_2D_ARRAY, true};
  return {GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D, false};
}

class BoundTexture {
 public:
  BoundTexture(const GlContext& gl, const Target& target, GLuint texture)
      : gl_(gl), target_(target.target), before_(gl.Get(target.binding)) {
    gl.BindTexture(target_, texture);
  }
  BoundTexture(const BoundTexture&) = delete;
  BoundTexture& operator=(const BoundTexture&) = delete;
  ~BoundTexture() { gl_.BindTexture(target_, static_cast<GLuint>(before_)); }

 private:
  const GlContext& gl_;
  GLenum target_;
  GLint before_;
};

// How texels are written to memory: without gaps, and not into a buffer of the application.
class PlainPacking {
 public:
  explicit PlainPacking(const GlContext& gl) : gl_(gl), buffer_(gl.Get(GL_PIXEL_PACK_BUFFER_BINDING)) {
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    for (size_t i = 0; i < std::size(kNames); ++i) {
      before_[i] = gl.Get(kNames[i]);
      gl.PixelStorei(kNames[i], kNames[i] == GL_PACK_ALIGNMENT ? 1 : 0);
    }
  }
  PlainPacking(const PlainPacking&) = delete;
  PlainPacking& operator=(const PlainPacking&) = delete;
  ~PlainPacking() {
    for (size_t i = 0; i < std::size(kNames); ++i) gl_.PixelStorei(kNames[i], before_[i]);
    gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(buffer_));
  }

 private:
  static constexpr GLenum kNames[] = {GL_PACK_ALIGNMENT,  GL_PACK_ROW_LENGTH,  GL_PACK_IMAGE_HEIGHT,
                                      GL_PACK_SKIP_ROWS,  GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_IMAGES,
                                      GL_PACK_SWAP_BYTES, GL_PACK_LSB_FIRST};
  const GlContext& gl_;
  GLint buffer_;
  GLint before_[std::size(kNames)] = {};
};

class GlImages : public Images {
 public:
  GlImages(std::shared_ptr<const GlContext> gl, const XrSwapchainCreateInfo& info, const Format& format)
      : gl_(std::move(gl)), info_(info), format_(format) {}
  ~GlImages() override {
    const Current current(*gl_);
    if (current.ok()) gl_->DeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
  }

  // The context is current.
  bool Add(uint32_t count) {
    while (gl_->GetError() != GL_NO_ERROR) {
    }
    textures_.resize(count);
    gl_->GenTextures(static_cast<GLsizei>(count), textures_.data());
    const Target target = TargetOf(info_);
    const auto width = static_cast<GLsizei>(info_.width);
    const auto height = static_cast<GLsizei>(info_.height);
    const auto mips = static_cast<GLsizei>(info_.mipCount);
    for (const GLuint texture : textures_) {
      const BoundTexture bound(*gl_, target, texture);
      if (target.layered) {
        gl_->TexStorage3D(target.target, mips, format_.format, width, height,
                          static_cast<GLsizei>(info_.arraySize * info_.faceCount));
      } else {
        gl_->TexStorage2D(target.target, mips, format_.format, width, height);
      }
    }
    return gl_->GetError() == GL_NO_ERROR;
  }

  bool depth() const override { return format_.depth; }
  XrStructureType structure() const override { return XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR; }
  size_t structure_size() const override { return sizeof(XrSwapchainImageOpenGLKHR); }
  void Describe(uint32_t image, void* structure) const override {
    static_cast<XrSwapchainImageOpenGLKHR*>(structure)->image = textures_[image];
  }
  // OpenGL has no layouts.
  bool HandOver(uint32_t) override { return true; }

  // OpenGL's rows come from the bottom, and it reads whole textures.
  Picture Read(uint32_t image, uint32_t array_index, const XrRect2Di& rect) override {
    const size_t row = info_.width * kTexelBytes;
    std::vector<uint8_t> all(row * info_.height * info_.arraySize);
    {
      const Current current(*gl_);
      if (!current.ok()) return {};
      const Target target = TargetOf(info_);
      const PlainPacking packing(*gl_);
      const BoundTexture bound(*gl_, target, textures_[image]);
      gl_->GetTexImage(target.target, 0, GL_RGBA, GL_UNSIGNED_BYTE, all.data());
    }
    const auto width = static_cast<uint32_t>(rect.extent.width);
    const auto height = static_cast<uint32_t>(rect.extent.height);
    std::vector<uint8_t> part;
    part.reserve(size_t{width} * height * kTexelBytes);
    for (uint32_t y = height; y-- > 0;) {
      const size_t line = size_t{array_index} * info_.height + static_cast<uint32_t>(rect.offset.y) + y;
      const auto begin =
          all.begin() + static_cast<std::ptrdiff_t>(line * row + static_cast<uint32_t>(rect.offset.x) * kTexelBytes);
      part.insert(part.end(), begin, begin + static_cast<std::ptrdiff_t>(width * kTexelBytes));
    }
    return FromTexels(part.data(), width, height, format_.srgb, false);
  }

 private:
  std::shared_ptr<const GlContext> gl_;
  XrSwapchainCreateInfo info_;
  const Format& format_;
  std::vector<GLuint> textures_;
};

class OpenglGraphics : public Graphics {
 public:
  explicit OpenglGraphics(std::shared_ptr<const GlContext> gl) : gl_(std::move(gl)) {
    for (const Format& format : kFormats) formats_.push_back(format.format);
  }
  const std::vector<int64_t>& formats() const override { return formats_; }

  // Usages mean nothing to OpenGL.
  XrResult CreateImages(const XrSwapchainCreateInfo& info, uint32_t count,
                        std::unique_ptr<Images>* images) const override {
    const Current current(*gl_);
    OMNI_REQUIRE(current.ok(), XR_ERROR_RUNTIME_FAILURE);
    const auto most =
        static_cast<uint32_t>(gl_->Get(info.faceCount == 6 ? GL_MAX_CUBE_MAP_TEXTURE_SIZE : GL_MAX_TEXTURE_SIZE));
    const auto most_layers = static_cast<uint32_t>(gl_->Get(GL_MAX_ARRAY_TEXTURE_LAYERS));
    const auto most_mips = static_cast<uint32_t>(std::bit_width(std::max(info.width, info.height)));
    OMNI_REQUIRE(info.width <= most && info.height <= most && info.arraySize <= most_layers / info.faceCount &&
                     info.mipCount <= most_mips,
                 XR_ERROR_VALIDATION_FAILURE);
    auto made = std::make_unique<GlImages>(gl_, info, *FindFormat(info.format));
    OMNI_REQUIRE(made->Add(count), XR_ERROR_OUT_OF_MEMORY);
    *images = std::move(made);
    return XR_SUCCESS;
  }

 private:
  std::shared_ptr<const GlContext> gl_;
  std::vector<int64_t> formats_;
};

XrResult GetOpenGLGraphicsRequirements(XrInstance instance, XrSystemId system, XrGraphicsRequirementsOpenGLKHR* out) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(out, XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  out->minApiVersionSupported = XR_MAKE_VERSION(kLeastMajor, kLeastMinor, 0);
  out->maxApiVersionSupported = XR_MAKE_VERSION(4, 6, 0);
  owner->opengl_asked = true;
  return XR_SUCCESS;
}

}  // namespace

std::vector<GraphicsExtension> OpenglExtensions() {
  return {{XR_KHR_OPENGL_ENABLE_EXTENSION_NAME, XR_KHR_opengl_enable_SPEC_VERSION}};
}

PFN_xrVoidFunction FindOpenglFunction(const Instance& instance, std::string_view name) {
  const bool ours =
      name == "xrGetOpenGLGraphicsRequirementsKHR" && instance.Enabled(XR_KHR_OPENGL_ENABLE_EXTENSION_NAME);
  return ours ? reinterpret_cast<PFN_xrVoidFunction>(&GetOpenGLGraphicsRequirements) : nullptr;
}

XrResult CreateOpenglGraphics(const Instance& instance, const void* chain, std::shared_ptr<Graphics>* graphics) {
  const auto& binding = *static_cast<const XrGraphicsBindingOpenGLXlibKHR*>(chain);
  OMNI_REQUIRE(instance.Enabled(XR_KHR_OPENGL_ENABLE_EXTENSION_NAME), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  OMNI_REQUIRE(instance.opengl_asked, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  OMNI_REQUIRE(binding.xDisplay != nullptr && binding.glxDrawable != 0 && binding.glxContext != nullptr,
               XR_ERROR_GRAPHICS_DEVICE_INVALID);
  const auto gl = std::make_shared<GlContext>();
  gl->display = binding.xDisplay;
  gl->drawable = binding.glxDrawable;
  gl->context = binding.glxContext;
  OMNI_REQUIRE(gl->Load(), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  const Current current(*gl);
  OMNI_REQUIRE(current.ok() && std::pair(gl->Get(GL_MAJOR_VERSION), gl->Get(GL_MINOR_VERSION)) >=
                                   std::pair(kLeastMajor, kLeastMinor),
               XR_ERROR_GRAPHICS_DEVICE_INVALID);
  *graphics = std::make_shared<OpenglGraphics>(gl);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
