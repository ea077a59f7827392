#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include <dlfcn.h>

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "render/gl_context.h"

namespace cheval::render {
namespace {

/// libEGL's functions in use, by name as EGL has them.
struct EglLibrary {
    decltype(&eglGetProcAddress) getProcAddress = nullptr;
    decltype(&eglInitialize) initialize = nullptr;
    decltype(&eglTerminate) terminate = nullptr;
    decltype(&eglQueryString) queryString = nullptr;
    decltype(&eglBindAPI) bindApi = nullptr;
    decltype(&eglChooseConfig) chooseConfig = nullptr;
    decltype(&eglCreateContext) createContext = nullptr;
    decltype(&eglDestroyContext) destroyContext = nullptr;
    decltype(&eglMakeCurrent) makeCurrent = nullptr;
    decltype(&eglGetError) getError = nullptr;
    PFNEGLGETPLATFORMDISPLAYEXTPROC getPlatformDisplay = nullptr;
};

template <typename Function>
bool find(void* library, const char* name, Function& function) {
    function = reinterpret_cast<Function>(librarySymbol(library, name));
    return function != nullptr;
}

Error unavailable(std::string cause) {
    return Error{.code = ErrorCode::unavailable,
                 .cause = std::move(cause),
                 .mend = "install libegl1, libgles2 and libgl1-mesa-dri",
                 .why = "EGL's surfaceless platform draws without a window system"};
}

/// The surfaceless display: one a process, since terminating it would end every context on it.
class EglDisplay {
  public:
    EglDisplay(const EglLibrary& library, EGLDisplay display) : library_(library), display_(display) {}
    ~EglDisplay() { library_.terminate(display_); }
    EglDisplay(const EglDisplay&) = delete;
    EglDisplay& operator=(const EglDisplay&) = delete;
    [[nodiscard]] const EglLibrary& library() const { return library_; }
    [[nodiscard]] EGLDisplay display() const { return display_; }

    static Expected<std::shared_ptr<EglDisplay>> get();

  private:
    EglLibrary library_;
    EGLDisplay display_;
};

Expected<EglLibrary> openLibrary() {
    // Never closed: drivers keep threads and thread-local data beyond the last context.
    void* handle = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return unavailable("libEGL.so.1 cannot be opened");
    EglLibrary library;
    const bool complete =
        find(handle, "eglGetProcAddress", library.getProcAddress) &&
        find(handle, "eglInitialize", library.initialize) && find(handle, "eglTerminate", library.terminate) &&
        find(handle, "eglQueryString", library.queryString) && find(handle, "eglBindAPI", library.bindApi) &&
        find(handle, "eglChooseConfig", library.chooseConfig) &&
        find(handle, "eglCreateContext", library.createContext) &&
        find(handle, "eglDestroyContext", library.destroyContext) &&
        find(handle, "eglMakeCurrent", library.makeCurrent) && find(handle, "eglGetError", library.getError);
    if (!complete) return unavailable("libEGL.so.1 lacks a function of EGL 1.4");
    library.getPlatformDisplay =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(library.getProcAddress("eglGetPlatformDisplayEXT"));
    const char* extensions = library.queryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (library.getPlatformDisplay == nullptr || extensions == nullptr ||
        std::string_view(extensions).find("EGL_MESA_platform_surfaceless") == std::string_view::npos)
        return unavailable("EGL has no surfaceless platform");
    return library;
}

Expected<std::shared_ptr<EglDisplay>> EglDisplay::get() {
    static std::mutex mutex;
    static std::weak_ptr<EglDisplay> shared;
    const std::lock_guard lock(mutex);
    if (auto display = shared.lock()) return display;
    auto library = openLibrary();
    if (!library) return std::move(library).error();
    EGLDisplay handle = library->getPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    if (handle == EGL_NO_DISPLAY || library->initialize(handle, nullptr, nullptr) != EGL_TRUE)
        return unavailable("EGL's surfaceless display cannot be opened");
    auto display = std::make_shared<EglDisplay>(*library, handle);
    shared = display;
    return display;
}

class EglContext final : public GlContext {
  public:
    explicit EglContext(std::shared_ptr<EglDisplay> display) : GlContext(Dialect::es3), display_(std::move(display)) {}
    ~EglContext() override {
        letGo();
        if (context_ != EGL_NO_CONTEXT) display_->library().destroyContext(display_->display(), context_);
    }
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    Expected<void> create() {
        const EglLibrary& egl = display_->library();
        if (egl.bindApi(EGL_OPENGL_ES_API) != EGL_TRUE) return unavailable("EGL has no OpenGL ES");
        const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (egl.chooseConfig(display_->display(), wanted, &config, 1, &count) != EGL_TRUE || count < 1)
            return unavailable("EGL offers no configuration for OpenGL ES 3");
        const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
        context_ = egl.createContext(display_->display(), config, EGL_NO_CONTEXT, attributes);
        if (context_ == EGL_NO_CONTEXT) return unavailable("EGL makes no OpenGL ES 3 context");
        if (auto bound = makeCurrent(); !bound) return bound;
        return load(egl.getProcAddress, "EGL surfaceless");
    }

  private:
    bool bind() override {
        const EglLibrary& egl = display_->library();
        return egl.bindApi(EGL_OPENGL_ES_API) == EGL_TRUE &&
               egl.makeCurrent(display_->display(), EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
    }
    void unbind() override {
        display_->library().makeCurrent(display_->display(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }

    std::shared_ptr<EglDisplay> display_;
    EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

Expected<std::unique_ptr<GlContext>> makeEglContext() {
    auto display = EglDisplay::get();
    if (!display) return std::move(display).error();
    auto context = std::make_unique<EglContext>(std::move(display).value());
    if (auto created = context->create(); !created) return std::move(created).error();
    return std::unique_ptr<GlContext>(std::move(context));
}

}  // namespace cheval::render
