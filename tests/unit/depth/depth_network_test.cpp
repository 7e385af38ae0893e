#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "base/system_library.hpp"
#include "base/system_process.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/onnx.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

using namespace altiro3D;
using namespace altiro3D::test;
using namespace altiro3D::test::onnx;
namespace fs = std::filesystem;

namespace {

NetworkProfile profileOf(int width, int height) {
    NetworkProfile profile;
    profile.name = "test";
    profile.file = "test.onnx";
    profile.inputWidth = width;
    profile.inputHeight = height;
    profile.multipleOf = 1;
    profile.engine = InferenceEngine::OpenCv; // whose words many tests expect
    return profile;
}

std::vector<InferenceEngine> engines() {
    std::vector<InferenceEngine> all{InferenceEngine::OpenCv};
    if (hasOnnxRuntime()) all.push_back(InferenceEngine::OnnxRuntime);
    return all;
}

// y = the mean over blocks of 14 x 14 px of the sum of weights[c] * x[c], for photos of any size,
// as [1, 1, H, W], or squeezed to [1, H, W]: the contract of Depth Anything V2.
std::string blockModel(const std::vector<float>& weights, bool squeezed) {
    constexpr int kBlock = 14;
    std::vector<float> down;
    for (const float weight : weights)
        down.insert(down.end(), kBlock * kBlock, weight / (kBlock * kBlock));
    const std::vector<float> up(kBlock * kBlock, 1);
    const std::string blocks = intsAttribute("kernel_shape", {kBlock, kBlock}) +
                               intsAttribute("strides", {kBlock, kBlock});
    std::string graph = node("Conv", {"pixel_values", "down"}, {"blocks"}, blocks) +
                        node("ConvTranspose", {"blocks", "up"}, {"grown"}, blocks);
    if (squeezed) graph += node("Squeeze", {"grown"}, {"depth"}, intsAttribute("axes", {1}));
    return model(
        graph + bytes(5, tensor("down", {1, 3, kBlock, kBlock}, down)) +
        bytes(5, tensor("up", {1, 1, kBlock, kBlock}, up)) +
        bytes(11, valueInfo("pixel_values", {1, 3, 0, 0})) +
        bytes(12, squeezed ? valueInfo("depth", {1, 0, 0}) : valueInfo("grown", {1, 1, 0, 0})));
}

// A channel in floats. @param channel of BGR
cv::Mat channelOf(const cv::Mat& photo, int channel, double scale = 1) {
    cv::Mat values;
    cv::extractChannel(photo, values, channel);
    values.convertTo(values, CV_32F, scale);
    return values;
}

cv::Mat colourfulPhoto(cv::Size size) {
    return pictureOf<cv::Vec3b>(size, [&](int x, int y) {
        return cv::Vec3b(static_cast<uchar>((x * 37 + y * 11) % 256),
                         static_cast<uchar>((x / 5 % 2) * 255),
                         static_cast<uchar>((x * x + 3 * y * y) % 256));
    });
}

cv::Mat inferred(DepthNetwork&& network, const cv::Mat& photo) {
    cv::Mat raw;
    network.infer(photo, raw);
    return raw;
}

// A graph of one convolution of x, of any size. @param weights the tensor w and what it has more
std::string convolution(const std::string& weights, const std::string& inputs,
                        const std::vector<int>& output) {
    return node("Conv", {"x", "w"}, {"y"}, intsAttribute("kernel_shape", {1, 1})) +
           bytes(5, weights) + inputs + bytes(12, valueInfo("y", output));
}
const std::string kInput = bytes(11, valueInfo("x", {1, 3, 6, 8}));

// The numbers of a .npy file of floats, behind its header.
cv::Mat readNpy(const fs::path& file, cv::Size size) {
    const std::string contents = slurp(file);
    cv::Mat values(size, CV_32FC1);
    const std::size_t bytes = values.total() * sizeof(float);
    std::memcpy(values.data, contents.data() + contents.size() - bytes, bytes);
    return values;
}

NetworkProfile catalogued(const std::string& name) {
    for (const NetworkProfile& profile : readModelCatalog(sourcePath("models/catalog.json")))
        if (profile.name == name) return profile;
    ADD_FAILURE() << name << " is not in the catalogue";
    return {};
}

// Sets an environment variable for one test; null removes it.
class Variable {
  public:
    Variable(const char* name, const char* value) : name_(name) {
        const char* before = std::getenv(name);
        if (before != nullptr) before_ = before;
        wasSet_ = before != nullptr;
        set(value);
    }
    ~Variable() { set(wasSet_ ? before_.c_str() : nullptr); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

  private:
    void set(const char* value) {
#ifdef _WIN32
        _putenv_s(name_, value == nullptr ? "" : value); // no value is the same as an empty one
#else
        if (value == nullptr) unsetenv(name_);
        if (value != nullptr) setenv(name_, value, 1);
#endif
    }
    const char* name_;
    std::string before_;
    bool wasSet_ = false;
};

class ModelCatalog : public FileTest {
  protected:
    fs::path write(const std::string& text) {
        spill(directory / "catalog.json", text);
        return directory / "catalog.json";
    }
    std::string errorOfCatalog(const std::string& text) {
        const fs::path file = write(text);
        return problemOf(file, [&] { readModelCatalog(file); });
    }
    std::string errorOfProfile(const std::string& text) {
        const fs::path file = write(text);
        return problemOf(file, [&] { readNetworkProfile(file); });
    }
};

class DepthNetworkFile : public FileTest {
  protected:
    fs::path write(const std::string& contents, const std::string& name = "test.onnx") {
        spill(directory / name, contents);
        return directory / name;
    }
    std::string errorOfLoading(const std::string& contents,
                               const NetworkProfile& profile = profileOf(8, 6)) {
        const fs::path file = write(contents);
        return problemOf(file, [&] { DepthNetwork(file, profile); });
    }
    std::string errorOfRunning(const std::string& contents) {
        const fs::path file = write(contents);
        DepthNetwork network(file, profileOf(8, 6));
        cv::Mat raw;
        return problemOf(file, [&] { network.infer(colourfulPhoto({20, 10}), raw); });
    }
};

} // namespace

// --- Profiles and the catalogue ----------------------------------------------------------------

TEST(NetworkProfile, ValidationNamesFieldValueAndRange) {
    using Profile = NetworkProfile;
    const std::pair<std::function<void(Profile&)>, const char*> cases[] = {
        {[](Profile&) {}, "(no error)"},
        {[](Profile& p) { p.name = ""; },
         "name: is \"\", expected 1..64 letters, digits, '.', '_' or '-'"},
        {[](Profile& p) { p.file = "../x.onnx"; },
         "file: is \"../x.onnx\", expected a file name without directories, of letters, digits, "
         "'.', '_' or '-'"},
        {[](Profile& p) { p.url = "http://example.org/x"; },
         "url: is \"http://example.org/x\", expected https://..."},
        {[](Profile& p) { p.sha256 = "ABC"; },
         "sha256: is \"ABC\", expected 64 lower-case hexadecimal digits"},
        {[](Profile& p) { p.inputWidth = 0; }, "inputWidth: is 0, expected a whole number 1..4096"},
        {[](Profile& p) { p.inputHeight = 4097; },
         "inputHeight: is 4097, expected a whole number 1..4096"},
        {[](Profile& p) { p.inputWidth = 250; }, "inputWidth: is 250, expected a multiple of 32"},
        {[](Profile& p) { p.multipleOf = 0; }, "multipleOf: is 0, expected a whole number 1..4096"},
        {[](Profile& p) { p.scale = 0; }, "scale: is 0, expected a number other than 0"},
        {[](Profile& p) { p.mean[1] = std::nan(""); }, "mean[1]: is nan, expected a number"},
        {[](Profile& p) { p.std[2] = 0; }, "std[2]: is 0, expected a number other than 0"}};
    for (const auto& [change, expected] : cases) {
        NetworkProfile profile = profileOf(256, 256);
        profile.multipleOf = 32;
        change(profile);
        EXPECT_EQ(errorOf([&p = profile] { validate(p); }), expected);
    }
}

TEST_F(ModelCatalog, OfTheSourceTreeHoldsTheKnownNetworks) {
    const auto catalog = readModelCatalog(sourcePath("models/catalog.json"));
    ASSERT_EQ(catalog.size(), 5U);

    const char* const names[] = {"depth-anything-v2-small", "midas-small", "midas-large",
                                 "altiro3d", "fastdepth"};
    for (std::size_t i = 0; i < catalog.size(); ++i)
        EXPECT_EQ(catalog[i].name, names[i]);
    EXPECT_EQ(catalog[0].engine, InferenceEngine::OnnxRuntime);
    EXPECT_EQ(catalog[0].mean, (std::array<double, 3>{0.485, 0.456, 0.406}));
    EXPECT_EQ(catalog[1].mean, (std::array<double, 3>{0, 0, 0})) << "it is inside the graph";
    EXPECT_EQ(catalog[1].resizeKernel, ResizeKernel::Cubic);
    EXPECT_TRUE(catalog[2].large);
    EXPECT_EQ(catalog[3].inputShape, InputShape::Photo);
    EXPECT_EQ(catalog[3].bytes, fs::file_size(sourcePath("models") / catalog[3].file));
    EXPECT_EQ(catalog[4].output, NetworkOutput::MetricDepth);

    EXPECT_EQ(findProfile(catalog, "/somewhere/model-small.onnx"), &catalog[1]);
    EXPECT_EQ(findProfile(catalog, "/somewhere/other.onnx"), nullptr);
    EXPECT_EQ(findProfile(catalog, ""), nullptr);
}

TEST_F(ModelCatalog, ReadsEveryFieldAndLeavesUnknownKeysAlone) {
    const NetworkProfile profile = readNetworkProfile(write(R"({
        "name": "n", "file": "f.onnx", "url": "https://example.org/f.onnx", "bytes": 5000000000,
        "sha256": "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
        "licence": "L", "large": true, "inputWidth": 28, "inputHeight": 14, "multipleOf": 14,
        "channelOrder": "BGR", "scale": 2, "mean": [1, 2.5, -3], "std": [4, 5, 6],
        "resizeKernel": "area", "output": "metricDepth", "engine": "opencv",
        "note": {"any": ["thing", null]}})"));
    EXPECT_EQ(profile.name + profile.file + profile.licence, "nf.onnxL");
    EXPECT_EQ(profile.url, "https://example.org/f.onnx");
    EXPECT_EQ(profile.bytes, 5000000000U);
    EXPECT_EQ(profile.sha256.substr(0, 4), "0123");
    EXPECT_TRUE(profile.large);
    EXPECT_EQ(cv::Size(profile.inputWidth, profile.inputHeight), cv::Size(28, 14));
    EXPECT_EQ(profile.multipleOf, 14);
    EXPECT_EQ(profile.channelOrder, ChannelOrder::Bgr);
    EXPECT_EQ(profile.scale, 2);
    EXPECT_EQ(profile.mean, (std::array<double, 3>{1, 2.5, -3}));
    EXPECT_EQ(profile.std, (std::array<double, 3>{4, 5, 6}));
    EXPECT_EQ(profile.resizeKernel, ResizeKernel::Area);
    EXPECT_EQ(profile.output, NetworkOutput::MetricDepth);
    EXPECT_EQ(profile.engine, InferenceEngine::OpenCv);
}

TEST_F(ModelCatalog, ErrorsNamePlaceAndExpectation) {
    const std::pair<const char*, const char*> cases[] = {
        {"[]", R"(is a list, expected {"networks": [...]})"},
        {"{}", R"(has no "networks", expected {"networks": [...]})"},
        {R"({"networks": 7})", "networks: is 7, expected a list"},
        {R"({"networks": ["x"]})", "networks[0]: is \"x\", expected an object"},
        {"{\"networks\": [\n  {]}",
         R"(is not valid JSON (line 2, column 4), expected {"networks": [...]})"},
        {"", R"(is not valid JSON (line 1, column 1), expected {"networks": [...]})"},
        {R"({"networks": [{"name": "a", "file": "a", "inputWidth": 32, "inputHeight": 32},
             {"name": "b", "inputWidth": "x"}]})",
         "networks[1].inputWidth: is \"x\", expected a whole number 1..4096"},
        {R"({"networks": [{"name": "a", "inputWidth": 32, "inputHeight": 32}]})",
         "networks[0].file: is empty, expected the ONNX file's name"}};
    for (const auto& [text, problem] : cases)
        EXPECT_EQ(errorOfCatalog(text), problem);
    const std::string pair = R"({"networks": [{"name": "a", "file": "a", "inputWidth": 32,
                                "inputHeight": 32}, {"name": "NAME", "file": "FILE",
                                "inputWidth": 32, "inputHeight": 32}]})";
    const auto with = [&](const std::string& name, const std::string& file) {
        std::string text = pair;
        text.replace(text.find("NAME"), 4, name);
        return text.replace(text.find("FILE"), 4, file);
    };
    EXPECT_EQ(readModelCatalog(write(with("b", "b"))).size(), 2U);
    EXPECT_EQ(errorOfCatalog(with("a", "b")),
              "networks[1].name: is \"a\" for the second time, expected a new name");
    EXPECT_EQ(errorOfCatalog(with("b", "a")),
              "networks[1].file: is \"a\" for the second time, expected a new file");
}

