#include "sandbox.hpp"

#include "altiro3D/depth_source.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "support/hand_slide.hpp"
#include "support/tiny_network.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

// The main() of the tools, which CMakeLists.txt renames in the object files.
extern "C" {
int altiro3DnativeMain(int argc, char** argv);
int photo2nativeMain(int argc, char** argv);
int video2nativeMain(int argc, char** argv);
int quilt2nativeMain(int argc, char** argv);
int quilt2videoMain(int argc, char** argv);
int views2nativeMain(int argc, char** argv);
int native2viewMain(int argc, char** argv);
int slide2nativeMain(int argc, char** argv);
int splat2nativeMain(int argc, char** argv);
int altiro3DtradeoffMain(int argc, char** argv);
}

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

// A short video out of a quilt.
const Arguments kSway("-q 2x3 --seconds 0.2 --turns 1 --fps 20");

constexpr unsigned kTimeLimitSeconds = 300; // also under sanitizers on a busy machine

std::vector<char*> pointers(std::vector<std::string>& strings) {
    std::vector<char*> result;
    for (std::string& text : strings)
        result.push_back(text.data());
    result.push_back(nullptr);
    return result;
}

using Main = int (*)(int, char**);

// The main() of a tool that this program holds; null: it is started as a program.
Main mainOf(const std::string& tool) {
#ifdef ALTIRO3D_SANITIZED
    (void)tool; // sanitizers are set up at a program's start
#else
    static const std::map<std::string, Main> tools{
        {"altiro3Dnative", altiro3DnativeMain}, {"photo2native", photo2nativeMain},
        {"video2native", video2nativeMain},     {"quilt2native", quilt2nativeMain},
        {"quilt2video", quilt2videoMain},       {"views2native", views2nativeMain},
        {"native2view", native2viewMain},       {"slide2native", slide2nativeMain},
        {"splat2native", splat2nativeMain},     {"altiro3Dtradeoff", altiro3DtradeoffMain}};
    if (const auto found = tools.find(tool); found != tools.end()) return found->second;
#endif
    return nullptr;
}

// A child that calls a main() needs a parent without threads of OpenCV, which it would wait for.
class SingleThread : public ::testing::Environment {
    void SetUp() override { cv::setNumThreads(1); }
};
[[maybe_unused]] const ::testing::Environment* const kSingleThread =
    ::testing::AddGlobalTestEnvironment(new SingleThread);

