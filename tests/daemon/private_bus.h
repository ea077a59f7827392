// A session bus of a test's own, that can be ended, stopped and started again at the same address.
#pragma once

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hal/clock.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {

/// Polls until it holds; false after a limit that only a fault reaches.
inline bool eventually(const std::function<bool()>& holds) {
    hal::SteadyClock clock;
    hal::Interrupt never;
    const hal::TimePoint limit = clock.now() + std::chrono::seconds(60);
    while (!holds()) {
        if (clock.now() > limit) return false;
        clock.waitUntil(clock.now() + std::chrono::milliseconds(10), never);
    }
    return true;
}

/// Thread-bound. While it lives, DBUS_SESSION_BUS_ADDRESS is its own.
class PrivateBus {
  public:
    PrivateBus() {
        path_ = (folder_.path() / "bus").string();
        setenv("DBUS_SESSION_BUS_ADDRESS", ("unix:path=" + path_).c_str(), 1);
    }
    ~PrivateBus() {
        end();
        unsetenv("DBUS_SESSION_BUS_ADDRESS");
    }
    PrivateBus(const PrivateBus&) = delete;
    PrivateBus& operator=(const PrivateBus&) = delete;

    void start() {
        const std::string address = "--address=unix:path=" + path_;
        std::array<const char*, 6> arguments{"dbus-daemon", "--session",     "--nofork",
                                             "--nopidfile", address.c_str(), nullptr};
        ASSERT_EQ(
            posix_spawnp(&process_, arguments[0], nullptr, nullptr, const_cast<char**>(arguments.data()), environ), 0)
            << "dbus-daemon is not installed";
        ASSERT_TRUE(eventually([this] { return answers(); }));
    }
    void end() {
        if (process_ <= 0) return;
        signal(SIGCONT);
        signal(SIGKILL);
        waitpid(process_, nullptr, 0);
        process_ = 0;
        unlink(path_.c_str());
    }
    void signal(int number) const { kill(process_, number); }

  private:
    [[nodiscard]] bool answers() const {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path_.copy(address.sun_path, sizeof(address.sun_path) - 1);
        const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        const bool good = connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
        close(descriptor);
        return good;
    }

    test::TemporaryFolder folder_;
    std::string path_;
    pid_t process_ = 0;
};

}  // namespace cheval::daemon
