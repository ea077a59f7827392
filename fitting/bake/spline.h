// Natural cubic splines through tables of numbers: how the builders describe girths along a limb.
#pragma once

#include <span>
#include <vector>

namespace cheval::fitting::bake {

/// A twice continuously differentiable curve through (x, y) knots; constant outside them.
class Spline {
  public:
    Spline() = default;
    /// `xs` rises strictly and is as long as `ys`; at least two knots.
    Spline(std::span<const double> xs, std::span<const double> ys);
    [[nodiscard]] double operator()(double x) const;

  private:
    std::vector<double> xs_;
    std::vector<double> ys_;
    std::vector<double> second_;  ///< Second derivatives at the knots.
};

/// 0 below `from`, 1 above `to`, with zero slope at both.
double smoothStep(double from, double to, double x);

}  // namespace cheval::fitting::bake
