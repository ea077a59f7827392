// A bounded number of samples of a stream of unknown length, spread evenly over it.
#pragma once

#include <cassert>
#include <cstddef>
#include <utility>
#include <vector>

#include "hal/clock.h"

namespace cheval::daemon {

/// Keeps samples about `interval` apart; each time it is full it drops every second one and doubles the interval, so
/// that it holds more than half of its capacity of any stream that is long enough. Thread-bound.
template <typename Sample>
class EvenSamples {
  public:
    struct Entry {
        hal::TimePoint time;
        Sample sample;
    };

    /// @param capacity at least 2.
    /// @param interval more than zero.
    EvenSamples(std::size_t capacity, hal::Duration interval)
        : capacity_(capacity), interval_(interval), tolerance_(interval / 8) {
        assert(capacity >= 2 && interval > hal::Duration::zero());
        entries_.reserve(capacity);
    }

    /// Whether a sample of `time` is to be kept. The first always is. A little early is on time: frames jitter, and the
    /// next one may be a whole frame late.
    [[nodiscard]] bool due(hal::TimePoint time) const { return entries_.empty() || time + tolerance_ >= next_; }

    /// Keeps a sample that is due; times must not fall.
    void keep(hal::TimePoint time, Sample sample) {
        entries_.push_back({time, std::move(sample)});
        if (entries_.size() == capacity_) {
            std::size_t kept = 1;
            for (std::size_t i = 2; i < entries_.size(); i += 2) {
                entries_[kept++] = std::move(entries_[i]);
            }
            entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(kept), entries_.end());
            interval_ *= 2;
        }
        // Counted from the first sample and not from the last, or the stream's own period would add up to a slower
        // rate.
        const hal::TimePoint first = entries_.front().time;
        const auto step = (entries_.back().time - first + interval_ / 2) / interval_ + 1;
        next_ = first + step * interval_;
    }

    [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
    [[nodiscard]] hal::Duration interval() const { return interval_; }

  private:
    std::size_t capacity_;
    hal::Duration interval_;
    hal::Duration tolerance_;
    hal::TimePoint next_{};
    std::vector<Entry> entries_;
};

}  // namespace cheval::daemon
