#include "tests/hal/usb/mock_usb.h"

#include <atomic>
#include <cerrno>
#include <iomanip>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>

namespace cheval::test {

namespace {

constexpr const char* kRoot = "/devices/pci0000:00/0000:00:14.0/usb1";

std::string threeDigits(int number) {
    std::ostringstream text;
    text << std::setw(3) << std::setfill('0') << number;
    return text.str();
}

// The path in sysfs, through the hubs that it hangs on: 1-2.3 lies in 1-2.
std::string folderOf(const std::string& portPath) {
    std::string path = kRoot;
    if (portPath.empty()) return path;
    for (std::size_t end = portPath.find('.'); end != std::string::npos; end = portPath.find('.', end + 1))
        path += "/" + portPath.substr(0, end);
    return path + "/" + portPath;
}

std::string nodeOf(int address) {
    return "bus/usb/001/" + threeDigits(address);
}

// A device descriptor and one configuration without interfaces, as USB 2.0 lays them out in chapter 9.6.
std::vector<std::uint8_t> descriptors(std::uint16_t vendor, std::uint16_t product) {
    const auto low = [](std::uint16_t word) { return static_cast<std::uint8_t>(word & 0xffU); };
    const auto high = [](std::uint16_t word) { return static_cast<std::uint8_t>(word >> 8U); };
    return {18, 1, 0x00, 0x02, 0, 0, 0, 64, low(vendor), high(vendor), low(product), high(product), 0x00, 0x01, 0, 0,
            0,  1, 9,    2,    9, 0, 0, 1,  0,           0x80,         250};
}

std::string describe(const std::string& portPath, int address, std::uint16_t vendor, std::uint16_t product) {
    std::ostringstream text;
    text << "P: " << folderOf(portPath) << "\nN: " << nodeOf(address) << "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n"
         << "E: BUSNUM=001\nE: DEVNUM=" << threeDigits(address) << "\nE: DEVNAME=/dev/" << nodeOf(address)
         << "\nA: busnum=1\\n\nA: devnum=" << address << "\\n\nA: bConfigurationValue=1\\n\nA: speed=480\\n\n"
         << "H: descriptors=" << std::hex << std::uppercase << std::setfill('0');
    for (const std::uint8_t byte : descriptors(vendor, product))
        text << std::setw(2) << static_cast<int>(byte);
    text << "\n\n";
    return text.str();
}

void check(gboolean good, GError* error, const char* attempt) {
    if (good != FALSE) return;
    std::string text = std::string("umockdev cannot ") + attempt;
    if (error != nullptr) text += std::string(": ") + error->message;
    g_clear_error(&error);
    throw std::runtime_error(text);
}

}  // namespace

struct MockUsb::Parts {
    UMockdevTestbed* testbed = nullptr;
    std::map<std::string, UMockdevIoctlBase*> nodes;
    std::atomic<MockReset> answer{MockReset::done};
    std::atomic<int> resets{0};

    // Runs in a thread of umockdev's.
    static gboolean answerIoctl(UMockdevIoctlBase* /*node*/, UMockdevIoctlClient* client, gpointer data) {
        auto& parts = *static_cast<Parts*>(data);
        if (umockdev_ioctl_client_get_request(client) != USBDEVFS_RESET) {
            umockdev_ioctl_client_complete(client, -1, ENOTTY);
            return TRUE;
        }
        ++parts.resets;
        switch (parts.answer) {
            case MockReset::done:
                umockdev_ioctl_client_complete(client, 0, 0);
                break;
            case MockReset::gone:
                umockdev_ioctl_client_complete(client, -1, ENODEV);
                break;
            case MockReset::refused:
                umockdev_ioctl_client_complete(client, -1, EIO);
                break;
            case MockReset::hangs:
                g_object_ref(client);  // Kept, or umockdev would hang up on it. It goes with its connection.
                break;
        }
        return TRUE;
    }
};

MockUsb::MockUsb() : parts_(std::make_unique<Parts>()) {
    parts_->testbed = umockdev_testbed_new();
    if (umockdev_in_mock_environment() == FALSE) {
        throw std::runtime_error("run this program with libumockdev-preload.so.0 in LD_PRELOAD, as ctest does");
    }
    GError* error = nullptr;
    const std::string hub = describe("", 1, 0x1d6b, 0x0002);
    check(umockdev_testbed_add_from_string(parts_->testbed, hub.c_str(), &error), error, "make a root hub");
}

MockUsb::~MockUsb() {
    for (auto& [node, handler] : parts_->nodes) {
        umockdev_testbed_detach_ioctl(parts_->testbed, node.c_str(), nullptr);
        g_object_unref(handler);
    }
    g_object_unref(parts_->testbed);
}

void MockUsb::plugIn(const MockDevice& device) {
    GError* error = nullptr;
    const std::string text = describe(device.portPath, device.address, device.vendor, device.product);
    check(umockdev_testbed_add_from_string(parts_->testbed, text.c_str(), &error), error, "plug a device in");
}

void MockUsb::pullOut(const MockDevice& device) {
    const std::string path = "/sys" + folderOf(device.portPath);
    umockdev_testbed_uevent(parts_->testbed, path.c_str(), "remove");
    umockdev_testbed_remove_device(parts_->testbed, path.c_str());
}

void MockUsb::answerResets(const MockDevice& device, MockReset answer) {
    parts_->answer = answer;
    const std::string node = "/dev/" + nodeOf(device.address);
    UMockdevIoctlBase* handler = umockdev_ioctl_base_new();
    g_signal_connect(handler, "handle-ioctl", G_CALLBACK(&Parts::answerIoctl), parts_.get());
    GError* error = nullptr;
    check(umockdev_testbed_attach_ioctl(parts_->testbed, node.c_str(), handler, &error), error, "answer resets");
    parts_->nodes.emplace(node, handler);
}

int MockUsb::resets() const {
    return parts_->resets;
}

}  // namespace cheval::test
