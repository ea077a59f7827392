// The devices that the settings ask for.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "config/settings.h"
#include "daemon/camera_supervisor.h"
#include "hal/buttons.h"
#include "hal/clock.h"
#include "hal/display.h"
#include "hal/preview/preview_server.h"

namespace cheval::daemon {

/// An open display, with the buttons that come with it. Closed on destruction.
class Screen {
  public:
    /// Errors: the preview's port is taken, the display does not open.
    static Expected<std::unique_ptr<Screen>> open(const config::Settings& settings, hal::Clock& clock);
    ~Screen();
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    [[nodiscard]] hal::Display& display() const { return *display_; }
    [[nodiscard]] const hal::DisplayMode& mode() const { return mode_; }
    /// Null where the display has none.
    [[nodiscard]] hal::Buttons* buttons() const { return preview_ == nullptr ? nullptr : &preview_->buttons(); }
    /// Where people can look at it, e.g. "http://127.0.0.1:8080/"; empty: nowhere.
    [[nodiscard]] std::string address() const { return preview_ == nullptr ? std::string() : preview_->address(); }

    /// The line that people see who look at it there; elsewhere there is nobody to tell.
    void setStatus(std::string_view status) {
        if (preview_ != nullptr) preview_->setStatus(status);
    }

    /// The two settings ask for one and the same screen, which can stay open over a change.
    static bool same(const config::Settings& a, const config::Settings& b);

  private:
    Screen() = default;

    std::unique_ptr<hal::PreviewServer> preview_;
    std::unique_ptr<hal::Display> headless_;
    hal::Display* display_ = nullptr;
    hal::DisplayMode mode_;
};

/// Where frames come from, with the buttons that belong to it.
struct FrameSource {
    CameraFactory camera;
    std::unique_ptr<hal::Buttons> buttons;  ///< Null where the source has none.
};

/// Nothing is opened yet: what does not work turns up when the factory is called, and again at each retry.
FrameSource makeFrameSource(const config::Settings& settings, hal::Clock& clock);

/// The push buttons of the settings; null where there are none by design.
std::unique_ptr<hal::Buttons> makeButtons(const config::Settings& settings, const hal::Clock& clock);

}  // namespace cheval::daemon
