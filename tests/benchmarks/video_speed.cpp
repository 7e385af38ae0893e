// Speed of whole videos: the tool video2native in its profiles, compared with a plain serial
// program that handles one frame after the other: infer, 48 x cv::remap, look-up table, encode with
// the same codec settings. All in one run, in turns; quote ratios.
//
//   altiro3D_video_speed VIDEO2NATIVE CLIP NETWORK.onnx PROFILE.json [ROUNDS [SETTING]]

#include "altiro3D/altiro3D.hpp"
#include "paper_pipeline.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <unistd.h>

namespace fs = std::filesystem;
using namespace altiro3D;

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// A directory of this run, removed at its end.
struct TemporaryDirectory {
    TemporaryDirectory() {
        std::string name = (fs::temp_directory_path() / "altiro3D-video-speed-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
        path = name;
    }
    ~TemporaryDirectory() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    TemporaryDirectory(const TemporaryDirectory&) = delete;
    TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

    fs::path path;
};

struct Setting {
    const char* name;
    const char* arguments; // of video2native
    EncoderPreset preset;  // the plain way's
    double crf;
};

const Setting kSettings[] = {
    {"live", "--profile live", EncoderPreset::UltraFast, 20},
    {"balanced", "", EncoderPreset::SuperFast, 16},
    {"balanced, --depth-every 8", "--depth-every 8", EncoderPreset::SuperFast, 16},
    {"balanced, --depth-every 1", "--depth-every 1", EncoderPreset::SuperFast, 16},
};

// Frames a second of the plain serial way, its start included.
double plainRate(const fs::path& clip, const std::function<DepthNetwork()>& load,
                 const Calibration& calibration, const Setting& setting, const fs::path& out) {
    const Clock::time_point start = Clock::now();
    DepthNetwork network = load();
    VideoReader reader(clip);
    const VideoFacts& facts = reader.facts();
    const QuiltLayout layout; // 48 views of 420 x 560 px, a Portrait's
    const NativeLut lut(calibration, layout);
    PaperPipeline paper(layout, lut);
    VideoWriterOptions options;
    options.size = {calibration.screenW, calibration.screenH};
    options.timeBase = facts.timeBase;
    options.frameRate = facts.averageRate;
    options.constantRate = facts.constantRate;
    options.preset = setting.preset;
    options.crf = setting.crf;
    options.native = true;
    VideoWriter writer(out, options, &reader);
    const PhotoFit fit =
        fitPhoto(facts.size, static_cast<double>(calibration.screenW) / calibration.screenH,
                 layout.tileSize);
    std::map<std::string, double> stages;
    int frames = 0;
    Clock::time_point last = Clock::now();
    const auto end = [&](const char* stage) {
        stages[stage] += secondsSince(last);
        last = Clock::now();
    };
    cv::Mat depth;
    cv::Mat photo;
    cv::Mat fittedDepth;
    for (VideoFrame frame; reader.read(frame); ++frames) {
        end("decode");
        network.estimate(frame.picture, depth);
        end("depth");
        applyFit(frame.picture, fit, photo);
        cv::resize(depth, fittedDepth, facts.size, 0, 0, cv::INTER_LINEAR);
        cv::resize(fittedDepth(fit.source), fittedDepth, layout.tileSize, 0, 0, cv::INTER_LINEAR);
        paper.run(photo, fittedDepth);
        end("render");
        frame.picture = paper.native();
        writer.write(frame);
        end("encode");
    }
    writer.finish();
    const double seconds = secondsSince(start);
    std::printf("%-36s plain serial way %6.2f fps  (", setting.name, frames / seconds);
    for (const char* stage : {"decode", "depth", "render", "encode"})
        std::printf(" %s %.1f ms", stage, 1000 * stages[stage] / frames);
    std::printf(" )\n");
    return frames / seconds;
}

double toolRate(const std::string& command, const Setting& setting, const fs::path& directory) {
    const fs::path report = directory / "report.json";
    const std::string line =
        command + " " + setting.arguments + " --report '" + report.string() + "' >/dev/null 2>&1";
    const Clock::time_point start = Clock::now();
    if (std::system(line.c_str()) != 0) {
        throw std::runtime_error("failed: " + line);
    }
    const double seconds = secondsSince(start);
    const auto json = nlohmann::json::parse(readFile(report, 1 << 20));
    const double rate = json["frames"].get<double>() / seconds; // start and end included
    std::printf("%-36s video2native     %6.2f fps  (", setting.name, rate);
    for (const auto& stage : json["stages"])
        std::printf(" %s %.1f ms", stage["name"].get<std::string>().c_str(),
                    stage["millisecondsPerFrame"].get<double>());
    std::printf(" ) %d inferences, %.0f MB\n", json["inferences"].get<int>(),
                json["peakMegabytes"].get<double>());
    return rate;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 5) {
        std::fprintf(stderr, "usage: altiro3D_video_speed VIDEO2NATIVE CLIP NETWORK.onnx "
                             "PROFILE.json [ROUNDS [SETTING]]\n");
        return 2;
    }
    try {
        const fs::path clip = argv[2];
        const int rounds = argc > 5 ? std::max(1, std::atoi(argv[5])) : 3;
        const auto load = [&] { return DepthNetwork(argv[3], readNetworkProfile(argv[4])); };
        const fs::path sample = ALTIRO3D_BENCH_CALIBRATION;
        const Calibration calibration = readCalibration(sample);
        const TemporaryDirectory temporary;
        const fs::path& directory = temporary.path;
        const fs::path out = directory / "out.mp4";
        const std::string command = "'" + std::string(argv[1]) + "' -y -c '" + sample.string() +
                                    "' -n '" + argv[3] + "' --net-profile '" + argv[4] + "' '" +
                                    clip.string() + "' '" + out.string() + "'";
        std::vector<Setting> settings(std::begin(kSettings), std::end(kSettings));
        if (argc > 6) {
            const std::string only = argv[6];
            settings.erase(std::remove_if(settings.begin(), settings.end(),
                                          [&](const Setting& one) { return one.name != only; }),
                           settings.end());
        }
        std::map<std::string, std::vector<double>> plain;
        std::map<std::string, std::vector<double>> ours;
        for (int round = 0; round < rounds; ++round) {
            for (const Setting& setting : settings) {
                plain[setting.name].push_back(plainRate(clip, load, calibration, setting, out));
                ours[setting.name].push_back(toolRate(command, setting, directory));
            }
        }
        std::printf(
            "\n| video2native | fps | plain serial way, fps | ratio |\n|---|---:|---:|---:|\n");
        for (const Setting& setting : settings) {
            const double a = median(ours[setting.name]);
            const double b = median(plain[setting.name]);
            std::printf("| %s | %.1f | %.1f | %.1f x |\n", setting.name, a, b, a / b);
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "altiro3D_video_speed: %s\n", error.what());
        return 1;
    }
    return 0;
}
