// The mirror in a browser, for demonstrations and tests: a Display that serves its picture as MJPEG, and Buttons
// pressed on the page. Loopback only, and off unless configured.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "hal/buttons.h"
#include "hal/clock.h"
#include "hal/display.h"
#include "hal/expected.h"

namespace cheval::hal {

struct PreviewOptions {
    DisplayMode mode;
    std::uint16_t port = 8080;  ///< 0: any free port.
    int jpegQuality = 80;       ///< 1 … 100.
    int streamWidth = 540;      ///< The picture is scaled down to this width for the browser.
};

/// A page, its stream and its buttons. The display never waits for a browser; pictures are encoded in a thread of the
/// server, and only while somebody looks. At most four viewers at once, more are turned away. Buttons are next,
/// previous and view, each a ButtonAction::pressed with the time of the clock. Destroying the server ends every
/// connection at once. Thread-safe.
class PreviewServer {
  public:
    static constexpr int kMaxViewers = 4;
    static constexpr std::size_t kMaxStatusBytes = 240;

    virtual ~PreviewServer() = default;
    PreviewServer(const PreviewServer&) = delete;
    PreviewServer& operator=(const PreviewServer&) = delete;

    /// E.g. "http://127.0.0.1:8080/".
    [[nodiscard]] virtual std::string address() const = 0;
    /// Both belong to the server and live as long as it does.
    [[nodiscard]] virtual Display& display() = 0;
    [[nodiscard]] virtual Buttons& buttons() = 0;
    /// The line that the page shows (UTF-8, plain text), cut at kMaxStatusBytes. Takes no memory and waits for nobody.
    virtual void setStatus(std::string_view status) = 0;

  protected:
    PreviewServer() = default;
};

/// Binds the port at once; fails with cause and mend when it is taken, or when the mode has no pixels or more than 8192
/// a side. `clock` must outlive the server.
Expected<std::unique_ptr<PreviewServer>> startPreview(const PreviewOptions& options, Clock& clock);

}  // namespace cheval::hal
