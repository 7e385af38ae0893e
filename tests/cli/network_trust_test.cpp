// Which network files the tools run directly, and which they first test in a child process.

#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/onnx.hpp"

#include <cstdio>
#include <memory>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTool = "photo2native";
constexpr const char* kTried = "tested in a separate process";

std::string sha256(const fs::path& file) {
    const std::string command = "sha256sum <'" + file.string() + "'";
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string digits(64, '?');
    if (!pipe || std::fread(digits.data(), 1, digits.size(), pipe.get()) != digits.size())
        return {};
    return digits;
}

// A studio with one network, small.onnx, that a catalogue knows.
class NetworkTrust : public ::testing::Test {
  protected:
    NetworkTrust() {
        fs::create_directory(studio_ / "net");
        studio_.set("ALTIRO3D_MODELS", (studio_ / "net").string());
        spill(network_, onnx::mixModel({0.2F, 0.3F, 0.5F}, {32, 32}));
    }

    void writeCatalog(const std::string& hash) const {
        spill(studio_ / "net/catalog.json",
              R"({"networks": [{"name": "small", "file": "small.onnx", "sha256": ")" + hash +
                  R"(", "inputWidth": 32, "inputHeight": 32}]})");
    }
    Outcome run(const std::string& output) const {
        return studio_.convert(kTool,
                               {"-v", "-n", "small", "--engine", "opencv", "photo.png", output});
    }

    SmallStudio studio_;
    fs::path network_ = studio_ / "net/small.onnx";
};

bool wasTried(const Outcome& outcome) {
    return outcome.out.find(kTried) != std::string::npos;
}

TEST_F(NetworkTrust, AFileOfTheCatalogueIsTrusted) {
    writeCatalog(sha256(network_));
    const Outcome outcome = run("a.png");
    EXPECT_TRUE(isDone(outcome));
    EXPECT_FALSE(wasTried(outcome)) << outcome.text();
}

TEST_F(NetworkTrust, AKnownNameWithOtherContentsIsTriedInAChildAndWarnedOf) {
    writeCatalog(sha256(network_));
    EXPECT_TRUE(isDone(run("right.png")));
    writeCatalog(std::string(64, '0'));
    fs::remove_all(studio_.home()); // with the cache
    const Outcome first = run("a.png");
    EXPECT_TRUE(warns(first, "differs from the catalogue's small"));
    EXPECT_TRUE(wasTried(first)) << first.text();
    // its input is prepared as the catalogue says; another network of that name may need another
    // profile
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), readBack(studio_ / "right.png")));

    const Outcome second = run("b.png"); // the trial is remembered, the warning stays
    EXPECT_TRUE(warns(second, "differs from the catalogue's small"));
    EXPECT_FALSE(wasTried(second)) << second.text();

    spill(network_, onnx::mixModel({0.5F, 0.3F, 0.2F}, {32, 32}));
    const Outcome changed = run("c.png");
    EXPECT_TRUE(warns(changed, "differs from the catalogue's small"));
    EXPECT_TRUE(wasTried(changed)) << changed.text();
}

TEST_F(NetworkTrust, AKnownNameDoesNotSaveAFileThatCrashesOpenCv) {
    using namespace onnx;
    writeCatalog(sha256(network_));
    // weights that claim 3 x 3000 x 3000 values and hold one: OpenCV 4.6 reads beyond their end
    spill(network_, model(node("Conv", {"x", "w"}, {"y"}, intsAttribute("kernel_shape", {1, 1})) +
                          bytes(5, tensor("w", {1, 3, 3000, 3000}, {0})) +
                          bytes(11, valueInfo("x", {1, 3, 32, 32})) +
                          bytes(12, valueInfo("y", {1, 1, 32, 32}))));
    EXPECT_TRUE(fails(run("a.png"), 1, "crashes when"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

TEST_F(NetworkTrust, AGraphThatOpenCvRefusesGivesOneLine) { // OpenCV logs several more
    spill(network_, onnx::oneNodeModel("NoSuchOperation", {1, 3, 32, 32}));
    writeCatalog(sha256(network_)); // loaded in the tool's own process
    EXPECT_TRUE(fails(run("a.png"), 1, "cannot load this graph"));
}

TEST_F(NetworkTrust, ACatalogueCannotLeadOutOfItsFolder) {
    writeCatalog("");
    fs::rename(network_, studio_ / "small.onnx");
    std::string catalog = slurp(studio_ / "net/catalog.json");
    catalog.replace(catalog.find("small.onnx"), 10, "../small.onnx");
    spill(studio_ / "net/catalog.json", catalog);
    EXPECT_TRUE(fails(run("a.png"), 1, "expected a file name without directories"));
}

} // namespace
} // namespace altiro3D::test
