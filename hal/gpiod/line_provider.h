// The little that the mirror needs of GPIO lines, so that one file knows the library and tests need no hardware.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "hal/clock.h"
#include "hal/expected.h"

namespace cheval::hal {

enum class LineBias : std::uint8_t { asIs, disabled, pullUp, pullDown };

/// Which line, and how it is wired.
struct LineWiring {
    std::string chip;  ///< Name ("gpiochip0"), label, number or path; empty: any chip with a line of that name.
    std::string line;  ///< Its name, or its offset on `chip` in digits.
    bool activeLow = false;
    LineBias bias = LineBias::asIs;
};

/// A change of level. `active` is after activeLow.
struct LineEdge {
    bool active = false;
    TimePoint time{};  ///< The kernel's, on CLOCK_MONOTONIC: SteadyClock's time line.
};

/// A line that is read. Thread-bound; released on destruction.
class InputLine {
  public:
    virtual ~InputLine() = default;
    InputLine(const InputLine&) = delete;
    InputLine& operator=(const InputLine&) = delete;

    /// Edges since the last call, oldest first, without waiting. Errors: unavailable (the chip is gone).
    virtual Expected<std::size_t> read(std::span<LineEdge> edges) = 0;
    /// The level now. Errors: as read().
    virtual Expected<bool> active() = 0;

  protected:
    InputLine() = default;
};

/// A line that is driven. Thread-bound. The kernel may change its level on release.
class OutputLine {
  public:
    virtual ~OutputLine() = default;
    OutputLine(const OutputLine&) = delete;
    OutputLine& operator=(const OutputLine&) = delete;

    virtual Expected<void> set(bool active) = 0;

  protected:
    OutputLine() = default;
};

/// Where lines come from. Thread-bound.
class LineProvider {
  public:
    virtual ~LineProvider() = default;
    LineProvider(const LineProvider&) = delete;
    LineProvider& operator=(const LineProvider&) = delete;

    /// Errors: notFound (no such chip or line), unavailable (held by another, whom the text names; no permission).
    virtual Expected<std::unique_ptr<InputLine>> input(const LineWiring& wiring) = 0;
    virtual Expected<std::unique_ptr<OutputLine>> output(const LineWiring& wiring, bool active) = 0;

  protected:
    LineProvider() = default;
};

/// The kernel's character devices, through libgpiod.
std::unique_ptr<LineProvider> makeGpiodLines();

}  // namespace cheval::hal
