// Messages for the journal and the terminal.
#pragma once

#include <string_view>

namespace cheval::daemon {

enum class Severity { error = 3, warning = 4, notice = 5 };

/// Writes one line to standard error, with the severity in words; where standard error is the journal, an entry of it,
/// with its priority and, where `messageId` (see message_ids.h) is not empty, with that. Any thread. Takes memory: not
/// for the frame loop while all is well.
void log(Severity severity, std::string_view message, std::string_view messageId = {});

}  // namespace cheval::daemon
