// File descriptors that close themselves.
#pragma once

namespace cheval::hal {

/// A file descriptor with one owner. Movable, thread-bound.
class Descriptor {
  public:
    Descriptor() = default;
    explicit Descriptor(int value) : value_(value) {}
    ~Descriptor() { reset(); }
    Descriptor(Descriptor&& other) noexcept : value_(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept;
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    [[nodiscard]] int get() const { return value_; }
    [[nodiscard]] bool valid() const { return value_ >= 0; }
    /// Gives it away, unclosed.
    int release();
    void reset();

  private:
    int value_ = -1;
};

}  // namespace cheval::hal
