#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <span>

#include "tests/fitting/tracking/visit_figures.h"

namespace cheval::fitting::test {

namespace {

using Eigen::Vector3f;
namespace sim = hal::sim;

constexpr float kFullSkeletonMetres = 0.15F;
constexpr float kNearMetres = 0.10F;
constexpr float kSwapMetres = 0.15F;

float errorOf(const SeenFrame& frame, std::size_t joint) {
    return (frame.tracked.joints[joint].position - frame.truth.joints[joint].position).norm();
}

bool fullSkeleton(const SeenFrame& frame) {
    if (!tracksShopper(frame)) return false;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        if (!frame.tracked.joints[i].position.allFinite()) return false;
        if (frame.visible[i] && errorOf(frame, i) > kFullSkeletonMetres) return false;
    }
    return true;
}

long visibleCount(const SeenFrame& frame) {
    return std::count(frame.visible.begin(), frame.visible.end(), true);
}

class Reader {
  public:
    Reader(const VisitRecording& recording, VisitFigures& figures)
        : recording_(recording), frames_(recording.frames), figures_(figures) {
        const auto entry =
            std::find_if(frames_.begin(), frames_.end(), [](const SeenFrame& f) { return f.whollyInView; });
        entry_ = static_cast<std::size_t>(entry - frames_.begin());
    }

    void read();

  private:
    void miss(double time, const std::string& what) { figures_.miss(recording_, time, what); }
    void readEntry();
    void readErrors();
    void readSwaps(const SeenFrame& frame);
    void readHands(const SeenFrame& frame);
    void readOcclusion();
    void readPasses();
    void readRest();
    void readStill();
    /// Seconds since the shopper came into view.
    [[nodiscard]] double watched() const {
        return static_cast<double>(frames_.size() - entry_) / kVisitFramesPerSecond;
    }
    [[nodiscard]] std::string describe(const SeenFrame& frame) const;

    const VisitRecording& recording_;
    const std::vector<SeenFrame>& frames_;
    VisitFigures& figures_;
    std::array<double, 2> exchanged_ = {-1.0, -1.0};  ///< When arms and legs last were.
    std::size_t entry_ = 0;  ///< First frame with the shopper wholly in view, or the number of frames.
};

/// Who is tracked and which visible joint is worst.
std::string Reader::describe(const SeenFrame& frame) const {
    if (!frame.tracked.present()) return "no skeleton";
    if (frame.activeFigure == kRoom) return "the active user is a piece of the room";
    if (frame.activeFigure != 0) return "the active user is figure " + std::to_string(frame.activeFigure);
    std::size_t worst = 0;
    float most = 0.0F;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        if (!frame.visible[i] || errorOf(frame, i) < most) continue;
        most = errorOf(frame, i);
        worst = i;
    }
    return std::string(kJointNames[worst]) + " is " + std::to_string(std::lround(1e3F * most)) + " mm off";
}

void Reader::readEntry() {
    if (entry_ == frames_.size()) return;
    const auto full = std::find_if(frames_.begin() + static_cast<std::ptrdiff_t>(entry_), frames_.end(), fullSkeleton);
    const double time = full == frames_.end() ? kNever : full->time - frames_[entry_].time;
    figures_.firstFull.push_back(time);
    figures_.fullInTime[static_cast<std::size_t>(recording_.shopper)].add(time <= kAllowance);
    if (time <= kAllowance) return;
    const std::size_t then =
        std::min(frames_.size() - 1, entry_ + static_cast<std::size_t>(0.5 * kVisitFramesPerSecond));
    miss(frames_[then].time, "no full skeleton 0.5 s after entry (after " +
                                 (time < kNever ? std::to_string(time) + " s" : "never") +
                                 "): " + describe(frames_[then]));
}

void Reader::readSwaps(const SeenFrame& frame) {
    struct Limb {
        std::array<Joint, 2> left, right;
        const char* name;
    };
    constexpr std::array<Limb, 2> kLimbs = {
        {{{Joint::leftElbow, Joint::leftHand}, {Joint::rightElbow, Joint::rightHand}, "arms"},
         {{Joint::leftKnee, Joint::leftFoot}, {Joint::rightKnee, Joint::rightFoot}, "legs"}}};
    bool swapped = false;
    for (const Limb& limb : kLimbs) {
        float gain = 0.0F;
        bool seen = true;
        for (std::size_t i = 0; i < 2; ++i) {
            for (const auto& [own, other] :
                 {std::pair{limb.left[i], limb.right[i]}, std::pair{limb.right[i], limb.left[i]}}) {
                seen = seen && frame.visible[index(own)];
                gain += errorOf(frame, index(own)) - (frame.tracked[other].position - frame.truth[own].position).norm();
            }
        }
        if (!seen || gain < 4.0F * kSwapMetres) continue;
        swapped = true;
        // One line for frames that follow each other.
        double& last = exchanged_[static_cast<std::size_t>(&limb - kLimbs.data())];
        if (frame.time - last > 0.1) miss(frame.time, std::string(limb.name) + " exchanged");
        last = frame.time;
    }
    figures_.swaps.add(swapped);
}

