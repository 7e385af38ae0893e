#include "common/depth_trade.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/error.hpp"
#include "common/network_trust.hpp"
#include "common/run_tool.hpp"

#include <algorithm>
#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace altiro3D::tools {

namespace {

NamedDepthSource networkSource(const InstalledNetwork& network, cv::Size size, Messages& messages) {
    const NetworkProfile& profile = network.profile;
    const int longer = size.empty() ? std::max(profile.inputWidth, profile.inputHeight)
                                    : std::max(size.width, size.height);
    return {profile.name + ", " + std::to_string(longer) + " px",
            [network, size, &messages] {
                requireHarmless(network.file, network.profile, modelCatalog(), size,
                                InferenceEngine::Best, messages);
                const QuietStandardError quiet; // OpenCV and ONNX Runtime print by themselves
                return depthFromNetwork(
                    DepthNetwork(network.file, network.profile, InferenceTarget::Cpu, size));
            },
            size.empty()};
}

} // namespace

std::vector<NamedDepthSource> depthSources(Messages& messages) {
    std::vector<NamedDepthSource> sources;
    for (const InstalledNetwork& network : installedNetworks()) {
        const NetworkProfile& profile = network.profile;
        if (profile.large || !canRun(profile)) continue;
        sources.push_back(networkSource(network, {}, messages));
        const cv::Size half(profile.inputWidth / 2, profile.inputHeight / 2);
        if (half.width % profile.multipleOf == 0 && half.height % profile.multipleOf == 0)
            sources.push_back(networkSource(network, half, messages));
    }
    return sources;
}

DepthRow measureDepth(const std::string& name, DepthSource& source, const StereoScene& scene,
                      const DepthRefineOptions& refine) {
    DepthRow row;
    row.scene = scene.name;
    row.source = name;
    Scene estimated;
    row.milliseconds = fastestMilliseconds([&] { source.readScene(scene.photo, 0.5, estimated); });
    Scene aligned{scene.photo, {}, {}, {}, estimated.edges};
    cv::Mat& depth = aligned.depth;
    cv::resize(estimated.depth, depth, scene.depth.size(), 0, 0, cv::INTER_LINEAR);
    row.rankCorrelation = rankCorrelation(depth, scene.depth);
    alignDepth(depth, scene.depth, depth);
    refineScene(aligned, refine);
    ViewOptions layered;
    layered.method = ViewMethod::Layered;
    cv::Mat view;
    Depth2Quilt({1, 1, scene.photo.size(), 1}, scene.options(layered)).renderView(aligned, 1, view);
    row.accuracy = compareViews(view, scene.truth, scene.band());
    return row;
}

void addShare(double share, const ViewAccuracy& part, ViewAccuracy& mean) {
    mean.psnrWhole += share * part.psnrWhole;
    mean.ssimWhole += share * part.ssimWhole;
    mean.psnrInside += share * part.psnrInside;
    mean.ssimInside += share * part.ssimInside;
}

std::vector<DepthRow> meansOf(const std::vector<DepthRow>& rows, std::size_t sources) {
    std::vector<DepthRow> means;
    const double share = static_cast<double>(sources) / static_cast<double>(rows.size());
    for (std::size_t s = 0; s < sources; ++s) {
        DepthRow mean;
        mean.scene = "mean";
        mean.source = rows[s].source;
        for (std::size_t i = s; i < rows.size(); i += sources) {
            const DepthRow& row = rows[i];
            mean.milliseconds += share * row.milliseconds;
            mean.rankCorrelation += share * row.rankCorrelation;
            addShare(share, row.accuracy, mean.accuracy);
        }
        means.push_back(mean);
    }
    return means;
}

const char* const kDepthHeading =
    "estimated depth          per photo   order     layered, whole        inside";

std::string lineOf(const DepthRow& row) {
    char text[256];
    std::snprintf(text, sizeof text, "%-24s %6.1f ms %7.3f %9.2f dB %6.4f %9.2f dB %6.4f",
                  row.source.c_str(), row.milliseconds, row.rankCorrelation, row.accuracy.psnrWhole,
                  row.accuracy.ssimWhole, row.accuracy.psnrInside, row.accuracy.ssimInside);
    return text;
}

} // namespace altiro3D::tools
