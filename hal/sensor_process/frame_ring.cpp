#include "hal/sensor_process/frame_ring.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hal/sensor_process/ring_layout.h"

namespace cheval::hal {

namespace {

using namespace ring_layout;

Error systemError(const char* what) {
    return {.code = ErrorCode::resource,
            .cause = std::string(what) + " failed: " + std::strerror(errno),
            .mend = "see whether memory or descriptors ran out"};
}

Expected<std::byte*> map(int descriptor) {
    void* memory = ::mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (memory == MAP_FAILED) return systemError("mapping the frame ring");
    return static_cast<std::byte*>(memory);
}

std::int64_t monotonicNs() {
    return SteadyClock().now().time_since_epoch().count();
}

}  // namespace

Expected<RingMemory> RingMemory::create() {
    Descriptor descriptor(::memfd_create("cheval-frames", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    if (!descriptor.valid()) return systemError("memfd_create");
    if (::ftruncate(descriptor.get(), static_cast<off_t>(kSize)) != 0) return systemError("sizing the frame ring");
    // Whatever the other process does, no access of ours can fall off the end.
    if (::fcntl(descriptor.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
        return systemError("sealing the frame ring");
    const auto data = map(descriptor.get());
    if (!data) return data.error();
    new (*data) Header{.magic = kMagic,
                       .version = kVersion,
                       .slots = kRingSlots,
                       .maxWidth = kRingMaxWidth,
                       .maxHeight = kRingMaxHeight,
                       .claimed = kNoSlot,
                       .newest = 0};
    for (std::uint32_t i = 0; i < kRingSlots; ++i)
        new (&slot(*data, i)) Slot{};
    return RingMemory(std::move(descriptor), *data);
}

Expected<RingMemory> RingMemory::attach(Descriptor memory) {
    struct stat status {};
    if (::fstat(memory.get(), &status) != 0) return systemError("looking at the frame ring");
    if (status.st_size == static_cast<off_t>(kSize)) {
        const auto data = map(memory.get());
        if (!data) return data.error();
        RingMemory ring(std::move(memory), *data);
        const Header& head = header(*data);
        if (head.magic == kMagic && head.version == kVersion && head.slots == kRingSlots &&
            head.maxWidth == kRingMaxWidth && head.maxHeight == kRingMaxHeight)
            return ring;
    }
    return Error{.code = ErrorCode::invalidInput,
                 .cause = "the shared memory is no frame ring of this version",
                 .mend = "install chevald and cheval-sensor of one and the same release"};
}

RingMemory::~RingMemory() {
    if (data_ != nullptr) ::munmap(data_, kSize);
}

RingMemory::RingMemory(RingMemory&& other) noexcept
    : descriptor_(std::move(other.descriptor_)), data_(std::exchange(other.data_, nullptr)) {}

RingMemory& RingMemory::operator=(RingMemory&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    std::swap(data_, other.data_);
    return *this;
}

Expected<void> RingWriter::write(const DepthFrame& frame, std::uint32_t opening) {
    const ImageView<const std::uint16_t>& depthView = frame.depth;
    const bool hasColour = !frame.colour.empty();
    const bool fits = !depthView.empty() && depthView.width <= static_cast<int>(kRingMaxWidth) &&
                      depthView.height <= static_cast<int>(kRingMaxHeight);
    if (!fits || (hasColour && (frame.colour.width != depthView.width || frame.colour.height != depthView.height))) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "a picture of " + std::to_string(depthView.width) + "×" +
                              std::to_string(depthView.height) + " does not fit the frame ring",
                     .mend = "use a mode of at most 1280×1024, with colour of the same size"};
    }
    std::byte* memory = memory_.data();
    Header& head = header(memory);
    const auto newest =
        static_cast<std::uint32_t>(head.newest.load(std::memory_order_relaxed) & ((1U << kSlotBits) - 1));
    // Neither what the reader will take next, nor what it looks at. It may claim a slot in this very moment: it and we
    // both write first and look second, so that one of us sees the other. With four slots one is always free.
    std::uint32_t chosen = (newest + 1) % kRingSlots;
    for (std::uint32_t tries = 0; tries < 2 * kRingSlots; ++tries, chosen = (chosen + 1) % kRingSlots) {
        // Looked at before it is touched: the lock of a slot on loan must not even flicker.
        if ((chosen == newest && serial_ > 0) || head.claimed.load(std::memory_order_seq_cst) == chosen) continue;
        Slot& candidate = slot(memory, chosen);
        const std::uint32_t before = candidate.lock.load(std::memory_order_relaxed);
        candidate.lock.store(before + 1, std::memory_order_seq_cst);
        if (head.claimed.load(std::memory_order_seq_cst) != chosen) break;
        candidate.lock.store(before, std::memory_order_release);
    }
    Slot& target = slot(memory, chosen);
    if ((target.lock.load(std::memory_order_relaxed) & 1U) == 0) return {};  // The reader claims all: this one is lost.
    for (int y = 0; y < depthView.height; ++y)
        std::copy_n(depthView.row(y), depthView.width, depth(memory, chosen) + std::ptrdiff_t{y} * depthView.width);
    for (int y = 0; hasColour && y < depthView.height; ++y)
        std::copy_n(frame.colour.row(y), depthView.width, colour(memory, chosen) + std::ptrdiff_t{y} * depthView.width);
    target.serial = ++serial_;
    target.frame = {.width = static_cast<std::uint32_t>(depthView.width),
                    .height = static_cast<std::uint32_t>(depthView.height),
                    .colour = hasColour ? 1U : 0U,
                    .restart = frame.restart ? 1U : 0U,
                    .opening = opening,
                    .sequence = frame.sequence,
                    .sourceIndex = frame.sourceIndex,
                    .captureTimeNs = frame.captureTime.time_since_epoch().count(),
                    .publishedNs = monotonicNs()};
    target.lock.fetch_add(1, std::memory_order_release);
    head.newest.store(serial_ << kSlotBits | chosen, std::memory_order_release);
    return {};
}

bool RingReader::lentWasLeftAlone() const {
    if (!lent_) return true;
    // A sound writer may try the lock in the very moment of the claim, sees the claim, and puts it back untouched.
    const std::uint32_t lock = slot(memory_.data(), *lent_).lock.load(std::memory_order_acquire);
    return lock == lentLock_ || lock == lentLock_ + 1;
}

RingReader::Status RingReader::take(DepthFrame& frame) {
    std::byte* memory = memory_.data();
    Header& head = header(memory);
    if (!lentWasLeftAlone()) return Status::broken;
    // A sound writer can get in between, with a newer frame each time.
    std::uint64_t first = 0;
    bool overtaken = false;
    for (int tries = 0; tries < 16; ++tries) {
        const std::uint64_t newest = head.newest.load(std::memory_order_acquire);
        if (tries == 0) first = newest;
        overtaken = overtaken || newest != first;
        const std::uint64_t serial = newest >> kSlotBits;
        const auto index = static_cast<std::uint32_t>(newest & ((1U << kSlotBits) - 1));
        if (serial == lastSerial_) return Status::nothing;
        if (serial < lastSerial_ || index >= kRingSlots) return Status::broken;
        head.claimed.store(index, std::memory_order_seq_cst);
        lent_.reset();
        Slot& taken = slot(memory, index);
        const std::uint32_t lock = taken.lock.load(std::memory_order_seq_cst);
        if ((lock & 1U) != 0) continue;
        const RingFrame meta = taken.frame;
        const std::uint64_t slotSerial = taken.serial;
        std::atomic_thread_fence(std::memory_order_acquire);
        if (taken.lock.load(std::memory_order_relaxed) != lock || slotSerial != serial) continue;
        if (meta.width == 0 || meta.height == 0 || meta.width > kRingMaxWidth || meta.height > kRingMaxHeight)
            return Status::broken;
        lent_ = index;
        lentLock_ = lock;
        lastSerial_ = serial;
        meta_ = meta;
        const int width = static_cast<int>(meta.width);
        const int height = static_cast<int>(meta.height);
        frame = DepthFrame{.sequence = meta.sequence,
                           .sourceIndex = meta.sourceIndex,
                           .captureTime = TimePoint(Duration(meta.captureTimeNs)),
                           .restart = meta.restart != 0,
                           .lastOfStill = true,
                           .depth = {depth(memory, index), width, height, width}};
        if (meta.colour != 0) frame.colour = {colour(memory, index), width, height, width};
        return Status::frame;
    }
    // Always the same frame, and never whole: no sound writer touches what it has published.
    return overtaken ? Status::nothing : Status::broken;
}

}  // namespace cheval::hal
