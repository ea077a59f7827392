#include "hal/preview/preview_display.h"

#include <algorithm>

namespace cheval::hal {

PreviewDisplay::PreviewDisplay(const DisplayMode& mode) : mode_(mode) {
    for (Image<Rgba8>& picture : pictures_)
        picture.resize(mode.width, mode.height);
}

PreviewDisplay::Slot* PreviewDisplay::find(Slot state) {
    auto* const slot = std::find(slots_.begin(), slots_.end(), state);
    return slot == slots_.end() ? nullptr : slot;
}

Expected<DisplayMode> PreviewDisplay::open() {
    const std::lock_guard lock(mutex_);
    if (open_)
        return Error{.code = ErrorCode::invalidInput, .cause = "the display is open already", .mend = "close it first"};
    open_ = true;
    statistics_ = {};
    return mode_;
}

void PreviewDisplay::close() {
    const std::lock_guard lock(mutex_);
    open_ = false;
    // What is taken stays so: its pixels are being read.
    std::replace_if(
        slots_.begin(), slots_.end(), [](Slot slot) { return slot != Slot::taken; }, Slot::free);
}

Expected<DisplayBuffer> PreviewDisplay::lend(Duration /*timeout*/) {
    const std::lock_guard lock(mutex_);
    if (!open_) return Error{.code = ErrorCode::unavailable, .cause = "the display is closed", .mend = "open it first"};
    if (find(Slot::lent) != nullptr) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the display's buffer is on loan already",
                     .mend = "present it first"};
    }
    // One may be ready and one taken; the third is free.
    Slot* const slot = find(Slot::free);
    *slot = Slot::lent;
    return DisplayBuffer{.pixels = pictures_[indexOf(slot)].view(), .slot = ++loan_};
}

Expected<void> PreviewDisplay::present(const DisplayBuffer& buffer, TimePoint /*time*/) {
    {
        const std::lock_guard lock(mutex_);
        Slot* const lent = find(Slot::lent);
        if (lent == nullptr || buffer.slot != loan_ || buffer.pixels.data != pictures_[indexOf(lent)].pixels.data()) {
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "this buffer is not on loan",
                         .mend = "present what lend() gave, once"};
        }
        if (Slot* const replaced = find(Slot::ready)) {
            *replaced = Slot::free;
            ++statistics_.dropped;
        }
        *lent = Slot::ready;
        ++statistics_.presented;
        ++lastNumber_;
    }
    changed_.notify_one();
    return {};
}

DisplayStatistics PreviewDisplay::statistics() const {
    const std::lock_guard lock(mutex_);
    DisplayStatistics statistics = statistics_;
    statistics.connected = open_;
    return statistics;
}

std::uint64_t PreviewDisplay::lastNumber() const {
    const std::lock_guard lock(mutex_);
    return lastNumber_;
}

void PreviewDisplay::addViewer() {
    {
        const std::lock_guard lock(mutex_);
        ++viewers_;
    }
    changed_.notify_one();
}

void PreviewDisplay::removeViewer() {
    const std::lock_guard lock(mutex_);
    --viewers_;
}

int PreviewDisplay::viewers() const {
    const std::lock_guard lock(mutex_);
    return viewers_;
}

bool PreviewDisplay::take(Picture& picture) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stopped_ || (viewers_ > 0 && find(Slot::ready) != nullptr); });
    if (stopped_) return false;
    Slot* const slot = find(Slot::ready);
    *slot = Slot::taken;
    picture = {.pixels = std::as_const(pictures_[indexOf(slot)]).view(), .number = lastNumber_};
    return true;
}

void PreviewDisplay::giveBack() {
    const std::lock_guard lock(mutex_);
    if (Slot* const slot = find(Slot::taken)) *slot = Slot::free;
}

void PreviewDisplay::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopped_ = true;
    }
    changed_.notify_all();
}

}  // namespace cheval::hal
