#include "hal/sim/openni/faults.h"

#include <charconv>

namespace cheval::hal::sim {

namespace {

bool toNumber(std::string_view text, int& value) {
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    return fault == std::errc() && end == text.data() + text.size() && value >= 0;
}

}  // namespace

bool Faults::obey(std::string_view command) {
    const std::size_t blank = command.find(' ');
    const std::string_view verb = command.substr(0, blank);
    const std::string_view rest = blank == std::string_view::npos ? std::string_view() : command.substr(blank + 1);
    if (verb == "stall" || verb == "resume") {
        stalled = verb == "stall";
    } else if (verb == "garbage") {
        garbage = true;
    } else if (verb == "lie") {
        lying = true;
    } else if (verb == "sound") {
        garbage = false;
        lying = false;
        slowMs = 0;
    } else if (verb == "busy" || verb == "free") {
        busy = verb == "busy";
    } else if (verb == "slow") {
        int milliseconds = 0;
        if (!toNumber(rest, milliseconds)) return false;
        slowMs = milliseconds;
    } else if (verb == "mode") {
        if (rest != "640x480" && rest != "320x240" && rest != "160x120") return false;
        shrink = rest == "640x480" ? 1 : rest == "320x240" ? 2 : 4;
    } else if (verb == "hang" || verb == "unhang") {
        const std::lock_guard lock(mutex_);
        if (verb == "unhang") {
            hanging_ = HangingCall::none;
        } else if (rest == "open") {
            hanging_ = HangingCall::open;
        } else if (rest == "close") {
            hanging_ = HangingCall::close;
        } else if (rest == "read") {
            hanging_ = HangingCall::read;
        } else {
            return false;
        }
        changed_.notify_all();
    } else {
        return false;
    }
    return true;
}

void Faults::passThrough(HangingCall call) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return hanging_ != call; });
}

}  // namespace cheval::hal::sim
