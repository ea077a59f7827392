#include "daemon/frame_chain.h"

#include <algorithm>
#include <utility>

#include "daemon/hud_writer.h"

namespace cheval::daemon {

namespace {

using std::chrono::microseconds;

/// D5's threshold, here for "enough of a person to hang clothes on".
constexpr float kSeen = 0.5F;

bool enoughJoints(const fitting::Skeleton& skeleton) {
    if (!skeleton.present()) return false;
    const auto seen = [&skeleton](fitting::Joint joint) { return skeleton[joint].confidence >= kSeen; };
    return seen(fitting::Joint::neck) && seen(fitting::Joint::torso) &&
           (seen(fitting::Joint::leftShoulder) || seen(fitting::Joint::rightShoulder));
}

/// "cause. Mend: mend" without heap memory: buttons may fail in every frame.
std::string_view writeFault(const Error& error, render::FixedText<256>& text) {
    std::array<char, 256> bytes{};
    std::size_t length = 0;
    const auto append = [&bytes, &length](std::string_view part) {
        length += part.copy(bytes.data() + length, bytes.size() - length);
    };
    append(error.cause.empty() ? "the buttons fail" : std::string_view(error.cause));
    if (!error.mend.empty()) {
        append(". Mend: ");
        append(error.mend);
    }
    text.assign({bytes.data(), length});
    return text.view();
}

}  // namespace

/// The table's functions. A frame that did not come leaves all but buttons, session and the hand-over out.
struct FrameChain::Tasks {
    static FrameChain& self(void* context) { return *static_cast<FrameChain*>(context); }
    static bool haveFrame(const void* context) {
        return static_cast<const FrameChain*>(context)->input_->frame != nullptr;
    }
    static bool haveBody(const void* context) {
        const auto& chain = *static_cast<const FrameChain*>(context);
        return haveFrame(context) && chain.estimator_ != nullptr;
    }
    static bool changed(const void* context) { return static_cast<const FrameChain*>(context)->outfitChanged(); }
    static bool dressed(const void* context) {
        const auto& chain = *static_cast<const FrameChain*>(context);
        return haveBody(context) && chain.session_.dressed() && chain.somebody();
    }

    static void ingest(void* context) { self(context).pollButtons(); }
    static void track(void* context) { self(context).tracker_->track(*self(context).input_->frame); }
    static void hands(void* context) {
        FrameChain& chain = self(context);
        chain.tracker_->readHands(*chain.input_->frame);
        chain.hands_ = chain.tracker_->hands();
    }
    static void body(void* context) {
        FrameChain& chain = self(context);
        const fitting::Tracker& tracker = *chain.tracker_;
        chain.estimator_->update(*chain.input_->frame, tracker.users(), tracker.skeleton(), tracker.placement());
    }
    static void session(void* context) { self(context).updateSession(); }
    static void layering(void* context) { self(context).fitOutfit(); }
    static void animate(void* context) {
        FrameChain& chain = self(context);
        chain.animator_->pose(chain.shaped_, chain.fitter_->fitted(), chain.tracker_->skeleton(), chain.packet_->mesh);
        chain.packet_->dressed = true;
    }
    static void handOver(void* context) { self(context).handOver(); }