TEST_F(ModelCatalog, ProfileErrorsNameFieldAndExpectation) {
    const std::pair<const char*, const char*> cases[] = {
        {R"("url": 3)", "url: is 3, expected a text"},
        {R"("large": 1)", "large: is 1, expected true or false"},
        {R"("bytes": -1)", "bytes: is -1, expected a whole number of bytes, 0 if unknown"},
        {R"("multipleOf": 2.5)", "multipleOf: is 2.5, expected a whole number 1..4096"},
        {R"("multipleOf": 18446744073709551615)",
         "multipleOf: is 18446744073709551615, expected a whole number 1..4096"},
        {R"("multipleOf": -9223372036854775808)",
         "multipleOf: is -9223372036854775808, expected a whole number 1..4096"},
        {R"("scale": null)", "scale: is null, expected a number"},
        {R"("scale": 1e999)", "holds a number that is out of range, expected an object with the "
                              "fields of one network"},
        {R"("mean": 1)", "mean: is 1, expected a list of three numbers"},
        {R"("mean": [1, 2])", "mean: has 2 entries, expected a list of three numbers"},
        {R"("std": [1, 1, "1"])", "std[2]: is \"1\", expected a number"},
        {R"("resizeKernel": "lanczos")", "resizeKernel: is \"lanczos\", expected \"nearest\", "
                                         "\"linear\", \"cubic\" or \"area\""},
        {R"("output": {})", "output: is an object, expected \"inverseDepth\" or \"metricDepth\""},
        {R"("name": "m")", "the key \"name\" occurs twice in one object, expected it once"}};
    for (const auto& [field, problem] : cases)
        EXPECT_EQ(errorOfProfile(std::string("{") + field +
                                 R"(, "name": "n", "inputWidth": 32, "inputHeight": 32})"),
                  problem);
    EXPECT_EQ(errorOfProfile(R"({"name": "n", "inputWidth": 32})"),
              "inputHeight: is missing, expected it in every network");
}

