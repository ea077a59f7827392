#include "tests/fitting/tracking/visit_figures.h"

#include <algorithm>
#include <cstdio>

namespace cheval::fitting::test {

namespace {

namespace sim = hal::sim;

template <typename T>
void append(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

void JointErrors::add(const JointErrors& other) {
    sum += other.sum;
    count += other.count;
    missed += other.missed;
    within += other.within;
}

double LagCurve::bestMs() const {
    const auto least = static_cast<std::size_t>(std::min_element(misfit.begin(), misfit.end()) - misfit.begin());
    double shift = 0.0;
    if (least > 0 && least + 1 < kSize) {
        const double before = misfit[least - 1], after = misfit[least + 1];
        const double bend = before - 2.0 * misfit[least] + after;
        if (bend > 0.0) shift = 0.5 * (before - after) / bend;
    }
    return kFirstMs + kStepMs * (static_cast<double>(least) + shift);
}

void LagCurve::add(const LagCurve& other) {
    for (std::size_t i = 0; i < kSize; ++i)
        misfit[i] += other.misfit[i];
    frames += other.frames;
}

void VisitFigures::add(const VisitFigures& other) {
    append(firstFull, other.firstFull);
    append(recovery, other.recovery);
    samePersonAfter.add(other.samePersonAfter);
    for (std::size_t i = 0; i < kPassCount; ++i) {
        kept[i].add(other.kept[i]);
        passes[i].add(other.passes[i]);
    }
    for (std::size_t i = 0; i < kJointCount; ++i) {
        restSquares[i] += other.restSquares[i];
        restFrames[i] += other.restFrames[i];
        lagFacing[i].add(other.lagFacing[i]);
        lagAside[i].add(other.lagAside[i]);
    }
    append(restRms, other.restRms);
    swipes.add(other.swipes);
    grabs.add(other.grabs);
    strayGestures += other.strayGestures;
    gestureSeconds += other.gestureSeconds;
    falseEvents += other.falseEvents;
    fidgetSeconds += other.fidgetSeconds;
    for (const auto& [script, joints] : other.errors) {
        for (std::size_t i = 0; i < kJointCount; ++i)
            errors[script][i].add(joints[i]);
    }
    for (std::size_t i = 0; i < kShopperKindCount; ++i) {
        errorsByShopper[i].add(other.errorsByShopper[i]);
        fullInTime[i].add(other.fullInTime[i]);
    }
    swaps.add(other.swaps);
    hiddenClaims.add(other.hiddenClaims);
    openHands.add(other.openHands);
    closedHands.add(other.closedHands);
    unknownHands.add(other.unknownHands);
    mannequinActive.add(other.mannequinActive);
    dogActive.add(other.dogActive);
    append(misses, other.misses);
}

JointErrors VisitFigures::allErrors() const {
    JointErrors all;
    for (const auto& [script, joints] : errors) {
        for (const JointErrors& joint : joints)
            all.add(joint);
    }
    return all;
}

void VisitFigures::miss(const VisitRecording& recording, double time, const std::string& what) {
    char head[64];
    std::snprintf(head, sizeof head, "%-10s %-10s seed %5u  %6.2f s  ", nameOf(recording.script),
                  kShopperKindNames[static_cast<std::size_t>(recording.shopper)], recording.seed, time);
    misses.push_back(head + what);
}

const char* nameOf(sim::Script script) {
    switch (script) {
        case sim::Script::visit:
            return "visit";
        case sim::Script::resting:
            return "resting";
        case sim::Script::pacing:
            return "pacing";
        case sim::Script::gestures:
            return "gestures";
        case sim::Script::fidgeting:
            return "fidgeting";
        case sim::Script::passersBy:
            return "passers-by";
        case sim::Script::occlusion:
            return "occlusion";
        case sim::Script::mannequin:
            return "mannequin";
        case sim::Script::measuring:
            return "measuring";
        case sim::Script::dog:
            break;
    }
    return "dog";
}

}  // namespace cheval::fitting::test