void Reader::readHands(const SeenFrame& frame) {
    for (const Side side : {Side::left, Side::right}) {
        const HandState state = frame.trueHands[index(side)];
        const Joint hand = side == Side::left ? Joint::leftHand : Joint::rightHand;
        if (state == HandState::unknown || !frame.visible[index(hand)]) continue;
        const HandState read = frame.hands[side].state;
        (state == HandState::open ? figures_.openHands : figures_.closedHands).add(read == state);
        figures_.unknownHands.add(read == HandState::unknown);
    }
}

void Reader::readErrors() {
    auto& errors = figures_.errors[nameOf(recording_.script)];
    const std::size_t first = entry_ + static_cast<std::size_t>(kAllowance * kVisitFramesPerSecond);
    std::array<int, kJointCount> bad{};
    std::array<float, kJointCount> badSum{};
    const auto endBad = [&](std::size_t joint, double time) {
        if (bad[joint] >= 10) {
            const double seconds = bad[joint] / kVisitFramesPerSecond;
            char text[96];
            std::snprintf(text, sizeof text, "%s off by %.0f mm for %.1f s", std::string(kJointNames[joint]).c_str(),
                          static_cast<double>(1e3F * badSum[joint]) / bad[joint], seconds);
            miss(time - seconds, text);
        }
        bad[joint] = 0;
        badSum[joint] = 0.0F;
    };
    int lost = 0;
    const SeenFrame* lostAt = nullptr;
    const auto endLost = [&] {
        if (lost >= 5) {
            char text[64];
            std::snprintf(text, sizeof text, "not tracked for %.1f s: ", lost / kVisitFramesPerSecond);
            miss(lostAt->time, text + describe(*lostAt));
        }
        lost = 0;
    };
    for (std::size_t n = first; n < frames_.size(); ++n) {
        const SeenFrame& frame = frames_[n];
        if (!frame.inRoom || !frame.torsoInPicture) continue;
        const bool tracked = tracksShopper(frame);
        if (!tracked && visibleCount(frame) > 0) {
            if (lost++ == 0) lostAt = &frame;
        } else {
            endLost();
        }
        for (std::size_t i = 0; i < kJointCount; ++i) {
            if (!frame.visible[i]) {
                figures_.hiddenClaims.add(tracked && frame.tracked.joints[i].confidence >= 0.5F);
                endBad(i, frame.time);
                continue;
            }
            if (!tracked) {
                ++errors[i].missed;
                endBad(i, frame.time);
                continue;
            }
            const float error = errorOf(frame, i);
            errors[i].sum += static_cast<double>(error);
            ++errors[i].count;
            errors[i].within += error <= kNearMetres ? 1 : 0;
            if (error > kFullSkeletonMetres) {
                ++bad[i];
                badSum[i] += error;
            } else {
                endBad(i, frame.time);
            }
        }
        if (tracked) {
            readSwaps(frame);
            readHands(frame);
        }
    }
    for (const JointErrors& joint : errors)
        figures_.errorsByShopper[static_cast<std::size_t>(recording_.shopper)].add(joint);
    endLost();
    for (std::size_t i = 0; i < kJointCount; ++i)
        endBad(i, frames_.back().time);
}

void Reader::readOcclusion() {
    // From the last of at least half a second without a visible joint.
    std::size_t hidden = 0, last = 0, begun = 0;
    for (std::size_t n = entry_; n < frames_.size(); ++n) {
        if (visibleCount(frames_[n]) > 0) {
            if (hidden > 0 && hidden < 15) hidden = 0;
            if (hidden >= 15) break;
            continue;
        }
        if (hidden++ == 0) begun = n;
        last = n;
    }
    if (hidden < 15 || begun < 30) return;
    const std::uint32_t id = frames_[begun - 30].activeId;
    std::size_t back = last;
    while (back < frames_.size() && visibleCount(frames_[back]) < static_cast<long>(kJointCount))
        ++back;
    if (back == frames_.size()) return;
    const auto full = std::find_if(frames_.begin() + static_cast<std::ptrdiff_t>(back), frames_.end(), fullSkeleton);
    const double time = full == frames_.end() ? kNever : full->time - frames_[back].time;
    figures_.recovery.push_back(time);
    const bool same = id != 0 && full != frames_.end() && full->activeId == id;
    figures_.samePersonAfter.add(same);
    const std::size_t then = std::min(frames_.size() - 1, back + 9);
    if (time > 0.3) miss(frames_[then].time, "not recovered 0.3 s after the occlusion: " + describe(frames_[then]));
    if (!same) miss(frames_[back].time, "another ID after the occlusion");
}

