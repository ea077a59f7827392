// Whether the floor lies where the technician's figures put it.
#pragma once

#include <cstdint>

#include "fitting/tracking/cloud.h"
#include "fitting/tracking/placement.h"
#include "hal/clock.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Looks once a second, and believes what several looks in a row show: a floor that is clearly another one than the
/// written-down height, tilt and roll allow, beyond what PlacementFilter corrects. Then they are wrong, or the focal
/// length is: one that is s times its own moves a floor that is h below by h/s − h. Where nothing was written down, or
/// no floor is seen, nothing is said. Thread-bound; takes no heap memory.
class FloorWatch {
  public:
    explicit FloorWatch(const hal::Mount& written) : written_(mountEstimateFrom(written)), known_(written.known) {}
    void reset();
    /// `cloud` as it was made, with a placement near the written one.
    void update(const Cloud& cloud, hal::TimePoint time);
    /// The floor is elsewhere.
    [[nodiscard]] bool elsewhere() const { return elsewhere_; }

    enum class Verdict : std::uint8_t { unseen, agrees, differs };
    /// What one frame shows. Another `seed` looks at other planes.
    [[nodiscard]] Verdict judge(const Cloud& cloud, std::uint32_t seed) const;

    static constexpr hal::Duration kBetweenLooks = std::chrono::seconds(1);
    /// Looks that must differ in a row, and agree in a row to take it back.
    static constexpr int kBelieved = 5;

  private:
    MountEstimate written_;
    bool known_;
    bool begun_ = false;
    bool elsewhere_ = false;
    int against_ = 0;  ///< Looks in a row that contradict elsewhere_.
    std::uint32_t looks_ = 0;
    hal::TimePoint last_{};
};

}  // namespace cheval::fitting::tracking
