// The subcommands of chevalctl that talk to a running mirror: status, outfit, reload.
#pragma once

#include <optional>
#include <string>

#include "config/settings.h"

namespace CLI {  // NOLINT(readability-identifier-naming): the library's name.
class App;
}

namespace cheval::daemon {

/// Adds them to a command line and, once it was read, runs the one that was asked for. Thread-bound.
class ControlCommands {
  public:
    /// Some part of the mirror is at fault.
    static constexpr int kAtFault = 4;

    /// Borrows `app` for its lifetime.
    explicit ControlCommands(CLI::App& app);

    /// The exit status (0 nothing is at fault, 1 the mirror cannot be reached or refuses, kAtFault); std::nullopt where
    /// another subcommand was asked for.
    [[nodiscard]] std::optional<int> run() const;

  private:
    CLI::App* status_;
    CLI::App* outfit_;
    CLI::App* next_;
    CLI::App* previous_;
    CLI::App* set_;
    CLI::App* list_;
    CLI::App* reload_;
    config::BusKind bus_ = config::BusKind::system;
    bool json_ = false;
    std::string name_;
};

}  // namespace cheval::daemon
