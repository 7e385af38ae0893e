#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt2native.hpp"
#include "support/files.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace altiro3D::test {

/// The arguments of a call: one by one, or as they are typed, with blanks between them.
struct Arguments : std::vector<std::string> {
    using std::vector<std::string>::vector;
    Arguments(const std::vector<std::string>& words) : std::vector<std::string>(words) {}
    Arguments(const char* typed);
};

/// Several lists of arguments, one after the other.
Arguments operator+(Arguments first, const Arguments& second);

/// What a tool left behind.
struct Outcome {
    std::string call;             ///< The command line, for messages of tests.
    std::string tool;             ///< The tool's name.
    int status = -1;              ///< Exit status; 128 + signal if one ended it.
    std::string out;              ///< Standard output.
    std::string err;              ///< Standard error.
    std::vector<std::string> odd; ///< Temporary files that it left in the sandbox.

    std::vector<std::string> errLines() const;
    /// Everything, for messages of tests.
    std::string text() const;
};

/// Success without a word on standard error.
::testing::AssertionResult isDone(const Outcome& outcome);
/// Success without a word on standard error, and `part` on standard output.
::testing::AssertionResult says(const Outcome& outcome, const std::string& part);
/// Success with one warning, which holds `part`.
::testing::AssertionResult warns(const Outcome& outcome, const std::string& part);
/// This exit status, one line on standard error, `tool: error: ...`, which holds `part`, and no
/// temporary files.
::testing::AssertionResult fails(const Outcome& outcome, int status, const std::string& part);

/// An isolated place for runs of the tools, with an empty working directory and its own home. It
/// does not inherit the environment of the tests; its depth network is a tiny one.
class Sandbox {
  public:
    Sandbox();

    /// A file in the working directory.
    std::filesystem::path operator/(const std::string& name) const;
    const std::filesystem::path& work() const { return work_; }
    const std::filesystem::path& home() const { return home_; }
    std::filesystem::path models() const { return root_ / "models"; }

    /// Sets an environment variable for all following runs; nothing: removes it.
    void set(const std::string& name, const std::optional<std::string>& value);
    /// Standard output of the runs to come goes to this file and is not captured.
    void sendOutputTo(const std::filesystem::path& file) { outputFile_ = file; }

    /// Files of the runs to come can grow to this size only.
    void limitFiles(std::size_t bytes) { largestFile_ = bytes; }

    /// Standard input of the runs to come is this file; else it is empty.
    void readInputFrom(const std::filesystem::path& file) { inputFile_ = file; }

    /// A JSON file in the working directory.
    nlohmann::json json(const std::string& name) const;

    /// Starts the built program in the runs to come, which costs .08 s each.
    void startPrograms() { isStarted_ = true; }

    /// Runs a tool, one of ours by its name or a program by its path, in the working directory and
    /// without a terminal. One of ours is a child of the test that calls the tool's main(), except
    /// with startPrograms() or sanitizers.
    Outcome run(const std::string& tool, const Arguments& arguments) const {
        return run(tool, arguments, 0, {});
    }
    /// As run(), and sends a signal as soon as something is so.
    Outcome run(const std::string& tool, const Arguments& arguments, int signal,
                const std::function<bool()>& when) const;

  private:
    TemporaryDirectory root_;
    std::filesystem::path work_;
    std::filesystem::path home_;
    std::filesystem::path outputFile_;
    std::filesystem::path inputFile_ = "/dev/null";
    std::size_t largestFile_ = 0; // 0: no limit
    bool isStarted_ = false;
    std::map<std::string, std::string> environment_;
};

/// Names of all files below a folder, relative to it.
std::set<std::string> filesBelow(const std::filesystem::path& folder);
/// Contents of all files below some folders of a sandbox, by name; folders may be missing.
std::map<std::string, std::string> contentsBelow(const Sandbox& sandbox,
                                                 const std::vector<std::string>& folders);

/// Writes a calibration of a made-up panel.
void writeCalibration(const std::filesystem::path& file, cv::Size panel = {96, 128},
                      double pitch = 52.58, const std::string& serial = "TEST-1");

/// Writes pictures as a video without loss, 25 per second.
void writeLossless(const std::filesystem::path& file, const std::vector<cv::Mat>& pictures);

/// A picture of smooth colours and fine detail. [rows x cols, CV_8UC3, BGR]
cv::Mat madePhoto(int cols, int rows);
/// A near box in front of a far ramp. [rows x cols, CV_16UC1, near = white]
cv::Mat madeDepth(int cols, int rows);
/// Reads a picture unchanged from its file.
cv::Mat readBack(const std::filesystem::path& file);

