#include "hal/preview/http_server.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

namespace cheval::hal {

namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

// A fixed number of threads and as many waiting connections; beyond that accepting waits, and the kernel's backlog
// bounds it.
class BoundedQueue final : public httplib::TaskQueue {
  public:
    explicit BoundedQueue(std::size_t threads) : capacity_(threads) {
        for (std::size_t i = 0; i < threads; ++i)
            threads_.emplace_back([this] { work(); });
    }

    void enqueue(std::function<void()> task) override {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return tasks_.size() < capacity_; });
        tasks_.push_back(std::move(task));
        lock.unlock();
        changed_.notify_all();
    }

    void shutdown() override {
        {
            const std::lock_guard lock(mutex_);
            ending_ = true;
        }
        changed_.notify_all();
        for (std::thread& thread : threads_)
            thread.join();
    }

  private:
    void work() {
        while (true) {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return ending_ || !tasks_.empty(); });
            // Every task is run, also at the end, since each closes a socket.
            if (tasks_.empty()) return;
            const std::function<void()> task = std::move(tasks_.front());
            tasks_.pop_front();
            lock.unlock();
            changed_.notify_all();
            task();
        }
    }

    std::size_t capacity_;
    std::vector<std::thread> threads_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::function<void()>> tasks_;
    bool ending_ = false;
};

// A connection with a budget of bytes and a deadline for the request, and a limit on standstill for the answer.
class BoundedStream final : public httplib::Stream {
  public:
    BoundedStream(socket_t socket, const HttpServer::Limits& limits)
        : socket_(socket), limits_(limits), deadline_(std::chrono::steady_clock::now() + limits.requestTime) {}

    [[nodiscard]] bool is_readable() const override { return wait(POLLIN, remaining()); }
    // Also false when the other side has gone, which a picture that stands still would not show otherwise.
    [[nodiscard]] bool is_writable() const override {
        pollfd one{.fd = socket_, .events = POLLRDHUP, .revents = 0};
        if (::poll(&one, 1, 0) > 0) return false;
        return wait(POLLOUT, limits_.writeTime);
    }

    ssize_t read(char* data, size_t size) override {
        if (read_ >= limits_.requestBytes || !is_readable()) return -1;
        const ssize_t got = ::recv(socket_, data, std::min(size, limits_.requestBytes - read_), 0);
        if (got > 0) read_ += static_cast<std::size_t>(got);
        return got;
    }
    ssize_t write(const char* data, size_t size) override {
        if (!wait(POLLOUT, limits_.writeTime)) return -1;
        return ::send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    }
    void get_remote_ip_and_port(std::string& address, int& port) const override {
        address = "127.0.0.1";
        port = 0;
    }
    void get_local_ip_and_port(std::string& address, int& port) const override {
        get_remote_ip_and_port(address, port);
    }
    [[nodiscard]] socket_t socket() const override { return socket_; }

  private:
    [[nodiscard]] std::chrono::milliseconds remaining() const {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - std::chrono::steady_clock::now());
        return std::max(left, std::chrono::milliseconds(0));
    }
    [[nodiscard]] bool wait(short events,
                            std::chrono::milliseconds limit) const {  // NOLINT(google-runtime-int): poll's type.
        pollfd one{.fd = socket_, .events = events, .revents = 0};
        return ::poll(&one, 1, static_cast<int>(limit.count())) > 0 && (one.revents & events) != 0;
    }

    socket_t socket_;
    HttpServer::Limits limits_;
    SteadyTime deadline_;
    std::size_t read_ = 0;
};

}  // namespace

HttpServer::HttpServer(const Limits& limits) : limits_(limits) {
    new_task_queue = [threads = limits.threads] { return new BoundedQueue(threads); };
    // The library would share the port with another server of the same user, and neither would notice.
    set_socket_options([](socket_t socket) {
        const int yes = 1;
        ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    set_tcp_nodelay(true);
    set_payload_max_length(limits.requestBytes);
}

int HttpServer::bind(int port) {
    constexpr const char* kLoopback = "127.0.0.1";
    if (port == 0) return std::max(0, bind_to_any_port(kLoopback));
    return bind_to_port(kLoopback, port) ? port : 0;
}

void HttpServer::run() {
    listen_after_bind();
    finished_ = true;
}

void HttpServer::end() {
    // The library forgets a stop that comes before its loop has begun. A loop that ended by itself begins no more.
    while (!is_running() && !finished_)
        std::this_thread::yield();
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        for (const socket_t socket : sockets_)
            ::shutdown(socket, SHUT_RDWR);
    }
    stop();
}

bool HttpServer::process_and_close_socket(socket_t socket) {
    ::fcntl(socket, F_SETFD, FD_CLOEXEC);  // NOLINT(cppcoreguidelines-pro-type-vararg)
    bool serve = false;
    {
        const std::lock_guard lock(mutex_);
        serve = !ending_;
        if (serve) sockets_.insert(socket);
    }
    if (serve) {
        BoundedStream stream(socket, limits_);
        bool closed = false;
        process_request(stream, true, closed, nullptr);
    }
    const std::lock_guard lock(mutex_);
    sockets_.erase(socket);
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return true;
}

}  // namespace cheval::hal
