#include "hal/preview/preview_server.h"

#include <array>
#include <atomic>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "hal/preview/button_queue.h"
#include "hal/preview/http_server.h"
#include "hal/preview/jpeg_stream.h"
#include "hal/preview/page.h"
#include "hal/preview/preview_display.h"

namespace cheval::hal {

namespace {

using httplib::Request;
using httplib::Response;

constexpr int kMaxSide = 8192;
constexpr Duration kSnapshotLimit = std::chrono::seconds(2);
// How long a viewer's thread waits for the next picture before it looks whether the viewer is still there.
constexpr Duration kViewerLimit = std::chrono::seconds(1);
constexpr std::string_view kBoundary = "--picture\r\n";

struct NamedButton {
    const char* path;
    Button button;
};
constexpr std::array kButtons{
    NamedButton{"/button/next", Button::next}, NamedButton{"/button/previous", Button::previous},
    NamedButton{"/button/view", Button::view}, NamedButton{"/button/service", Button::service}};

// The longest beginning of at most `limit` bytes that does not cut a UTF-8 character.
std::string_view cut(std::string_view text, std::size_t limit) {
    if (text.size() <= limit) return text;
    while (limit > 0 && (static_cast<unsigned char>(text[limit]) & 0xC0U) == 0x80U)
        --limit;
    return text.substr(0, limit);
}

// One who looks, counted as long as they do.
class Viewer {
  public:
    explicit Viewer(PreviewDisplay& display) : display_(display) { display_.addViewer(); }
    ~Viewer() { display_.removeViewer(); }
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

  private:
    PreviewDisplay& display_;
};

class HttpPreview final : public PreviewServer {
  public:
    HttpPreview(const PreviewOptions& options, Clock& clock)
        : clock_(clock),
          display_(options.mode),
          jpegs_(display_, options.mode, options.streamWidth, options.jpegQuality) {
        status_.reserve(kMaxStatusBytes);
        route();
    }

    ~HttpPreview() override {
        if (!thread_.joinable()) return;
        jpegs_.stop();
        server_.end();
        thread_.join();
    }
    HttpPreview(const HttpPreview&) = delete;
    HttpPreview& operator=(const HttpPreview&) = delete;

    bool start(int port) {
        port_ = server_.bind(port);
        if (port_ == 0) return false;
        hosts_ = {"127.0.0.1:" + std::to_string(port_), "localhost:" + std::to_string(port_)};
        thread_ = std::thread([this] { server_.run(); });
        return true;
    }

    [[nodiscard]] std::string address() const override { return "http://" + hosts_[0] + "/"; }
    [[nodiscard]] Display& display() override { return display_; }
    [[nodiscard]] Buttons& buttons() override { return buttons_; }
    void setStatus(std::string_view status) override {
        const std::lock_guard lock(statusMutex_);
        status_.assign(cut(status, kMaxStatusBytes));
    }

  private:
    void route() {
        server_.set_default_headers({{"Content-Security-Policy",
                                      "default-src 'none'; img-src 'self'; style-src 'self'; script-src 'self'; "
                                      "connect-src 'self'; base-uri 'none'; "
                                      "form-action 'none'; frame-ancestors 'none'"},
                                     {"X-Content-Type-Options", "nosniff"},
                                     {"X-Frame-Options", "DENY"},
                                     {"Referrer-Policy", "no-referrer"},
                                     {"Cross-Origin-Resource-Policy", "same-origin"},
                                     {"Cache-Control", "no-store"}});
        server_.set_pre_routing_handler([this](const Request& request, Response& response) {
            if (isOurs(request)) return httplib::Server::HandlerResponse::Unhandled;
            response.status = 403;
            response.set_content("This page answers itself only.\n", "text/plain");
            return httplib::Server::HandlerResponse::Handled;
        });
        serveText("/", kPageHtml, "text/html; charset=utf-8");
        serveText("/page.css", kPageStyle, "text/css; charset=utf-8");
        serveText("/page.js", kPageScript, "text/javascript; charset=utf-8");
        serveText("/favicon.svg", kPageIcon, "image/svg+xml");
        serveText("/favicon.ico", kPageIcon, "image/svg+xml");
        server_.Get("/status.json", [this](const Request&, Response& response) { serveStatus(response); });
        server_.Get("/snapshot.jpg", [this](const Request&, Response& response) { serveSnapshot(response); });
        server_.Get("/stream.mjpg", [this](const Request&, Response& response) { serveStream(response); });
        for (const NamedButton& named : kButtons) {
            server_.Post(named.path, [this, button = named.button](const Request&, Response& response) {
                buttons_.press({.button = button, .action = ButtonAction::pressed, .time = clock_.now()});
                response.status = 204;
            });
        }
    }

