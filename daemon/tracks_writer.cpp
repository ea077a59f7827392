#include "daemon/tracks_writer.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace cheval::daemon {

namespace {

std::string_view name(fitting::Side side) {
    return side == fitting::Side::left ? "left" : "right";
}

std::string_view name(fitting::GestureKind kind) {
    switch (kind) {
        case fitting::GestureKind::swipe:
            return "swipe";
        case fitting::GestureKind::grab:
            return "grab";
        case fitting::GestureKind::raise:
            return "raise";
        case fitting::GestureKind::hold:
            return "hold";
    }
    return "";
}

}  // namespace

Expected<std::unique_ptr<TracksWriter>> TracksWriter::create(const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "we");
    if (file == nullptr) {
        return Error{.code = ErrorCode::unavailable,
                     .cause = std::string("the tracks file cannot be written: ") + std::strerror(errno),
                     .mend = "name a file in a folder that exists and may be written",
                     .file = path};
    }
    return std::unique_ptr<TracksWriter>(new TracksWriter(path, file));
}

TracksWriter::~TracksWriter() {
    if (file_ != nullptr) std::fclose(file_);
}

Expected<void> TracksWriter::writeLine(const std::string& line) {
    if (file_ != nullptr && std::fputs(line.c_str(), file_) >= 0 && std::fputc('\n', file_) != EOF &&
        std::fflush(file_) == 0)
        return {};
    return Error{.code = ErrorCode::resource,
                 .cause = std::string("the tracks file cannot be written: ") + std::strerror(errno),
                 .mend = "make room on the disk",
                 .file = path_};
}

Expected<void> TracksWriter::writeFrame(const hal::DepthFrame& frame, const fitting::Skeleton& skeleton,
                                        const fitting::Hands& hands, const fitting::SensorPlacement& placement) {
    std::string line = fmt::format(R"({{"frame": {}, "time": {:.4f}, "user": {}, "joints": {{)", frame.sourceIndex,
                                   hal::seconds(frame.captureTime), skeleton.userId);
    bool first = true;
    for (std::size_t i = 0; i < fitting::kJointCount && skeleton.present(); ++i) {
        const fitting::JointState& joint = skeleton.joints[i];
        const Eigen::Vector3f sensor = placement.toSensor(joint.position);
        // JSON knows no NaN: a joint without a place is left out.
        if (!sensor.allFinite()) continue;
        fmt::format_to(std::back_inserter(line), R"({}"{}": [{:.1f}, {:.1f}, {:.1f}, {:.3f}])", first ? "" : ", ",
                       fitting::kJointNames[i], sensor.x(), sensor.y(), sensor.z(), joint.confidence);
        first = false;
    }
    fmt::format_to(std::back_inserter(line), R"(}}, "hands": {{"left": "{}", "right": "{}"}}}})",
                   nameOf(hands[fitting::Side::left].state), nameOf(hands[fitting::Side::right].state));
    return writeLine(line);
}

void TracksWriter::addGestures(const fitting::Hands& hands) {
    for (std::size_t i = 0; i < hands.gestureCount && i < hands.gestures.size(); ++i)
        events_.push_back(hands.gestures[i]);
}

Expected<void> TracksWriter::finish(const fitting::Measurements* measurements) {
    std::string line = R"({"measurements": {)";
    bool first = true;
    for (std::size_t i = 0; i < fitting::kDimensionCount && measurements != nullptr; ++i) {
        const fitting::Measurement& measurement = measurements->dimensions[i];
        if (!measurement.valid || !std::isfinite(measurement.value)) continue;
        fmt::format_to(std::back_inserter(line), R"({}"{}": {:.1f})", first ? "" : ", ", fitting::kDimensionNames[i],
                       measurement.value * 100.0F);
        first = false;
    }
    Expected<void> written = writeLine(line + "}}");
    if (!written) return written;

    line = R"({"events": [)";
    for (std::size_t i = 0; i < events_.size(); ++i) {
        const fitting::GestureEvent& event = events_[i];
        fmt::format_to(std::back_inserter(line), R"({}{{"type": "{}", )", i == 0 ? "" : ", ", name(event.kind));
        if (event.kind == fitting::GestureKind::swipe) {
            fmt::format_to(std::back_inserter(line), R"("direction": "{}", )",
                           event.direction == fitting::SwipeDirection::left ? "left" : "right");
        }
        fmt::format_to(std::back_inserter(line), R"("hand": "{}", "start": {}, "end": {}}})", name(event.hand),
                       event.startFrame, event.endFrame);
    }
    written = writeLine(line + "]}");
    std::fclose(std::exchange(file_, nullptr));
    return written;
}

}  // namespace cheval::daemon
