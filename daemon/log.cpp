#include "daemon/log.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <sys/stat.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

namespace cheval::daemon {

namespace {

/// The variable alone says only that some ancestor's was: JOURNAL_STREAM in systemd.exec(5).
bool standardErrorIsTheJournal() {
    const char* stream = std::getenv("JOURNAL_STREAM");
    struct stat standardError {};
    return stream != nullptr && fstat(STDERR_FILENO, &standardError) == 0 &&
           fmt::format("{}:{}", standardError.st_dev, standardError.st_ino) == stream;
}

/// False where the journal cannot be reached.
bool sendToJournal(Severity severity, std::string_view message, std::string_view messageId) {
    return sd_journal_send("MESSAGE=%.*s", static_cast<int>(message.size()), message.data(), "PRIORITY=%d",
                           static_cast<int>(severity), "MESSAGE_ID=%.*s", static_cast<int>(messageId.size()),
                           messageId.data(), "SYSLOG_IDENTIFIER=%s", program_invocation_short_name, nullptr) == 0;
}

}  // namespace

void log(Severity severity, std::string_view message, std::string_view messageId) {
    static const bool kJournal = standardErrorIsTheJournal();
    if (kJournal && !messageId.empty() && sendToJournal(severity, message, messageId)) return;
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
