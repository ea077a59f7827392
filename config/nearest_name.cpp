#include "config/nearest_name.h"

#include <algorithm>
#include <array>

namespace cheval::config {

namespace {
constexpr std::size_t kLongest = 64;
}  // namespace

std::size_t editDistance(std::string_view a, std::string_view b) {
    a = a.substr(0, kLongest);
    b = b.substr(0, kLongest);
    using Row = std::array<std::size_t, kLongest + 1>;
    Row beforeLast{};
    Row last{};
    Row current{};
    for (std::size_t j = 0; j <= b.size(); ++j)
        last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        current[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            current[j] = std::min({replaced, last[j] + 1, current[j - 1] + 1});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
                current[j] = std::min(current[j], beforeLast[j - 2] + 1);
            }
        }
        beforeLast = last;
        last = current;
    }
    return last[b.size()];
}

std::string_view nearestName(std::string_view wrong, std::span<const std::string_view> names) {
    const auto nearest = std::min_element(names.begin(), names.end(), [wrong](std::string_view a, std::string_view b) {
        return editDistance(wrong, a) < editDistance(wrong, b);
    });
    return nearest == names.end() ? std::string_view() : *nearest;
}

}  // namespace cheval::config
