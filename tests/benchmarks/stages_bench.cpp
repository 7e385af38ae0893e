// Speed of each stage at a Portrait's real sizes (panel 1536 x 2048, 48 views of 420 x 560 px).
// Every output is checked once before it is timed; quote ratios to the memcpy yardsticks.

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt2native.hpp"

#include <benchmark/benchmark.h>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <unistd.h>

namespace {

using namespace altiro3D;

Calibration portrait() {
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

void require(bool good, const char* what) {
    if (good) return;
    std::fprintf(stderr, "altiro3D_bench: wrong result: %s\n", what);
    std::exit(1);
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() &&
           cv::norm(a.reshape(1), b.reshape(1), cv::NORM_INF) == 0;
}

// A photo with detail and a depth map with steps, the same each time.
cv::Mat photo(cv::Size size) {
    cv::Mat picture(size, CV_8UC3);
    cv::RNG rng(7);
    rng.fill(picture, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(picture, picture, {5, 5}, 1.5);
    return picture;
}

cv::Mat depth(cv::Size size) {
    cv::Mat map(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y)
        map.row(y).setTo(0.6 * y / size.height);
    cv::circle(map, {size.width / 2, size.height / 2}, size.width / 4, cv::Scalar(0.9), cv::FILLED);
    return map;
}

const QuiltLayout kLayout; // 8 columns x 6 rows of 420 x 560 px

const NativeLut& lut() {
    static const NativeLut table(portrait(), kLayout);
    return table;
}

ViewOptions methodOf(ViewMethod method) {
    ViewOptions options;
    options.method = method;
    return options;
}

const cv::Mat& quilt() {
    static const cv::Mat picture = [] {
        cv::Mat views;
        Depth2Quilt(kLayout, methodOf(ViewMethod::Fast))
            .render(photo(kLayout.tileSize), depth(kLayout.tileSize), views);
        return views;
    }();
    return picture;
}

// Number of threads of a variant: 1, or all.
class Threads {
  public:
    explicit Threads(const benchmark::State& state) {
        cv::setNumThreads(state.range(0) == 1 ? 1 : -1);
    }
    ~Threads() { cv::setNumThreads(-1); }
    Threads(const Threads&) = delete;
    Threads& operator=(const Threads&) = delete;
};

void copyBytes(benchmark::State& state, std::size_t bytes) {
    const std::vector<char> source(bytes, 1);
    std::vector<char> target(bytes, 2);
    for (auto _ : state) {
        std::memcpy(target.data(), source.data(), bytes);
        benchmark::DoNotOptimize(target.data());
        benchmark::ClobberMemory();
    }
    state.SetBytesProcessed(static_cast<std::int64_t>(bytes) *
                            static_cast<std::int64_t>(state.iterations()));
}

void BM_CopyNative(benchmark::State& state) {
    copyBytes(state, std::size_t{1536} * 2048 * 3);
}
void BM_CopyLut(benchmark::State& state) {
    copyBytes(state, std::size_t{1536} * 2048 * 12);
}
void BM_CopyQuilt(benchmark::State& state) {
    copyBytes(state, std::size_t{3360} * 3360 * 3);
}

void BM_LutBuild(benchmark::State& state) {
    const Threads threads(state);
    const NativeLut built(portrait(), kLayout);
    for (int k = 0; k < 3; ++k)
        require(equal(built.channel(k), lut().channel(k)), "LutBuild");
    for (auto _ : state) {
        const NativeLut table(portrait(), kLayout);
        benchmark::DoNotOptimize(table.channel(0).data);
    }
}

void BM_LutLoad(benchmark::State& state) {
    const Threads threads(state);
    const auto file = std::filesystem::temp_directory_path() /
                      ("altiro3D-bench-" + std::to_string(getpid()) + ".map");
    lut().save(file);
    require(equal(NativeLut::load(file).channel(1), lut().channel(1)), "LutLoad");
    for (auto _ : state)
        benchmark::DoNotOptimize(NativeLut::load(file).channel(0).data);
    std::filesystem::remove(file);
}

void renderQuilts(benchmark::State& state, ViewMethod method) {
    const Threads threads(state);
    const cv::Mat source = photo(kLayout.tileSize);
    const cv::Mat map = depth(kLayout.tileSize);
    const Depth2Quilt maker(kLayout, methodOf(method));
    cv::Mat result;
    maker.render(source, map, result);
    cv::Mat view; // the first tile is the leftmost view
    maker.renderView(source, map, -1, view);
    require(equal(result(kLayout.tile(0)), view), "quilt");
    for (auto _ : state) {
        maker.render(source, map, result);
        benchmark::DoNotOptimize(result.data);
    }
}

void BM_FastQuilt(benchmark::State& state) {
    renderQuilts(state, ViewMethod::Fast);
}
void BM_RealQuilt(benchmark::State& state) {
    renderQuilts(state, ViewMethod::Real);
}
void BM_LayeredQuilt(benchmark::State& state) {
    renderQuilts(state, ViewMethod::Layered);
}

void BM_QuiltToNative(benchmark::State& state) {
    const Threads threads(state);
    const Quilt2Native renderer(lut());
    cv::Mat native;
    renderer.render(quilt(), native);
    for (int i = 0; i < 1000; ++i) { // against the table read by hand
        const int x = i * 641 % 1536;
        const int y = i * 1009 % 2048;
        for (int k = 0; k < 3; ++k) {
            const auto at = lut().channel(k).at<cv::Vec<std::uint16_t, 2>>(y, x);
            require(native.at<cv::Vec3b>(y, x)[2 - k] == quilt().at<cv::Vec3b>(at[1], at[0])[2 - k],
                    "QuiltToNative");
        }
    }
    for (auto _ : state) {
        renderer.render(quilt(), native);
        benchmark::DoNotOptimize(native.data);
    }
}

BENCHMARK(BM_CopyNative)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_CopyQuilt)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_CopyLut)->Unit(benchmark::kMillisecond)->UseRealTime();
// threads: 0 = all, 1 = one
#define ALTIRO3D_STAGE(function)                                                                   \
    BENCHMARK(function)                                                                            \
        ->ArgName("threads")                                                                       \
        ->Arg(0)                                                                                   \
        ->Arg(1)                                                                                   \
        ->Unit(benchmark::kMillisecond)                                                            \
        ->UseRealTime()
ALTIRO3D_STAGE(BM_LutBuild);
ALTIRO3D_STAGE(BM_LutLoad);
ALTIRO3D_STAGE(BM_FastQuilt);
ALTIRO3D_STAGE(BM_LayeredQuilt);
ALTIRO3D_STAGE(BM_RealQuilt);
ALTIRO3D_STAGE(BM_QuiltToNative);

} // namespace

BENCHMARK_MAIN();
