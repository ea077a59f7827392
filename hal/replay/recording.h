// Which files of a folder make a recording, and in which order. Knows names only; opens no picture.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/expected.h"

namespace cheval::hal {

/// One depth picture of a recording.
struct RecordedPicture {
    std::string depth;   ///< File name, without the folder.
    std::string colour;  ///< File name of the colour that goes with it; empty: none.
    std::uint64_t tick =
        0;  ///< Place in time, in frames from the first: larger than the position after a gap in the numbers.
};

struct Recording {
    std::vector<RecordedPicture> pictures;
    std::vector<std::string> warnings;
};

/// Compares names with the runs of digits in them taken as numbers of any length: depth-9 comes before depth-10. A
/// total order.
bool naturalLess(std::string_view left, std::string_view right);

/// Picks the depth pictures among a folder's file names, in natural order, and the colour of each. Where any name
/// begins with `depth-`, only those are depth; else every `*.png` that does not begin with `mask-`, `color-` or
/// `colour-`. Colour of `depth-X.png` is `color-X.png` or `colour-X.png`. `stills` do not follow each other, so their
/// numbers mean no time.
Recording arrangeRecording(const std::vector<std::string>& names, bool stills);

/// The names of a folder's plain files. Errors: notFound, invalidInput (not a folder, beyond a million files),
/// resource.
Expected<std::vector<std::string>> listFolder(const std::string& folder);

}  // namespace cheval::hal
