// One mirror a machine: two would fight over the sensor, the display and the buttons.
#pragma once

#include <string>
#include <utility>

#include "hal/expected.h"

namespace cheval::daemon {

/// Holds the lock until it is destroyed; the kernel lets go of it however the process ends, so that nothing is left
/// behind to clear away. Thread-bound.
class InstanceLock {
  public:
    /// Locks `chevald.lock` in the first folder of $RUNTIME_DIRECTORY (a service's), else in $XDG_RUNTIME_DIR (a
    /// person's); with neither it holds nothing, and the name on the bus alone keeps a second one away. A folder that
    /// cannot be written to is told in the log and holds nothing: it is no reason for a dark mirror. Errors:
    /// unavailable, where another daemon holds the lock, naming its process. Never waits.
    static Expected<InstanceLock> take();

    InstanceLock(InstanceLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    InstanceLock& operator=(InstanceLock&&) = delete;
    ~InstanceLock();

    /// Whether there is a lock file that keeps others away.
    [[nodiscard]] bool held() const { return descriptor_ >= 0; }

  private:
    explicit InstanceLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_;
};

}  // namespace cheval::daemon
