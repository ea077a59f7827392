// Messages for the journal and the terminal.
#pragma once

#include <string_view>

namespace cheval::daemon {

enum class Severity { error = 3, warning = 4, notice = 5 };

/// Writes one line to standard error: with the journal's priority prefix when standard error is the journal, else with
/// the severity in words. Any thread. Takes memory: not for the frame loop while all is well.
void log(Severity severity, std::string_view message);

}  // namespace cheval::daemon
