#include "cli/network_trust.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "cli/system.hpp"

#include <QCryptographicHash>
#include <algorithm>
#include <fstream>
#include <opencv2/core/version.hpp>
#include <sstream>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kStepBytes = std::size_t{1} << 20;
constexpr double kTrialSeconds = 120;

std::string hexadecimal(const QCryptographicHash& hash) {
    return hash.result().toHex().toStdString();
}

// Empty if the file cannot be read; loading it will say why.
std::string sha256(const fs::path& file) {
    QCryptographicHash hash(QCryptographicHash::Sha256);
    std::ifstream stream(file, std::ios::binary);
    std::vector<char> part(kStepBytes);
    while (stream) {
        stream.read(part.data(), static_cast<std::streamsize>(part.size()));
        hash.addData(part.data(), static_cast<int>(stream.gcount()));
    }
    return stream.eof() ? hexadecimal(hash) : std::string();
}

// A key that changes with the file and with what it is tested with. Empty without such a file.
std::string keyOf(const fs::path& file, const NetworkProfile& profile, cv::Size size,
                  InferenceEngine engine) {
    const std::string identity = identityOf(file);
    if (identity.empty()) return {};
    std::ostringstream text;
    text << version() << " " CV_VERSION << ' ' << identity << ' ' << profile.inputWidth << ' '
         << profile.inputHeight << ' ' << static_cast<int>(profile.inputShape) << ' '
         << profile.multipleOf << ' ' << size.width << ' ' << size.height << ' '
         << static_cast<int>(engine) << ' ' << static_cast<int>(profile.engine) << ' '
         << hasOnnxRuntime();
    const std::string key = text.str();
    QCryptographicHash hash(QCryptographicHash::Sha256);
    hash.addData(key.data(), static_cast<int>(key.size()));
    return hexadecimal(hash).substr(0, 16);
}

// Cached facts about a file.
struct Findings {
    std::string sha256;
    bool survived = false; // it has passed the test
};

// A missing or damaged entry gives empty findings.
Findings findingsIn(const fs::path& entry) {
    constexpr std::size_t kDigits = 64;
    Findings findings;
    if (entry.empty() || !isThere(entry)) return findings;
    try {
        const std::string text = readFile(entry, 1024);
        if (text.size() < kDigits + 2) return findings;
        findings.sha256 = text.substr(0, kDigits);
        findings.survived = text.substr(kDigits) == " tried\n";
    } catch (const Error&) { // the cache is a convenience
    }
    return findings;
}

void keep(const fs::path& entry, const Findings& findings) {
    if (entry.empty() || findings.sha256.empty()) return;
    try {
        std::error_code error;
        fs::create_directories(entry.parent_path(), error);
        writeFile(entry, findings.sha256 + (findings.survived ? " tried\n" : " known\n"));
    } catch (const Error&) { // the next run finds out again
    }
}

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

void requireHarmless(const fs::path& file, const NetworkProfile& profile,
                     const std::vector<NetworkProfile>& catalog, cv::Size inputSize,
                     InferenceEngine engine, Messages& messages) {
    const std::string key = keyOf(file, profile, inputSize, engine);
    if (key.empty()) return; // nothing to run
    const fs::path directory = cacheDirectory();
    const fs::path entry = directory.empty() ? fs::path() : directory / ("network-" + key + ".txt");
    Findings findings = findingsIn(entry);
    const bool isNew = findings.sha256.empty();
    if (isNew) findings.sha256 = sha256(file);

    const NetworkProfile* const named = findProfile(catalog, file);
    if (named != nullptr && !named->sha256.empty() && named->sha256 != findings.sha256) {
        messages.warn(file.string() + ": differs from the catalogue's " + named->name +
                      " (its SHA-256 is different): download it again (" + howToDownload(*named) +
                      ")");
    }
    const bool known =
        std::any_of(catalog.begin(), catalog.end(), [&](const NetworkProfile& network) {
            return !network.sha256.empty() && network.sha256 == findings.sha256;
        });
    if (!known && !findings.survived) {
        messages.detail(file.string() + ": is not in the catalogue; tested in a separate process");
        probeNetwork(file, profile, inputSize, kTrialSeconds, engine);
        findings.survived = true;
        keep(entry, findings);
    } else if (isNew) {
        keep(entry, findings);
    }
}

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

cv::Mat trustedEstimate(const cv::Mat& photo) {
    Scene scene;
    try {
        const std::optional<InstalledNetwork> network = standardNetwork();
        if (!network || sha256(network->file) != network->profile.sha256) return {};
        const QuietStandardError quiet; // some builds of ONNX Runtime print when they start
        depthFromNetworkFile(network->file, network->profile)->readScene(photo, 0.5, scene);
    } catch (const Error&) {
        return {};
    }
    return scene.depth;
}

std::string howToDownload(const NetworkProfile& network) {
    for (const fs::path& directory : dataDirectories()) {
        for (const char* place : {"", "scripts"}) { // installed, in the source tree
            const fs::path script = directory / place / "get-models.sh";
            if (isThere(script)) return script.string() + " " + network.name;
        }
    }
    return network.url + " as " + network.file + " in a folder that ALTIRO3D_MODELS names";
}

} // namespace altiro3D::tools