// In the child.
// @param called null: the program is executed, and only what is safe between fork and exec is done
[[noreturn]] void becomeTool(Main called, const std::vector<char*>& arguments,
                             char* const* environment, const char* directory, const char* input,
                             const char* out, const char* err, rlim_t largestFile) noexcept {
    const int in = open(input, O_RDONLY);
    const int outNumber = open(out, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    const int errNumber = open(err, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (in < 0 || outNumber < 0 || errNumber < 0 || chdir(directory) != 0) _exit(126);
    dup2(in, STDIN_FILENO);
    dup2(outNumber, STDOUT_FILENO);
    dup2(errNumber, STDERR_FILENO);
    alarm(kTimeLimitSeconds); // survives exec
    const rlimit limit{largestFile, largestFile};
    if (largestFile > 0) setrlimit(RLIMIT_FSIZE, &limit);
    if (called != nullptr) {
        clearenv();
        for (; *environment != nullptr; ++environment)
            putenv(*environment);
        cv::setNumThreads(-1); // as at a program's start
        std::exit(
            called(static_cast<int>(arguments.size()) - 1, const_cast<char**>(arguments.data())));
    }
    execve(arguments[0], arguments.data(), environment);
    _exit(127);
}

} // namespace

fs::path toolPath(const std::string& tool) {
    if (fs::path(tool).is_absolute()) return tool;
    return fs::path(ALTIRO3D_TOOLS) / tool;
}

Arguments::Arguments(const char* typed) {
    std::istringstream words(typed);
    for (std::string word; words >> word;)
        push_back(word);
}

Arguments operator+(Arguments first, const Arguments& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

std::vector<std::string> Outcome::errLines() const {
    std::vector<std::string> lines;
    std::istringstream stream(err);
    for (std::string line; std::getline(stream, line);)
        lines.push_back(line);
    return lines;
}

std::string Outcome::text() const {
    std::string text = call + "\nexit status " + std::to_string(status) + "\nstandard output:\n" +
                       out + "standard error:\n" + err;
    for (const std::string& file : odd)
        text += "left behind: " + file + "\n";
    return text;
}

::testing::AssertionResult isDone(const Outcome& outcome) {
    if (outcome.status == 0 && outcome.err.empty() && outcome.odd.empty()) {
        return ::testing::AssertionSuccess();
    }
    return ::testing::AssertionFailure() << outcome.text();
}

::testing::AssertionResult says(const Outcome& outcome, const std::string& part) {
    const ::testing::AssertionResult done = isDone(outcome);
    return done ? holds(outcome.out, part) : done;
}

::testing::AssertionResult warns(const Outcome& outcome, const std::string& part) {
    const std::string start = outcome.tool + ": warning: ";
    const std::vector<std::string> lines = outcome.errLines();
    if (outcome.status == 0 && lines.size() == 1 && lines[0].rfind(start, 0) == 0 &&
        lines[0].find(part) != std::string::npos && outcome.odd.empty()) {
        return ::testing::AssertionSuccess();
    }
    return ::testing::AssertionFailure() << "expected one warning with \"" << part << "\"\n"
                                         << outcome.text();
}

::testing::AssertionResult fails(const Outcome& outcome, int status, const std::string& part) {
    const std::string start = outcome.tool + ": error: ";
    const std::vector<std::string> lines = outcome.errLines();
    if (outcome.status == status && lines.size() == 1 && lines[0].rfind(start, 0) == 0 &&
        lines[0].find(part) != std::string::npos && outcome.odd.empty()) {
        return ::testing::AssertionSuccess();
    }
    return ::testing::AssertionFailure()
           << "expected exit status " << status << " and one error with \"" << part << "\"\n"
           << outcome.text();
}

Sandbox::Sandbox() : work_(root_ / "work"), home_(root_ / "home") {
    fs::create_directories(work_);
    fs::create_directories(home_);
    fs::create_directories(models());
    writeTinyNetwork(models());
    environment_ = {{"HOME", home_.string()},
                    {"LANG", "C.UTF-8"},
                    {"PATH", "/usr/bin:/bin"},
                    {"ALTIRO3D_MODELS", models().string()}};
    for (const char* name : {"ASAN_OPTIONS", "LSAN_OPTIONS", "UBSAN_OPTIONS", "TSAN_OPTIONS",
                             "LD_LIBRARY_PATH", "TMPDIR"}) {
        if (const char* value = std::getenv(name)) environment_[name] = value;
    }
}

fs::path Sandbox::operator/(const std::string& name) const {
    return work_ / name;
}

void Sandbox::set(const std::string& name, const std::optional<std::string>& value) {
    environment_.erase(name);
    if (value) environment_[name] = *value;
}

nlohmann::json Sandbox::json(const std::string& name) const {
    return nlohmann::json::parse(slurp(*this / name));
}

Outcome Sandbox::run(const std::string& tool, const Arguments& arguments, int signal,
                     const std::function<bool()>& when) const {
    Outcome outcome;
    outcome.tool = fs::path(tool).filename().string();
    outcome.call = tool;
    std::vector<std::string> words{toolPath(tool).string()};
    for (const std::string& argument : arguments) {
        words.push_back(argument);
        outcome.call += " '" + argument + "'";
    }
    std::vector<std::string> variables;
    for (const auto& [name, value] : environment_)
        variables.push_back(name + "=" + value);
    const std::vector<char*> argumentPointers = pointers(words);
    const std::vector<char*> variablePointers = pointers(variables);
    const fs::path out = outputFile_.empty() ? root_ / "out.txt" : outputFile_;
    const fs::path err = root_ / "err.txt";

    std::fflush(nullptr);                           // the child would write it again
    const bool isMainThread = gettid() == getpid(); // of the tests
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("cannot fork");
    if (child == 0) {
        // Qt wants to be called by the main thread
        becomeTool(isStarted_ || !isMainThread ? nullptr : mainOf(tool), argumentPointers,
                   variablePointers.data(), work_.c_str(), inputFile_.c_str(), out.c_str(),
                   err.c_str(), largestFile_);
    }
    int status = 0;
    bool ended = false;
    while (when && !ended && !when()) {
        usleep(2000);
        ended = waitpid(child, &status, WNOHANG) == child;
    }
    if (when && !ended) kill(child, signal);
    if (!ended && waitpid(child, &status, 0) != child) throw std::runtime_error("lost " + tool);
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (outputFile_.empty()) outcome.out = slurp(out);
    outcome.err = slurp(err);
    for (const auto& entry : fs::recursive_directory_iterator(root_.path())) {
        const std::string name = entry.path().filename().string();
        if (name.rfind(".altiro3D-", 0) == 0) outcome.odd.push_back(entry.path().string());
    }
    return outcome;
}

std::set<std::string> filesBelow(const fs::path& folder) {
    std::set<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) files.insert(fs::relative(entry.path(), folder).string());
    return files;
}

std::map<std::string, std::string> contentsBelow(const Sandbox& sandbox,
                                                 const std::vector<std::string>& folders) {
    std::map<std::string, std::string> contents;
    for (const std::string& folder : folders) {
        if (!fs::exists(sandbox / folder)) continue;
        for (const std::string& file : filesBelow(sandbox / folder))
            contents[folder + "/" + file] = slurp(sandbox / folder / file);
    }
    return contents;
}

void writeCalibration(const fs::path& file, cv::Size panel, double pitch,
                      const std::string& serial) {
    std::ostringstream text;
    text << R"({"configVersion": "1.0", "serial": ")" << serial << R"(", "pitch": {"value": )"
         << pitch << R"(}, "slope": {"value": -7.17}, "center": {"value": 0.5},)"
         << R"( "viewCone": {"value": 40}, "invView": {"value": 1}, "DPI": {"value": 324},)"
         << R"( "screenW": {"value": )" << panel.width << R"(}, "screenH": {"value": )"
         << panel.height << "}}";
    spill(file, text.str());
}

void writeLossless(const fs::path& file, const std::vector<cv::Mat>& pictures) {
    VideoWriterOptions options;
    options.size = pictures.front().size();
    options.codec = VideoCodec::Ffv1;
    options.timeBase = {1, 25};
    options.frameRate = {25, 1};
    VideoWriter writer(file, options);
    for (std::size_t i = 0; i < pictures.size(); ++i)
        writer.write({pictures[i], static_cast<std::int64_t>(i), 1});
    writer.finish();
}

cv::Mat madePhoto(int cols, int rows) {
    cv::Mat photo(rows, cols, CV_8UC3);
    cv::RNG random(7); // the same picture every time
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < cols; ++x) {
            const auto noise = static_cast<int>(random.uniform(0, 64));
            photo.at<cv::Vec3b>(y, x) = {cv::saturate_cast<uchar>(x * 191 / cols + noise),
                                         cv::saturate_cast<uchar>(y * 191 / rows + noise),
                                         cv::saturate_cast<uchar>((x + y) % 17 * 11 + noise)};
        }
    }
    return photo;
}

