#include "daemon/visit_report.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "daemon/animated_picture.h"
#include "daemon/budget_table.h"
#include "daemon/contact_sheet.h"
#include "daemon/even_samples.h"
#include "hal/png/png.h"
#include "hal/shrink.h"

namespace cheval::daemon {
namespace {

struct SheetCandidate {
    hal::Image<hal::Rgba8> picture;
    std::string caption;
};

Expected<void> requireRange(const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = fmt::format("{} is {}, outside {}…{}", name, value, low, high),
                     .key = name};
    }
    return {};
}

Expected<void> validate(const VisitReportOptions& options) {
    const struct {
        const char* name;
        double value, low, high;
    } ranges[] = {{"pictureWidth", static_cast<double>(options.pictureWidth), 16, 1080},
                  {"sheetPictures", static_cast<double>(options.sheetPictures), 1, 64},
                  {"sheetColumns", static_cast<double>(options.sheetColumns), 1, 16},
                  {"animationRate", options.animationRate, 1, 30},
                  {"animationPictures", static_cast<double>(options.animationPictures), 2, 1000}};
    for (const auto& range : ranges) {
        if (auto checked = requireRange(range.name, range.value, range.low, range.high); !checked) {
            return checked;
        }
    }
    return {};
}

Expected<void> writeText(const std::filesystem::path& path, const std::string& text) {
    return hal::writeBytes(path.string(), std::as_bytes(std::span(text)));
}

}  // namespace

struct VisitReport::State {
    explicit State(const VisitReportOptions& reportOptions)
        : options(reportOptions),
          // Thinning never leaves fewer than half: three times what is wanted, and the last one is near the visit's
          // end.
          candidates(static_cast<std::size_t>(options.sheetPictures) * 3 + 2, hal::fromSeconds(0.1)),
          animation(static_cast<std::size_t>(options.animationPictures),
                    hal::fromSeconds(1.0 / options.animationRate)) {}

    [[nodiscard]] Expected<hal::Image<hal::Rgba8>> contactSheet() const;
    [[nodiscard]] Expected<std::vector<std::byte>> animatedPicture() const;

    VisitReportOptions options;
    hal::Image<hal::Rgba8> small;
    std::vector<std::uint32_t> sums;
    EvenSamples<SheetCandidate> candidates;
    EvenSamples<CompactPicture> animation;
    hal::TimePoint first{};
    hal::TimePoint last{};
    std::int64_t frames = 0;
};

Expected<hal::Image<hal::Rgba8>> VisitReport::State::contactSheet() const {
    const auto& entries = candidates.entries();
    const std::size_t wanted = std::min(entries.size(), static_cast<std::size_t>(options.sheetPictures));
    std::vector<SheetPicture> pictures;
    for (std::size_t i = 0; i < wanted; ++i) {
        // From the first candidate to the last, both included.
        const std::size_t index = wanted == 1 ? 0 : (i * (entries.size() - 1) + (wanted - 1) / 2) / (wanted - 1);
        const auto& entry = entries[index];
        pictures.push_back({.picture = entry.sample.picture.view(),
                            .heading = fmt::format("{:.1f} s", hal::seconds(entry.time - first)),
                            .caption = entry.sample.caption});
    }
    return drawContactSheet(pictures,
                            {.title = options.title,
                             .subtitle = fmt::format("{} frames in {:.1f} s", frames, hal::seconds(last - first)),
                             .columns = options.sheetColumns});
}

Expected<std::vector<std::byte>> VisitReport::State::animatedPicture() const {
    // Plainer first, then slower: what moves is worth more than grain.
    constexpr struct {
        float quality;
        std::size_t every;
    } kAttempts[] = {{70, 1}, {45, 1}, {45, 2}, {25, 3}};
    Expected<std::vector<std::byte>> bytes = std::vector<std::byte>();
    for (const auto& attempt : kAttempts) {
        std::vector<AnimationFrame> chosen;
        const auto& entries = animation.entries();
        for (std::size_t i = 0; i < entries.size(); i += attempt.every) {
            chosen.push_back({.picture = &entries[i].sample, .time = entries[i].time});
        }
        bytes = encodeAnimation(chosen, attempt.quality);
        if (!bytes || bytes->size() <= options.animationBytes) {
            break;
        }
    }
    return bytes;
}

Expected<std::unique_ptr<VisitReport>> VisitReport::create(const VisitReportOptions& options) {
    if (auto valid = validate(options); !valid) {
        return std::move(valid).error().within("while preparing the visit report");
    }
    std::error_code problem;
    std::filesystem::create_directories(options.folder, problem);
    if (problem) {
        return Error{.code = ErrorCode::resource,
                     .cause = "the folder for the visit report cannot be made: " + problem.message(),
                     .mend = "name a folder that can be written",
                     .file = options.folder.string()};
    }
    return std::unique_ptr<VisitReport>(new VisitReport(std::make_unique<State>(options)));
}

VisitReport::VisitReport(std::unique_ptr<State> state) : state_(std::move(state)) {}
VisitReport::~VisitReport() = default;

void VisitReport::addFrame(hal::ImageView<const hal::Rgba8> frame, hal::TimePoint time, std::string_view caption) {
    State& state = *state_;
    if (frame.empty() || (state.frames > 0 && time < state.last)) {
        return;
    }
    if (state.frames == 0) {
        const int width = std::min(frame.width, state.options.pictureWidth);
        const int height =
            std::max(1, static_cast<int>(std::lround(static_cast<double>(frame.height) * width / frame.width)));
        state.small.resize(width, height);
        state.first = time;
    }
    ++state.frames;
    state.last = time;
    const bool forSheet = state.candidates.due(time);
    const bool forAnimation = state.animation.due(time);
    // A frame smaller than the first one's copy would have to be enlarged; the next one will do.
    if ((!forSheet && !forAnimation) || frame.width < state.small.width || frame.height < state.small.height) {
        return;
    }
    hal::shrink(frame, state.small.view(), state.sums);
    if (forSheet) {
        state.candidates.keep(time, {.picture = state.small, .caption = std::string(caption)});
    }
    if (forAnimation) {
        // A picture that there is no memory for is one fewer in the animation.
        if (auto compact = CompactPicture::create(state.small.view())) {
            state.animation.keep(time, std::move(compact).value());
        }
    }
}

Expected<void> VisitReport::finish(const std::vector<TaskStatistics>& tasks) {
    const State& state = *state_;
    if (state.candidates.entries().empty() || state.animation.entries().empty()) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the visit showed no frame, so there is no report",
                     .mend = "see the messages above for what kept the mirror from drawing"};
    }
    const std::filesystem::path& folder = state.options.folder;
    auto sheet = state.contactSheet();
    if (!sheet) {
        return std::move(sheet).error();
    }
    if (auto written = hal::writePng((folder / kSheetFile).string(), std::as_const(*sheet).view()); !written) {
        return written;
    }
    auto animated = state.animatedPicture();
    if (!animated) {
        return std::move(animated).error();
    }
    if (auto written = hal::writeBytes((folder / kAnimationFile).string(), *animated); !written) {
        return written;
    }
    const BudgetTable table{
        .title = state.options.title, .frames = state.frames, .visit = state.last - state.first, .tasks = tasks};
    if (auto written = writeText(folder / kTableFile, budgetMarkdown(table)); !written) {
        return written;
    }
    return writeText(folder / kTableDataFile, budgetJson(table));
}

}  // namespace cheval::daemon
