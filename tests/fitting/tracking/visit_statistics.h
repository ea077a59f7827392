// Rates, quantiles and their bounds, for reports about the tracker.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace cheval::fitting::test {

inline constexpr double kNormal95 = 1.959964;  ///< Two-sided 95 % of the normal distribution.

/// So many of so many.
struct Rate {
    long hits = 0;
    long count = 0;

    void add(bool hit) {
        ++count;
        hits += hit ? 1 : 0;
    }
    void add(const Rate& other) {
        hits += other.hits;
        count += other.count;
    }
    [[nodiscard]] double share() const {
        return count > 0 ? static_cast<double>(hits) / static_cast<double>(count) : 0.0;
    }
    /// Wilson's 95 % bounds (J. Am. Stat. Assoc. 22, 1927).
    [[nodiscard]] std::pair<double, double> bounds() const {
        if (count == 0) return {0.0, 1.0};
        const auto n = static_cast<double>(count);
        const double z = kNormal95;
        const double p = share();
        const double middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
        const double half = z * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n)) / (1.0 + z * z / n);
        return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
    }
};

/// 95 % bounds of the mean of a Poisson count by Byar's approximation of Garwood's exact ones (Breslow & Day,
/// Statistical Methods in Cancer Research II, 1987).
inline std::pair<double, double> poissonBounds(long events) {
    const auto byar = [](double n, double z) {
        const double root = 1.0 - 1.0 / (9.0 * n) + z / (3.0 * std::sqrt(n));
        return n * root * root * root;
    };
    const double low = events > 0 ? byar(static_cast<double>(events), -kNormal95) : 0.0;
    return {low, byar(static_cast<double>(events) + 1.0, kNormal95)};
}

/// The value under which `share` of the values lie, between neighbours by interpolation; 0 of none.
inline double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    const double place = share * static_cast<double>(values.size() - 1);
    const auto lower = static_cast<std::size_t>(place);
    const std::size_t upper = std::min(lower + 1, values.size() - 1);
    return values[lower] + (place - static_cast<double>(lower)) * (values[upper] - values[lower]);
}

}  // namespace cheval::fitting::test
