#include "daemon/frame_rate.h"

namespace cheval::daemon {

void FrameRate::add(const hal::DepthFrame& frame) {
    const bool backwards = frame.captureTime < since_ || frame.sequence < first_;
    if (!begun_ || frame.restart || backwards) {
        hz_ = 0.0;
    } else if (frame.captureTime - since_ >= kSpan) {
        hz_ = static_cast<double>(frame.sequence - first_) / hal::seconds(frame.captureTime - since_);
    } else {
        return;
    }
    begun_ = true;
    since_ = frame.captureTime;
    first_ = frame.sequence;
}

}  // namespace cheval::daemon