TEST_F(ModelCatalog, RefusesWhatWouldExhaustTheStackOrMemory) {
    std::string objects;
    for (int i = 0; i < 100000; ++i)
        objects += "{\"a\":";
    const std::string deep(100000, '[');
    for (const std::string& text : {deep, deep + std::string(100000, ']'), objects})
        EXPECT_EQ(errorOfCatalog(text),
                  "nests deeper than 16 levels, expected {\"networks\": [...]}");
    const fs::path large = write(std::string(1024 * 1024 + 1, ' '));
    EXPECT_EQ(codeOf([&] { readModelCatalog(large); }), ErrorCode::TooLarge);
    EXPECT_EQ(codeOf([&] { readModelCatalog(directory / "absent.json"); }), ErrorCode::NotFound);
}

#ifdef _WIN32
constexpr const char* kUserData = "LOCALAPPDATA";
#else
constexpr const char* kUserData = "XDG_DATA_HOME"; // else a folder in $HOME
#endif

TEST(ModelSearchPath, FollowsTheEnvironmentInOrderAndLeavesOutMissingDirectories) {
    const TemporaryDirectory root;
    fs::create_directories(root / "a");
    fs::create_directories(root / "b");
    fs::create_directories(root / "data/altiro3D/models");
    fs::create_directories(root / "home/.local/share/altiro3D/models");
    std::string list;
    for (const char* name : {"a", "", "absent", "b", "a/"})
        list += (*name == '\0' ? "" : (root / name).string()) + kListSeparator;
    const Variable models("ALTIRO3D_MODELS", list.c_str());
    const Variable home("HOME", (root / "home").string().c_str());
    {
        const Variable data(kUserData, (root / "data").string().c_str());
        const auto path = modelSearchPath();
        ASSERT_GE(path.size(), 4U);
        EXPECT_EQ(path[0], root / "a");
        EXPECT_EQ(path[1], root / "b") << "the absent one and the second a are left out";
        EXPECT_EQ(path[2], root / "data/altiro3D/models");
        EXPECT_TRUE(std::count(path.begin(), path.end(), sourcePath("models")) == 1);
    }
    if (std::string(kUserData) != "XDG_DATA_HOME") return;
    for (const char* unusable : {static_cast<const char*>(nullptr), "", "relative"}) {
        const Variable data(kUserData, unusable);
        const auto path = modelSearchPath();
        ASSERT_GE(path.size(), 3U);
        EXPECT_EQ(path[2], root / "home/.local/share/altiro3D/models");
    }
}

TEST(ModelSearchPath, NeedsNoHomeAndLeavesTheWorkingDirectoryAlone) {
    const TemporaryDirectory root;
    fs::create_directories(root / "models");
    const Variable models("ALTIRO3D_MODELS", nullptr);
    const Variable data(kUserData, nullptr);
    const Variable home("HOME", nullptr);
    const fs::path before = fs::current_path();
    fs::current_path(root.path());
    const auto path = modelSearchPath();
    fs::current_path(before);
    for (const fs::path& directory : path) {
        EXPECT_TRUE(directory.has_root_directory() && fs::is_directory(directory)) << directory;
        EXPECT_NE(directory, root / "models");
    }
}

TEST(DataDirectories, HoldWhatComesWithTheLibrary) {
    int calibrations = 0;
    for (const fs::path& directory : dataDirectories()) {
        EXPECT_TRUE(fs::is_directory(directory)) << directory;
        calibrations += fs::exists(directory / "calibration/portrait-sample.json") ? 1 : 0;
    }
    EXPECT_GE(calibrations, 1);
}

TEST(DataDirectories, ThePrefixIsThatOfTheFilesPlace) {
    EXPECT_EQ(prefixOf("/opt/a/lib/x86_64-linux-gnu/libaltiro3D.so.0", "lib/x86_64-linux-gnu"),
              "/opt/a");
    EXPECT_EQ(prefixOf("/usr/bin/photo2native", "bin"), "/usr");
    EXPECT_EQ(prefixOf("/lib/libaltiro3D.so.0", "lib"), "/");
    for (const char* elsewhere : {"/opt/a/lib/libaltiro3D.so", "/tmp/build/libaltiro3D.so",
                                  "/libaltiro3D.so", "libaltiro3D.so", "/", ""})
        EXPECT_EQ(prefixOf(elsewhere, "lib/x86_64-linux-gnu"), "") << elsewhere;
    EXPECT_EQ(prefixOf("/usr/bin/photo2native", "/usr/bin"), "") << "such a prefix cannot be moved";
    EXPECT_EQ(prefixOf("/usr/bin/photo2native", ""), "");
}

TEST(ModelSearchPath, FindsTheFirstFileOfTheName) {
    const TemporaryDirectory root;
    for (const char* directory : {"a/m.onnx", "b", "c"})
        fs::create_directories(root / directory);
    spill(root / "b/m.onnx", "b");
    spill(root / "c/m.onnx", "c");
    const std::vector<fs::path> path{root / "absent", root / "a", root / "b", root / "c"};
    EXPECT_EQ(findModelFile("m.onnx", path), root / "b/m.onnx") << "a/m.onnx is a directory";
    EXPECT_EQ(findModelFile("n.onnx", path), fs::path());
    EXPECT_EQ(findModelFile("", path), fs::path());
    EXPECT_EQ(findModelFile((root / "b/m.onnx").string(), {root / "c"}), fs::path());
    EXPECT_EQ(findModelFile("m.onnx", {}), fs::path());
}

// --- Input ---------------------------------------------------------------------------------------

TEST_F(DepthNetworkFile, EachChannelArrivesInTheProfilesOrderScaleMeanAndStd) {
    const cv::Size size(8, 6);
    const cv::Mat photo = colourfulPhoto(size); // the input's size: nothing is resampled
    for (const ChannelOrder order : {ChannelOrder::Rgb, ChannelOrder::Bgr}) {
        for (int channel = 0; channel < 3; ++channel) {
            std::vector<float> weights(3, 0.0F);
            weights[static_cast<std::size_t>(channel)] = 1.0F;
            NetworkProfile profile = profileOf(size.width, size.height);
            profile.channelOrder = order;
            profile.scale = 1.0 / 128;
            profile.mean = {0.5, 0.25, 0.125};
            profile.std = {0.25, 0.5, 2};
            const cv::Mat raw = inferred({write(mixModel(weights, size)), profile}, photo);
            const auto c = static_cast<std::size_t>(channel);
            const cv::Mat expected =
                (channelOf(photo, order == ChannelOrder::Rgb ? 2 - channel : channel, 1.0 / 128) -
                 profile.mean[c]) /
                profile.std[c];
            // All numbers of this case are exact in binary.
            EXPECT_TRUE(samePicture(raw, expected))
                << static_cast<int>(order) << " channel " << channel;
        }
    }
}

