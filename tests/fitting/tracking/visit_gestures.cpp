// Gestures reported against gestures meant.
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "tests/fitting/tracking/visit_figures.h"

namespace cheval::fitting::test {

namespace {

namespace sim = hal::sim;

constexpr double kSlack = 8.0 / 15.0;  ///< Seconds; eight frames of score.py.

/// All that was reported but raises, which wake the mirror and no more.
std::vector<GestureEvent> eventsOf(std::span<const SeenFrame> frames) {
    std::vector<GestureEvent> events;
    for (const SeenFrame& frame : frames) {
        for (std::size_t i = 0; i < frame.hands.gestureCount; ++i) {
            if (frame.hands.gestures[i].kind != GestureKind::raise) events.push_back(frame.hands.gestures[i]);
        }
    }
    return events;
}

std::string wordsFor(GestureKind kind, Side hand, SwipeDirection direction) {
    std::string words = kind == GestureKind::hold           ? "hold"
                        : kind == GestureKind::grab         ? "grab"
                        : direction == SwipeDirection::left ? "swipe left"
                                                            : "swipe right";
    return words + (hand == Side::left ? " of the left hand" : " of the right hand");
}

std::string wordsFor(const GestureEvent& event) {
    return wordsFor(event.kind, event.hand, event.direction);
}

}  // namespace

void readGestures(const VisitRecording& recording, double seconds, VisitFigures& figures) {
    std::vector<GestureEvent> left = eventsOf(recording.frames);
    const auto overlaps = [](const GestureEvent& e, const sim::MeantGesture& m, double after) {
        return hal::seconds(e.start) <= m.end + kSlack && hal::seconds(e.end) >= m.start - after;
    };
    for (const sim::MeantGesture& meant : recording.meant) {
        if (meant.kind == sim::MeantKind::transition) continue;
        const bool swipe = meant.kind == sim::MeantKind::swipe;
        const GestureKind kind = swipe ? GestureKind::swipe : GestureKind::grab;
        const auto found = std::find_if(left.begin(), left.end(), [&](const GestureEvent& e) {
            return e.kind == kind && e.hand == meant.hand && (!swipe || e.direction == meant.direction) &&
                   overlaps(e, meant, kSlack);
        });
        (swipe ? figures.swipes : figures.grabs).add(found != left.end());
        if (found != left.end()) {
            left.erase(found);
        } else {
            figures.miss(recording, meant.start, "missed: " + wordsFor(kind, meant.hand, meant.direction));
        }
    }
    for (const GestureEvent& event : left) {
        const bool neutral = std::any_of(recording.meant.begin(), recording.meant.end(), [&](const auto& meant) {
            return meant.kind == sim::MeantKind::transition && meant.hand == event.hand && overlaps(event, meant, 0.0);
        });
        if (neutral) continue;
        ++figures.strayGestures;
        figures.miss(recording, hal::seconds(event.start), "invented beside gestures: " + wordsFor(event));
    }
    figures.gestureSeconds += seconds;
}

void readFidgeting(const VisitRecording& recording, double seconds, VisitFigures& figures) {
    for (const GestureEvent& event : eventsOf(recording.frames)) {
        ++figures.falseEvents;
        figures.miss(recording, hal::seconds(event.start), "invented while fidgeting: " + wordsFor(event));
    }
    figures.fidgetSeconds += seconds;
}

}  // namespace cheval::fitting::test
