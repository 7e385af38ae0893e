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
#include "altiro3D/splats.hpp"
#include "altiro3D/stereo_views.hpp"
#include "altiro3D/sway.hpp"
#include "paper_pipeline.hpp"
#include "support/reference.hpp"
#include "support/splat_reference.hpp"

#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <hwy/highway.h>
#include <map>
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
            Depth2Quilt(layout, methodOf(ViewMethod::Fast)).render({photo(), depth()}, quilt_);
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

Calibration calibrationOf(const char* serial, double pitch, double slope, double center, double dpi,
                          cv::Size panel) {
    Calibration c;
    c.serial = serial;
    c.pitch = pitch;
    c.slope = slope;
    c.center = center;
    c.DPI = dpi;
    c.screenW = panel.width;
    c.screenH = panel.height;
    return c;
}

using Stage = std::function<void(benchmark::State&, const BenchDisplay&)>;

// Times work whose result is kept in a picture.
template <class Work>
void measure(benchmark::State& state, const cv::Mat& result, const Work& work) {
    for (auto _ : state) {
        work();
        auto* samples = result.data;
        benchmark::DoNotOptimize(samples);
        benchmark::ClobberMemory();
    }
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
    measure(state, fitted, [&] { fitDepth(small, whole, display.photo(), fitted); });
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

Stage refinement(bool isSoft) {
    return [isSoft](benchmark::State& state, const BenchDisplay& display) {
        cv::Mat depth = display.depth();
        if (isSoft) cv::GaussianBlur(display.depth(), depth = cv::Mat(), {}, 2);
        cv::Mat refined;
        measure(state, refined, [&] { refineDepth(display.photo(), depth, refined); });
    };
}

// ---- photo to depth; BM_NetworkRun, one run of the network at its own size, is the yardstick

InstalledNetwork ownNetwork() {
    return standardNetwork(false, {ALTIRO3D_BENCH_SAMPLES "/../../models"}).value();
}

void BM_NetworkRun(benchmark::State& state, const BenchDisplay& display) {
    const InstalledNetwork own = ownNetwork();
    DepthNetwork network(own.file, own.profile);
    cv::Mat depth;
    measure(state, depth, [&] { network.estimate(display.photo(), depth); });
}
Stage estimation(bool isFrame) {
    return [isFrame](benchmark::State& state, const BenchDisplay& display) {
        const InstalledNetwork own = ownNetwork();
        const auto source = depthFromNetworkFile(own.file, own.profile);
        cv::Mat photo;
        cv::Mat raw;
        measure(state, raw, [&] {
            isFrame ? source->readFrame(display.photo(), photo, raw)
                    : source->read(display.photo(), photo, raw);
        });
    };
}

// ---- photo and depth to quilt

Stage quilts(ViewMethod method) {
    return [method](benchmark::State& state, const BenchDisplay& display) {
        const Depth2Quilt maker(display.layout, methodOf(method));
        cv::Mat result;
        maker.render({display.photo(), display.depth()}, result);
        cv::Mat view; // the first tile is the leftmost view
        maker.renderView({display.photo(), display.depth()}, -1, view);
        require(equal(result(display.layout.tile(0)), view), "quilt");
        measure(state, result, [&] { maker.render({display.photo(), display.depth()}, result); });
    };
}

// ---- quilt to Native

void BM_QuiltToNative(benchmark::State& state, const BenchDisplay& display) {
    const Quilt2Native renderer(display.lut());
    cv::Mat native;
    renderer.render(display.quilt(), native);
    require(equal(native, display.native()), "QuiltToNative");
    measure(state, native, [&] { renderer.render(display.quilt(), native); });
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
    measure(state, native, render);
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
    measure(state, native, render);
}

// ---- photo and depth to Native

// Some views by the formula in double. cv::remap places samples in steps of 1/32 px and rounds,
// which moves a value by at most 1/64 of the step between two px, and 1.
void checkViews(const BenchDisplay& display, const cv::Mat& quilt) {
    for (int view : {0, display.layout.viewCount / 3, display.layout.viewCount - 1}) {
        const cv::Mat expected = test::referenceFast(
            display.photo(), display.depth(), PaperPipeline::shiftPixels(display.layout, view),
            ViewOptions().focus);
        cv::Mat tile;
        quilt(display.layout.tile(view)).convertTo(tile, CV_64F);
        require(cv::norm(tile, expected, cv::NORM_INF) <= 1 + 255.0 / 64, "PaperPipeline's views");
    }
}

void BM_PaperPipeline(benchmark::State& state, const BenchDisplay& display) {
    PaperPipeline pipeline(display.layout, display.lut());
    pipeline.run(display.photo(), display.depth());
    checkViews(display, pipeline.quilt());
    require(equal(pipeline.native(), display.slowNative(pipeline.quilt())), "PaperPipeline");
    measure(state, pipeline.native(), [&] { pipeline.run(display.photo(), display.depth()); });
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
    renderer.render({photo, depth}, native);
    if (path.positions == ViewPositions::Discrete && !path.panelPixels) {
        cv::Mat quilt;
        cv::Mat expected;
        Depth2Quilt(display.layout, path.options).render({photo, depth}, quilt);
        Quilt2Native(display.lut()).render(quilt, expected);
        require(equal(native, expected), "the Native of the quilt");
    }
    measure(state, native, [&] { renderer.render({photo, depth}, native); });
}

Stage natives(const DirectPath& path) {
    return [path](benchmark::State& state, const BenchDisplay& display) {
        renderNatives(state, display, path);
    };
}

DirectPath refinedFast() {
    DirectPath path{methodOf(ViewMethod::Fast)};
    path.options.refinement = 2;
    return path;
}

// A Native of the sample photo and its depth, from the fit on.
Stage nativesOfPhoto(std::optional<Detail> detail) {
    return [detail](benchmark::State& state, const BenchDisplay& display) {
        Scene scene;
        busyScene(display, scene.photo, scene.depth);
        NativeOptions options;
        if (detail) options.showAs(*detail);
        const NativeMaker maker(displayOf(display.calibration), display.layout, options);
        cv::Mat native;
        measure(state, native, [&] { maker.makeNative(scene, native); });
    };
}

// A scene of splats as a network makes it of a photo: two layers of a grid, soft and of all shapes.
const SplatScene& madeSplats(int count) {
    static std::map<int, SplatScene> scenes;
    SplatScene& scene = scenes[count];
    if (!scene.splats.empty()) return scene;
    const int side = static_cast<int>(std::sqrt(count / 2.0));
    cv::RNG random(5);
    const auto about = [&](double middle, double spread) {
        return static_cast<float>(middle + random.gaussian(spread));
    };
    for (int i = 0; i < 2 * side * side; ++i) {
        const int x = i % side;
        const int y = i / side % side;
        const int layer = i / (side * side);
        const float z =
            about(3 + 2 * std::sin(x * 8.0 / side) * std::cos(y * 11.0 / side) + layer, 0.01);
        const auto scale = z * 0.9F / static_cast<float>(side);
        Splat splat{{(static_cast<float>(x) - static_cast<float>(side) / 2) * scale,
                     (static_cast<float>(y) - static_cast<float>(side) / 2) * scale, z},
                    {scale * std::exp(about(-0.2, 0.4)), scale * std::exp(about(-0.2, 0.4)),
                     scale * std::exp(about(-0.2, 0.4))},
                    {about(0, 1), about(0, 1), about(0, 1), about(0, 1)},
                    {about(0.5, 0.2), about(0.5, 0.2), about(0.5, 0.2)},
                    1 / (1 + std::exp(about(-2.5, 2)))};
        splat.rotation /= cv::norm(splat.rotation);
        scene.splats.push_back(splat);
    }
    return scene;
}

// All views of a quilt, with the sorting.
Stage splatViews(int count) {
    return [count](benchmark::State& state, const BenchDisplay& display) {
        const SplatScene& scene = madeSplats(count);
        const cv::Size size = display.layout.tileSize;
        const double aspect = static_cast<double>(size.width) / size.height;
        const SplatCamera camera = chooseSplatCamera(scene, size, aspect).camera;
        const SplatRenderer renderer(scene, camera);
        const SplatView middle = renderer.render();
        const cv::Mat slow = test::slowSplats(scene, camera, 0, 1, renderer.nearest());
        require(test::psnrOf(middle.picture, slow) >= 45, "the middle view of splats");
        const SplatPlacement placed = placeSplats(middle, camera, display.layout);
        cv::Mat quilt;
        measure(state, quilt,
                [&] { renderQuilt(SplatRenderer(scene, camera), placed, display.layout, quilt); });
    };
}

// What a screen that follows its viewer shows after a move, from a photo of its own size: both
// views, of the half of the columns that an eye sees, and the px or sub-pixels of each.
Stage eyesMoved(bool isThroughLens) {
    return [isThroughLens](benchmark::State& state, const BenchDisplay& display) {
        const cv::Size half(display.panel().width / 2, display.panel().height);
        const Scene scene{makePhoto(half), makeDepth(half)};
        const ViewOptions options = methodOf(ViewMethod::Layered);
        const SwayView views = photoViews(scene, options);
        const Display shown = displayOf(display.calibration);
        cv::Mat eyes[2];
        cv::Mat wide[2];
        cv::Mat native;
        const auto move = [&](double x) {
            for (int i = 0; i < 2; ++i)
                views(x + (i == 0 ? -.25 : .25), eyes[i]);
            if (isThroughLens) return eyesToNative(eyes[0], eyes[1], shown, x, native);
            for (int i = 0; i < 2; ++i)
                cv::resize(eyes[i], wide[i], display.panel(), 0, 0, cv::INTER_NEAREST);
            joinEyes(wide[0], wide[1], EyesPicture::Columns, native);
        };
        move(.3);
        Depth2Quilt({1, 1, half, 1}, options).renderView(scene, .55, eyes[1]);
        if (!isThroughLens) require(equal(eyes[1].col(4), native.col(9)), "a column");
        double x = .3;
        measure(state, native, [&] { move(x = .6 - x); });
    };
}

// The time shown is real time; UseRealTime() would add to the names.
template <class F>
void registerAs([[maybe_unused]] const std::string& name, [[maybe_unused]] const F& run) {
#ifndef __clang_analyzer__ // it reports objects owned by the registry as leaks
    benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond);
#endif
}

