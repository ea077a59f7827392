#include "daemon/status_line.h"

#include <fmt/format.h>

#include "hal/clock.h"

namespace cheval::daemon {

std::string statusLine(const MirrorStatus& status) {
    if (status.fault.length > 0) return fmt::format("no frames: {}", status.fault.view());
    std::string text(name(status.state));
    if (status.state == SessionState::wearing) text += fmt::format(": {}", status.outfit.view());
    if (status.avatarView) text += " (mannequin)";
    text += fmt::format("  {:.1f} fps  loop {:.1f} ms  render {:.1f} ms  ", status.framesPerSecond,
                        hal::seconds(status.loopTime) * 1e3, hal::seconds(status.renderTime) * 1e3);
    text += status.degradeLevel == 0 ? "all details" : fmt::format("plainer: {}", status.degradeName);
    return text;
}

}  // namespace cheval::daemon
