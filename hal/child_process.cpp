#include "hal/child_process.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <mutex>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cheval::hal {

namespace {

constexpr int kFirstDescriptor = 3;

/// Children that the kernel had not ended within the limit, e.g. in a driver's uninterruptible wait.
class Unreaped {
  public:
    void add(pid_t pid) {
        const std::lock_guard lock(mutex_);
        pids_.push_back(pid);
    }
    void reap() {
        const std::lock_guard lock(mutex_);
        std::erase_if(pids_, [](pid_t pid) { return ::waitpid(pid, nullptr, WNOHANG) != 0; });
    }

  private:
    std::mutex mutex_;
    std::vector<pid_t> pids_;
};

Unreaped& unreaped() {
    static Unreaped all;
    return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
    std::vector<char*> list;
    list.reserve(texts.size() + 1);
    for (std::string& text : texts)
        list.push_back(text.data());
    list.push_back(nullptr);
    return list;
}

std::vector<std::string> environmentWith(const std::vector<std::string>& added) {
    std::vector<std::string> all = added;
    for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
        const std::string_view text(*variable);
        const std::string_view name = text.substr(0, text.find('=') + 1);
        const bool replaced =
            std::any_of(added.begin(), added.end(), [&](const std::string& other) { return other.starts_with(name); });
        if (!replaced) all.emplace_back(text);
    }
    return all;
}

std::string endingOf(int status) {
    if (WIFSIGNALED(status)) return "was ended by signal " + std::to_string(WTERMSIG(status));
    return "exited with status " + std::to_string(WEXITSTATUS(status));
}

bool readable(int descriptor, Duration limit) {
    pollfd waits{.fd = descriptor, .events = POLLIN, .revents = 0};
    const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(limit).count();
    return ::poll(&waits, 1, static_cast<int>(milliseconds)) > 0;
}

}  // namespace

void ChildProcess::reapAbandoned() {
    unreaped().reap();
}

Expected<ChildProcess> ChildProcess::start(const Start& start) {
    reapAbandoned();
    std::vector<std::string> arguments = {start.program};
    arguments.insert(arguments.end(), start.arguments.begin(), start.arguments.end());
    std::vector<std::string> environment = environmentWith(start.environment);

    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    // Copies above the range that they go to, so that no dup2 overwrites one that is still to be placed.
    std::vector<Descriptor> copies;
    const int last = kFirstDescriptor + static_cast<int>(start.descriptors.size());
    for (std::size_t i = 0; i < start.descriptors.size(); ++i) {
        copies.emplace_back(::fcntl(start.descriptors[i], F_DUPFD_CLOEXEC, last));
        posix_spawn_file_actions_adddup2(&files, copies.back().get(), kFirstDescriptor + static_cast<int>(i));
    }
    posix_spawn_file_actions_addclosefrom_np(&files, last);
    // The daemon's threads block the signals that it waits for; the child must not inherit that, and a terminal's
    // interrupt is for the daemon, which then ends the child in order.
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    pid_t pid = -1;
    const int failed = ::posix_spawn(&pid, start.program.c_str(), &files, &attributes, pointers(arguments).data(),
                                     pointers(environment).data());
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    if (failed != 0) {
        return Error{.code = failed == ENOENT || failed == EACCES ? ErrorCode::notFound : ErrorCode::resource,
                     .cause = std::string("the program cannot be started: ") + std::strerror(failed),
                     .mend = "install it beside chevald, of the same release",
                     .file = start.program};
    }
    Descriptor descriptor(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
    ChildProcess child(pid, std::move(descriptor));
    if (!child.descriptor_.valid()) {
        return Error{.code = ErrorCode::resource, .cause = "no descriptor for the child process was to be had"};
    }
    return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      descriptor_(std::move(other.descriptor_)),
      ending_(std::move(other.ending_)),
      exitStatus_(other.exitStatus_) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
    if (this != &other) {
        kill();
        pid_ = std::exchange(other.pid_, -1);
        descriptor_ = std::move(other.descriptor_);
        ending_ = std::move(other.ending_);
        exitStatus_ = other.exitStatus_;
    }
    return *this;
}

bool ChildProcess::running() {
    if (pid_ < 0) return false;
    int status = 0;
    const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
    if (ended == 0) return true;
    ending_ = ended == pid_ ? endingOf(status) : "is gone";
    if (ended == pid_ && WIFEXITED(status)) exitStatus_ = WEXITSTATUS(status);
    pid_ = -1;
    descriptor_.reset();
    return false;
}

bool ChildProcess::waitEnd(Duration limit) {
    if (!running()) return true;
    readable(descriptor_.get(), limit);
    return !running();
}

bool ChildProcess::kill(Duration limit) {
    if (!running()) return true;
    ::kill(pid_, SIGKILL);
    if (waitEnd(limit)) return true;
    unreaped().add(std::exchange(pid_, -1));
    descriptor_.reset();
    ending_ = "does not end";
    return false;
}

}  // namespace cheval::hal
