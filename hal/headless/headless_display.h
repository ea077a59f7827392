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

std::unique_ptr<Display> makeHeadlessDisplay(const HeadlessOptions& options);

}  // namespace cheval::hal
