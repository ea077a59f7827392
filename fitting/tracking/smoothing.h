// A causal filter that holds still what rests and does not lag behind what moves.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace cheval::fitting::tracking {

/// The 1€ filter (Casiez, Roussel, Vogel, CHI 2012) for a point: a low-pass whose cut-off rises with the speed. One
/// speed for all three axes, so that a path keeps its shape.
class PointFilter {
  public:
    struct Options {
        float restCutoff = 1.2F;   ///< Hz at rest.
        float speedFactor = 5.0F;  ///< Hz per metre a second.
        float speedCutoff = 2.0F;  ///< Hz, of the speed itself.
    };

    PointFilter() = default;
    explicit PointFilter(const Options& options) : options_(options) {}
    void reset() { *this = PointFilter(options_); }

    /// `elapsed` in seconds since the call before; 0 or less starts afresh.
    Eigen::Vector3f filter(const Eigen::Vector3f& point, float elapsed) {
        if (!started_ || elapsed <= 0.0F) {
            started_ = true;
            value_ = point;
            velocity_.setZero();
            derivative_.setZero();
            return value_;
        }
        const float follow = weight(options_.speedCutoff, elapsed);
        derivative_ += follow * ((point - value_) / elapsed - derivative_);
        const float cutoff = options_.restCutoff + options_.speedFactor * derivative_.norm();
        const Eigen::Vector3f step = weight(cutoff, elapsed) * (point - value_);
        value_ += step;
        velocity_ += follow * (step / elapsed - velocity_);
        return value_;
    }
    /// Of the filtered point, metres a second.
    [[nodiscard]] const Eigen::Vector3f& velocity() const { return velocity_; }
    [[nodiscard]] const Eigen::Vector3f& value() const { return value_; }

  private:
    static float weight(float cutoff, float elapsed) {
        const float r = 6.2831853F * cutoff * elapsed;
        return r / (r + 1.0F);
    }

    Options options_;
    Eigen::Vector3f value_ = Eigen::Vector3f::Zero();
    Eigen::Vector3f velocity_ = Eigen::Vector3f::Zero();
    /// The paper's filtered derivative: how fast the point would have to go to be where it was seen, which is more than
    /// its velocity.
    Eigen::Vector3f derivative_ = Eigen::Vector3f::Zero();
    bool started_ = false;
};

}  // namespace cheval::fitting::tracking
