// The time of a Native in C++, for python_overhead.py:
//
//     native_times CALIBRATION PHOTO DEPTH PRESET THREADS SECONDS
//
// PRESET: live or lens; THREADS of the program, with a maker each, while the library uses one.
// Prints the least processor time, ms, per Native of one thread, and Natives per second of all.
#include <algorithm>
#include <altiro3D/altiro3D.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <opencv2/core.hpp>
#include <string>
#include <thread>

namespace {

// Of this thread: other programs do not count.
double processorMilliseconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

} // namespace

int main(int argc, char** argv) try {
    if (argc != 7) return 2;
    using Clock = std::chrono::steady_clock;
    const auto source = altiro3D::depthFromFile(argv[3]);
    altiro3D::Scene scene;
    source->readScene(source->readPhoto(altiro3D::PhotoFile(argv[2])), 0.5, scene);
    altiro3D::NativeOptions options;
    if (argv[4] == std::string("live"))
        options.showLive();
    else
        options.showAs(altiro3D::Detail::Lens);
    const auto threads = static_cast<std::size_t>(std::atoi(argv[5]));
    const std::chrono::duration<double> duration(std::atof(argv[6]));
    cv::setNumThreads(1);
    const altiro3D::Display display = altiro3D::readDisplay(argv[1]);
    std::vector<std::vector<double>> times(threads);
    std::vector<std::thread> all;
    for (std::vector<double>& own : times) {
        all.emplace_back([&] {
            const altiro3D::NativeMaker maker(display, options);
            cv::Mat native;
            const auto end = Clock::now() + duration;
            while (Clock::now() < end) {
                const double start = processorMilliseconds();
                maker.makeNative(scene, native);
                own.push_back(processorMilliseconds() - start);
            }
        });
    }
    std::size_t count = 0;
    for (std::size_t i = 0; i < threads; ++i) {
        all[i].join();
        count += times[i].size();
    }
    std::printf("%f %f\n", *std::min_element(times[0].begin(), times[0].end()),
                static_cast<double>(count) / duration.count());
} catch (const altiro3D::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