cv::Mat madeDepth(int cols, int rows) {
    cv::Mat depth(rows, cols, CV_16UC1);
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < cols; ++x)
            depth.at<ushort>(y, x) = cv::saturate_cast<ushort>(1000 + 20000 * y / rows);
    }
    depth(cv::Rect(cols / 4, rows / 4, cols / 3, rows / 3)) = 60000;
    return depth;
}

cv::Mat readBack(const fs::path& file) {
    return cv::imread(file.string(), cv::IMREAD_UNCHANGED);
}

SmallStudio::SmallStudio() {
    writeCalibration(*this / "small.json");
    writeImage(*this / "photo.png", madePhoto(90, 120));
    writeImage(*this / "depth.png", madeDepth(45, 60));
    const cv::Mat quilt = madePhoto(90, 80);
    writeImage(*this / "quilt.png", quilt);
    writeImage(*this / "panel.png", madePhoto(96, 128));
    fs::create_directory(*this / "views");
    for (int i = 0; i < 6; ++i) {
        const cv::Rect tile(i % 3 * 30, (1 - i / 3) * 40, 30, 40);
        writeImage(*this / ("views/view" + std::to_string(i) + ".png"), quilt(tile));
    }
}

void SmallStudio::makeMap(const std::string& name) const {
    EXPECT_TRUE(isDone(run("altiro3Dnative", goodCall("altiro3Dnative", name))));
}

void SmallStudio::makeClip() const {
    EXPECT_TRUE(isDone(run("quilt2video", goodCall("quilt2video", "clip.mp4"))));
}

void SmallStudio::makeSlide() const {
    static const std::vector<cv::Mat> pictures = [] { // once for all tests
        const Boards boards;
        std::vector<cv::Mat> all;
        for (const HandCamera& camera : handSlide(shakyHand(8, 0.4)))
            all.push_back(boards.photograph({240, 180}, camera));
        return all;
    }();
    fs::create_directory(*this / "photos");
    for (std::size_t i = 0; i < pictures.size(); ++i)
        writeImage(*this / "photos" / (std::to_string(i + 1) + ".png"), pictures[i]);
    writeLossless(*this / "slide.mkv", pictures);
}

void SmallStudio::makeScan() const {
    std::string text = "ply\nformat ascii 1.0\nelement vertex 64\n";
    for (const char* const field :
         {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
          "rot_0", "rot_1", "rot_2", "rot_3"})
        text += "property float " + std::string(field) + "\n";
    text += "end_header\n";
    for (int i = 0; i < 64; ++i) { // a cube of coloured balls
        for (const int place : {i % 4, i / 4 % 4, i / 16})
            text += std::to_string(place - 1.5) + " ";
        for (const int place : {i % 4, i / 4 % 4, i / 16})
            text += std::to_string(place - 1) + " ";
        text += "3 -1 -1 -1 1 0 0 0\n";
    }
    spill(*this / "scan.ply", text);
}

