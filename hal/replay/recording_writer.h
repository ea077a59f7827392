// Records frames into a folder that ReplayCamera plays: sensor.json first, then depth-NNNNNN.png and, where asked for,
// color-NNNNNN.png, numbered as their frames, so that a lost frame is a gap in the numbers.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hal/clock.h"
#include "hal/expected.h"
#include "hal/frame.h"
#include "hal/replay/sensor_json.h"

namespace cheval::hal {

struct RecordingWriterOptions {
    std::string folder;        ///< Must be empty, or not there yet.
    SensorDescription sensor;  ///< Written down as it is; its unit must be the millimetre, as frames have it.
    bool colour = false;       ///< Colour too; otherwise depth alone is written, whatever frames bring.
    int slots = 16;            ///< Frames that may wait for the disk; each takes 5 bytes a pixel, or 2 without colour.
    int compression = 1;       ///< zlib's level. 1 takes 5 ms for depth and 8 ms for colour on the reference machine.
    /// The recording stops before the disk has less left than this, for the mirror needs it too.
    std::uint64_t leaveFreeBytes = std::uint64_t{256} << 20;
};

struct RecordingCounts {
    std::uint64_t written = 0;  ///< Frames, complete in the folder.
    std::uint64_t dropped = 0;  ///< Frames that were not written, since disk or coder could not keep up or failed.
};

/// Writes a recording in a thread of its own. Each file appears whole, under its name, or not at all, and a frame's
/// colour before its depth, so that what is there can be played whenever the writing ends, by a fault or a lost
/// process too. (Files are not forced to the disk one by one: after a power cut the last ones may be empty, which
/// replay leaves out with a warning.) Thread-bound, but for counts() and fault(), which any thread may call.
class RecordingWriter {
  public:
    /// Makes the folder, writes sensor.json and starts the thread. Errors: invalidInput (a folder that is not empty, no
    /// folder, a description that replay would refuse), resource or notFound (it cannot be written, the disk is
    /// full).
    static Expected<std::unique_ptr<RecordingWriter>> create(const RecordingWriterOptions& options);
    /// As finish(), whose error is lost.
    virtual ~RecordingWriter() = default;
    RecordingWriter(const RecordingWriter&) = delete;
    RecordingWriter& operator=(const RecordingWriter&) = delete;

    /// Takes a copy of the frame to be written under `number`, which must be greater than the one before. False: it is
    /// dropped, since no slot became free within `patience` (machine time), the number does not rise, or there is a
    /// fault. Takes no memory.
    virtual bool add(std::uint64_t number, const DepthFrame& frame, Duration patience = Duration::zero()) = 0;
    /// Writes what waits and ends the thread; nothing can be added any more. Errors: the fault, if there is one.
    virtual Expected<void> finish() = 0;
    [[nodiscard]] virtual RecordingCounts counts() const = 0;
    /// Why writing has ended early: the disk is full, a frame has another size than sensor.json says.
    [[nodiscard]] virtual std::optional<Error> fault() const = 0;

  protected:
    RecordingWriter() = default;
};

}  // namespace cheval::hal
