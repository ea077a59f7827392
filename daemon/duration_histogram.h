// How long something took, over and over: bounded memory, no allocation, percentiles good to about six per cent.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "hal/clock.h"

namespace cheval::daemon {

/// Logarithmic buckets, 16 an octave, from 1 µs to about 17 minutes. Thread-bound value; add() takes constant time.
class DurationHistogram {
  public:
    void add(hal::Duration duration) {
        const auto nanoseconds = static_cast<std::uint64_t>(std::max<hal::Duration::rep>(duration.count(), 0));
        ++buckets_[bucketOf(nanoseconds / 1000)];
        ++count_;
        sum_ += nanoseconds;
        minimum_ = std::min(minimum_, nanoseconds);
        maximum_ = std::max(maximum_, nanoseconds);
    }

    [[nodiscard]] std::uint64_t count() const { return count_; }
    [[nodiscard]] hal::Duration minimum() const { return toDuration(count_ == 0 ? 0 : minimum_); }
    [[nodiscard]] hal::Duration maximum() const { return toDuration(maximum_); }
    [[nodiscard]] hal::Duration mean() const { return toDuration(count_ == 0 ? 0 : sum_ / count_); }
    /// The least duration that a share of 0…1 of all does not exceed, to the bucket's upper end; zero when empty.
    [[nodiscard]] hal::Duration percentile(double share) const {
        const auto rank =
            static_cast<std::uint64_t>(std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(count_)));
        std::uint64_t seen = 0;
        for (std::size_t i = 0; i < buckets_.size(); ++i) {
            seen += buckets_[i];
            if (seen > 0 && seen >= rank) return toDuration(std::clamp(upperEnd(i) * 1000, minimum_, maximum_));
        }
        return maximum();
    }

  private:
    static constexpr std::size_t kSubBuckets = 16;
    static constexpr std::size_t kOctaves = 26;

    static hal::Duration toDuration(std::uint64_t nanoseconds) {
        return hal::Duration(static_cast<hal::Duration::rep>(nanoseconds));
    }
    static std::size_t bucketOf(std::uint64_t microseconds) {
        if (microseconds < kSubBuckets) return static_cast<std::size_t>(microseconds);
        const auto octave = static_cast<std::size_t>(std::bit_width(microseconds)) - 5;
        const auto within = static_cast<std::size_t>(microseconds >> octave) - kSubBuckets;
        return std::min((octave + 1) * kSubBuckets + within, kSubBuckets * (kOctaves + 1) - 1);
    }
    static std::uint64_t upperEnd(std::size_t bucket) {
        if (bucket < kSubBuckets) return bucket + 1;
        const std::size_t octave = bucket / kSubBuckets - 1;
        return (static_cast<std::uint64_t>(bucket % kSubBuckets + kSubBuckets) + 1) << octave;
    }

    std::array<std::uint32_t, kSubBuckets*(kOctaves + 1)> buckets_{};
    std::uint64_t count_ = 0;
    std::uint64_t sum_ = 0;
    std::uint64_t minimum_ = ~0ULL;
    std::uint64_t maximum_ = 0;
};

}  // namespace cheval::daemon
