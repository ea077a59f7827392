// Text of others (file names, device names, settings) on its way to a bus, a terminal or JSON.
#pragma once

#include <string>
#include <string_view>

namespace cheval::daemon {

/// `text` as UTF-8 on one line: what is not UTF-8 (RFC 3629) and control characters become U+FFFD each. A bus refuses
/// the first, and a terminal obeys the second.
std::string cleanText(std::string_view text);

}  // namespace cheval::daemon
