#include "hal/replay/recording_writer.h"

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <span>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <sys/statvfs.h>

#include "hal/image.h"
#include "hal/png/png.h"

namespace cheval::hal {

namespace {

namespace fs = std::filesystem;

/// How long the thread waits at a stretch for a frame; it is woken when there is one.
constexpr Duration kIdle = std::chrono::milliseconds(250);
constexpr std::size_t kDigits = 6;

std::string fileName(const char* kind, std::uint64_t number) {
    std::string digits = std::to_string(number);
    if (digits.size() < kDigits) digits.insert(0, kDigits - digits.size(), '0');
    return std::string(kind) + "-" + digits + ".png";
}

Expected<void> checkSpace(const std::string& folder, std::uint64_t leaveFree) {
    struct statvfs disk {};
    // A file system that does not say is judged by its writes.
    if (::statvfs(folder.c_str(), &disk) != 0) return {};
    const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
    if (free >= leaveFree) return {};
    return Error{.code = ErrorCode::resource,
                 .cause = "only " + std::to_string(free >> 20U) + " MiB are left on the disk",
                 .mend = "free some disk space, or name a folder on another disk",
                 .why = "the mirror needs " + std::to_string(leaveFree >> 20U) + " MiB of it for itself",
                 .file = folder};
}

/// A reader finds the whole file under its name or none.
Expected<void> writeWhole(const std::string& path, std::span<const std::byte> bytes) {
    // No name that replay would take for a picture.
    const std::string part = path + ".part";
    std::error_code ignored;
    if (auto done = writeBytes(part, bytes); !done) {
        fs::remove(part, ignored);
        done.error().file = path;
        return done;
    }
    std::error_code failed;
    fs::rename(part, path, failed);
    if (!failed) return {};
    fs::remove(part, ignored);
    return Error{.code = ErrorCode::resource,
                 .cause = "the file cannot be given its name: " + failed.message(),
                 .mend = "check the disk",
                 .file = path};
}

Expected<void> prepareFolder(const std::string& folder) {
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed) {
        return Error{.code = ErrorCode::resource,
                     .cause = "the folder cannot be made: " + failed.message(),
                     .mend = "name one that this user may write",
                     .file = folder};
    }
    const bool empty = fs::is_empty(folder, failed);
    if (failed) {
        return Error{.code = ErrorCode::resource,
                     .cause = "the folder cannot be read: " + failed.message(),
                     .mend = "name one that this user may write",
                     .file = folder};
    }
    if (!empty) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the folder is not empty",
                     .mend = "name a new one",
                     .why = "two recordings in one folder would be played as one",
                     .file = folder};
    }
    return {};
}

/// What would be written down must be what replay will read.
Expected<std::string> describe(const SensorDescription& sensor) {
    std::string text = formatSensorJson(sensor);
    const auto read = parseSensorJson(text, "sensor.json");
    if (!read) return Error(read.error()).within("while writing down the sensor");
    if (sensor.depthUnitMm != 1.0) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "frames are recorded in millimetres",
                     .mend = "give a depth_unit_mm of 1"};
    }
    return text;
}

class FolderWriter final : public RecordingWriter {
  public:
    explicit FolderWriter(const RecordingWriterOptions& options)
        : options_(options), slots_(static_cast<std::size_t>(std::max(options.slots, 1))) {
        const Intrinsics& lens = options.sensor.intrinsics;
        for (Slot& slot : slots_) {
            slot.depth.resize(lens.width, lens.height);
            if (options.colour) slot.colour.resize(lens.width, lens.height);
        }
    }
    ~FolderWriter() override { end(); }
    FolderWriter(const FolderWriter&) = delete;
    FolderWriter& operator=(const FolderWriter&) = delete;

    void start() {
        thread_ = std::thread([this] { work(); });
    }

    bool add(std::uint64_t number, const DepthFrame& frame, Duration patience) override {
        Slot* slot = freeSlot(number, frame, patience);
        if (slot == nullptr) return false;
        // The thread does not look at this slot before it is counted, so it needs no lock.
        slot->number = number;
        copyInto(frame.depth, slot->depth);
        slot->hasColour = options_.colour && !frame.colour.empty();
        if (slot->hasColour) copyInto(frame.colour, slot->colour);
        {
            const std::lock_guard lock(mutex_);
            last_ = number;
            ++waiting_;
        }
        changed_.notify_all();
        return true;
    }

    Expected<void> finish() override {
        end();
        const std::lock_guard lock(mutex_);
        if (fault_) return *fault_;
        return {};
    }

