// The tracks file: JSON lines in the sensor frame of reference, one record a source frame, then the measurements and
// the events once each.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "fitting/body.h"
#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "hal/expected.h"
#include "hal/frame.h"

namespace cheval::daemon {

/// Thread-bound. Same input, same bytes: millimetres to a tenth, confidences to a thousandth, centimetres to a tenth.
class TracksWriter {
  public:
    /// Makes or replaces the file. Errors: the file cannot be written.
    static Expected<std::unique_ptr<TracksWriter>> create(const std::string& path);
    ~TracksWriter();
    TracksWriter(const TracksWriter&) = delete;
    TracksWriter& operator=(const TracksWriter&) = delete;

    /// Writes `{"frame", "time", "user", "joints", "hands"}` and sees that it is with the system before it returns, so
    /// that no record can depend on a later frame. Joints are those of the capture time; without a person the record
    /// has none.
    Expected<void> writeFrame(const hal::DepthFrame& frame, const fitting::Skeleton& skeleton,
                              const fitting::Hands& hands, const fitting::SensorPlacement& placement);
    /// Keeps the swipes, grabs, raises and holds that a frame completed; events are written by finish().
    void addGestures(const fitting::Hands& hands);
    /// Writes the measurements (those that could be taken) and the events, and closes the file.
    Expected<void> finish(const fitting::Measurements* measurements);

  private:
    TracksWriter(std::string path, std::FILE* file) : path_(std::move(path)), file_(file) {}
    Expected<void> writeLine(const std::string& line);

    std::string path_;
    std::FILE* file_;
    std::vector<fitting::GestureEvent> events_;
};

}  // namespace cheval::daemon
