// The mirror in a browser, for demonstrations and tests: a Display that serves its picture as MJPEG, and Buttons
// pressed on the page. Loopback only, and off unless configured (DESIGN §11).
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hal/buttons.h"
#include "hal/clock.h"
#include "hal/display.h"
#include "hal/expected.h"

namespace cheval::hal {

struct PreviewOptions {
    DisplayMode mode;
    std::uint16_t port = 8080;  ///< 0: any free port.
    int jpegQuality = 80;
    int streamWidth = 540;  ///< The picture is scaled down to this width for the browser.
};

/// A page, its stream and its buttons. Thread-safe.
class PreviewServer {
  public:
    virtual ~PreviewServer() = default;
    PreviewServer(const PreviewServer&) = delete;
    PreviewServer& operator=(const PreviewServer&) = delete;

    /// E.g. "http://127.0.0.1:8080/".
    [[nodiscard]] virtual std::string address() const = 0;
    /// Both belong to the server and live as long as it does.
    [[nodiscard]] virtual Display& display() = 0;
    [[nodiscard]] virtual Buttons& buttons() = 0;

  protected:
    PreviewServer() = default;
};

/// Binds the port at once; fails with cause and mend when it is taken.
Expected<std::unique_ptr<PreviewServer>> startPreview(const PreviewOptions& options, Clock& clock);

}  // namespace cheval::hal
