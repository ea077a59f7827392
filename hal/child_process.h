// A child process that may hang: started with the descriptors that it needs and no others, watched, killed, reaped.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "hal/clock.h"
#include "hal/descriptor.h"
#include "hal/expected.h"

namespace cheval::hal {

/// Thread-bound. The child is killed on destruction.
class ChildProcess {
  public:
    struct Start {
        std::string program;
        std::vector<std::string> arguments;    ///< Without the program's own name.
        std::vector<std::string> environment;  ///< "NAME=value", added to this process's own or in place of it.
        std::vector<int> descriptors;          ///< Become 3, 4, … in the child; everything else is closed there.
    };

    /// Errors: notFound (no such program), resource.
    static Expected<ChildProcess> start(const Start& start);
    /// Reaps those that kill() could not end, where they have ended since. start() does it too. Any thread.
    static void reapAbandoned();
    ~ChildProcess() { kill(); }
    ChildProcess(ChildProcess&& other) noexcept;
    ChildProcess& operator=(ChildProcess&& other) noexcept;
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    [[nodiscard]] pid_t pid() const { return pid_; }
    /// Readable when the child has ended.
    [[nodiscard]] int descriptor() const { return descriptor_.get(); }
    /// True while it runs. Reaps it when it has ended.
    bool running();
    /// What it exited with; −1 while it runs, and where it did not exit by itself.
    [[nodiscard]] int exitStatus() const { return exitStatus_; }
    /// How it ended, in words, e.g. "was ended by signal 9"; empty while it runs.
    [[nodiscard]] const std::string& ending() const { return ending_; }
    /// Waits at most `limit` for it to end by itself.
    bool waitEnd(Duration limit);
    /// SIGKILL, and at most `limit` until it is gone. False: the kernel cannot end it yet; it is reaped later.
    bool kill(Duration limit = std::chrono::seconds(1));

  private:
    ChildProcess(pid_t pid, Descriptor descriptor) : pid_(pid), descriptor_(std::move(descriptor)) {}

    pid_t pid_ = -1;
    Descriptor descriptor_;
    std::string ending_;
    int exitStatus_ = -1;
};

}  // namespace cheval::hal
