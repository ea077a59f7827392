#include <array>
#include <memory>
#include <string>

#include <GL/osmesa.h>
#include <dlfcn.h>

#include "render/gl_context.h"

namespace cheval::render {
namespace {

struct OsmesaLibrary {
    decltype(&OSMesaCreateContextAttribs) createContext = nullptr;
    decltype(&OSMesaDestroyContext) destroyContext = nullptr;
    decltype(&OSMesaMakeCurrent) makeCurrent = nullptr;
    decltype(&OSMesaGetProcAddress) getProcAddress = nullptr;
};

template <typename Function>
bool find(void* library, const char* name, Function& function) {
    function = reinterpret_cast<Function>(librarySymbol(library, name));
    return function != nullptr;
}

Error unavailable(std::string cause) {
    return Error{.code = ErrorCode::unavailable,
                 .cause = std::move(cause),
                 .mend = "install libosmesa6",
                 .why = "OSMesa draws where there is no EGL"};
}

Expected<OsmesaLibrary> openLibrary() {
    void* handle = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return unavailable("libOSMesa.so.8 cannot be opened");
    OsmesaLibrary library;
    const bool complete = find(handle, "OSMesaCreateContextAttribs", library.createContext) &&
                          find(handle, "OSMesaDestroyContext", library.destroyContext) &&
                          find(handle, "OSMesaMakeCurrent", library.makeCurrent) &&
                          find(handle, "OSMesaGetProcAddress", library.getProcAddress);
    if (!complete) return unavailable("libOSMesa.so.8 lacks a function of OSMesa 11.2");
    return library;
}

class OsmesaGlContext final : public GlContext {
  public:
    explicit OsmesaGlContext(const OsmesaLibrary& library) : GlContext(Dialect::core33), library_(library) {}
    ~OsmesaGlContext() override {
        letGo();
        if (context_ != nullptr) library_.destroyContext(context_);
    }
    OsmesaGlContext(const OsmesaGlContext&) = delete;
    OsmesaGlContext& operator=(const OsmesaGlContext&) = delete;

    Expected<void> create() {
        const int attributes[] = {OSMESA_FORMAT,
                                  OSMESA_RGBA,
                                  OSMESA_DEPTH_BITS,
                                  0,
                                  OSMESA_PROFILE,
                                  OSMESA_CORE_PROFILE,
                                  OSMESA_CONTEXT_MAJOR_VERSION,
                                  3,
                                  OSMESA_CONTEXT_MINOR_VERSION,
                                  3,
                                  0};
        context_ = library_.createContext(attributes, nullptr);
        if (context_ == nullptr) return unavailable("OSMesa makes no GL 3.3 core context");
        if (auto bound = makeCurrent(); !bound) return bound;
        return load(library_.getProcAddress, "OSMesa");
    }

  private:
    /// OSMesa insists on a buffer of its own; all drawing goes to framebuffer objects instead.
    static constexpr int kBufferSize = 16;

    bool bind() override {
        return library_.makeCurrent(context_, buffer_.data(), kUnsignedByte, kBufferSize, kBufferSize) != 0;
    }
    void unbind() override { library_.makeCurrent(nullptr, nullptr, kUnsignedByte, 0, 0); }

    static constexpr GLenum kUnsignedByte = GL_UNSIGNED_BYTE;
    OsmesaLibrary library_;
    OSMesaContext context_ = nullptr;
    std::array<unsigned char, std::size_t{4} * kBufferSize * kBufferSize> buffer_{};
};

}  // namespace

Expected<std::unique_ptr<GlContext>> makeOsmesaContext() {
    auto library = openLibrary();
    if (!library) return std::move(library).error();
    auto context = std::make_unique<OsmesaGlContext>(*library);
    if (auto created = context->create(); !created) return std::move(created).error();
    return std::unique_ptr<GlContext>(std::move(context));
}

}  // namespace cheval::render
