#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <span>

namespace cheval::hal::sim {

/// A list of at most N that takes no memory. Adding more is a fault of the caller's, in a release it replaces the last.
template <typename T, std::size_t N>
class BoundedList {
  public:
    T& add(const T& item) {
        assert(count_ < N);
        if (count_ < N) ++count_;
        return items_[count_ - 1] = item;
    }
    void clear() { count_ = 0; }
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
