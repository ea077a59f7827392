#include "config/shipped_files.h"

#include <filesystem>
#include <system_error>

namespace cheval::config {

namespace fs = std::filesystem;

std::string shippedPath(std::string_view underPrefix) {
    std::error_code failed;
    const fs::path program = fs::read_symlink("/proc/self/exe", failed);
    if (failed) return {};
    const fs::path path = program.parent_path().parent_path() / underPrefix;
    return fs::exists(path, failed) ? path.string() : std::string();
}

}  // namespace cheval::config