Arguments fixedWay(Arguments given) {
    const std::pair<const char*, const char*> options[] = {
        {"--fit", "cover"}, {"--focus", "0.5"}, {"--strength", "10"}};
    for (const auto& [option, value] : options) {
        const bool isThere = std::find(given.begin(), given.end(), option) != given.end() ||
                             (option == std::string("--strength") &&
                              std::find(given.begin(), given.end(), "--camera") != given.end());
        if (!isThere) given = given + Arguments{option, value};
    }
    return given;
}

Arguments SmallStudio::goodCall(const std::string& tool, const std::string& output) const {
    if (tool == "altiro3Dnative") return {"-m", output, "-q", "2x3", "-r", "40x30", "small.json"};
    if (tool == "photo2native")
        return display() + Arguments{"-d", "photo.png", "depth.png", output};
    if (tool == "quilt2native") return display() + Arguments{"quilt.png", output};
    if (tool == "native2view") return display() + Arguments{"panel.png", output};
    if (tool == "slide2native") return display() + Arguments{"slide.mkv", output};
    if (tool == "splat2native") return display() + Arguments{"scan.ply", output};
    if (tool == "quilt2video") return kSway + Arguments{"quilt.png", output};
    if (tool == "video2native") return display() + Arguments{"--codec", "ffv1", "clip.mp4", output};
    return display() + Arguments{"views", output};
}

const std::vector<std::string>& allTools() {
    static const std::vector<std::string> tools{"altiro3Dnative", "native2view",  "photo2native",
                                                "quilt2native",   "quilt2video",  "slide2native",
                                                "splat2native",   "video2native", "views2native"};
    return tools;
}

std::string outputName(const std::string& tool, const std::string& stem) {
    if (tool == "altiro3Dnative") return stem + ".map";
    if (tool == "video2native") return stem + ".mkv";
    if (tool == "quilt2video") return stem + ".mp4";
    return stem + ".png";
}

bool ToolTest::takes(const std::string& option) const {
    const std::string help = studio_.run(tool(), "--help-all").out;
    for (const char end : {' ', ','})
        if (help.find("\n  " + option + end) != std::string::npos) return true;
    return false;
}

QuiltLayout smallLayout() {
    return {3, 2, {30, 40}, 6};
}

cv::Mat libraryNative(const Calibration& calibration, const cv::Mat& photo, const cv::Mat& depth,
                      const LibraryPath& path) {
    const double aspect = static_cast<double>(calibration.screenW) / calibration.screenH;
    const cv::Size size =
        path.keep ? cv::Size(calibration.screenW, calibration.screenH) : path.layout.tileSize;
    const PhotoFit fit = withMargins(fitPhoto(photo.size(), aspect, size, path.fit, path.framing),
                                     photo.size(), path.views);
    altiro3D::Scene fitted;
    cv::Mat quilt;
    cv::Mat native;
    DepthRefineOptions refine;
    if (!path.refine) refine.flaws = DepthFlaws();
    fitScene({photo, depth, {}, {}, path.edges}, fit, path.views.focus, fitted, refine);
    if (path.quilt) {
        Depth2Quilt(path.layout, path.views).render(fitted, quilt);
        Quilt2Native(calibration, path.layout, path.sampling, path.invert).render(quilt, native);
    } else {
        NativeRenderer(calibration, path.layout.viewCount, path.views, path.positions, path.invert)
            .render(fitted, native);
    }
    return native;
}

cv::Mat libraryNative(const Sandbox& sandbox, const LibraryPath& path) {
    const cv::Mat photo = readPhoto(sandbox / "photo.png");
    cv::Mat depth;
    LibraryPath known = path;
    if (path.isEstimated) {
        const InstalledNetwork tiny = standardNetwork(false, {sandbox.models()}).value();
        altiro3D::Scene scene;
        depthFromNetworkFile(tiny.file, tiny.profile)->readScene(photo, path.views.focus, scene);
        depth = scene.depth;
        known.edges = scene.edges;
    } else {
        DepthNormalization normalization;
        normalization.kind = path.kind;
        normalization.flatDepth = path.views.focus;
        normalizeDepth(readDepthImage(sandbox / "depth.png"), depth, normalization);
    }
    return libraryNative(readCalibration(sandbox / "small.json"), photo, depth, known);
}

cv::Mat libraryNative(const Sandbox& sandbox, const cv::Mat& quilt, int columns, int rows,
                      const QuiltSampling& sampling) {
    QuiltLayout layout;
    layout.columns = columns;
    layout.rows = rows;
    layout.tileSize = {quilt.cols / columns, quilt.rows / rows};
    layout.viewCount = columns * rows;
    cv::Mat native;
    Quilt2Native(readCalibration(sandbox / "small.json"), layout, sampling)
        .render(fitQuilt(quilt, layout), native);
    return native;
}

} // namespace altiro3D::test
