// How the mirror is doing, in one line for a terminal and for the preview page.
#pragma once

#include <string>

#include "daemon/mirror.h"

namespace cheval::daemon {

/// E.g. "wearing: T-shirt  29.9 fps  loop 8.1 ms  render 12.0 ms  all details"; without frames, why there are none.
std::string statusLine(const MirrorStatus& status);

}  // namespace cheval::daemon
