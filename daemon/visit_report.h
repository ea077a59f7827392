// What one visit leaves for people to look at: a contact sheet, a short animated picture and the frame-budget table.
// For `chevald --once --report FOLDER` alone: it holds pictures of what the mirror showed, so it is never made of a
// shopper in a shop.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.h"
#include "hal/expected.h"
#include "hal/image.h"

namespace cheval::daemon {

struct TaskStatistics;

/// What a visit report is made of. The limits bound its memory: about 0.35 MB a picture of the animation and 0.9 MB a
/// candidate of the sheet at 360x640.
struct VisitReportOptions {
    std::filesystem::path folder;     ///< Where the files go; made if it does not exist.
    std::string title = "One visit";  ///< Heads the contact sheet and the table.
    int pictureWidth = 360;           ///< Pixels, of the animation and of each picture on the sheet, 16…1080; a
                                      ///< narrower frame is not enlarged.
    int sheetPictures = 12;           ///< At most; 1…64.
    int sheetColumns = 6;             ///< 1…16.
    double animationRate = 10.0;      ///< Pictures a second of the visit, 1…30; halved as often as
                                      ///< animationPictures makes it necessary.
    int animationPictures = 300;      ///< At most; 2…1000.
    std::size_t animationBytes = 4U << 20U;  ///< The file's size that quality and rate are lowered for.
};

/// Collects the pictures of one visit and writes the report. Thread-bound.
class VisitReport {
  public:
    static constexpr std::string_view kSheetFile = "contact-sheet.png";
    static constexpr std::string_view kAnimationFile = "visit.webp";
    static constexpr std::string_view kTableFile = "frame-budget.md";
    static constexpr std::string_view kTableDataFile = "frame-budget.json";

    /// Makes the folder. Errors: invalidInput (an option out of its range), resource (the folder cannot be made).
    static Expected<std::unique_ptr<VisitReport>> create(const VisitReportOptions& options);

    VisitReport(const VisitReport&) = delete;
    VisitReport& operator=(const VisitReport&) = delete;
    VisitReport(VisitReport&&) = delete;
    VisitReport& operator=(VisitReport&&) = delete;
    ~VisitReport();

    /// Takes note of one shown frame, upright as the shopper sees it, and keeps a small copy if one is due: about 3 ms
    /// then, nothing otherwise. Pictures are kept evenly over the visit however long it lasts. A frame that is empty or
    /// older than the one before is left out.
    /// @param caption what the visit is at, a few words of UTF-8; stands under the picture on the sheet.
    void addFrame(hal::ImageView<const hal::Rgba8> frame, hal::TimePoint time, std::string_view caption);

    /// Writes kSheetFile, kAnimationFile (animated WebP), kTableFile (Markdown) and kTableDataFile (JSON,
    /// milliseconds), replacing what the folder held of these. A few seconds of work. Call once, last. Errors:
    /// invalidInput (no frame was added), resource (disk or memory).
    Expected<void> finish(const std::vector<TaskStatistics>& tasks);

  private:
    struct State;
    explicit VisitReport(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace cheval::daemon
