// Who appears in a visit and what each of them does: the scripts of world.h, written out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/sim/bounded_list.h"
#include "hal/sim/dog.h"
#include "hal/sim/hash.h"
#include "hal/sim/part.h"
#include "hal/sim/rig.h"
#include "hal/sim/shopper.h"
#include "hal/sim/world.h"

namespace cheval::hal::sim {

/// Where a moment falls in the endless row of visits.
struct Moment {
    std::uint32_t visit = 0;
    double seconds = 0.0;     ///< Since the visit began.
    double scriptTime = 0.0;  ///< The same in seconds of Script::visit, which is stretched to the visit's length.
    bool visiting = false;    ///< False in the pause after it.
};
Moment momentAt(const WorldOptions& options, double worldSeconds);

/// One who appears.
struct Performer {
    FigureKind kind = FigureKind::shopper;
    Shopper shopper;  ///< Or the mannequin.
    Dog dog;
    Part part;  ///< A dog follows its first walk. Unused in Script::visit, whose motion is in motion.h.
};

/// How many gestures and transitions a visit has at most.
inline constexpr std::size_t kMaximumMeant = 128;

/// All who appear in one visit, the shopper first, and what they mean. A function of options and visit alone.
struct Cast {
    Script script = Script::visit;
    BoundedList<Performer, kMaximumFigures> performers;
    BoundedList<MeantGesture, kMaximumMeant> meant;  ///< Seconds of the visit, by their starts.
};
/// Takes no memory.
void castVisit(const WorldOptions& options, std::uint32_t visit, Cast& cast);
/// How many figures a script has at most.
std::size_t figuresOf(Script script);

Rig rigOf(const Performer& performer);
/// Whether the performer is in the room.
bool inRoom(const Cast& cast, const Performer& performer, const Moment& moment);
Pose poseOf(const Cast& cast, const Performer& performer, const Rig& rig, const Moment& moment);

/// The scripts, each in its own file or in script.cpp.
void writeGestures(const WorldOptions& options, Draw& draw, Cast& cast);
void writeFidgeting(const WorldOptions& options, Draw& draw, Cast& cast);
void writeMeasuring(const WorldOptions& options, std::uint32_t visit, Draw& draw, Cast& cast);

}  // namespace cheval::hal::sim
