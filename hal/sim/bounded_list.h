#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <span>

namespace cheval::hal::sim {

/// A list of at most N, without memory of its own taking. What does not fit is a fault of who wrote the script.
template <typename T, std::size_t N>
class BoundedList {
  public:
    void add(const T& item) {
        assert(count_ < N);
        if (count_ < N) items_[count_++] = item;
    }
    [[nodiscard]] std::size_t room() const { return N - count_; }
    [[nodiscard]] std::size_t size() const { return count_; }
    [[nodiscard]] bool empty() const { return count_ == 0; }
    [[nodiscard]] std::span<const T> view() const { return std::span(items_).first(count_); }
    [[nodiscard]] const T& back() const { return items_[count_ - 1]; }

  private:
    std::array<T, N> items_{};
    std::size_t count_ = 0;
};

}  // namespace cheval::hal::sim
