#include "hal/usb/usb_watcher.h"

#include <array>
#include <optional>
#include <utility>

#include <libusb.h>

#include "hal/usb/usb_bus.h"

namespace cheval::hal {

namespace {

class LibusbWatcher final : public UsbWatcher {
  public:
    explicit LibusbWatcher(UsbContext context) : context_(std::move(context)) {}
    ~LibusbWatcher() override {
        if (registered_) libusb_hotplug_deregister_callback(context_.get(), handle_);
    }
    LibusbWatcher(const LibusbWatcher&) = delete;
    LibusbWatcher& operator=(const LibusbWatcher&) = delete;

    Expected<void> listen() {
        // Every device, for the list has ranges of products, which libusb cannot match.
        const int code = libusb_hotplug_register_callback(
            context_.get(), LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT,
            LIBUSB_HOTPLUG_NO_FLAGS, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY,
            &LibusbWatcher::changed, this, &handle_);
        if (code != LIBUSB_SUCCESS) return usbError(code, "USB hot-plug cannot be watched");
        registered_ = true;
        return {};
    }

    Expected<void> poll() override {
        timeval none{.tv_sec = 0, .tv_usec = 0};
        const int code = libusb_handle_events_timeout_completed(context_.get(), &none, nullptr);
        if (code != LIBUSB_SUCCESS && code != LIBUSB_ERROR_INTERRUPTED) {
            return usbError(code, "USB events cannot be read");
        }
        return {};
    }

    bool take(UsbEvent& event) override {
        if (waiting_ == 0) return false;
        event = events_.at(first_);
        first_ = (first_ + 1) % kMostWaiting;
        --waiting_;
        return true;
    }

    [[nodiscard]] Expected<std::vector<UsbSensor>> sensors() const override { return listSensors(context_.get()); }
    [[nodiscard]] const UsbCounts& counts() const override { return counts_; }

  private:
    // Runs within poll(). No call of libusb that waits is allowed here.
    static int LIBUSB_CALL changed(libusb_context* /*context*/, libusb_device* device, libusb_hotplug_event event,
                                   void* watcher) {
        std::optional<UsbSensor> sensor = describeSensor(device);
        if (sensor) {
            static_cast<LibusbWatcher*>(watcher)->add(
                {.change = event == LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT ? UsbChange::left : UsbChange::arrived,
                 .sensor = std::move(*sensor)});
        }
        return 0;  // Go on listening.
    }

    void add(UsbEvent event) {
        ++(event.change == UsbChange::left ? counts_.left : counts_.arrived);
        if (waiting_ == kMostWaiting) {
            ++counts_.dropped;
            first_ = (first_ + 1) % kMostWaiting;
            --waiting_;
        }
        events_.at((first_ + waiting_) % kMostWaiting) = std::move(event);
        ++waiting_;
    }

    UsbContext context_;
    libusb_hotplug_callback_handle handle_ = 0;
    bool registered_ = false;
    std::array<UsbEvent, kMostWaiting> events_;
    std::size_t first_ = 0;
    std::size_t waiting_ = 0;
    UsbCounts counts_;
};

}  // namespace

Expected<std::unique_ptr<UsbWatcher>> UsbWatcher::start() {
    Expected<UsbContext> context = openUsb();
    if (!context) return std::move(context).error();
    if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) == 0) {
        return Error{.code = ErrorCode::unavailable,
                     .cause = "this libusb reports no hot-plug",
                     .mend = "install Debian's libusb-1.0-0",
                     .why = "it was built without udev and netlink"};
    }
    auto watcher = std::make_unique<LibusbWatcher>(std::move(*context));
    Expected<void> listening = watcher->listen();
    if (!listening) return std::move(listening).error();
    return std::unique_ptr<UsbWatcher>(std::move(watcher));
}

}  // namespace cheval::hal