// The steps of MiDaS' own run_onnx: the picture as RGB in 0..1 (in double), resampled with the
// cubic kernel on these numbers to the input's size without keeping the aspect, rounded to float,
// channels first.
TEST_F(DepthNetworkFile, PreparesTheInputAsMidasDoes) {
    const cv::Size size(64, 32);
    for (const cv::Size photoSize : {cv::Size(640, 480), cv::Size(37, 101), cv::Size(1, 1)}) {
        const cv::Mat photo = colourfulPhoto(photoSize);
        cv::Mat rgb;
        cv::cvtColor(photo, rgb, cv::COLOR_BGR2RGB);
        rgb.convertTo(rgb, CV_64F, 1.0 / 255.0);
        cv::resize(rgb, rgb, size, 0, 0, cv::INTER_CUBIC);
        rgb.convertTo(rgb, CV_32F);
        for (int channel = 0; channel < 3; ++channel) {
            std::vector<float> weights(3, 0.0F);
            weights[static_cast<std::size_t>(channel)] = 1.0F;
            NetworkProfile profile = catalogued("midas-small");
            profile.inputWidth = size.width;
            profile.inputHeight = size.height;
            const cv::Mat raw = inferred({write(mixModel(weights, size)), profile}, photo);
            cv::Mat expected;
            cv::extractChannel(rgb, expected, channel);
            // Float against double: a few units of 2^-24 per tap; resampling bytes instead of
            // floats would be off by 2e-3, a second normalisation by 2.
            EXPECT_TRUE(samePicture(raw, expected, 1e-6)) << photoSize << " channel " << channel;
            if (photoSize.width == 37 && channel == 1) { // stripes of 0 and 1, enlarged
                double low = 0;
                double high = 0;
                cv::minMaxLoc(raw, &low, &high);
                EXPECT_LT(low, 0) << "the cubic kernel overshoots, and nothing may clamp it";
                EXPECT_GT(high, 1);
            }
        }
    }
}

TEST_F(DepthNetworkFile, EachResizeKernelIsOpenCvs) {
    const cv::Size size(16, 8);
    const std::pair<ResizeKernel, int> kernels[] = {{ResizeKernel::Nearest, cv::INTER_NEAREST},
                                                    {ResizeKernel::Linear, cv::INTER_LINEAR},
                                                    {ResizeKernel::Cubic, cv::INTER_CUBIC},
                                                    {ResizeKernel::Area, cv::INTER_AREA}};
    // 1000 rows are many times what is held as float at once; 32 x 16 is twice the input; the last
    // ones grow in one axis or both.
    for (const cv::Size photoSize :
         {cv::Size(61, 47), cv::Size(333, 1000), cv::Size(32, 16), cv::Size(17, 9),
          cv::Size(16, 100), cv::Size(61, 5), cv::Size(7, 47), cv::Size(5, 5)}) {
        const cv::Mat photo = colourfulPhoto(photoSize);
        for (const auto& [kernel, flag] : kernels) {
            NetworkProfile profile = profileOf(size.width, size.height);
            profile.resizeKernel = kernel;
            profile.scale = 1;
            const cv::Mat raw = inferred({write(mixModel({1, 0, 0}, size)), profile}, photo);
            cv::Mat expected;
            cv::resize(channelOf(photo, 2), expected, size, 0, 0, flag);
            // One channel and three may be vectorised differently inside cv::resize.
            EXPECT_TRUE(samePicture(raw, expected, 1e-4)) << flag << ' ' << photoSize;
        }
    }
}

TEST_F(DepthNetworkFile, GivesTheSameAgainAfterAPhotoOfAnotherSizeAndAfterAMove) {
    const cv::Size size(8, 6);
    DepthNetwork network(write(mixModel({0.3F, 0.5F, 0.2F}, size)), profileOf(8, 6));
    cv::Mat first;
    network.infer(colourfulPhoto(cv::Size(33, 21)), first);
    cv::Mat other;
    network.infer(colourfulPhoto(cv::Size(100, 7)), other);
    DepthNetwork moved = std::move(network);
    cv::Mat again;
    moved.infer(colourfulPhoto(cv::Size(33, 21)), again);
    EXPECT_TRUE(samePicture(again, first));
    EXPECT_EQ(moved.profile().name, "test");
    EXPECT_EQ(moved.file(), directory / "test.onnx");
    EXPECT_EQ(moved.target(), InferenceTarget::Cpu);
}

TEST_F(DepthNetworkFile, EstimatePutsNearToOneForBothKindsOfOutput) {
    const cv::Mat photo = pictureOf<cv::Vec3b>( // grows to the right
        {64, 4}, [](int x, int) { return cv::Vec3b::all(static_cast<uchar>(20 + 3 * x)); });
    NetworkProfile profile = profileOf(64, 4);
    for (const NetworkOutput output : {NetworkOutput::InverseDepth, NetworkOutput::MetricDepth}) {
        profile.output = output;
        cv::Mat depth;
        DepthNetwork(write(mixModel({0, 1, 0}, photo.size())), profile).estimate(photo, depth);
        const int near = output == NetworkOutput::InverseDepth ? 63 : 0;
        EXPECT_GT(depth.at<float>(1, near), 0.99F);
        EXPECT_LT(depth.at<float>(1, 63 - near), 0.01F);
    }
}

TEST_F(DepthNetworkFile, EachEngineGivesTheNumbersOfTheGraph) {
    NetworkProfile profile = catalogued("depth-anything-v2-small");
    profile.inputWidth = profile.inputHeight = 56;
    const std::vector<float> weights{0.5F, -1, 2};
    for (const InferenceEngine engine : engines()) {
        profile.engine = engine;
        // OpenCV 4.6 does not squeeze pictures of any size
        const fs::path file = write(blockModel(weights, engine != InferenceEngine::OpenCv));
        DepthNetwork network(file, profile);
        EXPECT_EQ(network.engine(), engine);
        for (const cv::Size size : {cv::Size(56, 42), cv::Size(28, 56), cv::Size(56, 56)}) {
            const cv::Mat photo = colourfulPhoto(size);
            cv::Mat raw;
            network.infer(photo, raw);
            ASSERT_EQ(raw.size(), size);
            forPixels(size, [&](int x, int y) {
                const cv::Scalar mean = cv::mean(photo(cv::Rect(x / 14 * 14, y / 14 * 14, 14, 14)));
                double expected = 0;
                for (std::size_t c = 0; c < 3; ++c) { // BGR to RGB
                    const double value = mean[static_cast<int>(2 - c)] / 255;
                    expected += weights[c] * (value - profile.mean[c]) / profile.std[c];
                }
                ASSERT_NEAR(raw.at<float>(y, x), expected, 1e-4) << size;
            });
        }
    }
}

TEST_F(DepthNetworkFile, TheBestEngineIsOneThatCanRunTheFile) {
    NetworkProfile profile = profileOf(8, 6);
    profile.engine = InferenceEngine::Best;
    const fs::path fixed = write(mixModel({0, 0, 1}, cv::Size(8, 6)));
    EXPECT_EQ(DepthNetwork(fixed, profile).engine(), engines().back());
    EXPECT_EQ(DepthNetwork(fixed, profile, InferenceTarget::Cpu, {16, 12}).engine(),
              InferenceEngine::OpenCv)
        << "a file that is fixed to one size";
    EXPECT_EQ(
        DepthNetwork(fixed, profile, InferenceTarget::Cpu, {}, InferenceEngine::OpenCv).engine(),
        InferenceEngine::OpenCv);
    profile.inputShape = InputShape::Photo;
    profile.inputWidth = profile.inputHeight = 28;
    EXPECT_EQ(DepthNetwork(write(blockModel({1, 1, 1}, false)), profile).engine(),
              engines().back());
}

