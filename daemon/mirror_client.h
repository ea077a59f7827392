// The other end of org.cheval.Mirror1: asks a running mirror, for chevalctl.
#pragma once

#include <optional>
#include <string>

#include "config/settings.h"
#include "daemon/status_report.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// All of the mirror's properties in one call. Waits at most five seconds. Errors: unavailable (no bus, no mirror),
/// timedOut, invalidInput (this account may not ask), each with what to do.
Expected<MirrorReport> askMirror(config::BusKind bus);

/// Calls a method of org.cheval.Mirror1 with one text or nothing. Waits at most five seconds. Errors: as askMirror();
/// what the mirror itself refuses comes back as notFound with its words.
Expected<void> tellMirror(config::BusKind bus, const std::string& method,
                          const std::optional<std::string>& argument = std::nullopt);

}  // namespace cheval::daemon
