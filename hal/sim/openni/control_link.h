// The simulated sensor's line to whoever makes it fail: a test's world listens, each sensor process connects.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <string_view>
#include <thread>

namespace cheval::hal::sim {

/// Thread-safe. Commands are packets of text over a SOCK_SEQPACKET socket, each answered by one packet.
class ControlLink {
  public:
    /// Obeys one command and returns the answer, "ok" or "error …". Called in the link's thread, but for the first.
    using Obey = std::function<std::string(std::string_view)>;

    ControlLink() = default;
    ~ControlLink() { stop(); }
    ControlLink(const ControlLink&) = delete;
    ControlLink& operator=(const ControlLink&) = delete;

    /// Connects and waits up to a second for the first packet, the state as it is, one command a line. False: nobody
    /// listens there.
    bool start(const std::string& path, Obey obey);
    void stop();

  private:
    void listen();

    int socket_ = -1;
    Obey obey_;
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

}  // namespace cheval::hal::sim