/// A sandbox with small.json (a panel of 96 x 128 px), photo.png, depth.png, quilt.png (3 columns x
/// 2 rows of 30 x 40 px), the same views in views/, and panel.png of the panel's size.
class SmallStudio : public Sandbox {
  public:
    SmallStudio();
    /// -c small.json -q 2x3 -r 40x30
    Arguments display() const { return {"-c", "small.json", "-q", "2x3", "-r", "40x30"}; }
    /// Runs a tool for that display.
    Outcome convert(const std::string& tool, const Arguments& arguments) const {
        return run(tool, display() + arguments);
    }
    /// Makes a look-up table for that display.
    void makeMap(const std::string& name = "a.map") const;
    /// Makes clip.mp4, which video2native reads.
    void makeClip() const;
    void makeSlide() const; ///< slide.mkv and the same in photos/, for slide2native.
    void makeScan() const;  ///< scan.ply, for splat2native.
    /// The arguments of a run that succeeds and writes one file.
    Arguments goodCall(const std::string& tool, const std::string& output) const;
};

/// Reports have six digits; for numbers below 100.
constexpr double kReportPrecision = 1e-4;

/// A test in a studio, mostly of one tool.
class StudioTest : public ::testing::Test {
  protected:
    explicit StudioTest(std::string tool) : tool_(std::move(tool)) {}
    Outcome run(const Arguments& arguments) const { return studio_.run(tool_, arguments); }
    /// Runs it for the studio's display.
    Outcome convert(const Arguments& arguments) const { return studio_.convert(tool_, arguments); }

    std::string tool_;
    SmallStudio studio_;
};

/// Options that leave no framing, focus or strength to the photo, as LibraryPath; the given ones
/// stay.
Arguments fixedWay(Arguments given = {});

/// The path of one of our tools.
std::filesystem::path toolPath(const std::string& tool);

/// The tools that turn inputs into one output: all but altiro3Dcluster, altiro3Dtradeoff and
/// altiro3Dview.
const std::vector<std::string>& allTools();

/// A name with the extension that a tool writes.
std::string outputName(const std::string& tool, const std::string& stem);

/// A test that runs for each tool, each time in a new studio.
class ToolTest : public ::testing::TestWithParam<std::string> {
  protected:
    ToolTest() {
        if (tool() == "video2native") studio_.makeClip();
        if (tool() == "slide2native") studio_.makeSlide();
        if (tool() == "splat2native") studio_.makeScan();
    }
    const std::string& tool() const { return GetParam(); }
    /// A name for the tool's output, with the extension that it writes.
    std::string output(const std::string& stem) const { return outputName(tool(), stem); }
    bool writesPictures() const { return output("") == ".png"; }
    /// Whether it has an option, by what --help-all lists ("-m", "--serial").
    bool takes(const std::string& option) const;
    /// A run that succeeds and writes one file.
    Outcome good(const std::string& output, const Arguments& more = {}) const {
        return studio_.run(tool(), more + studio_.goodCall(tool(), output));
    }

    SmallStudio studio_;
};

/// The layout of a SmallStudio's quilt.
QuiltLayout smallLayout();

/// How the library makes a Native of a photo and its depth.
struct LibraryPath {
    ViewOptions views;
    FitMode fit = FitMode::Cover;
    Framing framing;
    bool refine = true;                                ///< The depth is refined.
    bool keep = false;                                 ///< At the panel's resolution, not a view's.
    bool quilt = true;                                 ///< Over a quilt; false: by NativeRenderer.
    ViewPositions positions = ViewPositions::Discrete; ///< Of NativeRenderer.
    QuiltSampling sampling;                            ///< Of a quilt.
    InvertViews invert = InvertViews::Auto;
    QuiltLayout layout = smallLayout();
    DepthKind kind = DepthKind::NearWhite;  ///< Of depth.png.
    bool isEstimated = false;               ///< Depth is that of Sandbox::models(), not read.
    DepthEdges edges = DepthEdges::Unknown; ///< Of the depth, if it is not read.
};

/// The Native of a photo and its depth, by calls of the library alone.
/// @param depth [any size, CV_32FC1, 0..1, 1 = nearest]
cv::Mat libraryNative(const Calibration& calibration, const cv::Mat& photo, const cv::Mat& depth,
                      const LibraryPath& path);
/// The same of small.json, photo.png and depth.png in a sandbox.
cv::Mat libraryNative(const Sandbox& sandbox, const LibraryPath& path);
/// The Native that the library makes of a quilt for a sandbox's small.json, sampled as by
/// quilt2native.
cv::Mat libraryNative(const Sandbox& sandbox, const cv::Mat& quilt, int columns, int rows,
                      const QuiltSampling& sampling = {ViewFilter::Nearest, TileSampling::Linear});

} // namespace altiro3D::test
