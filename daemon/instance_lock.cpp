#include "daemon/instance_lock.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "daemon/clean_text.h"
#include "daemon/log.h"

namespace cheval::daemon {

namespace {

std::string runtimeFolder() {
    for (const char* name : {"RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"}) {
        const char* value = std::getenv(name);
        if (value == nullptr) continue;
        // systemd joins several folders by colons.
        const std::string_view folders(value);
        const std::string_view first = folders.substr(0, folders.find(':'));
        if (!first.empty()) return std::string(first);
    }
    return {};
}

std::string holder(int descriptor) {
    std::array<char, 16> bytes{};
    const ssize_t count = pread(descriptor, bytes.data(), bytes.size() - 1, 0);
    if (count <= 0) return "another process";
    std::string_view text(bytes.data(), static_cast<std::size_t>(count));
    return "process " + cleanText(text.substr(0, text.find('\n')));
}

}  // namespace

Expected<InstanceLock> InstanceLock::take() {
    const std::string folder = runtimeFolder();
    if (folder.empty()) return InstanceLock(-1);
    const std::string file = folder + "/chevald.lock";
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (descriptor < 0) {
        const std::string why = std::generic_category().message(errno);
        log(Severity::warning, Error{.code = ErrorCode::resource,
                                     .cause = "the lock that keeps a second mirror away cannot be taken: " + why,
                                     .mend = "let the mirror's account write to " + folder,
                                     .file = file}
                                   .message());
        return InstanceLock(-1);
    }
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
        const std::string who = holder(descriptor);
        close(descriptor);
        return Error{.code = ErrorCode::conflict,
                     .cause = "another mirror runs on this machine (" + who + ")",
                     .mend = "end it first (systemctl stop cheval), or give this one a runtime folder of its own",
                     .why = "two would fight over the sensor, the display and the buttons",
                     .file = file};
    }
    // For the message above alone: that the file cannot be written to does not loosen the lock.
    const std::string process = std::to_string(getpid()) + "\n";
    if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, process.data(), process.size(), 0) < 0)
        log(Severity::warning, "the lock file does not name this process: " + file);
    return InstanceLock(descriptor);
}

InstanceLock::~InstanceLock() {
    // The file stays: whoever removed it could take it from under the lock of a third.
    if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace cheval::daemon
