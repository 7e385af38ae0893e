// Speed of each stage at the real sizes of two displays: a Portrait (panel 1536 x 2048, 48 views of
// 420 x 560 px) and an 8K panel (7680 x 4320, 45 views of 819 x 455 px).
//
// BM_<stage>/<display> runs on all threads, BM_<stage>/<display>/threads:1 on one. Every output is
// checked against a plain reference before it is timed; memory is warm and reused. Quote ratios to
// the yardsticks BM_Copy..., each a memcpy on one thread. `--isa NAME` shows what processors with
// fewer instruction sets do (avx2, sse4, ...).

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt2native.hpp"
#include "media/yuv_kernels.hpp"
#include "paper_pipeline.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <hwy/highway.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <strings.h>
#include <unistd.h>
#include <vector>

namespace {

using namespace altiro3D;

void require(bool good, const char* what) {
    if (good) return;
    std::fprintf(stderr, "altiro3D_bench: wrong result: %s\n", what);
    std::exit(1);
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() &&
           cv::norm(a.reshape(1), b.reshape(1), cv::NORM_INF) == 0;
}

// A photo with detail, the same each time.
cv::Mat makePhoto(cv::Size size) {
    cv::Mat picture(size, CV_8UC3);
    cv::RNG rng(7);
    rng.fill(picture, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(picture, picture, {5, 5}, 1.5);
    return picture;
}

// A depth map with slopes and steps.
cv::Mat makeDepth(cv::Size size) {
    cv::Mat map(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y)
        map.row(y).setTo(0.6 * y / size.height);
    cv::circle(map, {size.width / 2, size.height / 2}, size.width / 4, cv::Scalar(0.9), cv::FILLED);
    return map;
}

ViewOptions methodOf(ViewMethod method) {
    ViewOptions options;
    options.method = method;
    return options;
}

// Quilt pixel of a sub-pixel, by the formula alone.
cv::Point quiltPixel(const LensGeometry& g, const QuiltLayout& layout, int x, int y, int channel) {
    const int view = LensGeometry::viewOfPhase(g.phase(x, y, channel), layout.viewCount);
    const cv::Size tile = layout.tileSize;
    const std::int64_t inX = (2 * std::int64_t{x} + 1) * tile.width / (2 * g.panelWidth);
    const std::int64_t inY = (2 * std::int64_t{y} + 1) * tile.height / (2 * g.panelHeight);
    return layout.tile(view).tl() + cv::Point(static_cast<int>(inX), static_cast<int>(inY));
}

// A display with its pictures and tables, which are made on first use.
class BenchDisplay {
  public:
    BenchDisplay(std::string displayName, Calibration displayCalibration, QuiltLayout quiltLayout)
        : name(std::move(displayName)), calibration(std::move(displayCalibration)),
          layout(quiltLayout) {}

    const std::string name;
    const Calibration calibration; // without mirrors
    const QuiltLayout layout;

    cv::Size panel() const { return {calibration.screenW, calibration.screenH}; }

    // Bytes of a Native, and of a look-up table of 4 bytes per sub-pixel.
    std::size_t nativeBytes() const { return static_cast<std::size_t>(panel().area()) * 3; }
    std::size_t lutBytes() const { return nativeBytes() * 4; }

    const cv::Mat& photo() const {
        if (photo_.empty()) photo_ = makePhoto(layout.tileSize);
        return photo_;
    }

    const cv::Mat& depth() const {
        if (depth_.empty()) depth_ = makeDepth(layout.tileSize);
        return depth_;
    }

    const cv::Mat& quilt() const {
        if (quilt_.empty()) {
            Depth2Quilt(layout, methodOf(ViewMethod::Fast)).render(photo(), depth(), quilt_);
        }
        return quilt_;
    }

    // Checked against the formula on every 61st row.
    const NativeLut& lut() const {
        if (lut_) return *lut_;
        lut_.emplace(calibration, layout);
        const LensGeometry g = lensGeometry(calibration);
        for (int y = 0; y < g.panelHeight; y += 61) {
            for (int x = 0; x < g.panelWidth; ++x) {
                for (int k = 0; k < 3; ++k) {
                    const auto at = lut_->channel(k).at<cv::Vec<std::uint16_t, 2>>(y, x);
                    require(cv::Point(at[0], at[1]) == quiltPixel(g, layout, x, y, k), "LUT");
                }
            }
        }
        return *lut_;
    }

    // Applies the table to a quilt, one sub-pixel after the other.
    cv::Mat slowNative(const cv::Mat& source) const {
        cv::Mat native(panel(), CV_8UC3);
        for (int y = 0; y < native.rows; ++y) {
            for (int x = 0; x < native.cols; ++x) {
                for (int k = 0; k < 3; ++k) {
                    const auto at = lut().channel(k).at<cv::Vec<std::uint16_t, 2>>(y, x);
                    native.at<cv::Vec3b>(y, x)[2 - k] = source.at<cv::Vec3b>(at[1], at[0])[2 - k];
                }
            }
        }
        return native;
    }

    // That of quilt().
    const cv::Mat& native() const {
        if (native_.empty()) native_ = slowNative(quilt());
        return native_;
    }

  private:
    mutable cv::Mat photo_;
    mutable cv::Mat depth_;
    mutable cv::Mat quilt_;
    mutable cv::Mat native_;
    mutable std::optional<NativeLut> lut_;
};

Calibration portraitCalibration() {
    Calibration c;
    c.serial = "LKG-PORT-BENCH";
    c.pitch = 52.58;
    c.slope = -7.17;
    c.center = 0.5;
    c.DPI = 324;
    c.screenW = 1536;
    c.screenH = 2048;
    return c;
}

Calibration largeCalibration() {
    Calibration c;
    c.serial = "LKG-8K-BENCH";
    c.pitch = 38.6;
    c.slope = -6.6;
    c.center = 0.3;
    c.DPI = 280;
    c.screenW = 7680;
    c.screenH = 4320;
    return c;
}

// Number of threads of a variant: one, or all.
class Threads {
  public:
    explicit Threads(bool one) { cv::setNumThreads(one ? 1 : -1); }
    ~Threads() { cv::setNumThreads(-1); }
    Threads(const Threads&) = delete;
    Threads& operator=(const Threads&) = delete;
};

// ---- yardsticks

void copyBytes(benchmark::State& state, std::size_t bytes) {
    const std::vector<char> source(bytes, 1);
    std::vector<char> target(bytes, 2);
    for (auto _ : state) {
        std::memcpy(target.data(), source.data(), bytes);
        auto* samples = target.data();
        benchmark::DoNotOptimize(samples);
        benchmark::ClobberMemory();
    }
    state.SetBytesProcessed(static_cast<std::int64_t>(bytes) *
                            static_cast<std::int64_t>(state.iterations()));
}

void BM_CopyNative(benchmark::State& state, const BenchDisplay& display) {
    copyBytes(state, display.nativeBytes());
}

void BM_CopyQuilt(benchmark::State& state, const BenchDisplay& display) {
    copyBytes(state, static_cast<std::size_t>(display.layout.size().area()) * 3);
}

void BM_CopyLut(benchmark::State& state, const BenchDisplay& display) {
    copyBytes(state, display.lutBytes());
}

// The least number of bytes that rendering a quilt to a Native must move. It reads the quilt's
// cache lines (64 bytes, the unit of memory access) that hold a needed sample and one byte of table
// per sub-pixel (the view), and writes the Native. A memcpy of n bytes reads n and writes n, so n
// is half of the sum.
void BM_CopyQuiltToNative(benchmark::State& state, const BenchDisplay& display) {
    const cv::Size quilt = display.layout.size();
    const std::size_t rowBytes = 3 * static_cast<std::size_t>(quilt.width);
    std::vector<char> lines(rowBytes * static_cast<std::size_t>(quilt.height) / 64 + 1);
    for (int k = 0; k < 3; ++k) {
        const cv::Mat& table = display.lut().channel(k);
        for (int y = 0; y < table.rows; ++y) {
            const auto* row = table.ptr<std::uint16_t>(y);
            for (int x = 0; x < table.cols; ++x)
                lines[(row[2 * x + 1] * rowBytes + 3U * row[2 * x]) / 64] = 1;
        }
    }
    std::size_t needed = 0;
    for (char line : lines)
        needed += line != 0 ? 64U : 0U;
    state.counters["quilt_bytes"] = static_cast<double>(needed);
    copyBytes(state, (needed + 2 * display.nativeBytes()) / 2);
}

// ---- the look-up table

void BM_LutBuild(benchmark::State& state, const BenchDisplay& display) {
    for (int i = 0; i < 2; ++i) { // the second time in memory that is already mapped
        const NativeLut built(display.calibration, display.layout);
        for (int k = 0; k < 3; ++k)
            require(equal(built.channel(k), display.lut().channel(k)), "LutBuild");
    }
    for (auto _ : state) {
        const NativeLut table(display.calibration, display.layout);
        auto* samples = table.channel(0).data;
        benchmark::DoNotOptimize(samples);
    }
}

void BM_LutLoad(benchmark::State& state, const BenchDisplay& display) {
    const auto file = std::filesystem::temp_directory_path() /
                      ("altiro3D-bench-" + std::to_string(getpid()) + ".map");
    display.lut().save(file);
    for (int i = 0; i < 2; ++i) {
        const NativeLut loaded = NativeLut::load(file);
        for (int k = 0; k < 3; ++k)
            require(equal(loaded.channel(k), display.lut().channel(k)), "LutLoad");
    }
    for (auto _ : state) {
        const NativeLut table = NativeLut::load(file);
        auto* samples = table.channel(0).data;
        benchmark::DoNotOptimize(samples);
    }
    std::filesystem::remove(file);
}

// ---- depth to the size of the photo

// Bytes of what a network gives and what it becomes; a memcpy of n bytes reads n and writes n.
constexpr int kNetworkSide = 256;

void BM_CopyFitDepth(benchmark::State& state, const BenchDisplay& display) {
    const auto pixels = static_cast<std::size_t>(display.photo().total());
    // reads depth and photo, writes depth
    copyBytes(state, (sizeof(float) * kNetworkSide * kNetworkSide + 7 * pixels) / 2);
}

void BM_FitDepth(benchmark::State& state, const BenchDisplay& display) {
    cv::Mat small;
    cv::resize(display.depth(), small, {kNetworkSide, kNetworkSide}, 0, 0, cv::INTER_AREA);
    const cv::Rect2d whole(0, 0, small.cols, small.rows);
    cv::Mat fitted;
    fitDepth(small, whole, display.photo(), fitted);
    const cv::Mat expected = test::referenceFit(small, whole, display.photo());
    require(cv::norm(fitted, expected, cv::NORM_INF) <= 2e-6, "FitDepth"); // float against double
    for (auto _ : state) {
        fitDepth(small, whole, display.photo(), fitted);
        benchmark::DoNotOptimize(fitted.data);
    }
}

// A file of docs/examples.
cv::Mat sample(const char* file, int flags) {
    cv::Mat picture = cv::imread(std::string(ALTIRO3D_BENCH_SAMPLES) + "/" + file, flags);
    require(!picture.empty(), "docs/examples cannot be read");
    return picture;
}

// The sample photo and its depth, of a view's size: many things one before the other.
void busyScene(const BenchDisplay& display, cv::Mat& photo, cv::Mat& depth) {
    const cv::Size tile = display.layout.tileSize;
    cv::Mat wholeDepth = sample("sample-depth.png", cv::IMREAD_UNCHANGED); // 16 bits
    cv::resize(sample("sample.jpg", cv::IMREAD_COLOR), photo, tile, 0, 0, cv::INTER_AREA);
    cv::resize(wholeDepth, wholeDepth, tile, 0, 0, cv::INTER_NEAREST);
    wholeDepth.convertTo(depth, CV_32F, 1 / 65535.0);
}

// Depth as it comes: exact, soft (both measured), soft with known flaws as in a video, and noisy.
void refine(benchmark::State& state, const cv::Mat& photo, const cv::Mat& depth, bool isKnown) {
    DepthRefineOptions options;
    if (isKnown) options.flaws = measureDepthFlaws(photo, depth);
    cv::Mat refined;
    for (auto _ : state) {
        refineDepth(photo, depth, refined, options);
        benchmark::DoNotOptimize(refined.data);
    }
}

cv::Mat softDepth(const BenchDisplay& display) {
    cv::Mat soft;
    cv::GaussianBlur(display.depth(), soft, {}, 2);
    return soft;
}

void BM_RefineDepthExact(benchmark::State& state, const BenchDisplay& display) {
    refine(state, display.photo(), display.depth(), false);
}
void BM_RefineDepth(benchmark::State& state, const BenchDisplay& display) {
    refine(state, display.photo(), softDepth(display), false);
}
void BM_RefineDepthKnown(benchmark::State& state, const BenchDisplay& display) {
    refine(state, display.photo(), softDepth(display), true);
}
// Soft depth as a network gives it: most px are in a step.
void BM_RefineDepthBusy(benchmark::State& state, const BenchDisplay& display) {
    cv::Mat photo;
    cv::Mat depth;
    busyScene(display, photo, depth);
    cv::Mat small;
    cv::resize(depth, small, {128, 128}, 0, 0, cv::INTER_AREA);
    cv::resize(small, depth, depth.size(), 0, 0, cv::INTER_CUBIC);
    refine(state, photo, depth, true);
}
// Steps of differing softness, as a network gives them; known flaws.
void BM_RefineDepthUneven(benchmark::State& state, const BenchDisplay& display) {
    cv::Mat depth = softDepth(display);
    const cv::Range part(0, depth.cols * 3 / 4);
    cv::Mat softer;
    cv::GaussianBlur(display.depth(), softer, {}, 6);
    softer.colRange(part).copyTo(depth.colRange(part));
    DepthRefineOptions options;
    options.flaws.emplace();
    options.flaws->softnessPixels = 12;
    options.flaws->isUneven = true;
    cv::Mat refined;
    for (auto _ : state) {
        refineDepth(display.photo(), depth, refined, options);
        benchmark::DoNotOptimize(refined.data);
    }
}
void refineNoisy(benchmark::State& state, const BenchDisplay& display, double deviation) {
    cv::Mat noise(display.depth().size(), CV_32FC1);
    cv::RNG(1).fill(noise, cv::RNG::NORMAL, 0, 10 * deviation); // a tenth after the blur
    cv::GaussianBlur(noise, noise, {}, 3);
    refine(state, display.photo(), display.depth() + noise, false);
}
void BM_RefineDepthNoisy(benchmark::State& state, const BenchDisplay& display) {
    refineNoisy(state, display, 0.02);
}
void BM_RefineDepthWeakNoise(benchmark::State& state, const BenchDisplay& display) {
    refineNoisy(state, display, 0.005);
}

// ---- photo to depth; BM_NetworkRun, one run of the network at its own size, is the yardstick

InstalledNetwork ownNetwork() {
    return standardNetwork(false, {ALTIRO3D_BENCH_SAMPLES "/../../models"}).value();
}

void BM_NetworkRun(benchmark::State& state, const BenchDisplay& display) {
    const InstalledNetwork own = ownNetwork();
    DepthNetwork network(own.file, own.profile);
    cv::Mat depth;
    for (auto _ : state) {
        network.estimate(display.photo(), depth);
        benchmark::DoNotOptimize(depth.data);
    }
}
void estimate(benchmark::State& state, const BenchDisplay& display, bool isFrame) {
    const InstalledNetwork own = ownNetwork();
    const auto source = depthFromNetworkFile(own.file, own.profile);
    cv::Mat photo;
    cv::Mat raw;
    for (auto _ : state) {
        if (isFrame) {
            source->readFrame(display.photo(), photo, raw);
        } else {
            source->read(display.photo(), photo, raw);
        }
        benchmark::DoNotOptimize(raw.data);
    }
}
void BM_DepthOfPhoto(benchmark::State& state, const BenchDisplay& display) {
    estimate(state, display, false);
}
void BM_DepthOfFrame(benchmark::State& state, const BenchDisplay& display) {
    estimate(state, display, true);
}

// ---- photo and depth to quilt

void renderQuilts(benchmark::State& state, const BenchDisplay& display, ViewMethod method) {
    const Depth2Quilt maker(display.layout, methodOf(method));
    cv::Mat result;
    maker.render(display.photo(), display.depth(), result);
    cv::Mat view; // the first tile is the leftmost view
    maker.renderView(display.photo(), display.depth(), -1, view);
    require(equal(result(display.layout.tile(0)), view), "quilt");
    for (auto _ : state) {
        maker.render(display.photo(), display.depth(), result);
        benchmark::DoNotOptimize(result.data);
    }
}

void BM_QuiltFast(benchmark::State& state, const BenchDisplay& display) {
    renderQuilts(state, display, ViewMethod::Fast);
}
void BM_QuiltReal(benchmark::State& state, const BenchDisplay& display) {
    renderQuilts(state, display, ViewMethod::Real);
}
void BM_QuiltLayered(benchmark::State& state, const BenchDisplay& display) {
    renderQuilts(state, display, ViewMethod::Layered);
}

// ---- quilt to Native

void BM_QuiltToNative(benchmark::State& state, const BenchDisplay& display) {
    const Quilt2Native renderer(display.lut());
    cv::Mat native;
    renderer.render(display.quilt(), native);
    require(equal(native, display.native()), "QuiltToNative");
    for (auto _ : state) {
        renderer.render(display.quilt(), native);
        benchmark::DoNotOptimize(native.data);
    }
}

// The same table by OpenCV: the quilt's colours apart, each one through its map, and together.
void BM_CvRemapNearest(benchmark::State& state, const BenchDisplay& display) {
    std::vector<cv::Mat> maps; // blue, green, red; a map of whole px is one of CV_16SC2
    for (int k = 2; k >= 0; --k) {
        const cv::Mat& table = display.lut().channel(k);
        maps.emplace_back(table.size(), CV_16SC2, table.data, table.step);
    }
    std::vector<cv::Mat> planes;
    std::vector<cv::Mat> mapped(3);
    cv::Mat native;
    const auto render = [&] {
        cv::split(display.quilt(), planes);
        for (std::size_t k = 0; k < 3; ++k)
            cv::remap(planes[k], mapped[k], maps[k], cv::Mat(), cv::INTER_NEAREST);
        cv::merge(mapped, native);
    };
    render();
    require(equal(native, display.native()), "CvRemapNearest");
    for (auto _ : state) {
        render();
        benchmark::DoNotOptimize(native.data);
    }
}

// Without a table: the phase of every sub-pixel in double, when it is needed.
void BM_NativeDirectNoLut(benchmark::State& state, const BenchDisplay& display) {
    const LensGeometry g = lensGeometry(display.calibration);
    const QuiltLayout& layout = display.layout;
    const cv::Mat& quilt = display.quilt();
    cv::Mat native(display.panel(), CV_8UC3);
    std::vector<cv::Point> origins;
    for (int view = 0; view < layout.viewCount; ++view)
        origins.push_back(layout.tile(view).tl());
    const auto render = [&] {
        cv::parallel_for_(cv::Range(0, native.rows), [&](const cv::Range& rows) {
            for (int y = rows.start; y < rows.end; ++y) {
                const int inY = (2 * y + 1) * layout.tileSize.height / (2 * g.panelHeight);
                std::uint8_t* out = native.ptr(y);
                for (int x = 0; x < g.panelWidth; ++x, out += 3) {
                    const int inX = (2 * x + 1) * layout.tileSize.width / (2 * g.panelWidth);
                    for (int k = 0; k < 3; ++k) {
                        const cv::Point origin = origins[static_cast<std::size_t>(
                            LensGeometry::viewOfPhase(g.phase(x, y, k), layout.viewCount))];
                        out[2 - k] = quilt.ptr(origin.y + inY)[3 * (origin.x + inX) + 2 - k];
                    }
                }
            }
        });
    };
    render();
    require(equal(native, display.native()), "NativeDirectNoLut");
    for (auto _ : state) {
        render();
        benchmark::DoNotOptimize(native.data);
    }
}

// ---- photo and depth to Native

// Some rows of some views by the formula in double. cv::remap places samples in steps of 1/32 px
// and rounds, which moves a value by at most 1/64 of the step between two px, and 1.
void checkViews(const BenchDisplay& display, const cv::Mat& quilt) {
    const double focus = ViewOptions().focus;
    const cv::Mat& photo = display.photo();
    for (int view : {0, display.layout.viewCount / 3, display.layout.viewCount - 1}) {
        const cv::Mat tile = quilt(display.layout.tile(view));
        const double shift = PaperPipeline::shiftPixels(display.layout, view);
        for (int y = 0; y < photo.rows; y += 41) {
            for (int x = 0; x < photo.cols; ++x) {
                const double place = x + shift * (display.depth().at<float>(y, x) - focus);
                const double inside = std::min(std::max(place, 0.0), photo.cols - 1.0);
                const int left = static_cast<int>(inside);
                const int right = std::min(left + 1, photo.cols - 1);
                for (int k = 0; k < 3; ++k) {
                    const double a = photo.at<cv::Vec3b>(y, left)[k];
                    const double b = photo.at<cv::Vec3b>(y, right)[k];
                    const double off =
                        tile.at<cv::Vec3b>(y, x)[k] - (a + (inside - left) * (b - a));
                    require(std::abs(off) <= 1 + 255.0 / 64, "PaperPipeline's views");
                }
            }
        }
    }
}

void BM_PaperPipeline(benchmark::State& state, const BenchDisplay& display) {
    PaperPipeline pipeline(display.layout, display.lut());
    pipeline.run(display.photo(), display.depth());
    checkViews(display, pipeline.quilt());
    require(equal(pipeline.native(), display.slowNative(pipeline.quilt())), "PaperPipeline");
    for (auto _ : state) {
        pipeline.run(display.photo(), display.depth());
        auto* samples = pipeline.native().data;
        benchmark::DoNotOptimize(samples);
    }
}

// ---- photo and depth to Native without a quilt

// How a Native is rendered straight from photo and depth.
struct DirectPath {
    ViewOptions options;
    ViewPositions positions = ViewPositions::Discrete;
    bool busy = false;        // the sample photo: many things one before the other
    bool panelPixels = false; // photo and depth of the panel's size
};

void renderNatives(benchmark::State& state, const BenchDisplay& display, const DirectPath& path) {
    cv::Mat photo = display.photo();
    cv::Mat depth = display.depth();
    if (path.busy) {
        photo.release(); // these are the display's
        depth.release();
        busyScene(display, photo, depth);
    }
    if (path.panelPixels) {
        cv::Mat large;
        cv::resize(photo, large, display.panel(), 0, 0, cv::INTER_CUBIC);
        photo = large;
        cv::Mat largeDepth;
        cv::resize(depth, largeDepth, display.panel(), 0, 0, cv::INTER_NEAREST);
        depth = largeDepth;
    }
    const NativeRenderer renderer(display.calibration, display.layout.viewCount, path.options,
                                  path.positions);
    cv::Mat native;
    renderer.render(photo, depth, native);
    if (path.positions == ViewPositions::Discrete && !path.panelPixels) {
        cv::Mat quilt;
        cv::Mat expected;
        Depth2Quilt(display.layout, path.options).render(photo, depth, quilt);
        Quilt2Native(display.lut()).render(quilt, expected);
        require(equal(native, expected), "the Native of the quilt");
    }
    for (auto _ : state) {
        renderer.render(photo, depth, native);
        benchmark::DoNotOptimize(native.data);
    }
}

void BM_NativeFast(benchmark::State& state, const BenchDisplay& display) {
    renderNatives(state, display, {methodOf(ViewMethod::Fast)});
}
void BM_NativeFastRefined(benchmark::State& state, const BenchDisplay& display) {
    DirectPath path{methodOf(ViewMethod::Fast)};
    path.options.refinement = 2;
    renderNatives(state, display, path);
}
void BM_NativeFastContinuous(benchmark::State& state, const BenchDisplay& display) {
    renderNatives(state, display, {methodOf(ViewMethod::Fast), ViewPositions::Continuous});
}
void BM_NativeLayered(benchmark::State& state, const BenchDisplay& display) {
    renderNatives(state, display, {methodOf(ViewMethod::Layered)});
}
void BM_NativeLayeredBusy(benchmark::State& state, const BenchDisplay& display) {
    renderNatives(state, display, {methodOf(ViewMethod::Layered), ViewPositions::Discrete, true});
}
void BM_NativeLayeredContinuous(benchmark::State& state, const BenchDisplay& display) {
    renderNatives(state, display, {methodOf(ViewMethod::Layered), ViewPositions::Continuous});
}
void BM_NativeLayeredPanelPixels(benchmark::State& state, const BenchDisplay& display) {
    renderNatives(state, display,
                  {methodOf(ViewMethod::Layered), ViewPositions::Continuous, false, true});
}

// A Native of the sample photo and its depth, from the fit on.
void makeNatives(benchmark::State& state, const BenchDisplay& display,
                 const NativeOptions& options) {
    Scene scene;
    busyScene(display, scene.photo, scene.depth);
    const NativeMaker maker(displayOf(display.calibration), display.layout, options);
    cv::Mat native;
    for (auto _ : state) {
        maker.makeNative(scene, native);
        benchmark::DoNotOptimize(native.data);
    }
}
void BM_NativeOfPhotoQuick(benchmark::State& state, const BenchDisplay& display) {
    makeNatives(state, display, {});
}
void BM_NativeOfPhoto(benchmark::State& state, const BenchDisplay& display) {
    NativeOptions options;
    options.showAs(Detail::Lens);
    makeNatives(state, display, options);
}
void BM_NativeOfPhotoBest(benchmark::State& state, const BenchDisplay& display) {
    NativeOptions options;
    options.showAs(Detail::Panel);
    makeNatives(state, display, options);
}

// ---- colours of videos

// The planes of a Native as an encoder takes them (4:4:4).
struct Planes {
    cv::Mat plane[3];

    explicit Planes(cv::Size size) {
        for (cv::Mat& one : plane)
            one.create(size, CV_8UC1);
    }
    void fill(const cv::Mat& picture, const YuvWeights& weights) {
        cv::parallel_for_(cv::Range(0, picture.rows), [&](const cv::Range& rows) {
            for (int y = rows.start; y < rows.end; ++y) {
                bgrToYuv(picture.ptr(y), static_cast<std::size_t>(picture.cols), weights,
                         plane[0].ptr(y), plane[1].ptr(y), plane[2].ptr(y));
            }
        });
    }
    void toPicture(const BgrWeights& weights, cv::Mat& picture) const {
        cv::parallel_for_(cv::Range(0, picture.rows), [&](const cv::Range& rows) {
            for (int y = rows.start; y < rows.end; ++y) {
                yuvToBgr(plane[0].ptr(y), plane[1].ptr(y), plane[2].ptr(y),
                         static_cast<std::size_t>(picture.cols), weights, picture.ptr(y));
            }
        });
    }
};

constexpr ColourMatrix kMatrix = ColourMatrix::Bt709;
constexpr ColourRange kRange = ColourRange::Limited;

void BM_NativeToYuv(benchmark::State& state, const BenchDisplay& display) {
    const cv::Mat native = makePhoto(display.panel());
    const YuvWeights weights = yuvWeights(kMatrix, kRange, 8);
    Planes planes(native.size());
    planes.fill(native, weights);
    for (int y = 0; y < native.rows; y += 61) {
        for (int x = 0; x < native.cols; ++x) {
            const auto& p = native.at<cv::Vec3b>(y, x);
            const double luma = 16 + (0.0722 * p[0] + 0.7152 * p[1] + 0.2126 * p[2]) * 219.0 / 255;
            require(std::abs(planes.plane[0].at<uchar>(y, x) - luma) < 0.55, "NativeToYuv");
        }
    }
    for (auto _ : state) {
        planes.fill(native, weights);
        benchmark::ClobberMemory();
    }
}

void BM_YuvToPicture(benchmark::State& state, const BenchDisplay& display) {
    const cv::Mat native = makePhoto(display.panel());
    Planes planes(native.size());
    planes.fill(native, yuvWeights(kMatrix, kRange, 8));
    cv::Mat picture(native.size(), CV_8UC3);
    const BgrWeights weights = bgrWeights(kMatrix, kRange);
    planes.toPicture(weights, picture);
    require(cv::norm(picture, native, cv::NORM_INF) <= 2, "YuvToPicture");
    for (auto _ : state) {
        planes.toPicture(weights, picture);
        benchmark::ClobberMemory();
    }
}

using Stage = void (*)(benchmark::State&, const BenchDisplay&);

// The time shown is real time; UseRealTime() would add to the names.
template <class F>
void registerAs([[maybe_unused]] const std::string& name, [[maybe_unused]] const F& run) {
#ifndef __clang_analyzer__ // it reports objects owned by the registry as leaks
    benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond);
#endif
}

void registerYardstick(const std::string& name, Stage stage, const BenchDisplay& display) {
    registerAs(name + "/" + display.name,
               [stage, &display](benchmark::State& state) { stage(state, display); });
}

// All threads, and one.
void registerStage(const std::string& name, Stage stage, const BenchDisplay& display) {
    for (bool one : {false, true}) {
        registerAs(name + "/" + display.name + (one ? "/threads:1" : ""),
                   [stage, &display, one](benchmark::State& state) {
                       const Threads threads(one);
                       stage(state, display);
                   });
    }
}

void registerAll(const BenchDisplay& display) {
    registerYardstick("BM_CopyNative", BM_CopyNative, display);
    registerYardstick("BM_CopyQuilt", BM_CopyQuilt, display);
    registerYardstick("BM_CopyLut", BM_CopyLut, display);
    registerYardstick("BM_CopyQuiltToNative", BM_CopyQuiltToNative, display);
    registerStage("BM_LutBuild", BM_LutBuild, display);
    registerStage("BM_LutLoad", BM_LutLoad, display);
    registerYardstick("BM_CopyFitDepth", BM_CopyFitDepth, display);
    registerStage("BM_FitDepth", BM_FitDepth, display);
    registerStage("BM_RefineDepthExact", BM_RefineDepthExact, display);
    registerStage("BM_RefineDepth", BM_RefineDepth, display);
    registerStage("BM_RefineDepthKnown", BM_RefineDepthKnown, display);
    registerStage("BM_RefineDepthBusy", BM_RefineDepthBusy, display);
    registerStage("BM_RefineDepthUneven", BM_RefineDepthUneven, display);
    registerStage("BM_RefineDepthNoisy", BM_RefineDepthNoisy, display);
    registerStage("BM_RefineDepthWeakNoise", BM_RefineDepthWeakNoise, display);
    registerStage("BM_NetworkRun", BM_NetworkRun, display);
    registerStage("BM_DepthOfPhoto", BM_DepthOfPhoto, display);
    registerStage("BM_DepthOfFrame", BM_DepthOfFrame, display);
    registerStage("BM_QuiltFast", BM_QuiltFast, display);
    registerStage("BM_QuiltLayered", BM_QuiltLayered, display);
    registerStage("BM_QuiltReal", BM_QuiltReal, display);
    registerStage("BM_QuiltToNative", BM_QuiltToNative, display);
    registerStage("BM_CvRemapNearest", BM_CvRemapNearest, display);
    registerStage("BM_NativeDirectNoLut", BM_NativeDirectNoLut, display);
    registerStage("BM_PaperPipeline", BM_PaperPipeline, display);
    registerStage("BM_NativeFast", BM_NativeFast, display);
    registerStage("BM_NativeFastRefined", BM_NativeFastRefined, display);
    registerStage("BM_NativeFastContinuous", BM_NativeFastContinuous, display);
    registerStage("BM_NativeLayered", BM_NativeLayered, display);
    registerStage("BM_NativeLayeredBusy", BM_NativeLayeredBusy, display);
    registerStage("BM_NativeLayeredContinuous", BM_NativeLayeredContinuous, display);
    registerStage("BM_NativeLayeredPanelPixels", BM_NativeLayeredPanelPixels, display);
    registerStage("BM_NativeOfPhotoQuick", BM_NativeOfPhotoQuick, display);
    registerStage("BM_NativeOfPhoto", BM_NativeOfPhoto, display);
    registerStage("BM_NativeOfPhotoBest", BM_NativeOfPhotoBest, display);
    registerStage("BM_NativeToYuv", BM_NativeToYuv, display);
    registerStage("BM_YuvToPicture", BM_YuvToPicture, display);
}

// What grows with the number of views, and what does not.
void registerViewCount(const BenchDisplay& display) {
    registerStage("BM_NativeFast", BM_NativeFast, display);
    registerStage("BM_NativeLayered", BM_NativeLayered, display);
    registerStage("BM_PaperPipeline", BM_PaperPipeline, display);
}

// Names of instruction sets in Highway, from the best one of this machine, with what OpenCV calls
// those of them that its own code may choose.
struct InstructionSet {
    std::int64_t target;
    const char* inOpenCv;
};
constexpr InstructionSet kInstructionSets[] = {
    {HWY_AVX3_DL, ""},
    {HWY_AVX3, "AVX512-SKX,AVX512-ICL,"},
    {HWY_AVX2, "AVX2,FMA3,FP16,AVX,"},
    {HWY_SSE4, "SSE4.2,SSE4.1,"},
    {HWY_SSSE3, "SSSE3,"},
};

// Removes `--isa NAME` from the arguments and lets only the instruction set NAME and lesser ones be
// chosen, by our kernels and by OpenCV's. OpenCV asks for them when it is loaded, hence the program
// starts again.
bool limitInstructionSet(int& argc, char** argv) {
    const auto* const last = argv + argc;
    auto* const option = std::find(argv, argv + argc, std::string("--isa"));
    if (option == last) return true;
    const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
    const std::string name = option + 1 == last ? "" : option[1];
    std::string names;
    std::string tooGood;
    for (const InstructionSet& set : kInstructionSets) {
        if ((set.target & supported) == 0) continue;
        if (strcasecmp(hwy::TargetName(set.target), name.c_str()) == 0) {
            if (std::getenv("OPENCV_CPU_DISABLE") == nullptr && !tooGood.empty()) {
                setenv("OPENCV_CPU_DISABLE", tooGood.c_str(), 1);
                execv("/proc/self/exe", argv);
            }
            hwy::DisableTargets(supported & (set.target - 1)); // lower bits are better sets
            std::copy(option + 2, argv + argc + 1, option);
            argc -= 2;
            return true;
        }
        names += (names.empty() ? "" : ", ") + std::string(hwy::TargetName(set.target));
        tooGood += set.inOpenCv;
    }
    std::fprintf(stderr, "--isa: is \"%s\", expected one of %s\n", name.c_str(), names.c_str());
    return false;
}

} // namespace

int main(int argc, char** argv) {
    if (!limitInstructionSet(argc, argv)) return 2;
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    const BenchDisplay portrait("portrait", portraitCalibration(), {8, 6, {420, 560}, 48});
    const BenchDisplay large("8k", largeCalibration(), {5, 9, {819, 455}, 45});
    const BenchDisplay fewViews("portrait-12-views", portraitCalibration(), {4, 3, {420, 560}, 12});
    const BenchDisplay manyViews("portrait-192-views", portraitCalibration(),
                                 {16, 12, {420, 560}, 192});
    registerAll(portrait);
    registerAll(large);
    registerViewCount(fewViews);
    registerViewCount(manyViews);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