TEST_F(DepthNetworkFile, WithoutOnnxRuntimeWhatNeedsItIsRefused) {
    NetworkProfile profile = profileOf(8, 6);
    const fs::path file = write(mixModel({0, 0, 1}, cv::Size(8, 6)));
    profile.engine = InferenceEngine::OnnxRuntime;
    spill(directory / "catalog.json", R"({"networks": [
        {"name": "a", "file": "test.onnx", "inputWidth": 8, "inputHeight": 6, "multipleOf": 1,
         "engine": "onnxruntime"}]})");
    EXPECT_EQ(standardNetwork(false, {directory.path()}).has_value(), hasOnnxRuntime());
    EXPECT_EQ(canRun(profile), hasOnnxRuntime());
    for (const InferenceEngine engine : {InferenceEngine::Best, InferenceEngine::OpenCv}) {
        NetworkProfile other = profile;
        other.engine = engine;
        EXPECT_TRUE(canRun(other));
    }
    if (hasOnnxRuntime()) {
        EXPECT_EQ(DepthNetwork(file, profile).engine(), InferenceEngine::OnnxRuntime);
        return;
    }
    EXPECT_EQ(errorOf([&] { DepthNetwork(file, profile); }),
              file.string() + ": needs ONNX Runtime, which this build of altiro3D does not have, "
                              "expected a network that OpenCV can run");
}

TEST_F(DepthNetworkFile, OnnxRuntimesErrorsAreOurs) {
    if (!hasOnnxRuntime()) GTEST_SKIP() << "this build has no ONNX Runtime";
    NetworkProfile profile = profileOf(8, 6);
    profile.engine = InferenceEngine::OnnxRuntime;
    const fs::path file = write(oneNodeModel("NoSuchLayer", {1, 3, 6, 8}));
    const std::string error = errorOf([&] { DepthNetwork(file, profile); });
    EXPECT_TRUE(startsWith(error, file.string() + ": ONNX Runtime "));
    EXPECT_TRUE(holds(error, " cannot load this graph ("));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    // three planes are not a depth map
    const fs::path planes = write(oneNodeModel("Relu", {1, 3, 6, 8}));
    cv::Mat raw;
    EXPECT_EQ(
        errorOf([&] { DepthNetwork(planes, profile).infer(colourfulPhoto(cv::Size(8, 6)), raw); }),
        planes.string() + ": puts out [1, 3, 6, 8] of CV_32FC1, expected [1, height, width] or "
                          "[1, 1, height, width] of CV_32FC1");
    // fixed to 8 x 6, asked for 16 x 12
    const fs::path fixed = write(mixModel({0, 0, 1}, cv::Size(8, 6)));
    const std::string size =
        errorOf([&] { DepthNetwork(fixed, profile, InferenceTarget::Cpu, cv::Size(16, 12)); });
    EXPECT_TRUE(holds(size, " cannot run this graph ("));
}

TEST_F(DepthNetworkFile, MayHaveAnyName) {
    const cv::Size size(8, 6);
    std::string name = "n\xc3\xa4me with '$(odd)'.bin";
    if (fs::path::preferred_separator == '/') name += "\"\xff"; // Windows allows neither
    const fs::path file = write(mixModel({1, 0, 0}, size), name);
    EXPECT_EQ(inferred({file, profileOf(8, 6)}, colourfulPhoto(size)).size(), size);
}

TEST_F(DepthNetworkFile, OpenSidesTakeTheProfilesSize) {
    // Old exporters list weights as inputs; they are ignored.
    const std::string graph = convolution(
        tensor("w", {1, 3, 1, 1}, {1, 0, 0}),
        bytes(11, valueInfo("w", {1, 3, 1, 1})) + bytes(11, valueInfo("x", {0, 3, 0, 0})), {});
    const cv::Mat photo = colourfulPhoto({8, 6});
    EXPECT_TRUE(samePicture(inferred({write(model(graph)), profileOf(8, 6)}, photo),
                            channelOf(photo, 2, 1.0 / 255), 1e-6)); // last bits of a float
}

TEST_F(DepthNetworkFile, RunsAtAnotherSizeIfRequested) {
    // The file is fixed to 8 x 6, and so is the shape in its last layer.
    for (const bool squeezed : {false, true}) {
        const fs::path file = write(mixModel({0, 0, 1}, cv::Size(8, 6), squeezed));
        NetworkProfile profile = profileOf(8, 6);
        profile.scale = 1;
        for (const cv::Size size : {cv::Size(16, 12), cv::Size(3, 2), cv::Size(8, 6)}) {
            DepthNetwork network(file, profile, InferenceTarget::Cpu, size);
            EXPECT_EQ(network.inputSize(), size);
            EXPECT_EQ(network.profile().inputWidth, 8);
            for (int i = 0; i < 2; ++i) {
                const cv::Mat photo = colourfulPhoto(size);
                cv::Mat raw;
                network.infer(photo, raw);
                EXPECT_TRUE(samePicture(raw, channelOf(photo, 0))) << size;
            }
        }
        EXPECT_EQ(DepthNetwork(file, profile).inputSize(), cv::Size(8, 6));
    }
}

TEST_F(DepthNetworkFile, TheInputMayFollowThePhotosShape) {
    const fs::path file = write(mixModel({0, 0, 1}, cv::Size(8, 6)));
    NetworkProfile profile = profileOf(8, 6);
    profile.scale = 1;
    profile.multipleOf = 2;
    profile.inputShape = InputShape::Photo;
    DepthNetwork network(file, profile);
    EXPECT_EQ(network.inputSize(), cv::Size(8, 6));
    const std::pair<cv::Size, cv::Size> cases[] = {
        {{8, 6}, {8, 6}},    {{80, 60}, {8, 6}},  {{60, 80}, {6, 8}},
        {{50, 50}, {8, 8}},  {{160, 90}, {8, 4}}, // 4.5: the nearest multiple of 2
        {{1, 4000}, {2, 8}},                      // never less than one multiple
        {{4000, 1}, {8, 2}}, {{1, 1}, {8, 8}}};
    for (const auto& [photoSize, inputSize] : cases) {
        cv::Mat raw;
        network.infer(colourfulPhoto(photoSize), raw);
        EXPECT_EQ(raw.size(), inputSize) << photoSize;
    }

    // Half as large, in the shape of the photo: each value is that of the px under it.
    const cv::Mat photo = colourfulPhoto({4, 8});
    EXPECT_TRUE(samePicture(inferred({file, profile, InferenceTarget::Cpu, {8, 8}}, photo),
                            channelOf(photo, 0)));
}

TEST_F(DepthNetworkFile, InstalledNetworksAreThoseOfTheCatalogueWhoseFilesAreThere) {
    const std::vector<fs::path> path{directory.path()};
    EXPECT_TRUE(modelCatalog(path).empty());
    EXPECT_TRUE(installedNetworks(path).empty());
    spill(directory / "catalog.json", R"({"networks": [
        {"name": "a", "file": "a.onnx", "inputWidth": 64, "inputHeight": 32},
        {"name": "b", "file": "b.onnx", "inputWidth": 64, "inputHeight": 64,
         "inputShape": "photo"},
        {"name": "c", "file": "c.onnx", "inputWidth": 64, "inputHeight": 64}]})");
    spill(directory / "b.onnx", "");
    const std::vector<NetworkProfile> catalog = modelCatalog(path);
    ASSERT_EQ(catalog.size(), 3U);
    EXPECT_EQ(catalog[0].inputShape, InputShape::Fixed);
    EXPECT_EQ(catalog[1].inputShape, InputShape::Photo);
    const std::vector<InstalledNetwork> installed = installedNetworks(path);
    ASSERT_EQ(installed.size(), 1U);
    EXPECT_EQ(installed[0].profile.name, "b");
    EXPECT_EQ(installed[0].file, directory / "b.onnx");
}

