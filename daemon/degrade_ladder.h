// Draws more plainly when the machine cannot keep up, and steps back when it can: cloth iterations, render scale, level
// of detail, frame rate. The picture gets plainer, never late, never black.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace cheval::daemon {

/// One rung, from the top (everything) to the bottom (least). Each is no dearer than the one above it.
struct Rung {
    std::string_view name;
    float clothIterations = 1.0F;  ///< Share of the solver's iterations.
    float renderScale = 1.0F;      ///< render::Scene::renderScale.
    int levelOfDetail = 0;         ///< 0 is the finest.
    double rateShare = 1.0;        ///< Of the configured frame rate: 30 → 20 → 15.
};

struct LadderOptions {
    bool enabled = true;
    /// Rungs that would change nothing are stepped over.
    bool haveCloth = false;
    bool haveLevelsOfDetail = false;
    int downAfter = 10;         ///< Late frames, less those in time, before a step down.
    int upAfter = 90;           ///< Frames in a row with room to spare before a step up.
    double upBelow = 0.75;      ///< Room to spare: predicted load of the rung above under this share of its period.
    int longestUpAfter = 2880;  ///< A step up that had to be taken back doubles upAfter, up to this.
};

/// Thread-bound. No call takes heap memory.
class DegradeLadder {
  public:
    explicit DegradeLadder(const LadderOptions& options);

    /// Tells what a frame took as a share of the current rung's period (1 = all of it): the slower of the loop and the
    /// renderer. Returns true when the rung changed.
    bool update(double load);
    [[nodiscard]] const Rung& rung() const;
    /// 0 at the top.
    [[nodiscard]] std::size_t level() const { return level_; }

    static std::span<const Rung> rungs();

  private:
    [[nodiscard]] bool offered(std::size_t level) const;
    [[nodiscard]] std::size_t below() const;
    [[nodiscard]] std::size_t above() const;

    LadderOptions options_;
    std::size_t level_ = 0;
    int late_ = 0;
    int spare_ = 0;
    int upAfter_ = 0;
    int sinceUp_ = 0;
    bool steppedUp_ = false;
};

}  // namespace cheval::daemon
