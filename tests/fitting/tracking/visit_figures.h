// What a visit says of the tracker, and what all of them say together.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "tests/fitting/tracking/visit_recording.h"
#include "tests/fitting/tracking/visit_statistics.h"

namespace cheval::fitting::test {

/// Seconds to find a shopper: the goal, and what is allowed before errors count.
inline constexpr double kAllowance = 0.5;
/// A time that never came.
inline constexpr double kNever = 99.0;

/// Errors of one joint over the frames in which it can be seen, from half a second after the shopper came wholly into
/// view.
struct JointErrors {
    double sum = 0.0;  ///< Metres.
    long count = 0;    ///< Frames with an answer.
    long missed = 0;   ///< Frames without.
    long within = 0;   ///< Frames within 100 mm.

    [[nodiscard]] double meanMm() const { return count > 0 ? 1e3 * sum / static_cast<double>(count) : 0.0; }
    [[nodiscard]] Rate rate() const { return {within, count + missed}; }
    void add(const JointErrors& other);
};

/// Squared misfit of a joint's tracked path to its true one, delayed by each of a row of times.
struct LagCurve {
    static constexpr int kFirstMs = -100;
    static constexpr int kStepMs = 4;
    static constexpr std::size_t kSize = 96;
    std::array<double, kSize> misfit{};
    long frames = 0;

    /// The delay that fits best, milliseconds, by a parabola through the least and its neighbours.
    [[nodiscard]] double bestMs() const;
    void add(const LagCurve& other);
};

enum class Pass : std::uint8_t { before, behind, beside };
inline constexpr std::size_t kPassCount = 3;

/// Sums over one visit or many.
struct VisitFigures {
    std::vector<double> firstFull;  ///< Seconds from wholly in view to the first full skeleton, one a visit.
    std::vector<double> recovery;   ///< Seconds from all joints in view again after an occlusion to a full skeleton.
    Rate samePersonAfter;           ///< Occlusions after which the active user has the ID of before.
    std::array<Rate, kPassCount> kept;              ///< Frames while others pass.
    std::array<Rate, kPassCount> passes;            ///< Visits' passes without a frame lost.
    std::array<double, kJointCount> restSquares{};  ///< Square metres from each joint's own mean at rest.
    std::array<long, kJointCount> restFrames{};
    std::vector<double> restRms;  ///< Millimetres, one a joint and visit.
    std::array<LagCurve, kJointCount> lagFacing, lagAside;
    Rate swipes, grabs;      ///< Found of those meant.
    long strayGestures = 0;  ///< Events beside the meant ones, not in neutral spans.
    double gestureSeconds = 0.0;
    long falseEvents = 0;  ///< While fidgeting.
    double fidgetSeconds = 0.0;
    std::map<std::string, std::array<JointErrors, kJointCount>> errors;  ///< By script.
    std::array<JointErrors, kShopperKindCount> errorsByShopper;
    std::array<Rate, kShopperKindCount> fullInTime;  ///< Visits with a full skeleton after 0.5 s.
    Rate swaps;                                      ///< Frames in which left and right limbs are exchanged.
    Rate hiddenClaims;                               ///< Hidden joints reported with confidence ≥ 0.5.
    Rate openHands, closedHands;                     ///< Raised hands read right.
    Rate unknownHands;                               ///< Raised hands not read.
    Rate mannequinActive;                            ///< Frames in which the mannequin is the active user.
    Rate dogActive;                                  ///< Frames with an active user while only a dog is there.
    std::vector<std::string> misses;                 ///< One line each: script, seed, seconds, what.

    void add(const VisitFigures& other);
    /// Notes what went wrong at `time` seconds of a visit.
    void miss(const VisitRecording& recording, double time, const std::string& what);
    [[nodiscard]] JointErrors allErrors() const;
};

/// Compares the events reported with those meant as score.py does (kind, hand and direction agree, spans overlap with
/// half a second of slack, each event counts once), or counts all as false. `seconds` is how long the shopper was in
/// view.
void readGestures(const VisitRecording& recording, double seconds, VisitFigures& figures);
void readFidgeting(const VisitRecording& recording, double seconds, VisitFigures& figures);

/// Finds by how much each joint's path follows the true one too late, from frame `first` of a pacing visit on. A
/// constant offset is no lag, nor is one that turns with the body.
void readLag(const VisitRecording& recording, std::size_t first, VisitFigures& figures);

/// All figures that a visit of its script gives.
VisitFigures figuresOf(const VisitRecording& recording);
/// The script's name as on the command line.
const char* nameOf(hal::sim::Script script);

}  // namespace cheval::fitting::test