enum class Runs { OnOneThread, OnAllAndOneThread };

struct NamedStage {
    const char* name;
    Stage stage;
    Runs runs = Runs::OnAllAndOneThread;
};

std::vector<NamedStage> allStages() {
    constexpr auto kYardstick = Runs::OnOneThread;
    constexpr auto kDiscrete = ViewPositions::Discrete;
    constexpr auto kContinuous = ViewPositions::Continuous;
    const ViewOptions fast = methodOf(ViewMethod::Fast);
    const ViewOptions layered = methodOf(ViewMethod::Layered);
    return {{"BM_CopyNative", BM_CopyNative, kYardstick},
            {"BM_CopyQuilt", BM_CopyQuilt, kYardstick},
            {"BM_CopyLut", BM_CopyLut, kYardstick},
            {"BM_CopyQuiltToNative", BM_CopyQuiltToNative, kYardstick},
            {"BM_LutBuild", BM_LutBuild},
            {"BM_LutLoad", BM_LutLoad},
            {"BM_CopyFitDepth", BM_CopyFitDepth, kYardstick},
            {"BM_FitDepth", BM_FitDepth},
            {"BM_RefineDepthExact", refinement(false)},
            {"BM_RefineDepth", refinement(true)},
            {"BM_NetworkRun", BM_NetworkRun},
            {"BM_DepthOfPhoto", estimation(false)},
            {"BM_DepthOfFrame", estimation(true)},
            {"BM_QuiltFast", quilts(ViewMethod::Fast)},
            {"BM_QuiltLayered", quilts(ViewMethod::Layered)},
            {"BM_QuiltReal", quilts(ViewMethod::Real)},
            {"BM_QuiltToNative", BM_QuiltToNative},
            {"BM_CvRemapNearest", BM_CvRemapNearest},
            {"BM_NativeDirectNoLut", BM_NativeDirectNoLut},
            {"BM_PaperPipeline", BM_PaperPipeline},
            {"BM_NativeFast", natives({fast})},
            {"BM_NativeFastRefined", natives(refinedFast())},
            {"BM_NativeFastContinuous", natives({fast, kContinuous})},
            {"BM_NativeLayered", natives({layered})},
            {"BM_NativeLayeredBusy", natives({layered, kDiscrete, true})},
            {"BM_NativeLayeredContinuous", natives({layered, kContinuous})},
            {"BM_NativeLayeredPanelPixels", natives({layered, kContinuous, false, true})},
            {"BM_NativeOfPhotoQuick", nativesOfPhoto({})},
            {"BM_NativeOfPhoto", nativesOfPhoto(Detail::Lens)},
            {"BM_NativeOfPhotoBest", nativesOfPhoto(Detail::Panel)},
            {"BM_EyesMovedColumns", eyesMoved(false)},
            {"BM_EyesMovedLens", eyesMoved(true)},
            {"BM_SplatViews100k", splatViews(100'000)},
            {"BM_SplatViews1200k", splatViews(1'200'000)}};
}

// @param names empty: all
void registerStages(const BenchDisplay& display, const std::vector<std::string>& names = {}) {
    for (const auto& [name, stage, runs] : allStages()) {
        if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) continue;
        const std::string whole = std::string(name) + "/" + display.name;
        registerAs(whole, [stage = stage, &display](benchmark::State& state) {
            const Threads threads(false);
            stage(state, display);
        });
        if (runs == Runs::OnOneThread) continue;
        registerAs(whole + "/threads:1", [stage = stage, &display](benchmark::State& state) {
            const Threads threads(true);
            stage(state, display);
        });
    }
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
    const Calibration panel = calibrationOf("LKG-PORT-BENCH", 52.58, -7.17, 0.5, 324, {1536, 2048});
    const BenchDisplay portrait("portrait", panel, {8, 6, {420, 560}, 48});
    const BenchDisplay large("8k",
                             calibrationOf("LKG-8K-BENCH", 38.6, -6.6, 0.3, 280, {7680, 4320}),
                             {5, 9, {819, 455}, 45});
    const BenchDisplay fewViews("portrait-12-views", panel, {4, 3, {420, 560}, 12});
    const BenchDisplay manyViews("portrait-192-views", panel, {16, 12, {420, 560}, 192});
    registerStages(portrait);
    registerStages(large);
    // what grows with the number of views, and what does not
    for (const BenchDisplay* const display : {&fewViews, &manyViews})
        registerStages(*display, {"BM_NativeFast", "BM_NativeLayered", "BM_PaperPipeline"});
    const BenchDisplay tracked("tracked", calibrationOf("TRACKED", 40, -9, 0.5, 110, {2560, 1440}),
                               {2, 1, {2560, 1440}, 2});
    registerStages(tracked, {"BM_EyesMovedColumns", "BM_EyesMovedLens"});
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