void Reader::readPasses() {
    std::array<Rate, kPassCount> kept{};
    std::array<bool, kPassCount> told{};
    std::uint32_t id = 0;
    for (std::size_t n = entry_; n < frames_.size(); ++n) {
        const SeenFrame& frame = frames_[n];
        if (!frame.other || std::abs(frame.other->x()) > 1.2F) {
            // The one to be kept is who is active before the next pass.
            if (frame.activeFigure == 0) id = frame.activeId;
            continue;
        }
        if (id == 0) continue;
        const float depth = frame.other->z();
        const Pass pass = depth < -0.4F ? Pass::before : depth > 0.4F ? Pass::behind : Pass::beside;
        const auto which = static_cast<std::size_t>(pass);
        const bool held = frame.activeId == id && (frame.activeFigure == 0 || frame.activeFigure == kNobody);
        kept[which].add(held);
        if (!held && !told[which]) {
            constexpr std::array<const char*, kPassCount> kWords = {"before", "behind", "beside"};
            miss(frame.time,
                 std::string("active user lost as another is ") + kWords[which] + " the shopper: " + describe(frame));
            told[which] = true;
        }
    }
    for (std::size_t i = 0; i < kPassCount; ++i) {
        figures_.kept[i].add(kept[i]);
        if (kept[i].count > 0) figures_.passes[i].add(kept[i].hits == kept[i].count);
    }
}

void Reader::readRest() {
    // The last walk and turn end by 4.2 s, and the filter has settled by 4.5.
    const auto first = std::find_if(frames_.begin(), frames_.end(), [](const SeenFrame& f) { return f.time >= 4.5; });
    const std::span<const SeenFrame> rest(first, frames_.end());
    for (std::size_t i = 0; i < kJointCount; ++i) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        long count = 0;
        const auto counts = [&](const SeenFrame& f) { return tracksShopper(f) && f.visible[i]; };
        for (const SeenFrame& frame : rest) {
            if (!counts(frame)) continue;
            sum += frame.tracked.joints[i].position.cast<double>();
            ++count;
        }
        // Three seconds at least.
        if (count < 90) continue;
        const Eigen::Vector3d mean = sum / static_cast<double>(count);
        double squares = 0.0;
        for (const SeenFrame& frame : rest) {
            if (counts(frame)) squares += (frame.tracked.joints[i].position.cast<double>() - mean).squaredNorm();
        }
        figures_.restSquares[i] += squares;
        figures_.restFrames[i] += count;
        const double rms = 1e3 * std::sqrt(squares / static_cast<double>(count));
        figures_.restRms.push_back(rms);
        if (rms > 8.0) {
            char text[80];
            std::snprintf(text, sizeof text, "%s jitters by %.1f mm at rest", std::string(kJointNames[i]).c_str(), rms);
            miss(rest.front().time, text);
        }
    }
}

/// Mannequin and dog.
void Reader::readStill() {
    const bool dog = recording_.script == sim::Script::dog;
    bool told = false;
    for (const SeenFrame& frame : frames_) {
        const bool wrong = dog ? frame.activeId != 0 : frame.activeFigure == 1;
        (dog ? figures_.dogActive : figures_.mannequinActive).add(wrong);
        if (wrong && !told)
            miss(frame.time, dog ? "somebody is active while only a dog is there" : "the mannequin is active");
        told |= wrong;
    }
}

void Reader::read() {
    if (recording_.script == sim::Script::dog) return readStill();
    if (entry_ == frames_.size()) {
        miss(0.0, "the shopper never came wholly into view");
        return;
    }
    readEntry();
    readErrors();
    switch (recording_.script) {
        case sim::Script::resting:
            return readRest();
        case sim::Script::pacing:
            return readLag(recording_, entry_ + 30, figures_);
        case sim::Script::visit:
        case sim::Script::gestures:
            return readGestures(recording_, watched(), figures_);
        case sim::Script::fidgeting:
            return readFidgeting(recording_, watched(), figures_);
        case sim::Script::passersBy:
            return readPasses();
        case sim::Script::occlusion:
            return readOcclusion();
        case sim::Script::measuring:
            return;  // Judged in tests/fitting/body.
        case sim::Script::mannequin:
        case sim::Script::dog:
            return readStill();
    }
}

}  // namespace

VisitFigures figuresOf(const VisitRecording& recording) {
    VisitFigures figures;
    if (!recording.frames.empty()) Reader(recording, figures).read();
    return figures;
}

}  // namespace cheval::fitting::test
