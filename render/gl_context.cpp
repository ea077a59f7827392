#include "render/gl_context.h"

#include <dlfcn.h>
#include <glad/gl.h>

namespace cheval::render {
namespace {

/// The context that makeCurrent() bound last on this thread.
thread_local GlContext* currentContext = nullptr;

std::string text(const GladGLContext& gl, GLenum name) {
    const auto* value = gl.GetString(name);
    return value == nullptr ? std::string("unknown") : std::string(reinterpret_cast<const char*>(value));
}

}  // namespace

GlContext::GlContext(Dialect dialect) : dialect_(dialect), table_(std::make_unique<GladGLContext>()) {}
GlContext::~GlContext() = default;

Expected<void> GlContext::makeCurrent() {
    if (currentContext == this) return {};
    if (currentContext != nullptr) currentContext->unbind();
    currentContext = nullptr;
    if (!bind())
        return Error{.code = ErrorCode::unavailable,
                     .cause = "the GL context cannot be made current",
                     .mend = "restart the mirror; if it happens again, reinstall libgl1-mesa-dri"};
    currentContext = this;
    return {};
}

void GlContext::letGo() {
    if (currentContext != this) return;
    unbind();
    currentContext = nullptr;
}

Expected<void> GlContext::load(GetProcAddress getProcAddress, const std::string& kind) {
    const int version = dialect_ == Dialect::es3 ? gladLoadGLES2Context(table_.get(), getProcAddress)
                                                 : gladLoadGLContext(table_.get(), getProcAddress);
    const int wanted = dialect_ == Dialect::es3 ? GLAD_MAKE_VERSION(3, 0) : GLAD_MAKE_VERSION(3, 3);
    if (version < wanted)
        return Error{.code = ErrorCode::unavailable,
                     .cause = kind + " gives " +
                              (version == 0 ? std::string("no GL functions") : "only " + text(*table_, GL_VERSION)),
                     .mend = "install Mesa's drivers (libgl1-mesa-dri) of Debian 12 or later",
                     .why = "the renderer needs OpenGL ES 3.0 or GL 3.3 core"};
    description_ = kind + ", " + text(*table_, GL_VERSION) + ", " + text(*table_, GL_RENDERER);
    return {};
}

void* librarySymbol(void* library, const char* name) {
    return dlsym(library, name);
}

Expected<std::unique_ptr<GlContext>> makeGlContext(ContextKind kind) {
    if (kind == ContextKind::osmesa) return makeOsmesaContext();
    auto egl = makeEglContext();
    if (egl || kind == ContextKind::egl) return egl;
    auto osmesa = makeOsmesaContext();
    if (osmesa) return osmesa;
    return Error{
        .code = ErrorCode::unavailable,
        .cause = "neither EGL nor OSMesa gives a GL context: " + egl.error().cause + "; " + osmesa.error().cause,
        .mend = "install libegl1 and libgl1-mesa-dri, or libosmesa6",
        .why = "garments are drawn with OpenGL ES 3.0 or GL 3.3 core"};
}

}  // namespace cheval::render