TEST_F(DepthNetworkFile, TheStandardNetworkIsTheFirstOneThatIsInstalled) {
    const std::vector<fs::path> path{directory.path()};
    EXPECT_FALSE(standardNetwork(false, path).has_value());
    spill(directory / "catalog.json", R"({"networks": [
        {"name": "big", "file": "l.onnx", "inputWidth": 64, "inputHeight": 64, "large": true},
        {"name": "a", "file": "a.onnx", "inputWidth": 64, "inputHeight": 64},
        {"name": "b", "file": "b.onnx", "inputWidth": 64, "inputHeight": 64}]})");
    EXPECT_FALSE(standardNetwork(false, path).has_value());
    spill(directory / "l.onnx", "");
    EXPECT_FALSE(standardNetwork(false, path).has_value());
    spill(directory / "b.onnx", "");
    EXPECT_EQ(standardNetwork(false, path)->profile.name, "b");
    spill(directory / "a.onnx", "");
    EXPECT_EQ(standardNetwork(false, path)->profile.name, "a");
    EXPECT_EQ(standardNetwork(false, path)->file, directory / "a.onnx");
    EXPECT_EQ(standardNetwork(true, path)->profile.name, "big");
}

TEST_F(DepthNetworkFile, WithoutANetworkOnlyDepthThatMustBeEstimatedFails) {
    spill(directory / "catalog.json", R"({"networks": []})");
    const Variable models("ALTIRO3D_MODELS", directory.path().string().c_str());
    const cv::Mat photo = randomPhoto({60, 40});
    writeImage(directory / "photo.png", photo);
    const std::shared_ptr<DepthSource> source = estimatedDepth();
    altiro3D::Scene scene;
    const std::string problem = "depth: no network is installed that could estimate it, expected ";
    EXPECT_TRUE(startsWith(errorOf([&] { source->readScene(photo, 0.5, scene); }), problem));
    const auto stored = storedDepthOr(source);
    const auto read = [&] {
        const PhotoDepth found = stored->readPhoto(directory / "photo.png");
        stored->readScene(found, 0.5, scene);
        return found.origin;
    };
    EXPECT_TRUE(startsWith(errorOf([&] { read(); }), problem));
    EXPECT_TRUE(startsWith(errorOf([&] { stored->load(); }), problem));
    writeImage(directory / "photo-depth.png", depthTo16Bit(randomDepth({60, 40})));
    EXPECT_EQ(read(), DepthOrigin::Given);
}

// --- Errors --------------------------------------------------------------------------------------

TEST_F(DepthNetworkFile, AnotherSizeIsRefusedIfTheGraphCannotRunAtIt) {
    const fs::path file = write(mixModel({1, 0, 0}, cv::Size(8, 6)));
    const auto errorAt = [&](NetworkProfile profile, cv::Size size) {
        return problemOf(file, [&] { DepthNetwork(file, profile, InferenceTarget::Cpu, size); });
    };
    NetworkProfile inTwos = profileOf(8, 6);
    inTwos.multipleOf = 2;
    const std::pair<cv::Size, std::string> sizes[] = {
        {{10, 5}, "10 x 5"}, {{4098, 6}, "4098 x 6"}, {{-8, 6}, "-8 x 6"}};
    for (const auto& [size, text] : sizes)
        EXPECT_EQ(errorAt(inTwos, size),
                  "inputSize: is " + text + " px, expected sides of 1..4096 px, multiples of 2");
    // A wrong profile stays one.
    EXPECT_EQ(errorAt(profileOf(16, 12), {16, 12}),
              "takes pictures of 8 x 6 px, expected 16 x 12 px as in the profile \"test\"");
    // A shape that is fixed before the end.
    const std::string graph =
        node("Conv", {"x", "w"}, {"a"}, intsAttribute("kernel_shape", {1, 1})) +
        node("Squeeze", {"a"}, {"b"}, intsAttribute("axes", {1})) + node("Relu", {"b"}, {"y"}) +
        bytes(5, tensor("w", {1, 3, 1, 1}, {1, 0, 0})) + bytes(11, valueInfo("x", {1, 3, 6, 8})) +
        bytes(12, valueInfo("y", {1, 6, 8}));
    spill(file, model(graph));
    EXPECT_EQ(errorAt(profileOf(8, 6), {}), "(no error)");
    const std::string error = errorAt(profileOf(8, 6), {16, 12});
    EXPECT_TRUE(startsWith(error, "OpenCV " CV_VERSION " cannot run this graph ("));
}

TEST_F(DepthNetworkFile, FilesThatAreNotOnnxAreRefusedInOneLine) {
    const std::pair<std::string, const char*> cases[] = {
        {"", "is empty"},
        {"\n<!DOCTYPE html><html></html>", "is a web page or XML"},
        {"\x89PNG\r\n\x1a\n and so on", "is a PNG picture"},
        {"\xff\xd8\xff\xe0 and so on", "is a JPEG picture"},
        {"version https://git-lfs.github.com/spec/v1\noid sha256:00\n",
         "is a Git LFS pointer, not the file itself"},
        {"PK\x03\x04 and so on", "is a ZIP archive or a PyTorch file"},
        {"\x1f\x8b and so on", "is a gzip archive"},
        {std::string("\x1c\0\0\0TFL3", 8), "is a TensorFlow Lite file"},
        {"{\"a\": 1}", "is a JSON text"}};
    for (const auto& [contents, problem] : cases)
        EXPECT_EQ(errorOfLoading(contents), std::string(problem) + ", expected an ONNX file");
    for (const std::string& contents :
         {std::string("Not Found"), std::string(1000, '\0'), std::string(1000, '\xff')})
        EXPECT_EQ(errorOfLoading(contents), "is not an ONNX file, expected a whole ONNX file");
    const std::string whole = mixModel({1, 0, 0}, cv::Size(8, 6));
    for (std::size_t size = 1; size + 8 < whole.size(); ++size) {
        EXPECT_EQ(errorOfLoading(whole.substr(0, size)),
                  "is damaged or cut off, expected a whole ONNX file")
            << size << " of " << whole.size() << " bytes";
    }
    EXPECT_EQ(codeOf([&] { DepthNetwork(directory / "absent.onnx", profileOf(8, 6)); }),
              ErrorCode::NotFound);
    EXPECT_TRUE(
        holds(errorOf([&] { DepthNetwork(directory.path(), profileOf(8, 6)); }), "directory"));
}

