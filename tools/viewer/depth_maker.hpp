#pragma once

#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "viewer/knobs.hpp"

#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// Estimates depth by what Knobs::depth names: a network whose file is there, or the estimator that
/// is built in. For any thread.
class DepthMaker {
  public:
    /// Looks for networks.
    DepthMaker();

    /// What a wish comes to: a network's name, kBuiltInDepth or kGivenDepth.
    /// @param wish Knobs::depth @param given the picture has depth of its own
    std::string choose(const std::string& wish, bool given) const;

    /// Calls a function with the source of depth; it has a network to itself meanwhile.
    ///
    /// A network that is not known to be harmless runs in a process of its own first.
    /// @param chosen from choose(), not kGivenDepth
    /// @throws Error and what the function throws
    void use(const std::string& chosen, const std::function<void(DepthSource&)>& use);

  private:
    const InstalledNetwork* find(const std::string& name) const;

    std::vector<InstalledNetwork> networks_;
    std::mutex mutex_; // of what follows
    std::set<std::string> harmless_;
    std::unique_ptr<DepthSource> network_;
    std::string loaded_; // name of network_
};

/// What a process of the viewer's own does with a network: see requireHarmless().
/// @return exit status; an error is a line on stderr
int tryNetwork(const std::string& name);
/// The argument that a program with a DepthMaker in it has to hand to tryNetwork(), followed by the
/// name.
constexpr const char* kTryNetwork = "--try-network";

} // namespace altiro3D::viewer
