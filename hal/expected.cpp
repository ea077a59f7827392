#include "hal/expected.h"

namespace cheval {

namespace {

void appendSentence(std::string& text, std::string_view label, std::string_view sentence) {
    if (sentence.empty()) return;
    // Some sentences are questions ("did you mean …?").
    if (!text.empty() && text.back() != '.' && text.back() != '?') text += '.';
    text += ' ';
    text += label;
    text += sentence;
}

}  // namespace

std::string Error::message() const {
    std::string text;
    if (!file.empty()) {
        text += file;
        if (line > 0) text += ':' + std::to_string(line);
        text += ": ";
    }
    if (!key.empty()) text += key + ": ";
    text += cause;
    appendSentence(text, "Mend: ", mend);
    appendSentence(text, "Why: ", why);
    return text;
}

}  // namespace cheval
