// Small pictures with captions in a grid, on one sheet.
#pragma once

#include <string>
#include <vector>

#include "hal/expected.h"
#include "hal/image.h"

namespace cheval::daemon {

/// One picture on the sheet. The alpha channel is not looked at.
struct SheetPicture {
    hal::ImageView<const hal::Rgba8> picture;
    std::string heading;  ///< Bold, under the picture, e.g. "3.2 s"; UTF-8.
    std::string caption;  ///< Beside the heading, cut short with … where it does not fit; UTF-8.
};

/// What the sheet looks like.
struct ContactSheetOptions {
    std::string title;     ///< Large, above the pictures; UTF-8.
    std::string subtitle;  ///< Small, under the title; UTF-8.
    int columns = 6;       ///< At least 1.
};

/// Draws the sheet: pictures in reading order, each at its own size in a cell of the largest. Text in the system's
/// sans-serif font by Pango.
/// Errors: invalidInput (no picture, an empty one, or a sheet larger than 32767 pixels either way), resource.
Expected<hal::Image<hal::Rgba8>> drawContactSheet(const std::vector<SheetPicture>& pictures,
                                                  const ContactSheetOptions& options);

}  // namespace cheval::daemon
