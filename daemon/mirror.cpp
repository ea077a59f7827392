#include "daemon/mirror.h"

#include <algorithm>
#include <utility>

#include "daemon/hud_writer.h"
#include "daemon/log.h"
#include "daemon/message_ids.h"
#include "daemon/room_options.h"
#include "fitting/tracking/cloud.h"

namespace cheval::daemon {

namespace {

using std::chrono::milliseconds;

/// Without a new packet for this long the renderer shows the last one again: a display that goes to sleep is a dark
/// one.
constexpr hal::Duration kRedrawAfter = milliseconds(250);
/// A sensor that is brought back sooner disturbs nobody: the last picture stays, then the shopper is found where they
/// were, and is the same person.
constexpr hal::Duration kPictureStays = std::chrono::seconds(3);
/// Until then shoppers are asked for a moment's patience; after it the service screen says what is wrong.
constexpr hal::Duration kReasonAfter = std::chrono::minutes(1);
/// Long enough to read a new notice, and to fetch somebody who should.
constexpr hal::Duration kNoticeShown = std::chrono::seconds(8);

FrameChainOptions chainOptions(const config::Settings& settings, const Wardrobe& wardrobe,
                               const hal::DisplayMode& mode) {
    return {.tracker = trackerOptions(settings, {}),
            .session = sessionOptions(settings, wardrobe),
            .scheduler = schedulerOptions(settings),
            .displayWidth = mode.width,
            .displayHeight = mode.height,
            .rotated = rendererOptions(settings, mode).rotated};
}

CameraSupervisorOptions supervisorOptions(const config::Settings& settings, const MirrorParts& parts) {
    return {.recovery = recoveryOptions(settings, parts.hardware),
            .width = fitting::tracking::kFrameWidth,
            .height = fitting::tracking::kFrameHeight,
            .hardware = parts.hardware};
}

/// What was learnt with one holds with the other.
bool alike(const hal::CameraInfo& a, const hal::CameraInfo& b) {
    return a.intrinsics.width == b.intrinsics.width && a.intrinsics.fx == b.intrinsics.fx &&
           a.intrinsics.fy == b.intrinsics.fy && a.intrinsics.cx == b.intrinsics.cx &&
           a.intrinsics.cy == b.intrinsics.cy && a.mount.heightMm == b.mount.heightMm &&
           a.mount.tiltDeg == b.mount.tiltDeg && a.mount.rollDeg == b.mount.rollDeg && a.mount.known == b.mount.known &&
           !a.independent;
}

/// The last row is the whole of one thread's frame, under a name that tells the two threads apart.
std::size_t copyRows(const Scheduler& scheduler, std::string_view whole, std::span<TaskStatistics> rows) {
    const std::size_t count = scheduler.taskCount();
    for (std::size_t i = 0; i < count; ++i)
        rows[i] = scheduler.statistics(i);
    rows[count] = scheduler.frameStatistics();
    rows[count].name = whole;
    return count + 1;
}

}  // namespace

Expected<std::unique_ptr<Mirror>> Mirror::create(const config::Settings& settings, MirrorParts parts) {
    std::unique_ptr<Mirror> mirror(new Mirror(settings, std::move(parts)));
    Expected<std::unique_ptr<FrameChain>> chain = FrameChain::create(
        *mirror->parts_.wardrobe, chainOptions(settings, *mirror->parts_.wardrobe, mirror->parts_.mode),
        *mirror->parts_.admission, *mirror->parts_.cost);
    if (!chain) return std::move(chain).error();
    mirror->chain_ = std::move(*chain);
    const hal::Intrinsics usual;
    mirror->packets_.forEachSlot(
        [&](FramePacket& packet) { mirror->chain_->reserve(packet, usual.width, usual.height, true); });
    return mirror;
}

Mirror::Mirror(const config::Settings& settings, MirrorParts parts)
    : settings_(settings),
      parts_(std::move(parts)),
      supervisor_(parts_.camera, supervisorOptions(settings, parts_), *parts_.clock),
      ladder_(ladderOptions(settings)),
      basePeriod_(schedulerOptions(settings).framePeriod) {
    if (parts_.admission == nullptr) parts_.admission = parts_.clock;
    // Where admission's clock stands apart from time, nothing is late, however slow the machine is: the ladder stays at
    // the top, or a test or a simulated visit would leave out frames on a slow machine and not on a quick one.
    if (parts_.runToTheEnd || parts_.admission != parts_.clock) ladder_ = DegradeLadder({.enabled = false});
    faultText_.reserve(512);
}

Mirror::~Mirror() {
    stop();
}

Expected<void> Mirror::makePictures() {
    Expected<std::unique_ptr<PictureMaker>> made =
        PictureMaker::create({.renderer = rendererOptions(settings_, parts_.mode),
                              .scheduler = schedulerOptions(settings_),
                              .observer = parts_.observer},
                             parts_.wardrobe->materials, *parts_.display, *parts_.cost);
    if (!made) return std::move(made).error();
    pictures_ = std::move(*made);
    const std::lock_guard lock(shared_);
    description_ = pictures_->description();
    return {};
}

CameraNext Mirror::takeFrame() {
    const CameraNext next = supervisor_.next(frame_);
    if (supervisor_.openings() != openingsSeen_) {
        const hal::CameraInfo& info = supervisor_.info();
        const bool same = openingsSeen_ > 0 && alike(info, lastCamera_);
        openingsSeen_ = supervisor_.openings();
        lastCamera_ = info;
        if (!same) chain_->cameraOpened(trackerOptions(settings_, info.mount));
        otherCamera_ = !same;
        if (!parts_.runToTheEnd) log(Severity::notice, "camera: " + info.name);
    }
    // One and the same sensor sees the same shop again: the background that was learnt holds, and with it somebody who
    // stands still is found at once. After a short outage it is the same person too, with their measurements.
    if (supervisor_.resumed() && !otherCamera_) {
        frame_.restart = false;
        if (supervisor_.outage() >= kPictureStays) chain_->personMayHaveChanged();
    }
    if (next == CameraNext::frame) {
        otherCamera_ = false;
        sensorRate_.add(frame_);
    }
    if (supervisor_.recovery().counts() != rungsTold_) {
        const RecoveryRung rung = supervisor_.recovery().rung();
        const bool quiet = supervisor_.recovery().counts()[0] != rungsTold_[0] || parts_.runToTheEnd;
        rungsTold_ = supervisor_.recovery().counts();
        // A late frame is nobody's news.
        if (!quiet) log(Severity::notice, "to bring the sensor back: " + std::string(name(rung)));
    }
    const bool faulty = supervisor_.fault().has_value();
    if (faulty != faulty_ || (faulty && supervisor_.fault()->cause != faultCause_)) {
        faulty_ = faulty;
        faultCause_ = faulty ? supervisor_.fault()->cause : "";
        faultText_ = faulty ? serviceText(*supervisor_.fault()) : "";
        if (faulty_ && !parts_.runToTheEnd)
            log(Severity::warning, supervisor_.fault()->message(), message::kSensorLost);
    }
    return next;
}

bool Mirror::patience() const {
    // The end of a recording is no outage, and before the first frame there was nothing to come back.
    return supervisor_.state() != CameraState::ended && supervisor_.anyFrame() && supervisor_.silence() < kReasonAfter;
}

bool Mirror::tooSoon(const hal::DepthFrame& frame) {
    // On a lower rung frames are left out, evenly, by their own times; half a period of grace absorbs their jitter.
    const double share = ladder_.rung().rateShare;
    if (share >= 1.0 || frame.restart) return false;
    const hal::Duration period = hal::fromSeconds(hal::seconds(basePeriod_) / share);
    if (frame.captureTime + basePeriod_ / 2 < nextDue_) return true;
    nextDue_ = std::max(nextDue_ + period, frame.captureTime + period / 2);
    return false;
}

void Mirror::turn(bool haveFrame, FramePacket& packet) {
    const hal::TimePoint now = parts_.clock->now();
    render::FixedText<512> notice;
    {
        const std::lock_guard lock(shared_);
        notice = notice_;
        noticeWaits_ = noticeWaits_ || noticeNew_;
        noticeNew_ = false;
    }
    // Whoever is being dressed is not disturbed; the notice's time begins when they have gone.
    const SessionState state = chain_->session().state();
    const bool undisturbed = state == SessionState::idle || state == SessionState::approaching;
    if (noticeWaits_ && undisturbed) {
        noticeWaits_ = false;
        noticeUntil_ = now + kNoticeShown;
    }
    const hal::Duration taken =
        chain_->process({.frame = haveFrame ? &frame_ : nullptr,
                         .time = haveFrame ? frame_.captureTime : now,
                         .started = parts_.admission->now(),
                         .buttons = parts_.buttons,
                         .commands = parts_.commands,
                         .fault = patience() ? std::string_view() : faultText_,
                         .away = !haveFrame && patience() && supervisor_.silence() >= kPictureStays,
                         .notice = notice.view(),
                         .showNotice = notice.length > 0 && now < noticeUntil_,
                         .renderScale = ladder_.rung().renderScale},
                        packet);
    afterLoop(taken, haveFrame);
}

void Mirror::afterLoop(hal::Duration taken, bool haveFrame) {
    if (haveFrame) {
        const hal::Duration slower = std::max(taken, hal::Duration(renderTime_.load(std::memory_order_relaxed)));
        if (ladder_.update(hal::seconds(slower) / hal::seconds(chain_->scheduler().framePeriod()))) {
            chain_->setFramePeriod(hal::fromSeconds(hal::seconds(basePeriod_) / ladder_.rung().rateShare));
        }
    }
    const std::lock_guard lock(shared_);
    const Session& session = chain_->session();
    status_.state = session.state();
    // A view, not the name itself: a conditional of name and literal would copy it onto the heap.
    std::string_view outfit;
    if (session.outfit() < parts_.wardrobe->outfits.size()) outfit = parts_.wardrobe->outfits[session.outfit()].name;
    status_.outfit.assign(outfit);
    status_.outfitIndex = session.outfit();
    status_.camera = supervisor_.state();
    status_.fault.assign(faultText_);
    status_.viewFault = chain_->tracker().viewFault();
    status_.sensorFramesPerSecond = sensorRate_.hz();
    status_.recovery = supervisor_.recovery().counts();
    status_.openings = supervisor_.openings();
    if (chain_->buttonsFault() != status_.buttonsFault.view() && !parts_.runToTheEnd) {
        const std::string_view fault = chain_->buttonsFault();
        log(fault.empty() ? Severity::notice : Severity::warning, fault.empty() ? "the buttons work again" : fault);
    }
    status_.buttonsFault.assign(chain_->buttonsFault());
    status_.avatarView = session.avatarView();
    status_.visits = session.visits();
    status_.loopTime = taken;
    status_.degradeLevel = ladder_.level();
    status_.degradeName = ladder_.rung().name;
    ++status_.turns;
    if (haveFrame) ++status_.frames;
    loopRowCount_ = copyRows(chain_->scheduler(), "loop, whole frame", loopRows_);
}

void Mirror::afterPicture(const Expected<hal::Duration>& shown) {
    if (!shown) {
        const std::string fault = serviceText(shown.error());
        // A screen that is away, or busy, is no renderer that hangs; one that cannot draw is as good as one.
        const ErrorCode code = shown.error().code;
        const bool screenIsAway = code == ErrorCode::unavailable || code == ErrorCode::timedOut;
        const std::lock_guard lock(shared_);
        status_.displayFault.assign(fault);
        if (screenIsAway) ++status_.drawTurns;
        return;
    }
    renderTime_.store(shown.value().count(), std::memory_order_relaxed);
    const hal::TimePoint now = parts_.cost->now();
    const double gap = hal::seconds(now - lastRate_);
    lastRate_ = now;
    // A tenth of each new reading: quick enough to follow, steady enough to read.
    if (gap > 0.0) rate_ = picturesShown_ == 0 ? 0.0 : rate_ + 0.1 * (1.0 / gap - rate_);
    const std::lock_guard lock(shared_);
    status_.renderTime = shown.value();
    status_.displayFault.assign("");
    status_.pictures = ++picturesShown_;
    ++status_.drawTurns;
    status_.framesPerSecond = rate_;
    renderRowCount_ = copyRows(pictures_->scheduler(), "renderer, whole frame", renderRows_);
}

Expected<StepResult> Mirror::step(const std::function<bool(const hal::DepthFrame&)>& draw) {
    const CameraNext next = takeFrame();
    if (next == CameraNext::stopped) return StepResult::stopped;
    const bool haveFrame = next == CameraNext::frame;
    if (haveFrame && tooSoon(frame_)) return StepResult::frame;
    FramePacket& packet = packets_.back();
    turn(haveFrame, packet);
    if (haveFrame ? !draw || draw(frame_) : !parts_.runToTheEnd) {
        if (pictures_ == nullptr) {
            Expected<void> made = makePictures();
            if (!made) return std::move(made).error();
        }
        packets_.publish();
        packets_.take();
        Expected<hal::Duration> shown = pictures_->show(packets_.front());
        afterPicture(shown);
        if (!shown) return std::move(shown).error();
    }
    if (haveFrame) return StepResult::frame;
    return supervisor_.state() == CameraState::ended ? StepResult::ended : StepResult::none;
}

void Mirror::runLoop() {
    while (!stopping_.load(std::memory_order_acquire)) {
        const CameraNext next = takeFrame();
        if (next == CameraNext::stopped) break;
        const bool haveFrame = next == CameraNext::frame;
        if (haveFrame && tooSoon(frame_)) continue;
        turn(haveFrame, packets_.back());
        if (!haveFrame && supervisor_.anyFrame() && supervisor_.silence() < kPictureStays) continue;
        packets_.publish();
        packetReady_.raise();
    }
}

void Mirror::runRenderer(std::promise<Expected<void>> standing) {
    Expected<void> made = makePictures();
    const bool good = made.hasValue();
    standing.set_value(std::move(made));
    if (!good) return;
    bool failing = false;
    while (!stopping_.load(std::memory_order_acquire)) {
        packetReady_.clear();
        if (!packets_.take()) {
            parts_.clock->waitUntil(parts_.clock->now() + kRedrawAfter, packetReady_);
            if (stopping_.load(std::memory_order_acquire)) break;
            packets_.take();
        }
        const Expected<hal::Duration> shown = pictures_->show(packets_.front());
        // Told when it begins and when it is over, not thirty times a second.
        if (!shown && !failing) log(Severity::error, shown.error().message(), message::kPictureNotShown);
        failing = !shown;
        afterPicture(shown);
    }
    // The context belongs to this thread.
    pictures_.reset();
}

Expected<void> Mirror::start() {
    std::promise<Expected<void>> standing;
    std::future<Expected<void>> stands = standing.get_future();
    renderThread_ = std::thread([this, standing = std::move(standing)]() mutable { runRenderer(std::move(standing)); });
    Expected<void> made = stands.get();
    if (!made) {
        renderThread_.join();
        return made;
    }
    loopThread_ = std::thread([this] { runLoop(); });
    return {};
}

void Mirror::stop() {
    stopping_.store(true, std::memory_order_release);
    supervisor_.stop();
    packetReady_.raise();
    if (loopThread_.joinable()) loopThread_.join();
    // The loop's last packet may have been published after the first raise.
    packetReady_.raise();
    if (renderThread_.joinable()) renderThread_.join();
}

void Mirror::setNotice(std::string_view notice) {
    const std::lock_guard lock(shared_);
    notice_.assign(notice);
    noticeNew_ = !notice.empty();
}

MirrorStatus Mirror::status() const {
    const std::lock_guard lock(shared_);
    return status_;
}

std::vector<TaskStatistics> Mirror::statistics() const {
    const std::lock_guard lock(shared_);
    std::vector<TaskStatistics> rows(loopRows_.begin(), loopRows_.begin() + static_cast<std::ptrdiff_t>(loopRowCount_));
    rows.insert(rows.end(), renderRows_.begin(), renderRows_.begin() + static_cast<std::ptrdiff_t>(renderRowCount_));
    return rows;
}

std::string Mirror::rendererDescription() const {
    const std::lock_guard lock(shared_);
    return description_;
}

}  // namespace cheval::daemon
