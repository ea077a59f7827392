#include "tests/support/sensor_world.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "hal/clock.h"

namespace cheval::test {

namespace {

constexpr int kAnswerMs = 2000;

/// What a command takes the place of.
std::string kindOf(const std::string& command) {
    const std::string verb = command.substr(0, command.find(' '));
    if (verb == "plug" || verb == "unplug") return "plug";
    if (verb == "stall" || verb == "resume") return "stall";
    if (verb == "busy" || verb == "free") return "busy";
    if (verb == "hang" || verb == "unhang") return "hang";
    if (verb == "slow") return "slow";
    if (verb == "mode") return "mode";
    return "sound";
}

}  // namespace

SensorWorld::SensorWorld(const std::string& spec) : spec_(spec), path_((folder_.path() / "world").string()) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path_.size() >= sizeof address.sun_path) throw std::system_error(ENAMETOOLONG, std::generic_category(), path_);
    std::memcpy(address.sun_path, path_.data(), path_.size());
    listener_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    wake_ = ::eventfd(0, EFD_CLOEXEC);
    if (listener_ < 0 || wake_ < 0 ||
        ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener_, 8) != 0)
        throw std::system_error(errno, std::generic_category(), "the world cannot listen on " + path_);
    thread_ = std::thread([this] { accept(); });
}

SensorWorld::~SensorWorld() {
    ::eventfd_write(wake_, 1);
    thread_.join();
    for (const int connection : connections_)
        ::close(connection);
    ::close(listener_);
    ::close(wake_);
}

std::vector<std::string> SensorWorld::environment() const {
    return {"CHEVAL_SIMULATED_SENSOR=" + spec_, "CHEVAL_SIMULATED_SENSOR_CONTROL=" + path_,
            "LD_LIBRARY_PATH=" CHEVAL_OPENNI_FOLDER};
}

void SensorWorld::useInThisProcess() const {
    for (const std::string& variable : environment()) {
        const std::size_t equals = variable.find('=');
        ::setenv(variable.substr(0, equals).c_str(), variable.substr(equals + 1).c_str(), 1);
    }
}

std::string SensorWorld::state() {
    std::string lines = "plug\n";
    for (const auto& [kind, command] : state_)
        lines += command + '\n';
    return lines;
}

void SensorWorld::accept() {
    while (true) {
        std::array<pollfd, 2> waits = {pollfd{.fd = listener_, .events = POLLIN, .revents = 0},
                                       pollfd{.fd = wake_, .events = POLLIN, .revents = 0}};
        if (::poll(waits.data(), waits.size(), -1) < 0) continue;
        if ((waits[1].revents & POLLIN) != 0) return;
        const int connection = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
        if (connection < 0) continue;
        // In one breath with tell(), so that no command falls between the state and the list.
        const std::lock_guard lock(mutex_);
        const std::string now = state();
        ::send(connection, now.data(), now.size(), MSG_NOSIGNAL);
        connections_.push_back(connection);
    }
}

bool SensorWorld::tell(const std::string& command) {
    const std::lock_guard lock(mutex_);
    state_[kindOf(command)] = command;
    bool obeyed = true;
    std::erase_if(connections_, [&](int connection) {
        bool alive =
            ::send(connection, command.data(), command.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(command.size());
        if (alive) {
            pollfd waits{.fd = connection, .events = POLLIN, .revents = 0};
            std::array<char, 64> answer{};
            const bool answered = ::poll(&waits, 1, kAnswerMs) > 0;
            const ssize_t size = answered ? ::recv(connection, answer.data(), answer.size(), MSG_DONTWAIT) : -1;
            alive = !answered || size > 0;
            if (alive)
                obeyed = obeyed && answered && std::string(answer.data(), static_cast<std::size_t>(size)) == "ok";
        }
        if (!alive) ::close(connection);
        return !alive;
    });
    return obeyed;
}

std::size_t SensorWorld::sensors() {
    const std::lock_guard lock(mutex_);
    std::erase_if(connections_, [](int connection) {
        pollfd waits{.fd = connection, .events = POLLRDHUP, .revents = 0};
        const bool gone = ::poll(&waits, 1, 0) > 0 && (waits.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
        if (gone) ::close(connection);
        return gone;
    });
    return connections_.size();
}

std::string SensorWorld::visitInProgress(const std::string& options, double seconds) {
    const hal::TimePoint zero = hal::SteadyClock().now() - hal::fromSeconds(seconds);
    return "sim:" + options + (options.empty() ? "" : ",") +
           "start_ns=" + std::to_string(zero.time_since_epoch().count());
}

}  // namespace cheval::test
