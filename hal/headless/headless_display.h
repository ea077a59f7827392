// A display without a screen: keeps statistics and, if asked, writes what it is shown as PNG files.
#pragma once

#include <memory>
#include <string>

#include "hal/display.h"

namespace cheval::hal {

struct HeadlessOptions {
    DisplayMode mode;
    std::string folder;  ///< PNG files `frame-000000.png` … go here; empty: nothing is written.
    int every = 1;       ///< Write every n-th frame.
};

/// A display that is always there and shows everything. present() writes the file itself, in the caller's thread; where
/// that fails (a full disk) it says so, counts the picture as dropped and goes on. open() makes the folder and fails
/// where it cannot, or where the mode has no pixels or more than 8192 a side. Thread-bound, but for statistics().
std::unique_ptr<Display> makeHeadlessDisplay(const HeadlessOptions& options);

}  // namespace cheval::hal
