// `chevald --once`: one visit of the simulated shopper, on virtual time, so that it is the same visit on every machine.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "config/settings.h"
#include "daemon/mirror.h"
#include "hal/expected.h"

namespace cheval::daemon {

struct OnceOptions {
    std::filesystem::path report;                     ///< Folder for the visit's report; empty: none.
    std::function<void(const MirrorStatus&)> status;  ///< Called about twice a second of the visit; may be empty.
};

struct OnceResult {
    MirrorStatus status;
    double visitSeconds = 0.0;
    std::vector<TaskStatistics> tasks;
    std::string renderer;
};

/// Plays one visit to its end. Errors: no renderer, the report cannot be written, or nobody could be dressed: then
/// something is wrong with the mirror, for the simulated shopper always can be.
Expected<OnceResult> runOnce(const config::Settings& settings, const OnceOptions& options);

}  // namespace cheval::daemon
