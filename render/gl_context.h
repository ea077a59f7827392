// A GL context without a window: EGL surfaceless (OpenGL ES 3) or OSMesa (GL 3.3 core), and the one function table that
// either fills.
#pragma once

#include <memory>
#include <string>

#include "hal/expected.h"
#include "render/renderer.h"

// NOLINTNEXTLINE(readability-identifier-naming): glad's name.
struct GladGLContext;

namespace cheval::render {

enum class Dialect : std::uint8_t { es3, core33 };

/// A live context. Thread-bound to the thread that made it.
class GlContext {
  public:
    virtual ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    /// Makes this the thread's context, if it is not already. Another kind of context is let go first: EGL and OSMesa
    /// share Mesa's dispatch table.
    Expected<void> makeCurrent();

    [[nodiscard]] const GladGLContext& gl() const { return *table_; }
    [[nodiscard]] Dialect dialect() const { return dialect_; }
    /// E.g. "EGL surfaceless, OpenGL ES 3.2 Mesa 22.3.6, llvmpipe".
    [[nodiscard]] const std::string& description() const { return description_; }

  protected:
    explicit GlContext(Dialect dialect);
    using AnyFunction = void (*)();
    using GetProcAddress = AnyFunction (*)(const char* name);
    /// Fills the table; the context must be current.
    Expected<void> load(GetProcAddress getProcAddress, const std::string& kind);
    /// To be called first in a derived destructor.
    void letGo();

  private:
    virtual bool bind() = 0;
    virtual void unbind() = 0;

    Dialect dialect_;
    std::unique_ptr<GladGLContext> table_;
    std::string description_;
};

/// Fails with cause and mend where that kind cannot be had; automatic tries EGL, then OSMesa.
Expected<std::unique_ptr<GlContext>> makeGlContext(ContextKind kind);

/// EGL on Mesa's surfaceless platform, OpenGL ES 3.
Expected<std::unique_ptr<GlContext>> makeEglContext();
/// OSMesa, GL 3.3 core.
Expected<std::unique_ptr<GlContext>> makeOsmesaContext();

/// A function out of a library opened at run time; null where it has none.
void* librarySymbol(void* library, const char* name);

}  // namespace cheval::render
