#include "altiro3D/display.hpp"
#include "display/usb_memory.hpp"
#include "support/files.hpp"
#include "support/picture_files.hpp"

#include <array>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

using std::chrono::milliseconds;

std::string json() {
    return R"({"configVersion":"1.0","serial":"LKG-2K-04409","pitch":{"value":49.91},"slope":)"
           R"({"value":-5.44},"center":{"value":0.18},"viewCone":{"value":40},"invView":)"
           R"({"value":1},"DPI":{"value":338},"screenW":{"value":2560},"screenH":{"value":1600}})";
}

// A display whose answers arrive over a socket, as those of /dev/hidraw do.
class FakeDisplay {
  public:
    explicit FakeDisplay(std::string memory) : memory_(std::move(memory)) {
        if (::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends_.data()) != 0) ADD_FAILURE();
    }
    ~FakeDisplay() {
        ::close(ends_[0]);
        ::close(ends_[1]);
    }
    FakeDisplay(const FakeDisplay&) = delete;
    FakeDisplay& operator=(const FakeDisplay&) = delete;

    void send(const std::string& report) const {
        EXPECT_EQ(::write(ends_[1], report.data(), report.size()),
                  static_cast<ssize_t>(report.size()));
    }
    std::string answer(std::size_t page) const {
        std::string data = memory_.substr(std::min(64 * page, memory_.size()), 64);
        data.resize(64);
        return std::string{'\x05', '\0', static_cast<char>(page >> 8), static_cast<char>(page)} +
               data;
    }
    void sendInHalves(const std::string& report) const {
        send(report.substr(0, 64));
        send(report.substr(64));
    }
    std::string read(const std::string& cached = {}) {
        return readUsbMemory({[this](const std::string& report) {
                                  ASSERT_EQ(report.size(), 68U);
                                  ASSERT_EQ(report.substr(0, 2), std::string(2, '\0'));
                                  ++requests;
                                  onRequest(256 * static_cast<unsigned char>(report[2]) +
                                            static_cast<unsigned char>(report[3]));
                              },
                              [this](milliseconds wait) {
                                  if (!isSilent) return readInputReport(ends_[0], "fake", wait);
                                  std::string report = readInputReport(ends_[0], "fake", {});
                                  if (report.empty()) waited += wait;
                                  return report;
                              }},
                             "fake", cached);
    }

    int requests = 0;
    bool isSilent = false; ///< Nothing comes later than at once: waits only count, in `waited`.
    milliseconds waited{0};
    std::function<void(std::size_t page)> onRequest = [this](std::size_t page) {
        send(answer(page));
    };

  private:
    std::string memory_;
    std::array<int, 2> ends_{-1, -1};
};

std::string memoryOf(const std::string& text) {
    return bigEndian(text.size()) + text;
}

TEST(UsbMemory, IsReadInWholeReportsAndInHalves) {
    FakeDisplay display(memoryOf(json()));
    EXPECT_EQ(display.read(), json());
    EXPECT_EQ(display.requests, static_cast<int>((json().size() + 4 + 63) / 64));
    display.onRequest = [&](std::size_t page) { display.sendInHalves(display.answer(page)); };
    EXPECT_EQ(display.read(), json());
    EXPECT_EQ(parseCalibrations(display.read(), "fake").front().serial, "LKG-2K-04409");
    const std::string full = json() + std::string(64 * 3 - 4 - json().size() % 64, ' ');
    FakeDisplay exact(memoryOf(full)); // the JSON ends where a page ends
    EXPECT_EQ(exact.read(), full);
}

TEST(UsbMemory, ReportsOfButtonsAreSkipped) {
    FakeDisplay display(memoryOf(json()));
    display.send(display.answer(0).replace(4, 4, bigEndian(9))); // from before the request
    display.onRequest = [&](std::size_t page) {
        const std::string pressed = display.answer(page + 1);
        display.send(pressed);
        display.sendInHalves(pressed);
        display.send(pressed.substr(0, 64)); // half of one that is lost
        display.send("\x01");
        display.send(std::string(4, '\x02'));
        if (page % 2 == 0)
            display.send(display.answer(page));
        else
            display.sendInHalves(display.answer(page));
        display.sendInHalves(pressed);
    };
    EXPECT_EQ(display.read(), json());
}

TEST(UsbMemory, ALostAnswerIsAskedForAgain) {
    FakeDisplay display(memoryOf(json()));
    bool isLost = true;
    display.onRequest = [&](std::size_t page) {
        if (page == 1 && std::exchange(isLost, false)) return;
        display.send(display.answer(page));
    };
    EXPECT_EQ(display.read(), json());
}

