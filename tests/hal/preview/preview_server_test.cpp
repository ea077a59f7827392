#include "hal/preview/preview_server.h"

#include <algorithm>
#include <thread>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <turbojpeg.h>
#include <unistd.h>

#include "tests/support/allocation_counter.h"

namespace cheval::hal {
namespace {

using testing::HasSubstr;

constexpr DisplayMode kMode{.width = 64, .height = 128, .refreshHz = 30};

// The mean colour of a JPEG, and its size.
struct Decoded {
    int width = 0;
    int height = 0;
    Rgb8 middle;
};

Decoded decode(const std::string& jpeg) {
    Decoded decoded;
    void* const handle = tjInitDecompress();
    int sampling = 0;
    int colours = 0;
    const auto* bytes = reinterpret_cast<const unsigned char*>(jpeg.data());
    if (tjDecompressHeader3(handle, bytes, jpeg.size(), &decoded.width, &decoded.height, &sampling, &colours) == 0) {
        Image<Rgb8> pixels(decoded.width, decoded.height);
        tjDecompress2(handle, bytes, jpeg.size(), &pixels.pixels[0].r, decoded.width, 0, decoded.height, TJPF_RGB, 0);
        decoded.middle = pixels.view().at(decoded.width / 2, decoded.height / 2);
    }
    tjDestroy(handle);
    return decoded;
}

class PreviewServerTest : public testing::Test {
  protected:
    void SetUp() override {
        auto started = startPreview({.mode = kMode, .port = 0, .jpegQuality = 90, .streamWidth = 32}, clock_);
        ASSERT_TRUE(started) << started.error().message();
        server_ = std::move(*started);
        ASSERT_TRUE(server_->display().open());
        const std::string address = server_->address();
        host_ = address.substr(7, address.size() - 8);
        port_ = std::stoi(host_.substr(host_.find(':') + 1));
    }

    [[nodiscard]] std::unique_ptr<httplib::Client> client() const {
        auto made = std::make_unique<httplib::Client>("127.0.0.1", port_);
        made->set_read_timeout(std::chrono::seconds(60));
        return made;
    }

    void show(Rgba8 colour) const {
        auto buffer = server_->display().lend(Duration::zero());
        ASSERT_TRUE(buffer);
        for (int y = 0; y < buffer->pixels.height; ++y) {
            std::fill_n(buffer->pixels.row(y), buffer->pixels.width, colour);
        }
        ASSERT_TRUE(server_->display().present(*buffer, clock_.now()));
    }

    [[nodiscard]] nlohmann::json status() const { return nlohmann::json::parse(client()->Get("/status.json")->body); }

