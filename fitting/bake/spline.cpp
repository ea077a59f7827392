#include "fitting/bake/spline.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace cheval::fitting::bake {

Spline::Spline(std::span<const double> xs, std::span<const double> ys)
    : xs_(xs.begin(), xs.end()), ys_(ys.begin(), ys.end()), second_(xs.size(), 0.0) {
    assert(xs.size() == ys.size() && xs.size() >= 2);
    const std::size_t n = xs_.size();
    // Thomas algorithm for the second derivatives, which are 0 at both ends.
    std::vector<double> upper(n, 0.0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double before = xs_[i] - xs_[i - 1];
        const double after = xs_[i + 1] - xs_[i];
        const double slopeChange = (ys_[i + 1] - ys_[i]) / after - (ys_[i] - ys_[i - 1]) / before;
        const double pivot = 2.0 * (before + after) - before * upper[i - 1];
        upper[i] = after / pivot;
        second_[i] = (6.0 * slopeChange - before * second_[i - 1]) / pivot;
    }
    for (std::size_t i = n - 1; i-- > 1;) {
        second_[i] -= upper[i] * second_[i + 1];
    }
}

double Spline::operator()(double x) const {
    if (x <= xs_.front()) return ys_.front();
    if (x >= xs_.back()) return ys_.back();
    const auto i =
        static_cast<std::size_t>(std::distance(xs_.begin(), std::upper_bound(xs_.begin(), xs_.end(), x))) - 1;
    const double width = xs_[i + 1] - xs_[i];
    const double a = (xs_[i + 1] - x) / width;
    const double b = 1.0 - a;
    return a * ys_[i] + b * ys_[i + 1] +
           ((a * a * a - a) * second_[i] + (b * b * b - b) * second_[i + 1]) * width * width / 6.0;
}

double smoothStep(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

}  // namespace cheval::fitting::bake