    [[nodiscard]] RecordingCounts counts() const override {
        const std::lock_guard lock(mutex_);
        return counts_;
    }
    [[nodiscard]] std::optional<Error> fault() const override {
        const std::lock_guard lock(mutex_);
        return fault_;
    }

  private:
    struct Slot {
        std::uint64_t number = 0;
        Image<std::uint16_t> depth;
        Image<Rgb8> colour;
        bool hasColour = false;
    };

    void end() {
        {
            const std::lock_guard lock(mutex_);
            ending_ = true;
        }
        changed_.notify_all();
        if (thread_.joinable()) thread_.join();
    }

    [[nodiscard]] bool fits(const DepthFrame& frame) const {
        const Intrinsics& lens = options_.sensor.intrinsics;
        const auto same = [&lens](const auto& view) { return view.width == lens.width && view.height == lens.height; };
        return same(frame.depth) && (!options_.colour || frame.colour.empty() || same(frame.colour));
    }

    /// Null: the frame is dropped, and counted.
    Slot* freeSlot(std::uint64_t number, const DepthFrame& frame, Duration patience) {
        std::unique_lock lock(mutex_);
        if (!fits(frame) && !fault_) {
            fault_ = Error{.code = ErrorCode::invalidInput,
                           .cause = "the sensor sends frames of another size than it said",
                           .mend = "record again",
                           .why = "a recording has one size",
                           .file = options_.folder};
        }
        const auto possible = [this] { return waiting_ < slots_.size() || fault_ || ending_; };
        if (!possible() && patience > Duration::zero()) changed_.wait_for(lock, patience, possible);
        if (waiting_ == slots_.size() || fault_ || ending_ || (last_ && number <= *last_)) {
            ++counts_.dropped;
            return nullptr;
        }
        return &slots_[(first_ + waiting_) % slots_.size()];
    }

    void work() {
        while (true) {
            std::unique_lock lock(mutex_);
            changed_.wait_for(lock, kIdle, [this] { return waiting_ > 0 || ending_; });
            if (waiting_ == 0) {
                if (ending_) return;
                continue;
            }
            const bool failed = fault_.has_value();
            Slot& slot = slots_[first_];
            lock.unlock();
            const Expected<void> done = failed ? Expected<void>() : write(slot);
            lock.lock();
            ++(failed || !done ? counts_.dropped : counts_.written);
            if (!done && !fault_) fault_ = done.error();
            first_ = (first_ + 1) % slots_.size();
            --waiting_;
            lock.unlock();
            changed_.notify_all();
        }
    }

    Expected<void> write(const Slot& slot) {
        if (auto done = checkSpace(options_.folder, options_.leaveFreeBytes); !done) return done;
        if (slot.hasColour) {
            if (auto done = writePicture("color", slot.number, slot.colour); !done) return done;
        }
        return writePicture("depth", slot.number, slot.depth);
    }

    template <typename Pixel>
    Expected<void> writePicture(const char* kind, std::uint64_t number, const Image<Pixel>& picture) {
        if (auto done = encodePng(picture.view(), png_, {.compression = options_.compression, .oneFilter = true});
            !done)
            return done;
        return writeWhole((fs::path(options_.folder) / fileName(kind, number)).string(), png_);
    }

    const RecordingWriterOptions options_;
    std::vector<std::byte> png_;  // The thread's own.
    std::thread thread_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Slot> slots_;  // A ring: `waiting_` from `first_` on are the thread's, the others the caller's.
    std::size_t first_ = 0;
    std::size_t waiting_ = 0;
    std::optional<std::uint64_t> last_;  // Number of the frame that was added last.
    RecordingCounts counts_;
    std::optional<Error> fault_;
    bool ending_ = false;
};

}  // namespace

Expected<std::unique_ptr<RecordingWriter>> RecordingWriter::create(const RecordingWriterOptions& options) {
    const Expected<std::string> description = describe(options.sensor);
    if (!description) return description.error();
    Expected<void> ready = prepareFolder(options.folder);
    if (ready) ready = checkSpace(options.folder, options.leaveFreeBytes);
    if (ready) {
        ready = writeWhole((fs::path(options.folder) / "sensor.json").string(), std::as_bytes(std::span(*description)));
    }
    if (!ready) return std::move(ready).error();
    auto writer = std::make_unique<FolderWriter>(options);
    writer->start();
    return std::unique_ptr<RecordingWriter>(std::move(writer));
}

}  // namespace cheval::hal
