#include "hal/replay/recording.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <system_error>

namespace cheval::hal {

namespace {

constexpr std::size_t kMaxFiles = 1'000'000;
constexpr std::string_view kSuffix = ".png";

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

std::string_view takeDigits(std::string_view& text) {
    std::size_t length = 0;
    while (length < text.size() && isDigit(text[length]))
        ++length;
    const std::string_view digits = text.substr(0, length);
    text.remove_prefix(length);
    return digits;
}

std::string_view withoutZeros(std::string_view digits) {
    while (digits.size() > 1 && digits.front() == '0')
        digits.remove_prefix(1);
    return digits;
}

// The last number in a name, unless it is too long to be the number of a frame.
std::optional<std::uint64_t> lastNumber(std::string_view name) {
    std::size_t end = name.size();
    while (end > 0 && !isDigit(name[end - 1]))
        --end;
    std::size_t begin = end;
    while (begin > 0 && isDigit(name[begin - 1]))
        --begin;
    std::uint64_t number = 0;
    const auto [rest, error] = std::from_chars(name.data() + begin, name.data() + end, number);
    if (begin == end || error != std::errc{} || rest != name.data() + end) return std::nullopt;
    return number;
}

// Numbers that count frames lie close together; otherwise (time stamps, say) they are names and nothing more.
constexpr std::uint64_t kMostTicksPerPicture = 4;

// Gives each picture its place in time: by its number where the numbers count frames, else by its position.
void placeInTime(Recording& recording) {
    auto& pictures = recording.pictures;
    for (std::size_t i = 0; i < pictures.size(); ++i)
        pictures[i].tick = i;
    std::vector<std::uint64_t> numbers;
    std::uint64_t step = 0;
    for (const RecordedPicture& picture : pictures) {
        const auto number = lastNumber(picture.depth);
        if (!number) return;
        if (!numbers.empty()) {
            if (*number <= numbers.back()) return;
            const std::uint64_t difference = *number - numbers.back();
            step = step == 0 ? difference : std::min(step, difference);
        }
        numbers.push_back(*number);
    }
    if (step == 0 || (numbers.back() - numbers.front()) / step > kMostTicksPerPicture * numbers.size()) return;
    for (const std::uint64_t number : numbers) {
        if ((number - numbers.front()) % step != 0) return;
    }
    for (std::size_t i = 1; i < pictures.size(); ++i) {
        pictures[i].tick = (numbers[i] - numbers.front()) / step;
        const std::uint64_t missing = pictures[i].tick - pictures[i - 1].tick - 1;
        if (missing > 0) {
            recording.warnings.push_back(std::to_string(missing) + " picture(s) missing between " +
                                         pictures[i - 1].depth + " and " + pictures[i].depth +
                                         ": played as lost frames");
        }
    }
}

}  // namespace

bool naturalLess(std::string_view left, std::string_view right) {
    std::string_view a = left;
    std::string_view b = right;
    while (!a.empty() && !b.empty()) {
        if (isDigit(a.front()) && isDigit(b.front())) {
            const std::string_view x = withoutZeros(takeDigits(a));
            const std::string_view y = withoutZeros(takeDigits(b));
            if (x.size() != y.size()) return x.size() < y.size();
            if (x != y) return x < y;
        } else {
            if (a.front() != b.front()) return a.front() < b.front();
            a.remove_prefix(1);
            b.remove_prefix(1);
        }
    }
    if (a.empty() != b.empty()) return a.empty();
    return left < right;  // The same but for leading zeros.
}

Recording arrangeRecording(const std::vector<std::string>& names, bool stills) {
    std::vector<std::string_view> pictures;
    bool named = false;
    for (const std::string& name : names) {
        if (!name.ends_with(kSuffix) || name.starts_with("mask-")) continue;
        pictures.emplace_back(name);
        named = named || name.starts_with("depth-");
    }
    std::sort(pictures.begin(), pictures.end(), naturalLess);

    Recording recording;
    bool anyColour = false;
    for (const std::string_view name : pictures) {
        if (named ? !name.starts_with("depth-") : name.starts_with("color-") || name.starts_with("colour-")) continue;
        RecordedPicture picture{.depth = std::string(name)};
        if (named) {
            for (const char* prefix : {"color-", "colour-"}) {
                const std::string colour = prefix + std::string(name.substr(std::string_view("depth-").size()));
                if (std::binary_search(pictures.begin(), pictures.end(), colour, naturalLess)) picture.colour = colour;
            }
        }
        anyColour = anyColour || !picture.colour.empty();
        recording.pictures.push_back(std::move(picture));
    }
    if (anyColour) {
        for (const RecordedPicture& picture : recording.pictures) {
            if (picture.colour.empty()) recording.warnings.push_back(picture.depth + " has no colour picture");
        }
    }
    if (stills) {
        for (std::size_t i = 0; i < recording.pictures.size(); ++i)
            recording.pictures[i].tick = i;
    } else {
        placeInTime(recording);
    }
    return recording;
}

Expected<std::vector<std::string>> listFolder(const std::string& folder) {
    std::error_code code;
    std::filesystem::directory_iterator entry(folder, code);
    if (code) {
        return Error{
            .code = code == std::errc::no_such_file_or_directory ? ErrorCode::notFound : ErrorCode::invalidInput,
            .cause = "the folder cannot be opened: " + code.message(),
            .mend = "name a folder of depth pictures with their sensor.json",
            .file = folder};
    }
    std::vector<std::string> names;
    for (; entry != std::filesystem::directory_iterator(); entry.increment(code)) {
        std::error_code ignored;
        if (entry->is_regular_file(ignored)) names.push_back(entry->path().filename().string());
        if (names.size() > kMaxFiles) {
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "the folder holds more than " + std::to_string(kMaxFiles) + " files",
                         .mend = "split the recording",
                         .file = folder};
        }
    }
    if (code) {
        return Error{
            .code = ErrorCode::resource, .cause = "the folder cannot be read: " + code.message(), .file = folder};
    }
    return names;
}

}  // namespace cheval::hal
