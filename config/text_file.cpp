#include "config/text_file.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace cheval::config {

namespace fs = std::filesystem;

Expected<std::string> readText(const std::string& path, std::size_t maximumBytes, std::string_view kind) {
    std::error_code failed;
    // Only a regular file is opened: opening a pipe that nobody writes to would wait for ever.
    const bool regular = fs::is_regular_file(path, failed);
    const std::uintmax_t size = regular ? fs::file_size(path, failed) : 0;
    std::ifstream stream;
    if (regular) stream.open(path, std::ios::binary);
    if (failed || !regular || !stream) {
        return Error{.code = ErrorCode::unavailable,
                     .cause = "the file cannot be read",
                     .mend = "check that it is a file and may be read by the service's user",
                     .file = path};
    }
    if (size > maximumBytes) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the file has " + std::to_string(size) + " bytes",
                     .mend = "keep " + std::string(kind) + " under " + std::to_string(maximumBytes) + " bytes",
                     .why = "nobody writes that much",
                     .file = path};
    }
    std::string text(static_cast<std::size_t>(size), '\0');
    stream.read(text.data(), static_cast<std::streamsize>(size));
    text.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    return text;
}

}  // namespace cheval::config