    // A connection that has sent `text` and nothing more.
    [[nodiscard]] int rawConnection(const std::string& text) const {
        const int connection = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port_));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        EXPECT_EQ(::send(connection, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
        return connection;
    }

    VirtualClock clock_;
    std::unique_ptr<PreviewServer> server_;
    std::string host_;
    int port_ = 0;
};

TEST_F(PreviewServerTest, ServesItsPageWithStrictHeaders) {
    for (const auto& [path, type] : {std::pair{"/", "text/html"},
                                     {"/page.css", "text/css"},
                                     {"/page.js", "text/javascript"},
                                     {"/favicon.svg", "image/svg+xml"},
                                     {"/favicon.ico", "image/svg+xml"}}) {
        const auto answer = client()->Get(path);
        ASSERT_TRUE(answer) << path;
        EXPECT_EQ(answer->status, 200) << path;
        EXPECT_THAT(answer->get_header_value("Content-Type"), HasSubstr(type));
        EXPECT_THAT(answer->get_header_value("Content-Security-Policy"), HasSubstr("default-src 'none'"));
        EXPECT_EQ(answer->get_header_value("X-Content-Type-Options"), "nosniff");
        EXPECT_FALSE(answer->has_header("Access-Control-Allow-Origin"));
        EXPECT_FALSE(answer->body.empty());
    }
    EXPECT_EQ(client()->Get("/nothing")->status, 404);
}

TEST_F(PreviewServerTest, ThePageNeedsNothingFromElsewhere) {
    for (const char* path : {"/", "/page.css", "/page.js"}) {
        const std::string body = client()->Get(path)->body;
        EXPECT_THAT(body, testing::Not(HasSubstr("http:"))) << path;
        EXPECT_THAT(body, testing::Not(HasSubstr("https:"))) << path;
    }
}

TEST_F(PreviewServerTest, ASnapshotShowsWhatWasPresentedLast) {
    EXPECT_EQ(client()->Get("/snapshot.jpg")->status, 503);
    for (const Rgba8 colour : {Rgba8{255, 0, 0, 255}, Rgba8{0, 0, 255, 255}}) {
        show({9, 9, 9, 255});
        show(colour);
        const auto answer = client()->Get("/snapshot.jpg");
        ASSERT_TRUE(answer);
        ASSERT_EQ(answer->status, 200);
        EXPECT_EQ(answer->get_header_value("Content-Type"), "image/jpeg");
        const Decoded decoded = decode(answer->body);
        EXPECT_EQ(decoded.width, 32);
        EXPECT_EQ(decoded.height, 64);
        EXPECT_NEAR(decoded.middle.r, colour.r, 8);
        EXPECT_NEAR(decoded.middle.b, colour.b, 8);
    }
    // The same picture again, though it was encoded already.
    EXPECT_NEAR(decode(client()->Get("/snapshot.jpg")->body).middle.b, 255, 8);
}

TEST_F(PreviewServerTest, TheStreamShowsPicturesAsTheyArePresented) {
    show({255, 0, 0, 255});
    std::string received;
    int parts = 0;
    std::vector<Rgb8> middles;
    client()->Get("/stream.mjpg", [&](const char* data, std::size_t size) {
        received.append(data, size);
        // A part is over with the boundary after it; the first boundary comes before anything.
        std::size_t end = 0;
        while ((end = received.find("\r\n--picture\r\n", 1)) != std::string::npos) {
            const std::size_t body = received.find("\r\n\r\n");
            middles.push_back(decode(received.substr(body + 4, end - body - 4)).middle);
            received.erase(0, end + 2);
            show(++parts == 1 ? Rgba8{0, 255, 0, 255} : Rgba8{0, 0, 255, 255});
        }
        return parts < 3;
    });
    ASSERT_EQ(middles.size(), 3U);
    EXPECT_NEAR(middles[0].r, 255, 8);
    EXPECT_NEAR(middles[1].g, 255, 8);
    EXPECT_NEAR(middles[2].b, 255, 8);
}

TEST_F(PreviewServerTest, ButtonsArriveInOrderWithTheClocksTime) {
    clock_.advance(fromSeconds(7));
    EXPECT_EQ(client()->Post("/button/next")->status, 204);
    clock_.advance(fromSeconds(1));
    EXPECT_EQ(client()->Post("/button/previous")->status, 204);
    EXPECT_EQ(client()->Post("/button/view")->status, 204);
    EXPECT_EQ(client()->Post("/button/service")->status, 204);
    EXPECT_EQ(client()->Post("/button/wake")->status, 404);
    EXPECT_EQ(client()->Get("/button/next")->status, 404);
    std::array<ButtonEvent, 8> events;
    ASSERT_EQ(*server_->buttons().poll(events), 4U);
    EXPECT_EQ(events[0].button, Button::next);
    EXPECT_EQ(events[0].action, ButtonAction::pressed);
    EXPECT_EQ(events[0].time, TimePoint(fromSeconds(7)));
    EXPECT_EQ(events[1].button, Button::previous);
    EXPECT_EQ(events[1].time, TimePoint(fromSeconds(8)));
    EXPECT_EQ(events[2].button, Button::view);
    EXPECT_EQ(events[3].button, Button::service);
    EXPECT_EQ(status()["buttons"], 4);
}

TEST_F(PreviewServerTest, AnotherSitesPageCanDoNothing) {
    const std::vector<httplib::Headers> foreign{{{"Origin", "http://evil.example"}},
                                                {{"Origin", "null"}},
                                                {{"Origin", "https://" + host_}},
                                                {{"Sec-Fetch-Site", "cross-site"}},
                                                {{"Sec-Fetch-Site", "same-site"}},
                                                {{"Host", "evil.example"}},
                                                {{"Host", "evil.example:" + std::to_string(port_)},
                                                 {"Origin", "http://evil.example:" + std::to_string(port_)}}};
    show({});
    for (const auto& headers : foreign) {
        EXPECT_EQ(client()->Post("/button/next", headers, "", "text/plain")->status, 403);
        EXPECT_EQ(client()->Get("/snapshot.jpg", headers)->status, 403);
    }
    EXPECT_EQ(
        client()
            ->Post("/button/next", httplib::Headers{{"Origin", "http://" + host_}, {"Sec-Fetch-Site", "same-origin"}},
                   "", "text/plain")
            ->status,
        204);
    std::array<ButtonEvent, 8> events;
    EXPECT_EQ(*server_->buttons().poll(events), 1U);
}

TEST_F(PreviewServerTest, TheStatusLineIsBoundedTextWhateverItHolds) {
    server_->setStatus("T-shirt · \"30 fps\" <b>\n");
    EXPECT_EQ(status()["status"], "T-shirt · \"30 fps\" <b>\n");
    server_->setStatus("\xFF\xFE broken");
    EXPECT_THAT(status()["status"].get<std::string>(), HasSubstr("broken"));
    std::string umlauts;
    for (int i = 0; i < 500; ++i)
        umlauts += "ä";
    server_->setStatus("x" + umlauts);
    EXPECT_EQ(status()["status"], "x" + umlauts.substr(0, 238));
}

TEST_F(PreviewServerTest, SettingTheStatusTakesNoMemory) {
    const std::string text(500, 'x');
    const test::AllocationCounter counter;
    for (int i = 0; i < 10; ++i)
        server_->setStatus(text);
    EXPECT_EQ(counter.count(), 0U);
}

TEST_F(PreviewServerTest, TheStatusCountsWhatHappened) {
    for (int i = 0; i < 5; ++i)
        show({});
    const auto counted = status();
    EXPECT_EQ(counted["presented"], 5);
    EXPECT_EQ(counted["dropped"], 4);
    EXPECT_EQ(counted["viewers"], 0);
    EXPECT_EQ(counted["width"], 32);
    EXPECT_EQ(counted["height"], 64);
}

TEST_F(PreviewServerTest, MoreViewersThanAllowedAreTurnedAwayAndTheRestGoesOn) {
    show({});
    const std::string request = "GET /stream.mjpg HTTP/1.1\r\nHost: " + host_ + "\r\n\r\n";
    std::vector<int> viewers;
    for (int i = 0; i < PreviewServer::kMaxViewers; ++i) {
        viewers.push_back(rawConnection(request));
        char byte = 0;
        ASSERT_EQ(::recv(viewers.back(), &byte, 1, MSG_WAITALL), 1);
    }
    EXPECT_EQ(client()->Get("/stream.mjpg")->status, 503);
    EXPECT_EQ(status()["viewers"], PreviewServer::kMaxViewers);
    EXPECT_EQ(client()->Post("/button/next")->status, 204);
    // None of them reads on; drawing goes on all the same.
    for (int i = 0; i < 2000; ++i)
        show({static_cast<std::uint8_t>(i), 1, 2, 255});
    for (const int viewer : viewers)
        ::close(viewer);
    while (status()["viewers"] != 0)
        show({});
}

TEST_F(PreviewServerTest, RequestsWithoutEndAreCutOff) {
    const std::string start = "GET / HTTP/1.1\r\nHost: " + host_ + "\r\n";
    const int connection = rawConnection(start);
    const std::string header = "X-More: " + std::string(1000, 'x') + "\r\n";
    // The server closes once the request's budget is spent; sending then fails.
    int sent = 0;
    while (sent < 10000 && ::send(connection, header.data(), header.size(), MSG_NOSIGNAL) > 0)
        ++sent;
    EXPECT_LT(sent, 10000);
    ::close(connection);
    EXPECT_EQ(client()->Get("/")->status, 200);
}

TEST_F(PreviewServerTest, EndsAtOnceWithEveryKindOfClientConnected) {
    show({});
    const int idle = rawConnection("");
    const int slow = rawConnection("GET / HT");
    const int viewer = rawConnection("GET /stream.mjpg HTTP/1.1\r\nHost: " + host_ + "\r\n\r\n");
    char byte = 0;
    ASSERT_EQ(::recv(viewer, &byte, 1, MSG_WAITALL), 1);
    server_.reset();
    // Every connection is over; what was on its way may still be read.
    for (const int connection : {idle, slow, viewer}) {
        char rest[4096];
        while (::recv(connection, rest, sizeof rest, 0) > 0) {
        }
        ::close(connection);
    }
}

TEST_F(PreviewServerTest, APortInUseIsRefusedWithAMend) {
    const auto second = startPreview({.mode = kMode, .port = static_cast<std::uint16_t>(port_)}, clock_);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::conflict);
    EXPECT_THAT(second.error().cause, HasSubstr(std::to_string(port_)));
    EXPECT_FALSE(second.error().mend.empty());
}

TEST_F(PreviewServerTest, ThePortIsFreeAgainAfterwards) {
    server_.reset();
    EXPECT_TRUE(startPreview({.mode = kMode, .port = static_cast<std::uint16_t>(port_)}, clock_));
}

TEST(PreviewTest, StartsAndEndsManyTimes) {
    VirtualClock clock;
    for (int i = 0; i < 50; ++i)
        EXPECT_TRUE(startPreview({.mode = kMode, .port = 0}, clock));
}

TEST(PreviewTest, AModeWithoutPixelsIsRefused) {
    VirtualClock clock;
    EXPECT_FALSE(startPreview({.mode = {.width = 0, .height = 5}, .port = 0}, clock));
    EXPECT_FALSE(startPreview({.mode = {.width = 5, .height = 50000}, .port = 0}, clock));
}

}  // namespace
}  // namespace cheval::hal
