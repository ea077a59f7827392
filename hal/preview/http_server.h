// cpp-httplib's server made fit to run for months: a fixed number of threads, connections that wait their turn, limits
// on bytes and time for every request, and a stop that ends every connection at once.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>

#include <httplib.h>

namespace cheval::hal {

/// Answers one request a connection. Set the handlers, bind(), then run() in a thread of its own; stop() from any
/// other.
class HttpServer final : public httplib::Server {
  public:
    struct Limits {
        std::size_t threads = 10;                     ///< Requests answered at once.
        std::size_t requestBytes = 16384;             ///< Request line, headers and body together.
        std::chrono::milliseconds requestTime{5000};  ///< To send the whole request.
        std::chrono::milliseconds writeTime{5000};    ///< Without being able to send a byte.
    };

    explicit HttpServer(const Limits& limits);

    /// Binds a port of the loopback interface, 0 for any free one. Returns the port, or 0 when it is taken.
    int bind(int port);
    /// Serves until end().
    void run();
    /// Ends run() and all connections; call it after run() was started in a thread, and join that thread afterwards.
    /// Thread-safe.
    void end();

  private:
    bool process_and_close_socket(socket_t socket) override;

    Limits limits_;
    std::mutex mutex_;
    std::set<socket_t> sockets_;
    bool ending_ = false;
    std::atomic<bool> finished_{false};
};

}  // namespace cheval::hal
