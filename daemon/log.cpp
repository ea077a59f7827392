#include "daemon/log.h"

#include <cstdio>
#include <cstdlib>
#include <string>

namespace cheval::daemon {

void log(Severity severity, std::string_view message) {
    static const bool kJournal = std::getenv("JOURNAL_STREAM") != nullptr;
    std::string line;
    if (kJournal) {
        line = "<" + std::to_string(static_cast<int>(severity)) + ">";
    } else if (severity == Severity::error) {
        line = "error: ";
    } else if (severity == Severity::warning) {
        line = "warning: ";
    }
    line += message;
    line += '\n';
    // One write a line, so that lines of two threads do not mix.
    std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace cheval::daemon
