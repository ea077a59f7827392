// How late the tracked paths are.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/fitting/tracking/visit_figures.h"

namespace cheval::fitting::test {

namespace {

using Eigen::Vector3f;

constexpr std::size_t kLeastFrames = 90;

/// Truth of a joint at any time of the visit, between frames by a straight line. Metres along the mirror frame's x, in
/// which people pace.
double truthAt(const VisitRecording& recording, std::size_t joint, double time) {
    const std::vector<SeenFrame>& frames = recording.frames;
    const double place = std::clamp(time * kVisitFramesPerSecond, 0.0, static_cast<double>(frames.size() - 1));
    const auto lower = static_cast<std::size_t>(place);
    const std::size_t upper = std::min(lower + 1, frames.size() - 1);
    const double share = place - static_cast<double>(lower);
    return (1.0 - share) * static_cast<double>(frames[lower].truth.joints[joint].position.x()) +
           share * static_cast<double>(frames[upper].truth.joints[joint].position.x());
}

/// Sine of the angle by which the trunk is turned from the glass.
float turned(const SeenFrame& frame) {
    return (frame.truth[Joint::torso].orientation * Vector3f::UnitZ()).x();
}

/// Frames between which the body does not turn; each stretch has an offset of its own.
using Stretches = std::vector<std::vector<const SeenFrame*>>;

Stretches stretchesOf(const VisitRecording& recording, std::size_t first, bool facing, std::size_t joint) {
    Stretches stretches;
    int before = 0;
    for (std::size_t n = first; n < recording.frames.size(); ++n) {
        const SeenFrame& frame = recording.frames[n];
        const float sine = turned(frame);
        const int way = facing ? 1 : std::abs(sine) < 0.9F ? 0 : sine > 0.0F ? 1 : 2;
        if (way != 0 && way != before) stretches.emplace_back();
        before = way;
        if (way != 0 && tracksShopper(frame) && frame.visible[joint]) stretches.back().push_back(&frame);
    }
    return stretches;
}

}  // namespace

void readLag(const VisitRecording& recording, std::size_t first, VisitFigures& figures) {
    // Who paces in profile has turned aside for half of the time at least.
    const auto aside = std::count_if(recording.frames.begin(), recording.frames.end(),
                                     [](const SeenFrame& frame) { return std::abs(turned(frame)) > 0.9F; });
    const bool facing = aside < static_cast<long>(recording.frames.size()) / 3;
    for (std::size_t joint = 0; joint < kJointCount; ++joint) {
        const Stretches stretches = stretchesOf(recording, first, facing, joint);
        LagCurve curve;
        for (const auto& stretch : stretches)
            curve.frames += static_cast<long>(stretch.size());
        if (curve.frames < static_cast<long>(kLeastFrames)) continue;
        for (std::size_t k = 0; k < LagCurve::kSize; ++k) {
            const double delay = 1e-3 * (LagCurve::kFirstMs + LagCurve::kStepMs * static_cast<int>(k));
            for (const auto& stretch : stretches) {
                double sum = 0.0;
                double squares = 0.0;
                for (const SeenFrame* frame : stretch) {
                    const double off = static_cast<double>(frame->tracked.joints[joint].position.x()) -
                                       truthAt(recording, joint, frame->time - delay);
                    sum += off;
                    squares += off * off;
                }
                if (!stretch.empty()) curve.misfit[k] += squares - sum * sum / static_cast<double>(stretch.size());
            }
        }
        (facing ? figures.lagFacing : figures.lagAside)[joint].add(curve);
        if (std::abs(curve.bestMs()) <= 80.0) continue;
        char text[80];
        std::snprintf(text, sizeof text, "%s lags by %.0f ms", std::string(kJointNames[joint]).c_str(), curve.bestMs());
        figures.miss(recording, recording.frames[first].time, text);
    }
}

}  // namespace cheval::fitting::test
