#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/system_process.hpp"

#include <opencv2/core.hpp>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

void probeNetwork(const fs::path& file, const NetworkProfile& profile, cv::Size inputSize,
                  double seconds, InferenceEngine engine) {
    checkRange("seconds", seconds, 0.1, 3600);
    const ApartEnd end = runApart(
        [&] {
            try {
                cv::setNumThreads(1); // the process does not have the threads of this one
                DepthNetwork network(file, profile, InferenceTarget::Cpu, inputSize, engine);
                cv::Mat raw;
                network.infer(cv::Mat(network.inputSize(), CV_8UC3, cv::Scalar::all(128)), raw);
            } catch (const std::exception&) { // the caller gets the same error and reports it
            }
        },
        seconds);
    if (end.error != 0) {
        throw Error(ErrorCode::ReadFailed, file.string(),
                    "cannot be tested in a separate process: " +
                        std::generic_category().message(end.error));
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
