#include "hal/headless/headless_display.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "hal/png/png.h"

namespace cheval::hal {

namespace {

class HeadlessDisplay final : public Display {
  public:
    explicit HeadlessDisplay(HeadlessOptions options) : options_(std::move(options)) {}

    Expected<DisplayMode> open() override {
        if (open_)
            return Error{
                .code = ErrorCode::invalidInput, .cause = "the display is open already", .mend = "close it first"};
        if (options_.mode.width <= 0 || options_.mode.height <= 0 || options_.mode.width > kMaxSide ||
            options_.mode.height > kMaxSide) {
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "the display would have " + std::to_string(options_.mode.width) + " by " +
                                  std::to_string(options_.mode.height) + " pixels",
                         .mend = "use 1 to " + std::to_string(kMaxSide)};
        }
        if (!options_.folder.empty()) {
            std::error_code code;
            std::filesystem::create_directories(options_.folder, code);
            if (code) {
                return Error{.code = ErrorCode::resource,
                             .cause = "the folder cannot be made: " + code.message(),
                             .mend = "name a folder that this user may write",
                             .file = options_.folder};
            }
        }
        picture_.resize(options_.mode.width, options_.mode.height);
        presented_ = 0;
        dropped_ = 0;
        open_ = true;
        lent_ = false;
        return options_.mode;
    }

    void close() override {
        open_ = false;
        lent_ = false;
    }

    Expected<DisplayBuffer> lend(Duration /*timeout*/) override {
        if (!open_)
            return Error{.code = ErrorCode::unavailable, .cause = "the display is closed", .mend = "open it first"};
        if (lent_)
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "the display's buffer is on loan already",
                         .mend = "present it first"};
        lent_ = true;
        return DisplayBuffer{.pixels = picture_.view(), .slot = ++slot_};
    }

    Expected<void> present(const DisplayBuffer& buffer, TimePoint /*time*/) override {
        if (!lent_ || buffer.slot != slot_) {
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "this buffer is not on loan",
                         .mend = "present what lend() gave, once"};
        }
        lent_ = false;
        const std::uint64_t number = presented_++;
        if (options_.folder.empty() || number % static_cast<std::uint64_t>(std::max(1, options_.every)) != 0) return {};
        std::array<char, 40> name{};
        std::snprintf(name.data(), name.size(), "/frame-%06llu.png", static_cast<unsigned long long>(number));
        auto written =
            writePng(options_.folder + name.data(), std::as_const(picture_).view(), {.compression = kCompression});
        if (!written) ++dropped_;
        return written;
    }

    [[nodiscard]] DisplayStatistics statistics() const override {
        return {.presented = presented_, .dropped = dropped_, .connected = open_};
    }

  private:
    static constexpr int kMaxSide = 8192;
    // Pictures of a mirror hardly get smaller beyond this, but take much longer.
    static constexpr int kCompression = 3;

    HeadlessOptions options_;
    Image<Rgba8> picture_;
    // Atomic because any thread may read statistics().
    std::atomic<std::uint64_t> presented_{0};
    std::atomic<std::uint64_t> dropped_{0};
    std::atomic<bool> open_{false};
    bool lent_ = false;
    std::uint32_t slot_ = 0;
};

}  // namespace

std::unique_ptr<Display> makeHeadlessDisplay(const HeadlessOptions& options) {
    return std::make_unique<HeadlessDisplay>(options);
}

}  // namespace cheval::hal