    // Another site's page must neither press buttons nor read pictures, not even through a name of its own that it
    // points at this machine.
    [[nodiscard]] bool isOurs(const Request& request) const {
        const std::string host = request.get_header_value("Host");
        if (host != hosts_[0] && host != hosts_[1]) return false;
        if (request.has_header("Sec-Fetch-Site")) {
            const std::string site = request.get_header_value("Sec-Fetch-Site");
            if (site != "same-origin" && site != "none") return false;
        }
        return !request.has_header("Origin") || request.get_header_value("Origin") == "http://" + host;
    }

    void serveText(const char* path, std::string_view text, const char* type) {
        server_.Get(path, [text, type](const Request&, Response& response) {
            response.set_content(text.data(), text.size(), type);
        });
    }

    void serveStatus(Response& response) {
        const DisplayStatistics statistics = display_.statistics();
        nlohmann::ordered_json json{{"presented", statistics.presented}, {"dropped", statistics.dropped},
                                    {"open", statistics.connected},      {"viewers", display_.viewers()},
                                    {"buttons", buttons_.pressed()},     {"buttonsDropped", buttons_.dropped()},
                                    {"width", jpegs_.width()},           {"height", jpegs_.height()}};
        {
            const std::lock_guard lock(statusMutex_);
            json["status"] = status_;
        }
        // Text that is not UTF-8 is replaced, not refused: the line is for people.
        response.set_content(json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace),
                             "application/json");
    }

    void serveSnapshot(Response& response) {
        const std::uint64_t number = display_.lastNumber();
        std::shared_ptr<const JpegPicture> jpeg;
        if (number > 0) {
            const Viewer viewer(display_);
            jpeg = jpegs_.next(number - 1, kSnapshotLimit);
        }
        if (jpeg == nullptr) jpeg = jpegs_.latest();
        if (jpeg == nullptr) return refuse(response, "There is no picture yet.\n");
        response.set_content(reinterpret_cast<const char*>(jpeg->bytes.data()), jpeg->bytes.size(), "image/jpeg");
    }

    void serveStream(Response& response) {
        if (streams_.fetch_add(1) >= kMaxViewers) {
            --streams_;
            return refuse(response, "Too many viewers.\n");
        }
        // Both counts are taken back by whoever ends the stream, whether or not a picture was ever sent.
        auto viewer = std::make_shared<Viewer>(display_);
        auto shown = std::make_shared<std::uint64_t>(0);
        response.set_content_provider(
            "multipart/x-mixed-replace; boundary=picture",
            [this, viewer, shown](std::size_t /*offset*/, httplib::DataSink& sink) {
                const auto jpeg = jpegs_.next(*shown, kViewerLimit);
                if (jpeg == nullptr) return !ending(sink);
                const bool first = std::exchange(*shown, jpeg->number) == 0;
                std::string head = first ? std::string(kBoundary) : std::string();
                head +=
                    "Content-Type: image/jpeg\r\nContent-Length: " + std::to_string(jpeg->bytes.size()) + "\r\n\r\n";
                // The boundary goes out with its picture: browsers show a part only once it is over.
                const std::string tail = "\r\n" + std::string(kBoundary);
                return sink.write(head.data(), head.size()) &&
                       sink.write(reinterpret_cast<const char*>(jpeg->bytes.data()), jpeg->bytes.size()) &&
                       sink.write(tail.data(), tail.size());
            },
            [this](bool /*success*/) { --streams_; });
    }

    static bool ending(const httplib::DataSink& sink) { return !sink.is_writable(); }

    static void refuse(Response& response, const char* text) {
        response.status = 503;
        response.set_content(text, "text/plain");
    }

    Clock& clock_;
    PreviewDisplay display_;
    JpegStream jpegs_;
    ButtonQueue buttons_;
    std::mutex statusMutex_;
    std::string status_;
    std::atomic<int> streams_{0};
    int port_ = 0;
    std::array<std::string, 2> hosts_;
    HttpServer server_{HttpServer::Limits{}};
    std::thread thread_;
};

}  // namespace

Expected<std::unique_ptr<PreviewServer>> startPreview(const PreviewOptions& options, Clock& clock) {
    if (options.mode.width <= 0 || options.mode.height <= 0 || options.mode.width > kMaxSide ||
        options.mode.height > kMaxSide) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the preview would have " + std::to_string(options.mode.width) + " by " +
                              std::to_string(options.mode.height) + " pixels",
                     .mend = "use 1 to " + std::to_string(kMaxSide)};
    }
    auto server = std::make_unique<HttpPreview>(options, clock);
    if (!server->start(options.port)) {
        return Error{.code = ErrorCode::conflict,
                     .cause = "port " + std::to_string(options.port) + " of 127.0.0.1 cannot be had",
                     .mend = "end the program that uses it, or set another port (0 for any free one)",
                     .why = "the preview serves its page there"};
    }
    return std::unique_ptr<PreviewServer>(std::move(server));
}

}  // namespace cheval::hal