TEST_F(DepthNetworkFile, AnInputThatDoesNotFitIsNamed) {
    const cv::Size size(8, 6);
    const auto problemOfShape = [&](const std::vector<int>& shape) {
        return errorOfLoading(oneNodeModel("Relu", shape));
    };
    EXPECT_EQ(errorOfLoading(mixModel({1, 0, 0}, size), profileOf(16, 6)),
              "takes pictures of 8 x 6 px, expected 16 x 6 px as in the profile \"test\"");
    EXPECT_EQ(errorOfLoading(mixModel({1, 0, 0}, size), profileOf(6, 8)),
              "takes pictures of 8 x 6 px, expected 6 x 8 px as in the profile \"test\"");
    EXPECT_EQ(problemOfShape({1, 4, 6, 8}),
              "takes an input of shape [1, 4, 6, 8], expected [1, 3, height, width]");
    EXPECT_EQ(problemOfShape({1, 6, 8, 3}),
              "takes an input of shape [1, 6, 8, 3], expected [1, 3, height, width]");
    EXPECT_EQ(problemOfShape({0, 48}),
              "takes an input of shape [?, 48], expected [1, 3, height, width]");
    EXPECT_EQ(problemOfShape(std::vector<int>(1000, 2)),
              "takes an input of shape [2, 2, 2, 2, 2, 2, 2, 2, ...], expected [1, 3, height, "
              "width]");
    EXPECT_EQ(errorOfLoading(model(node("Add", {"a", "b"}, {"y"}) +
                                   bytes(11, valueInfo("a", {1, 3, 6, 8})) +
                                   bytes(11, valueInfo("b", {1, 3, 6, 8})) +
                                   bytes(12, valueInfo("y", {1, 3, 6, 8})))),
              "takes 2 inputs (a, b), expected one, the picture");
    std::string many;
    for (int i = 0; i < 1000; ++i)
        many += bytes(11, valueInfo(std::to_string(i) + std::string(5000, 'n'), {1, 3, 6, 8}));
    EXPECT_EQ(errorOfLoading(model(node("Add", {"a", "b"}, {"y"}) + many)),
              "takes 1000 inputs (0" + std::string(59, 'n') + "..., 1" + std::string(59, 'n') +
                  "..., 2" + std::string(59, 'n') + "... and 997 more), expected one, the picture");
    EXPECT_EQ(errorOfLoading(mixModel({1, 0, 0}, size), profileOf(0, 6)),
              "inputWidth: is 0, expected a whole number 1..4096");
}

TEST_F(DepthNetworkFile, WeightsInAnotherFileAreNamed) {
    const auto external = [](const std::string& location) {
        return bytes(13, bytes(1, "location") + bytes(2, location)) +
               bytes(13, bytes(1, "offset") + bytes(2, "0")) + number(14, 1);
    };
    const std::string graph =
        convolution(tensor("w", {1, 3, 1, 1}, {}) + external("w.data"), kInput, {1, 1, 6, 8});
    EXPECT_EQ(errorOfLoading(model(graph)),
              "keeps its weights in another file, \"w.data\", which is missing, expected one ONNX "
              "file that holds its weights");
    spill(directory / "w.data", std::string(12, '\0'));
    EXPECT_EQ(errorOfLoading(model(graph)),
              "keeps its weights in another file, \"w.data\", expected one ONNX file that holds "
              "its weights");
    const std::string constant =
        node("Constant", {}, {"c"}, bytes(5, bytes(1, "value") + bytes(5, external("c.data"))));
    EXPECT_EQ(errorOfLoading(model(graph + constant)),
              "keeps its weights in another file, \"c.data\", which is missing (and 1 more), "
              "expected one ONNX file that holds its weights");
    // also in the graphs of conditions and loops, and in functions
    const std::string inner = bytes(5, tensor("v", {1}, {}) + external("inner.data"));
    std::string deep = inner;
    for (int i = 0; i < 8; ++i)
        deep = node("Loop", {}, {"l"}, bytes(5, bytes(1, "body") + bytes(6, deep)));
    for (const std::string& hidden :
         {node("If", {"c"}, {"z"}, bytes(5, bytes(1, "then_branch") + bytes(6, inner))),
          node("If", {"c"}, {"z"}, bytes(5, bytes(1, "graphs") + bytes(11, inner))),
          node("Constant", {}, {"c"},
               bytes(5, bytes(1, "values") + bytes(10, tensor("v", {1}, {}) + external("t")))),
          bytes(15, bytes(1, tensor("s", {1}, {}) + external("s"))), deep})
        EXPECT_TRUE(holds(errorOfLoading(model(graph + hidden)), "(and 1 more)"));
    const std::string function =
        bytes(25, bytes(7, bytes(5, bytes(1, "value") +
                                        bytes(5, tensor("v", {1}, {}) + external("f.data")))));
    EXPECT_TRUE(holds(errorOfLoading(model(graph) + function), "(and 1 more)"));
    const std::string standard = // value of an attribute of a function that a call leaves out
        bytes(25, bytes(11, bytes(1, "value") + bytes(5, tensor("v", {1}, {}) + external("d"))));
    EXPECT_TRUE(holds(errorOfLoading(model(graph) + standard), "(and 1 more)"));
    const std::string longName =
        node("Constant", {}, {"c"},
             bytes(5, bytes(1, "value") + bytes(5, external(std::string(100000, 'a')))));
    EXPECT_EQ(errorOfLoading(model(graph + longName)),
              "keeps its weights in another file, \"" + std::string(60, 'a') +
                  "...\", which is missing (and 1 more), expected one ONNX file that holds its "
                  "weights");
}

// Encodings that protobuf reads as "data_location: EXTERNAL" and "location: w.data".
TEST_F(DepthNetworkFile, UnusualEncodingsDoNotHideWeightsInAnotherFile) {
    const auto fixed32 = [](unsigned field, const std::string& four) {
        return varint(field * 8U + 5U) + four; // a known field of another wire type is skipped
    };
    const std::uint64_t beyond = std::uint64_t{1} << 32U; // higher bits are dropped
    const std::string entry = bytes(13, bytes(1, "location") + bytes(2, "w.data"));
    const std::string usual = entry + number(14, 1);
    for (const std::string& weights :
         {usual, entry + number(14, beyond + 1), entry + varint(beyond + 14U * 8U) + varint(1),
          usual + fixed32(14, std::string(4, '\0')),
          bytes(13, bytes(1, "location") + bytes(2, "w.data") + fixed32(1, "hide")) + number(14, 1),
          bytes(13, bytes(1, "location") + bytes(2, "w.data") + fixed32(2, "hide")) +
              number(14, 1)}) {
        EXPECT_EQ(errorOfLoading(model(
                      convolution(tensor("w", {1, 3, 1, 1}, {}) + weights, kInput, {1, 1, 6, 8}))),
                  "keeps its weights in another file, \"w.data\", which is missing, expected one "
                  "ONNX file that holds its weights");
    }
}

TEST_F(DepthNetworkFile, AGraphThatOpenCvCannotLoadGivesOneLine) {
    const std::string error = errorOfLoading(oneNodeModel("NoSuchOperation", {1, 3, 6, 8}));
    EXPECT_TRUE(startsWith(error, "OpenCV " CV_VERSION " cannot load this graph ("));
    EXPECT_TRUE(holds(error, "NoSuchOperation"));
    EXPECT_TRUE(holds(error, "), expected a loadable graph"));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    EXPECT_LT(error.size(), 300U);
}

// The callback is told the error of a graph that cannot be loaded, so it stays during the call.
TEST_F(DepthNetworkFile, DoesNotChangeOpenCvsLogLevelAndErrorCallback) {
    using namespace cv::utils::logging;
    const LogLevel level = setLogLevel(LOG_LEVEL_FATAL); // no default
    int errors = 0;
    const cv::ErrorCallback count = [](int, const char*, const char*, const char*, int,
                                       void* number) { return ++*static_cast<int*>(number); };
    const cv::ErrorCallback callback = cv::redirectError(count, &errors);
    cv::Mat raw;
    DepthNetwork(write(mixModel({1, 0, 0}, {8, 6})), profileOf(8, 6))
        .infer(colourfulPhoto({8, 6}), raw);
    EXPECT_NE(errorOfLoading(oneNodeModel("NoSuchOperation", {1, 3, 6, 8})), "(no error)");
    EXPECT_GE(errors, 1);
    EXPECT_EQ(cv::redirectError(callback), count);
    EXPECT_EQ(setLogLevel(level), LOG_LEVEL_FATAL);
}

