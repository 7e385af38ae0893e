#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/system_file.hpp"
#include "base/system_process.hpp"

#include <array>
#include <cstdlib>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr const char* kProbe = "--altiro3D-probe";

bool answers = false; // this program calls answerProbe()

void runOnce(const fs::path& file, const NetworkProfile& profile, cv::Size inputSize,
             InferenceEngine engine) {
    try {
        cv::setNumThreads(1); // the process does not have the threads of the one that started it
        DepthNetwork network(file, profile, InferenceTarget::Cpu, inputSize, engine);
        cv::Mat raw;
        network.infer(cv::Mat(network.inputSize(), CV_8UC3, cv::Scalar::all(128)), raw);
    } catch (const std::exception&) { // the caller gets the same error and reports it
    }
}

} // namespace

bool answerProbe(const std::vector<std::string>& arguments) {
    answers = true;
    constexpr std::size_t kNumbers = 7;
    if (arguments.size() != 2 + kNumbers || arguments.front() != kProbe) return false;
    std::array<int, kNumbers> numbers{};
    for (std::size_t i = 0; i < kNumbers; ++i)
        numbers[i] = std::atoi(arguments[2 + i].c_str());
    NetworkProfile profile;
    profile.name = "tried"; // one without a name is refused
    profile.inputWidth = numbers[0];
    profile.inputHeight = numbers[1];
    profile.multipleOf = numbers[2];
    profile.inputShape = static_cast<InputShape>(numbers[3]);
    runOnce(arguments[1], profile, {numbers[4], numbers[5]},
            static_cast<InferenceEngine>(numbers[6]));
    return true;
}

void probeNetwork(const fs::path& file, const NetworkProfile& profile, cv::Size inputSize,
                  double seconds, InferenceEngine engine) {
    checkRange("seconds", seconds, 0.1, 3600);
    std::vector<std::string> program;
    if (answers) {
        program = {kProbe, file.string()};
        for (const int number :
             {profile.inputWidth, profile.inputHeight, profile.multipleOf,
              static_cast<int>(profile.inputShape), inputSize.width, inputSize.height,
              static_cast<int>(engine == InferenceEngine::Best ? profile.engine : engine)})
            program.push_back(std::to_string(number));
    }
    const ApartEnd end =
        runApart([&] { runOnce(file, profile, inputSize, engine); }, program, seconds);
    if (end.error != 0) {
        throw Error(ErrorCode::ReadFailed, file.string(),
                    "cannot be tested in a separate process: " + reasonOf(end.error));
    }
    if (!end.isInTime) {
        throw Error(ErrorCode::NetworkFailed, file.string(),
                    "does not finish within " + numberText(seconds) +
                        " s, expected a depth network that the engine can run");
    }
    if (end.isWhole) return;
    throw Error(ErrorCode::NetworkFailed, file.string(),
                "crashes when it is loaded or run" + end.how +
                    ", expected a depth network that the engine can run");
}

} // namespace altiro3D