    static constexpr std::array<Task, 8> kTable = {{
        {.name = "ingest", .budget = microseconds(500), .priority = 10, .skip = SkipPolicy::never, .work = &ingest},
        {.name = "track",
         .budget = microseconds(6000),
         .priority = 20,
         .skip = SkipPolicy::never,
         .work = &track,
         .wanted = &haveFrame},
        {.name = "hands",
         .budget = microseconds(1000),
         .priority = 30,
         .skip = SkipPolicy::whenLate,
         .work = &hands,
         .wanted = &haveFrame},
        {.name = "body",
         .budget = microseconds(2000),
         .priority = 40,
         .skip = SkipPolicy::whenLate,
         .work = &body,
         .wanted = &haveBody},
        {.name = "session", .budget = microseconds(200), .priority = 50, .skip = SkipPolicy::never, .work = &session},
        {.name = "layering",
         .budget = microseconds(3000),
         .priority = 60,
         .skip = SkipPolicy::whenLate,
         .work = &layering,
         .wanted = &changed},
        {.name = "animate",
         .budget = microseconds(1500),
         .priority = 70,
         .skip = SkipPolicy::never,
         .work = &animate,
         .wanted = &dressed},
        {.name = "hand over",
         .budget = microseconds(1500),
         .priority = 80,
         .skip = SkipPolicy::never,
         .work = &handOver},
    }};
};

std::span<const Task> FrameChain::tasks() {
    return Tasks::kTable;
}

Expected<std::unique_ptr<FrameChain>> FrameChain::create(const Wardrobe& wardrobe, const FrameChainOptions& options,
                                                         const hal::Clock& admission, const hal::Clock& cost) {
    Expected<Scheduler> scheduler = Scheduler::create(Tasks::kTable, options.scheduler, admission, cost);
    if (!scheduler) return std::move(scheduler).error();
    return std::unique_ptr<FrameChain>(new FrameChain(wardrobe, options, std::move(*scheduler)));
}

FrameChain::FrameChain(const Wardrobe& wardrobe, const FrameChainOptions& options, Scheduler scheduler)
    : wardrobe_(wardrobe),
      scheduler_(std::move(scheduler)),
      session_(options.session),
      tracker_(std::make_unique<fitting::Tracker>(options.tracker)),
      displayWidth_(options.displayWidth),
      displayHeight_(options.displayHeight),
      rotated_(options.rotated) {
    if (!wardrobe.body) return;
    estimator_ = std::make_unique<fitting::BodyEstimator>(*wardrobe.body, options.estimator);
    fitter_ = std::make_unique<fitting::OutfitFitter>(*wardrobe.body, wardrobe.garments);
    animator_ = std::make_unique<fitting::Animator>(*wardrobe.body, options.animator);
    // Fit every outfit once, so that the first change in front of a shopper takes no memory.
    fitting::shapeBody(*wardrobe.body, fittedShape_, shaped_);
    for (const OutfitChoice& choice : wardrobe.outfits)
        fitter_->fit(shaped_, choice.outfit);
    fitOutfit();
}

FrameChain::~FrameChain() = default;

void FrameChain::reserve(FramePacket& packet, int width, int height, bool colour) const {
    packet.depth.resize(width, height);
    packet.userMap.resize(width, height);
    if (colour) packet.colour.resize(width, height);
    if (animator_ != nullptr) animator_->reserve(packet.mesh);
    writeCarousel(wardrobe_, packet.hud);
}

void FrameChain::cameraOpened(const fitting::TrackerOptions& options) {
    tracker_ = std::make_unique<fitting::Tracker>(options);
    personMayHaveChanged();
}

void FrameChain::personMayHaveChanged() {
    if (estimator_ != nullptr) estimator_->reset();
    if (animator_ != nullptr) animator_->reset();
    adviser_.reset();
    hands_ = {};
}

const fitting::Measurements* FrameChain::measurements() const {
    return estimator_ == nullptr ? nullptr : &estimator_->measurements();
}

hal::Duration FrameChain::process(const ChainInput& input, FramePacket& packet) {
    input_ = &input;
    packet_ = &packet;
    packet.dressed = false;
    // Gestures are told once: what is not read anew is not there.
    hands_.gestureCount = 0;
    if (input.frame != nullptr && input.frame->restart) {
        session_.reset();
        adviser_.reset();
        hands_ = {};
        if (animator_ != nullptr) animator_->reset();
    }
    const hal::Duration taken = scheduler_.runFrame(input.started, this);
    input_ = nullptr;
    packet_ = nullptr;
    return taken;
}

void FrameChain::pollButtons() {
    eventCount_ = 0;
    std::string_view fault;
    for (hal::Buttons* buttons : input_->buttons) {
        const std::span<hal::ButtonEvent> room = std::span(events_).subspan(eventCount_);
        if (room.empty()) break;
        // Buttons that fail are buttons that nobody pressed; the mirror goes on, and its health says so.
        const Expected<std::size_t> count = buttons->poll(room);
        if (count) {
            eventCount_ += std::min(*count, room.size());
        } else if (fault.empty()) {
            fault = writeFault(count.error(), buttonsFault_);
        }
    }
    // Events are told before faults, so that only silence says that nothing is wrong.
    if (fault.empty() && eventCount_ == 0) buttonsFault_.assign("");
    commandCount_ = input_->commands == nullptr ? 0 : input_->commands->take(commands_);
}

bool FrameChain::somebody() const {
    return tracker_->skeleton().present();
}

void FrameChain::updateSession() {
    SessionInput input{.time = input_->time,
                       .buttons = std::span(events_.data(), eventCount_),
                       .commands = std::span(commands_.data(), commandCount_)};
    if (input_->frame != nullptr) {
        input.userId = tracker_->users().activeId;
        input.jointsSeen = enoughJoints(tracker_->skeleton());
        input.measured = estimator_ != nullptr && estimator_->shape().measured;
        input.gestures = std::span(hands_.gestures.data(), std::min(hands_.gestureCount, hands_.gestures.size()));
    }
    // Without a mannequin there is nothing to wear: the session stays before the dressing.
    if (estimator_ == nullptr) input.jointsSeen = false;
    session_.update(input);
}

fitting::Outfit FrameChain::chosen() const {
    if (session_.outfit() >= wardrobe_.outfits.size()) return {};
    return wardrobe_.outfits[session_.outfit()].outfit;
}

bool FrameChain::outfitChanged() const {
    if (fitter_ == nullptr) return false;
    return estimator_->shape().revision != fittedShape_.revision || !(chosen() == fittedOutfit_);
}

void FrameChain::fitOutfit() {
    fittedShape_ = estimator_->shape();
    fittedOutfit_ = chosen();
    fitting::shapeBody(*wardrobe_.body, fittedShape_, shaped_);
    fitter_->fit(shaped_, fittedOutfit_);
}

void FrameChain::adviseSize() {
    const std::uint32_t user = input_->frame == nullptr ? 0 : tracker_->users().activeId;
    // Nobody is told the size of whoever stood there before.
    if (session_.state() == SessionState::idle || (user != 0 && user != advisedUser_)) adviser_.reset();
    advisedUser_ = user != 0 ? user : session_.state() == SessionState::idle ? 0 : advisedUser_;
    if (user == 0) return;
    fitting::SizeQuestion question{.measurements = measurements()};
    const fitting::Outfit outfit = chosen();
    // What is worn outermost is what a shopper looks at; a hat over it has no size of these.
    for (std::size_t i = outfit.count; i > 0 && question.chart == nullptr; --i) {
        const fitting::Garment& garment = wardrobe_.garments[outfit.garments[i - 1]];
        const fitting::SizeChart* chart = sizeChartOf(wardrobe_, garment);
        if (chart == nullptr || fitting::primaryGirths(garment.kind, *chart).count == 0) continue;
        question.chart = chart;
        question.kind = garment.kind;
    }
    adviser_.update(question, input_->time);
}

void FrameChain::handOver() {
    adviseSize();
    FramePacket& packet = *packet_;
    packet.hasPicture = input_->frame != nullptr;
    packet.captureTime = input_->time;
    packet.renderScale = input_->renderScale;
    // Without a picture of the shop the mannequin's stage is what can be shown.
    packet.view = session_.avatarView() || input_->away ? render::View::avatar : render::View::mirror;
    packet.skeleton = {};
    packet.userLabel = 0;
    if (input_->frame != nullptr) {
        const hal::DepthFrame& frame = *input_->frame;
        const fitting::Users& users = tracker_->users();
        hal::copyInto(frame.depth, packet.depth);
        hal::copyInto(frame.colour, packet.colour);
        // The renderer takes pictures of one size alone.
        const bool sameSize = users.map.width == frame.depth.width && users.map.height == frame.depth.height;
        hal::copyInto(sameSize ? users.map : hal::ImageView<const std::uint8_t>{}, packet.userMap);
        packet.intrinsics = frame.intrinsics;
        packet.sourceIndex = frame.sourceIndex;
        packet.placement = tracker_->placement();
        packet.skeleton = tracker_->skeleton();
        mapping_ = crop_.follow(frame.depth.width, frame.depth.height, displayWidth_, displayHeight_,
                                render::uprightTurn(rotated_, packet.placement), frame.intrinsics, packet.placement,
                                packet.skeleton);
        if (const fitting::User* user = users.active()) packet.userLabel = user->label;
    }
    writeHud({.session = &session_,
              .wardrobe = &wardrobe_,
              .hands = &hands_,
              .placement = &packet.placement,
              .advice = &adviser_.advice(),
              .measurements = measurements(),
              .intrinsics = packet.intrinsics,
              .mapping = input_->frame != nullptr ? &mapping_ : nullptr,
              .displayWidth = displayWidth_,
              .displayHeight = displayHeight_,
              .fault = input_->fault,
              .away = input_->away,
              .notice = input_->notice,
              .showNotice = input_->showNotice},
             packet.hud);
}

}  // namespace cheval::daemon
