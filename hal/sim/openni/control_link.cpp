#include "hal/sim/openni/control_link.h"

#include <array>
#include <cstring>
#include <utility>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace cheval::hal::sim {

namespace {

constexpr int kFirstPacketMs = 1000;
constexpr int kSliceMs = 100;  ///< How long stop() may wait.
constexpr std::size_t kLongestPacket = 4096;

bool readable(int socket, int limitMs) {
    pollfd waits{.fd = socket, .events = POLLIN, .revents = 0};
    return ::poll(&waits, 1, limitMs) > 0;
}

}  // namespace

bool ControlLink::start(const std::string& path, Obey obey) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof address.sun_path) return false;
    std::memcpy(address.sun_path, path.data(), path.size());
    socket_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (socket_ < 0) return false;
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        ::close(std::exchange(socket_, -1));
        return false;
    }
    obey_ = std::move(obey);
    if (readable(socket_, kFirstPacketMs)) {
        std::array<char, kLongestPacket> bytes{};
        const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
        std::string_view state(bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
        while (!state.empty()) {
            const std::string_view line = state.substr(0, state.find('\n'));
            if (!line.empty()) obey_(line);
            state.remove_prefix(std::min(state.size(), line.size() + 1));
        }
    }
    thread_ = std::thread([this] { listen(); });
    return true;
}

void ControlLink::listen() {
    std::array<char, kLongestPacket> bytes{};
    while (!stopping_) {
        if (!readable(socket_, kSliceMs)) continue;
        const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (size <= 0) return;  // The world is gone; the sensor stays as it is.
        const std::string answer = obey_({bytes.data(), static_cast<std::size_t>(size)});
        ::send(socket_, answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    }
}

void ControlLink::stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    if (socket_ >= 0) ::close(std::exchange(socket_, -1));
    stopping_ = false;
}

}  // namespace cheval::hal::sim