TEST(UsbMemory, OnlyPageZeroIsReadIfItIsThatOfTheCache) {
    FakeDisplay display(memoryOf(json()));
    EXPECT_EQ(display.read(json()), json());
    EXPECT_EQ(display.requests, 1);
    std::string other = json();
    other[20] = 'x';
    for (const std::string& cached : {other, json() + " ", std::string("{")}) {
        display.requests = 0;
        EXPECT_EQ(display.read(cached), json());
        EXPECT_GT(display.requests, 1);
    }
}

TEST(UsbMemory, SilenceAndEndlessButtonsEndAfterTwoSeconds) {
    FakeDisplay display(memoryOf(json()));
    display.isSilent = true;
    const std::string silent = "fake: the display does not answer, expected page 0 of its memory "
                               "within 2 s; plug it in again";
    for (const bool hasButtons : {false, true}) {
        display.onRequest = [&](std::size_t page) {
            for (int i = 0; hasButtons && i < 20; ++i)
                display.send(display.answer(page + 1));
        };
        display.waited = milliseconds(0);
        EXPECT_EQ(errorOf([&] { (void)display.read(); }), silent);
        EXPECT_GT(display.waited, milliseconds(hasButtons ? 1000 : 1900)); // buttons take time too
        EXPECT_LE(display.waited, milliseconds(2000));
    }
}

TEST(UsbMemory, HostileLengthsAndEmptyMemoriesAreRefused) {
    const std::string empty = "fake: its memory is empty, expected a calibration";
    EXPECT_EQ(errorOf([] { (void)FakeDisplay(std::string(64, '\xff')).read(); }), empty);
    EXPECT_EQ(errorOf([] { (void)FakeDisplay(std::string(64, '\0')).read(); }), empty);
    for (const std::size_t length : {4097UL, 0x7fffffffUL, 0x80000000UL, 0xfffffffeUL}) {
        FakeDisplay display(bigEndian(length) + json());
        EXPECT_EQ(errorOf([&] { (void)display.read(); }),
                  "fake: its memory states a calibration of " + std::to_string(length) +
                      " bytes, expected at most 4096");
        EXPECT_EQ(display.requests, 1);
    }
}

TEST(UsbMemory, AnUnpluggedDisplayIsAnError) {
    std::array<int, 2> ends{-1, -1};
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends.data()), 0);
    EXPECT_EQ(readInputReport(ends[0], "fake", milliseconds(1)), "");
    ::close(ends[1]);
    const std::string error =
        errorOf([&] { (void)readInputReport(ends[0], "fake", milliseconds(1)); });
    EXPECT_TRUE(startsWith(error, "fake: cannot be read: ")) << error;
    ::close(ends[0]);
}

TEST(UsbDisplay, IsFoundByNumberAndName) {
    const TemporaryDirectory root;
    EXPECT_TRUE(findUsbDisplays(root.path()).empty());
    const auto connect = [&](const std::string& node, const std::string& facts) {
        fs::create_directories(root / "sys/class/hidraw" / node / "device");
        spill(root / "sys/class/hidraw" / node / "device/uevent", facts);
    };
    const std::string id = "DRIVER=hid-generic\nHID_ID=0003:000004D8:0000EF7E\n";
    connect("hidraw2", id + "HID_NAME=Looking Glass HoloPlay\nHID_PHYS=usb-1/input2\n");
    connect("hidraw1", id + "HID_NAME=Looking Glass HoloPlay\nHID_PHYS=usb-2/input2\n");
    connect("hidraw0", id + "HID_NAME=Somebody's Keyboard\n");
    connect("hidraw3", "HID_ID=0003:000004D8:0000EF7F\nHID_NAME=HoloPlay\n");
    const std::vector<UsbDisplay> found = findUsbDisplays(root.path());
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[0].device, root / "dev/hidraw1");
    EXPECT_EQ(found[1].device, root / "dev/hidraw2");
    EXPECT_NE(found[0].id, found[1].id);
    EXPECT_EQ(found[0].id.size(), 16U);
    const std::string error = errorOf([&] { (void)readUsbCalibration(found[0]); });
    EXPECT_TRUE(startsWith(error, found[0].device.string() + ": cannot be read: ")) << error;
}

TEST(UsbDisplay, WithoutPermissionTheErrorNamesTheRule) {
    const TemporaryDirectory root;
    spill(root / "hidraw0", "");
    fs::permissions(root / "hidraw0", fs::perms::none);
    const bool isRoot = ::geteuid() == 0; // who may read everything
    if (isRoot && ::seteuid(65534) != 0) GTEST_SKIP() << "there is no other user";
    const std::string error = errorOf([&] { (void)readUsbCalibration({root / "hidraw0", ""}); });
    EXPECT_TRUE(!isRoot || ::seteuid(0) == 0);
    EXPECT_TRUE(holds(error, "70-altiro3D.rules in /etc/udev/rules.d")) << error;
}

} // namespace
} // namespace altiro3D::test
