#pragma once

#include "altiro3D/export.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D {

/// What the numbers that a network puts out mean.
enum class NetworkOutput {
    InverseDepth, ///< Relative inverse depth, larger = nearer, unknown scale and shift (MiDaS).
    MetricDepth   ///< Distance, larger = farther (FastDepth).
};

/// Order of the colours in the network's input.
enum class ChannelOrder { Rgb, Bgr };

/// Shape of a network's input.
enum class InputShape {
    Fixed, ///< inputWidth x inputHeight for every photo, which is stretched to it.
    Photo  ///< The photo's own shape, its longer side that of inputWidth and inputHeight.
};

/// How a photo is resampled to the network's input.
enum class ResizeKernel { Nearest, Linear, Cubic, Area };

/// The program that runs the graph of a network.
enum class InferenceEngine {
    Best,       ///< What the profile says, else OnnxRuntime where it can be used, else OpenCv.
    OpenCv,     ///< OpenCV's DNN module.
    OnnxRuntime ///< ONNX Runtime, several times faster, on the CPU only; see hasOnnxRuntime().
};

/// Whether this library was built with ONNX Runtime. @return true if it was
[[nodiscard]] ALTIRO3D_EXPORT bool hasOnnxRuntime();

/// Everything that exact inference with one network needs; one entry of `models/catalog.json`, or
/// a file of the same keys given by the user. `pixel -> (pixel * scale - mean) / std` per channel.
struct NetworkProfile {
    std::string name;        ///< Short name ("midas-small").
    std::string file;        ///< File name of the ONNX file, without directories.
    std::string url;         ///< Where to download it; may be empty.
    std::uint64_t bytes = 0; ///< Exact file size; 0 = unknown.
    std::string sha256;      ///< SHA-256 of the file in lower-case hex; empty = unknown.
    std::string licence;     ///< Licence of the weights.
    bool large = false;      ///< True for the large profile (`-l`).
    int inputWidth = 0;      ///< Input width in px, 1..4096.
    int inputHeight = 0;     ///< Input height in px, 1..4096.
    int multipleOf = 32;     ///< Input sides must be multiples of this, 1..4096.
    InputShape inputShape = InputShape::Fixed;       ///< Whether the input has the photo's shape.
    ChannelOrder channelOrder = ChannelOrder::Rgb;   ///< Order of the input's planes.
    double scale = 1.0 / 255.0;                      ///< Factor on 8-bit values.
    std::array<double, 3> mean{0, 0, 0};             ///< Subtracted after scale, in channelOrder.
    std::array<double, 3> std{1, 1, 1};              ///< Divisor after mean, in channelOrder, != 0.
    ResizeKernel resizeKernel = ResizeKernel::Cubic; ///< On float values, after scale.
    NetworkOutput output = NetworkOutput::InverseDepth; ///< Meaning of the output.
    InferenceEngine engine = InferenceEngine::Best;     ///< The only engine that can run it.
    /// Share of the built-in estimator in the depth that depthFromNetwork() gives, 0 up to (not
    /// including) 1. DepthNetwork itself ignores it.
    double cuesShare = 0;
};

/// Checks a profile.
/// @param profile what to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const NetworkProfile& profile);

/// Reads one profile from a JSON file.
/// @param file the file, at most 1 MiB
/// @return the profile, valid; `file` may be empty
/// @throws Error NotFound, ReadFailed, TooLarge, BadFormat (file, field, expected), OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT NetworkProfile readNetworkProfile(const std::filesystem::path& file);

/// Reads the list of known networks (`{"networks": [...]}`), at most 1000.
/// @param file the file, at most 1 MiB
/// @return the profiles in the file's order, valid, no two of one `name` or `file`
/// @throws Error as readNetworkProfile()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<NetworkProfile>
readModelCatalog(const std::filesystem::path& file);

/// The catalogue entry of a network file.
/// @param catalog from readModelCatalog(); the result points into it
/// @param modelFile the ONNX file; its directories do not count
/// @return the entry whose `file` equals the path's file name, or null
[[nodiscard]] ALTIRO3D_EXPORT const NetworkProfile*
findProfile(const std::vector<NetworkProfile>& catalog, const std::filesystem::path& modelFile);

