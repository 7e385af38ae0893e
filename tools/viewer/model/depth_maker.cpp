#include "viewer/model/depth_maker.hpp"

#include "altiro3D/error.hpp"
#include "cli/network_trust.hpp"
#include "cli/run_tool.hpp"

#include <QCoreApplication>
#include <QProcess>
#include <algorithm>
#include <cstdio>
#include <opencv2/core.hpp>
#include <utility>

namespace altiro3D::viewer {

namespace {

const InstalledNetwork* findIn(const std::vector<InstalledNetwork>& networks,
                               const std::string& name) {
    const auto found =
        std::find_if(networks.begin(), networks.end(),
                     [&name](const InstalledNetwork& n) { return n.profile.name == name; });
    return found != networks.end() ? &*found : nullptr;
}

// Tests a network in a new process. The test forks, which needs a process with a single thread: in
// a fork of this one, locks that other threads hold would never be released.
void requireHarmless(const std::string& name) {
    QProcess process;
    process.start(QCoreApplication::applicationFilePath(),
                  {QString(kTryNetwork), QString::fromStdString(name)});
    const bool ended = process.waitForStarted() && process.waitForFinished(-1) &&
                       process.exitStatus() == QProcess::NormalExit;
    const std::string said = process.readAllStandardError().trimmed().toStdString();
    if (ended && process.exitCode() == 0) {
        if (!said.empty()) std::fprintf(stderr, "%s\n", said.c_str());
        return;
    }
    throw Error(
        ErrorCode::NetworkFailed, name,
        said.empty()
            ? "cannot be tested: the separate process did not end normally, expected exit status 0"
            : said);
}

} // namespace

DepthMaker::DepthMaker() {
    findNetworks();
}

void DepthMaker::findNetworks() {
    const std::lock_guard<std::mutex> lock(listMutex_);
    try {
        networks_ = installedNetworks();
    } catch (const Error&) {
        // the list of networks in the window reports a damaged catalogue
    }
}

std::optional<InstalledNetwork> DepthMaker::find(const std::string& name) const {
    const std::lock_guard<std::mutex> lock(listMutex_);
    const InstalledNetwork* const found = findIn(networks_, name);
    return found != nullptr ? std::optional(*found) : std::nullopt;
}

std::string DepthMaker::choose(const std::string& wish, bool given) const {
    const std::lock_guard<std::mutex> lock(listMutex_);
    if (findIn(networks_, wish) != nullptr) return wish;
    if (given) return kGivenDepth;
    const auto standard =
        std::find_if(networks_.begin(), networks_.end(), [](const InstalledNetwork& network) {
            return !network.profile.large && canRun(network.profile);
        });
    return standard != networks_.end() ? standard->profile.name : kBestDepth;
}

void DepthMaker::use(const std::string& chosen, const std::function<void(DepthSource&)>& use) {
    const std::optional<InstalledNetwork> network = find(chosen);
    if (!network)
        throw Error(ErrorCode::NotFound, "depth",
                    "no network is installed that could estimate it, expected one from Edit > "
                    "Better depth, or a depth image");
    const std::lock_guard<std::mutex> lock(mutex_);
    if (loaded_ != chosen) {
        network_.reset();
        loaded_.clear();
        if (harmless_.count(chosen) == 0) requireHarmless(chosen);
        harmless_.insert(chosen);
        {
            const tools::QuietStandardError
                quiet; // some builds of ONNX Runtime print when they start
            network_ = depthFromNetwork(DepthNetwork(network->file, network->profile));
        }
        loaded_ = chosen;
    }
    use(*network_);
}

int tryNetwork(const std::string& name) {
    tools::Messages messages("altiro3Dview", false);
    try {
        const std::vector<InstalledNetwork> networks = installedNetworks();
        const InstalledNetwork* const network = findIn(networks, name);
        if (network == nullptr)
            throw Error(ErrorCode::NotFound, name,
                        "was not found, expected the name of a network of the catalogue");
        std::vector<NetworkProfile> catalog;
        for (const InstalledNetwork& ready : networks)
            catalog.push_back(ready.profile);
        tools::requireHarmless(network->file, network->profile, catalog, {}, InferenceEngine::Best,
                               messages);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", tools::sentenceOf(error).c_str());
        return tools::kExitFailed;
    }
    messages.flushWarnings();
    return 0;
}

PlayedDepth::PlayedDepth(std::shared_ptr<DepthMaker> maker) : maker_(std::move(maker)) {}

// As in video2native.
void PlayedDepth::matchEyes(const cv::Mat& left, cv::Mat& raw) {
    const StereoMatch match = matchStereo(left, right_, raw);
    if (match.areEyes() && !match.isFlat) return;
    const std::string network = maker_->choose(kBestDepth, false);
    if (network == kBestDepth) { // none is installed
        raw = cv::Mat::zeros(left.size(), CV_32FC1);
        return;
    }
    maker_->use(network, [&](DepthSource& source) {
        cv::Mat photo;
        cv::Mat numbers;
        source.readFrame(left, photo, numbers);
        DepthNormalization normalization;
        normalization.kind = source.kind();
        normalizeDepth(numbers, raw, normalization);
    });
}

void PlayedDepth::next(Document& document, const std::string& wish, double seconds) {
    const std::string chosen = maker_->choose(wish, document.hasDepth());
    right_ = document.right;
    const bool isMatched = chosen == kGivenDepth && !right_.empty();
    const bool isGiven = chosen == kGivenDepth && !isMatched;
    if (GivenDepthReader* const track = document.depthTrack.get()) {
        const bool isCut = track->next(document.picture, seconds, document.rawDepth).cut;
        if (isGiven) {
            chosen_ = chosen;
            document.scene = isCut ? ++scene_ : scene_;
            return;
        }
    }
    if (chosen != chosen_) {
        DepthKind kind = DepthKind::NearWhite;
        if (!isMatched && !isGiven)
            maker_->use(chosen, [&](DepthSource& source) { kind = source.kind(); });
        const auto estimate = [this, maker = maker_, chosen, isMatched,
                               isGiven](const cv::Mat& picture, cv::Mat& raw) {
            if (isMatched) return matchEyes(picture, raw);
            if (isGiven) return cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)).copyTo(raw); // scenes alone
            cv::Mat photo;
            maker->use(chosen, [&](DepthSource& source) { source.readFrame(picture, photo, raw); });
        };
        depth_.emplace(estimate, kind);
        chosen_ = chosen;
    }
    cv::Mat depth;
    if (depth_->next(document.picture, depth).cut) ++scene_;
    if (!isGiven) document.depth = depth;
    document.scene = scene_;
}

} // namespace altiro3D::viewer