TEST_F(DepthNetworkFile, AnOutputThatIsNoDepthImageIsNamed) {
    EXPECT_EQ(errorOfRunning(oneNodeModel("Relu", {1, 3, 6, 8})),
              "puts out [1, 3, 6, 8] of CV_32FC1, expected [1, height, width] or [1, 1, height, "
              "width] of CV_32FC1");
    EXPECT_EQ(errorOfRunning(model(node("Flatten", {"x"}, {"y"}) +
                                   bytes(11, valueInfo("x", {1, 3, 6, 8})) +
                                   bytes(12, valueInfo("y", {1, 144})))),
              "puts out [1, 144] of CV_32FC1, expected [1, height, width] or [1, 1, height, width] "
              "of CV_32FC1");
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        EXPECT_EQ(errorOfRunning(mixModel({bad, 0, 0}, cv::Size(8, 6))),
                  "puts out NaN or infinity for this picture, expected finite numbers");
    }
}

TEST_F(DepthNetworkFile, OfSeveralOutputsTheLastIsTaken) {
    const std::string graph =
        convolution(tensor("w", {1, 3, 1, 1}, {1, 0, 0}), kInput, {1, 1, 6, 8}) +
        node("Conv", {"x", "v"}, {"z"}, intsAttribute("kernel_shape", {1, 1})) +
        bytes(5, tensor("v", {1, 3, 1, 1}, {0, 0, 1})) + bytes(12, valueInfo("z", {1, 1, 6, 8}));
    const cv::Mat photo = colourfulPhoto({8, 6});
    NetworkProfile profile = profileOf(8, 6);
    profile.scale = 1;
    EXPECT_TRUE(samePicture(inferred({write(model(graph)), profile}, photo), channelOf(photo, 0)));
}

TEST_F(DepthNetworkFile, OnlyEightBitColourPhotosAreTaken) {
    DepthNetwork network(write(mixModel({1, 0, 0}, cv::Size(8, 6))), profileOf(8, 6));
    cv::Mat raw;
    EXPECT_EQ(errorOf([&] { network.infer(cv::Mat(), raw); }),
              "photo: is empty, expected CV_8UC3 (8-bit BGR)");
    EXPECT_EQ(errorOf([&] { network.infer(cv::Mat::zeros(4, 4, CV_8UC1), raw); }),
              "photo: is 4 x 4 px of CV_8UC1, expected CV_8UC3 (8-bit BGR)");
}

TEST_F(DepthNetworkFile, CudaIsRefusedWhereOpenCvHasNone) {
    EXPECT_EQ(bestInferenceTarget(InferenceEngine::OnnxRuntime), InferenceTarget::Cpu);
    if (bestInferenceTarget() == InferenceTarget::Cuda) GTEST_SKIP() << "this OpenCV offers CUDA";
    const fs::path file = write(mixModel({1, 0, 0}, cv::Size(8, 6)));
    EXPECT_EQ(errorOf([&] { DepthNetwork(file, profileOf(8, 6), InferenceTarget::Cuda); }),
              file.string() +
                  ": cannot run on CUDA, which this OpenCV does not offer, expected the "
                  "CPU");
}

TEST_F(DepthNetworkFile, AProbeSurvivesFilesThatCrashOpenCv) {
    // weights that claim 3 x 3000 x 3000 values and hold one: OpenCV 4.6 reads beyond their end
    const fs::path file =
        write(model(convolution(tensor("w", {1, 3, 3000, 3000}, {0}),
                                bytes(11, valueInfo("x", {1, 3, 8, 8})), {1, 1, 8, 8})));
    const std::string error = errorOf([&] { probeNetwork(file, profileOf(8, 8)); });
    EXPECT_TRUE(holds(error, "crashes when"));
}

TEST_F(DepthNetworkFile, AProbeIgnoresErrorsThatTheNetworkReports) {
    const fs::path file = write(mixModel({1, 1, 1}, {8, 8}));
    probeNetwork(file, profileOf(8, 8));
    probeNetwork(file, profileOf(16, 16)); // Mismatch
    write("no network");
    probeNetwork(file, profileOf(8, 8)); // BadFormat
    fs::remove(file);
    probeNetwork(file, profileOf(8, 8)); // NotFound
}

TEST_F(DepthNetworkFile, OnlyAProgramThatIsStartedForAProbeAnswersIt) {
    const std::string file = write(mixModel({1, 1, 1}, {8, 8})).string();
    for (const std::vector<std::string>& other :
         {std::vector<std::string>{},
          {"--altiro3D-probe"},
          {file, "8", "8", "8", "0", "0", "0", "1"},
          {"photo.jpg", file, "8", "8", "8", "0", "0", "0", "1"}})
        EXPECT_FALSE(answerProbe(other));
    const std::vector<std::string> probe{
        "--altiro3D-probe", file, "8", "8", "8", "0", "0", "0", "1"};
    EXPECT_TRUE(answerProbe(probe));
    write("no network"); // its caller reports this
    EXPECT_TRUE(answerProbe(probe));
}

TEST_F(DepthNetworkFile, TheTimeOfAProbeIsChecked) {
    for (const double seconds : {0.0, -1.0, 4000.0, std::nan("")}) {
        EXPECT_TRUE(holds(
            errorOf([&] { probeNetwork(directory / "a.onnx", profileOf(8, 8), {}, seconds); }),
            "expected 0.1..3600"));
    }
}

TEST_F(DepthNetworkFile, ManyMayLoadAndRunAtTheSameTime) {
    const fs::path file = write(mixModel({1, 0, 0}, cv::Size(8, 6)));
    const fs::path broken = directory / "broken.onnx";
    spill(broken, oneNodeModel("NoSuchOperation", {1, 3, 6, 8}));
    ::testing::internal::CaptureStderr(); // OpenCV's log
    std::vector<cv::Mat> results(4);
    std::vector<std::thread> threads;
    for (cv::Mat& result : results) {
        threads.emplace_back([&] {
            for (int i = 0; i < 5; ++i) {
                errorOf([&] { DepthNetwork(broken, profileOf(8, 6)); });
                DepthNetwork(file, profileOf(8, 6)).infer(colourfulPhoto(cv::Size(9, 9)), result);
            }
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    ::testing::internal::GetCapturedStderr();
    for (const cv::Mat& result : results)
        EXPECT_TRUE(samePicture(result, results[0]));
}

// --- Real networks -------------------------------------------------------------------------------

TEST(FastDepth, GivesTheNumbersOfItsReference) {
    ALTIRO3D_REQUIRE_DATA("models/fastdepth/fastdepth_224_op10.onnx");
    const fs::path folder = dataPath("models/fastdepth");
    const cv::Mat photo = cv::imread((folder / "rgb.png").string(), cv::IMREAD_COLOR);
    ASSERT_EQ(photo.size(), cv::Size(224, 224));
    const cv::Mat expected = readNpy(folder / "expected_rgb_npy_output.npy", photo.size());
    DepthNetwork network(folder / "fastdepth_224_op10.onnx", catalogued("fastdepth"));
    cv::Mat raw;
    network.infer(photo, raw);
    // Metres, 0.7..10; summation order and instruction set move the last bits of a float.
    EXPECT_TRUE(samePicture(raw, expected, 1e-4));

    cv::Mat depth;
    network.estimate(photo, depth);
    ASSERT_EQ(depth.type(), CV_32FC1);
    EXPECT_LT(rankCorrelation(depth, raw), -0.99) << "far in metres must be dark";
}