/// The processor a network runs on.
enum class InferenceTarget { Cpu, Cuda };

/// Chooses the processor.
/// @param backends OpenCV's (back-end, target) numbers, from availableBackends()
/// @return CUDA if it is among them, else the CPU
[[nodiscard]] ALTIRO3D_EXPORT InferenceTarget
chooseInferenceTarget(const std::vector<std::pair<int, int>>& backends);

/// What this OpenCV build can run networks on.
/// @return (back-end, target), OpenCV's numbers (cv::dnn::Backend, cv::dnn::Target)
[[nodiscard]] ALTIRO3D_EXPORT std::vector<std::pair<int, int>> availableBackends();

/// A depth network, loaded and ready. Move-only; one thread at a time per object.
///
/// OpenCV's log level and error callback belong to the process and stay as they are. OpenCV logs
/// details of a graph that it cannot load or run, by default on stderr; the sentence of the Error
/// is complete without them. cv::utils::logging::setLogLevel() turns the log off. ONNX Runtime 1.21
/// of Debian 13 writes about a thousand harmless lines on stderr when a process loads its first
/// network.
class ALTIRO3D_EXPORT DepthNetwork {
  public:
    /// Loads an ONNX file.
    ///
    /// @param file the ONNX file
    /// @param profile how to feed it
    /// @param target processor to run on
    /// @param engine program that runs the graph. ONNX Runtime cannot run a file that is fixed to
    ///        one size at another; InferenceEngine::Best then takes OpenCV.
    /// @param inputSize size to bring photos to, sides of 1..4096 px, multiples of the profile's
    ///        `multipleOf`; empty: the profile's. Most networks take others than they were trained
    ///        for: less is quicker and sees less. The file may be fixed to the profile's size; what
    ///        it does at its end to bring its numbers into the shape for that size is left out
    ///        then.
    /// @throws Error NotFound; BadFormat (no ONNX file, external weights missing, a graph OpenCV
    ///         cannot load); Mismatch (the file is fixed to another size than the profile's);
    ///         NetworkFailed (cannot run at `inputSize`); Unsupported (weights in another file, no
    ///         CUDA or ONNX Runtime here); InvalidArgument (profile, inputSize); ReadFailed,
    ///         TooLarge (2 GiB), OutOfMemory
    DepthNetwork(const std::filesystem::path& file, NetworkProfile profile,
                 InferenceTarget target = InferenceTarget::Cpu, cv::Size inputSize = {},
                 InferenceEngine engine = InferenceEngine::Best);
    ~DepthNetwork();
    DepthNetwork(DepthNetwork&&) noexcept;            ///< Moves.
    DepthNetwork& operator=(DepthNetwork&&) noexcept; ///< Moves. @return *this

    /// The profile in use. @return as given to the constructor
    [[nodiscard]] const NetworkProfile& profile() const;
    /// The size that photos are brought to, with InputShape::Photo that of a photo of the profile's
    /// shape. @return width x height in px
    [[nodiscard]] cv::Size inputSize() const;
    /// The size that a photo is brought to.
    /// @param photo its size in px
    /// @return inputSize(); with InputShape::Photo its longer side along the photo's, and the other
    ///         side the multiple of `multipleOf` that is nearest to the photo's shape
    /// @throws Error InvalidArgument (an empty photo)
    [[nodiscard]] cv::Size inputSize(cv::Size photo) const;
    /// The file it was loaded from. @return as given to the constructor
    [[nodiscard]] const std::filesystem::path& file() const;
    /// The processor it runs on. @return as given to the constructor
    [[nodiscard]] InferenceTarget target() const;
    /// The program that runs its graph. @return OpenCv or OnnxRuntime
    [[nodiscard]] InferenceEngine engine() const;

