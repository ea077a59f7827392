// The last measurements of one length, and their robust average.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace cheval::fitting {

/// A ring of the last kCapacity values. Thread-bound; takes no memory.
class SampleWindow {
  public:
    static constexpr std::size_t kCapacity = 120;

    struct Average {
        float value = 0.0F;
        float standardError = 0.0F;
        std::size_t count = 0;  ///< Values that went in; 0: no average.
    };

    void add(float value) {
        values_[next_] = value;
        next_ = (next_ + 1) % kCapacity;
        count_ = std::min(count_ + 1, kCapacity);
    }
    void clear() { count_ = next_ = 0; }
    [[nodiscard]] std::size_t count() const { return count_; }

    /// Mean of what lies within 2.5 robust standard deviations of the median: one frame with a joint astray does not
    /// move it.
    [[nodiscard]] Average average() const {
        if (count_ == 0) return {};
        std::array<float, kCapacity> sorted{};
        std::copy_n(values_.begin(), count_, sorted.begin());
        const float median = medianOf(sorted);
        std::array<float, kCapacity> away{};
        for (std::size_t i = 0; i < count_; ++i)
            away[i] = std::abs(values_[i] - median);
        const float limit = 2.5F * 1.4826F * medianOf(away) + 1e-4F;
        double sum = 0.0;
        double squares = 0.0;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const double difference = static_cast<double>(values_[i]) - static_cast<double>(median);
            if (std::abs(difference) > static_cast<double>(limit)) continue;
            sum += difference;
            squares += difference * difference;
            ++kept;
        }
        const auto n = static_cast<double>(kept);
        const double mean = sum / n;
        const double variance = kept > 1 ? std::max(0.0, (squares - n * mean * mean) / (n - 1.0)) : 0.0;
        return {.value = static_cast<float>(static_cast<double>(median) + mean),
                .standardError = static_cast<float>(std::sqrt(variance / n)),
                .count = kept};
    }

  private:
    [[nodiscard]] float medianOf(std::array<float, kCapacity>& values) const {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count_ / 2);
        std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count_));
        return *middle;
    }

    std::array<float, kCapacity> values_{};
    std::size_t count_ = 0;
    std::size_t next_ = 0;
};

}  // namespace cheval::fitting
