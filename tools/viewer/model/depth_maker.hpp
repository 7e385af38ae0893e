#pragma once

#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/video_depth.hpp"
#include "viewer/model/document.hpp"
#include "viewer/model/knobs.hpp"

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// Estimates depth with the installed network that Knobs::depth names. Thread-safe.
class DepthMaker {
  public:
    /// Finds the installed networks.
    DepthMaker();
    /// Finds those that were installed since.
    void findNetworks();

    /// Resolves a choice of depth to a network's name, kGivenDepth, or kBestDepth without a
    /// network.
    /// @param wish Knobs::depth @param given true if the picture has its own depth
    std::string choose(const std::string& wish, bool given) const;

    /// Calls a function with the source of depth. Only one call at a time uses the network.
    ///
    /// An untested network is first run in a separate process.
    /// @param chosen from choose(), not kGivenDepth
    /// @throws Error and the exceptions of the function
    void use(const std::string& chosen, const std::function<void(DepthSource&)>& use);

  private:
    std::optional<InstalledNetwork> find(const std::string& name) const;

    mutable std::mutex listMutex_; // guards networks_
    std::vector<InstalledNetwork> networks_;
    std::mutex mutex_; // guards the following members
    std::set<std::string> harmless_;
    std::unique_ptr<DepthSource> network_;
    std::string loaded_; // name of network_
};

/// Main function of the process that tests a network, see requireHarmless().
/// @return exit status; an error is a line on stderr
int tryNetwork(const std::string& name);
/// A program that uses DepthMaker must call tryNetwork() if this is its first argument; the second
/// one is the network's name.
constexpr const char* kTryNetwork = "--try-network";

/// The depth of a playing video, flat or of both eyes: steady, inferred as often as the pictures
/// require.
class PlayedDepth {
  public:
    explicit PlayedDepth(std::shared_ptr<DepthMaker> maker);
    PlayedDepth(const PlayedDepth&) = delete;
    PlayedDepth& operator=(const PlayedDepth&) = delete;

    /// Sets the scene of the next picture, and its depth unless the file gives it. If it has the
    /// pictures of both eyes, depth is found by matching; if they do not match, all of it is
    /// estimated, or flat without a network.
    /// @param wish Knobs::depth @param seconds time of the picture in the file
    void next(Document& document, const std::string& wish, double seconds);

  private:
    void matchEyes(const cv::Mat& left, cv::Mat& raw);

    std::shared_ptr<DepthMaker> maker_;
    std::string chosen_;
    cv::Mat right_; // the right eye's picture
    int scene_ = 0;
    std::optional<VideoDepth> depth_;
};

} // namespace altiro3D::viewer
