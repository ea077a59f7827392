// `chevald` as a service: the mirror runs until SIGTERM, and takes new settings on SIGHUP.
#pragma once

#include <functional>

#include "config/loader.h"
#include "daemon/mirror.h"
#include "hal/expected.h"

namespace cheval::daemon {

struct ServiceOptions {
    config::LoadOptions settings;
    /// Called about twice a second, and once more at the end, with where the preview is (may be empty).
    std::function<void(const MirrorStatus&)> status;
    std::function<void(const std::string& address)> started;  ///< The mirror is lit.
};

/// Blocks SIGTERM, SIGINT and SIGHUP in this thread and all that it starts, so that they can be waited for: no code
/// runs in a signal handler. Call before any thread is started.
void blockSignals();

/// Runs until SIGTERM or SIGINT; ends within a second. Settings that are refused leave the last good ones in force (at
/// the start: what could be understood) and a message on the service screen. Errors: no display, no renderer, or
/// another mirror runs already.
Expected<void> runService(const ServiceOptions& options);

}  // namespace cheval::daemon