    /// The network's own numbers for a photo. Of several outputs the last one counts.
    ///
    /// OpenCV runs the network: its numbers are not the same bits for any number of threads, they
    /// may differ in the 7th digit between 2 and 3 (docs/reliability.md, "The same bytes"), and
    /// between processors.
    ///
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param raw [network's output size, CV_32FC1, finite, see NetworkProfile::output]
    /// @throws Error InvalidArgument (empty or wrong type); NetworkFailed (output of unexpected
    ///         shape, NaN or infinity in it, failure inside OpenCV); OutOfMemory
    void infer(const cv::Mat& photo, cv::Mat& raw);

    /// infer() followed by normalizeDepth() with the meaning of the profile. As infer()'s numbers
    /// the depth may differ in the last digits between numbers of threads and processors.
    ///
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param depth [network's output size, CV_32FC1, 0..1, 1 = nearest]
    /// @throws Error as infer()
    void estimate(const cv::Mat& photo, cv::Mat& depth);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Loads a network and runs it once in a child process: some files that are no ordinary networks
/// make OpenCV crash or never end, and then only the child is lost.
///
/// Errors that DepthNetwork can tell by itself (no ONNX file, a graph OpenCV refuses, ...) are left
/// to it: the call returns. To be called before the process has other threads at work, as the child
/// is a copy of it with this thread alone.
///
/// @param file the ONNX file
/// @param profile how to feed it
/// @param inputSize as for DepthNetwork
/// @param seconds time for the child, 0.1..3600; it uses one thread of the CPU
/// @param engine as for DepthNetwork
/// @throws Error NetworkFailed (it crashes OpenCV, or takes longer); InvalidArgument (seconds);
///         ReadFailed (there can be no child)
ALTIRO3D_EXPORT void probeNetwork(const std::filesystem::path& file, const NetworkProfile& profile,
                                  cv::Size inputSize = {}, double seconds = 120,
                                  InferenceEngine engine = InferenceEngine::Best);

/// Where network files and the catalogue are looked for, in this order: `$ALTIRO3D_MODELS` (a list
/// separated by ':'), `$XDG_DATA_HOME` or `~/.local/share` + `/altiro3D/models`, `models/` of each
/// of dataDirectories(). Directories that do not exist are left out. The working directory is not
/// among them: pictures from elsewhere must not bring their own network.
///
/// @return the directories, first choice first
[[nodiscard]] ALTIRO3D_EXPORT std::vector<std::filesystem::path> modelSearchPath();

/// Looks for a file that is no directory.
/// @param name file name, as "midas.onnx"; not absolute
/// @param searchPath directories, as modelSearchPath() gives them
/// @return the file in the first directory that holds it; empty if none does, or `name` is empty or
///         absolute
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
findModelFile(const std::string& name, const std::vector<std::filesystem::path>& searchPath);

/// A network that is ready for use.
struct InstalledNetwork {
    NetworkProfile profile;     ///< How to feed it.
    std::filesystem::path file; ///< The ONNX file.
};

/// The known networks: the first `catalog.json` of a search path.
/// @param searchPath directories, as modelSearchPath() gives them
/// @return the profiles, the preferred ones first; empty if there is no catalogue
/// @throws Error as readModelCatalog()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<NetworkProfile>
modelCatalog(const std::vector<std::filesystem::path>& searchPath = modelSearchPath());

/// The networks of the catalogue whose files are there.
/// @param searchPath directories, as modelSearchPath() gives them
/// @return the networks, the preferred ones first
/// @throws Error as readModelCatalog()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<InstalledNetwork>
installedNetworks(const std::vector<std::filesystem::path>& searchPath = modelSearchPath());

/// The network to use if nobody names one: the first of installedNetworks() that is large, or not.
/// Networks that need ONNX Runtime count only if it is there.
/// @param large which one is wanted, see NetworkProfile::large
/// @param searchPath directories, as modelSearchPath() gives them
/// @return the network; nothing if no such network is installed
/// @throws Error as readModelCatalog()
[[nodiscard]] ALTIRO3D_EXPORT std::optional<InstalledNetwork>
standardNetwork(bool large = false,
                const std::vector<std::filesystem::path>& searchPath = modelSearchPath());

} // namespace altiro3D
